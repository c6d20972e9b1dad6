//! From camera to force: effect of each camera condition on the marker positions, mm, and on the sensed force.

use super::drawings::{Line, by_contact};
use super::format::{list, percent_two_digits};
use crate::prelude::*;
use finray_studies::experiments::camera::{AS_IT_IS, ASKED_ERROR, CameraRow, CameraStudy, FrameTimes, NeededNoise};
use finray_studies::settings::CAMERA_NOISE_MM;

const CSV: &str = "camera.csv";
/// Height of a row in a drawing, px.
const LINE_PX: f64 = 24.0;
const NEEDED_CSV: &str = "camera_needed.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![
        Dataset::records(CSV, study.camera.iter().flat_map(|camera| &camera.rows)),
        Dataset::records(NEEDED_CSV, study.camera.iter().flat_map(|camera| &camera.needed)).csv_alone(),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(camera) = &study.camera else { return Ok(None) };
    let reference = &Reference::of(study);
    let mut blocks = vec![text(about(camera, study.is_paper))];
    blocks.extend(camera.times.map(|of| text(times(of, study.is_paper))));
    let drawings: [(_, _, CameraQuantity); 2] = [
        ("Errors of displacements", "rms error of a coordinate, mm", |row| row.displacement_rms_mm),
        ("Errors of forces", "rms error of the force, %", |row| row.force_rms_error.map(|error| 100.0 * error)),
    ];
    let errors = [Some(reference.noise_mm), camera.bound_rms(reference.noise_mm).map(|error| 100.0 * error)];
    let asked = [None, Some(100.0 * ASKED_ERROR)];
    let mut figures = Vec::new();
    for (((title, axis, of), error), asked) in drawings.into_iter().zip(errors).zip(asked) {
        if let Some(svg) = drawing(camera, (title, axis), of, (reference, error), asked)? {
            figures.push(Figure::narrow(svg, format!("{title}, one row per condition of the camera."), CSV));
        }
    }
    blocks.push(Block::Figures(figures));
    let columns = Columns::<&CameraRow>::new()
        .page("what differs", Format::Words, |row| row.item)
        .page("setting", Format::Words, |row| setting(row))
        .page("displacement, mm", Format::Fixed(4), |row| row.displacement_rms_mm)
        .page("largest, mm", Format::Fixed(4), |row| row.displacement_largest_mm)
        .page("stated, mm", Format::Fixed(4), |row| row.stated_mm)
        .page("not found", Format::Plain, |row| row.markers - row.found)
        .page("force", Format::Percent, |row| row.force_rms_error)
        .page("largest", Format::Percent, |row| row.force_largest_error)
        .page("first order", Format::Percent, |row| row.first_order_rms_error)
        .page("refused", Format::Plain, |row| row.refused);
    let caption = "Error of each displacement coordinate: rms, largest, and stated. Error of the force: rms over the nodes, \
        largest, and rms computed to first order from the displacement errors";
    blocks.push(details("By condition", vec![Block::Table(columns.table(caption, CSV, &camera.rows))]));
    blocks.extend(needed(camera, reference)?);
    Ok(Some(Section::new("camera", "From camera to force", blocks).saying(says(camera, reference))))
}

/// Noise to which the camera is compared: that of the paper's camera, or of the scene.
struct Reference {
    name: &'static str,
    noise_mm: f64,
    /// What is known of the noise, in a sentence.
    about: &'static str,
}

impl Reference {
    fn of(study: &Study) -> Reference {
        match study.is_paper {
            true => Reference {
                name: "the paper's camera",
                noise_mm: CAMERA_NOISE_MM,
                about: "0.2 mm at worst, standard deviation",
            },
            false => Reference { name: "the maps", noise_mm: study.noise_mm, about: "standard deviation" },
        }
    }
}

/// Chart by contact node with two lines: the noise at which a force errs by [`ASKED_ERROR`], and the noise of the reference.
fn needed(camera: &CameraStudy, reference: &Reference) -> Result<Option<Block>, FigureError> {
    let asked = percent_two_digits(ASKED_ERROR);
    let title = format!("Noise at which a force of {} N errs by {asked}", camera.force_n);
    let alt = format!(
        "{title}, by contact node. At nodes where this noise exceeds the noise of {}, a force \
            sensed with that noise errs by less.",
        reference.name
    );
    let row = |needed: &NeededNoise| (needed.node.to_string(), [needed.noise_mm, reference.noise_mm]);
    let rows: Vec<(String, [f64; 2])> = camera.needed.iter().rev().map(row).collect();
    let lines: [Line<[f64; 2]>; 2] =
        [("needed", |[needed, _]| Some(*needed)), (reference.name, |[_, noise]| Some(*noise))];
    let drawn = by_contact(Frame::half(title, alt), "noise of a coordinate, mm", &rows, &lines)?;
    let caption =
        format!("Standard deviation of a coordinate's noise at which the force errs by {asked} (root mean square).");
    Ok(drawn.map(|svg| Block::Figure(Figure::narrow(svg, caption, NEEDED_CSV))))
}

/// Text on how the errors are computed; `is_paper` states whether the camera is the paper's camera.
fn about(camera: &CameraStudy, is_paper: bool) -> String {
    let CameraStudy { force_n, nodes, size_px: [width, height], px_a_mm, .. } = camera;
    let nodes = list(nodes, " and ");
    let scale = px_a_mm.map_or_else(String::new, |scale| format!(" ({scale:.1} px per mm)"));
    let assumed = match is_paper {
        true => {
            " Focal length, colours and light of the camera are assumed; the paper gives the size of the image and the distance."
        }
        false => "",
    };
    format!(
        "In simulation: a force of {force_n} N along the normal acts at {nodes} in turn. The finger is rendered as an image of {width} x {height} px{scale} \
         and located in it. The nonlinear estimator senses the force with the same beams that bent the finger.{assumed} Errors of the assumed lens, pose and \
         height are computed by projection, without an image. \"mesh\" is the error of the mesh with key nodes only, for exact displacements from a finer \
         mesh."
    )
}

/// Times from an image to node positions.
fn times(FrameTimes { search_s, track_s }: FrameTimes, is_paper: bool) -> String {
    let [search_ms, track_ms] = [1e3 * search_s, 1e3 * track_s];
    let papers = match is_paper {
        true => " The paper's vision system takes about 40 ms on another computer, with images of a real finger.",
        false => "",
    };
    format!(
        "From an image in memory to node positions: {search_ms:.1} ms if the whole image is searched, {track_ms:.1} ms if only the surroundings of \
         the previous positions are searched (medians, one core of this computer, finger at rest).{papers}"
    )
}

fn setting(row: &CameraRow) -> String {
    if row.is_rest_seen { format!("{}, image at rest", row.setting) } else { row.setting.to_owned() }
}

/// Reads a numeric column of the table from a row.
type CameraQuantity = fn(&CameraRow) -> Option<f64>;

/// Label of a row of the drawing. Two camera conditions share a row if they differ only in the source of the undeformed positions (scene or image at
/// rest) to which displacements refer.
fn line(row: &CameraRow) -> String {
    if row.item == AS_IT_IS { "nothing changed".to_owned() } else { format!("{}: {}", row.item, row.setting) }
}

/// Chart of the errors with one row per condition; the last row is the noise of the reference, with its error. `None` if no error can be drawn on a logarithmic axis.
fn drawing(
    camera: &CameraStudy,
    (title, axis): (&str, &str),
    of: CameraQuantity,
    (reference, error): (&Reference, Option<f64>),
    asked: Option<f64>,
) -> Result<Option<String>, FigureError> {
    // Rows are sorted so that conditions that vary the same property are adjacent.
    let first = |item: &str| camera.rows.iter().position(|row| row.item == item);
    let mut rows: Vec<&CameraRow> = camera.rows.iter().collect();
    rows.sort_by_key(|row| first(row.item));
    // A row in which no error can be drawn on a logarithmic axis is left out.
    let drawn = |row: &&CameraRow| of(row).is_some_and(|error| error > 0.0);
    let mut lines: Vec<String> = rows.into_iter().filter(drawn).map(line).collect();
    lines.dedup();
    lines.push(reference.name.to_owned());
    // Position of a row on the axis, which counts from the bottom.
    let at = |name: &str| (lines.len() - 1 - lines.iter().position(|other| other == name).unwrap_or(0)) as f64;
    let points = |is_rest_seen: bool| -> Vec<Point> {
        let rows = camera.rows.iter().filter(|row| row.is_rest_seen == is_rest_seen);
        let drawn = rows.filter_map(|row| Some([of(row).filter(|error| *error > 0.0)?, at(&line(row))]));
        drawn.collect()
    };
    let noise = error.filter(|error| *error > 0.0).map(|error| [error, 0.0]).into_iter().collect();
    let named = [
        ("relative to the scene", points(false)),
        ("relative to an image at rest", points(true)),
        ("independent noise", noise),
    ];
    let mut series: Vec<Series> = named
        .into_iter()
        .enumerate()
        .filter(|(_, (_, points))| !points.is_empty())
        .map(|(n, (label, points))| Series { dash: Dash::None, ..Series::nth(n, label, points) })
        .collect();
    if series.is_empty() {
        return Ok(None);
    }
    let [low, high] = [-0.5, lines.len() as f64 - 0.5];
    series.extend(asked.map(|asked| Series::guide(format!("{asked} %"), vec![[asked, low], [asked, high]])));
    let alt = format!("{title} on a logarithmic axis, one row per condition of the camera");
    let frame = Frame::half(title, alt).with_plot_height(LINE_PX * lines.len() as f64);
    lines.reverse();
    Chart::new(frame, [Axis::log(axis), Axis::categories("", lines)], series).svg().map(Some)
}

/// Sentence on the camera's accuracy, the required accuracy, and the condition with the largest error.
fn says(camera: &CameraStudy, reference: &Reference) -> Option<String> {
    let row = camera.as_it_is()?;
    let worst = camera.worst()?;
    let costs = camera.rows.iter().filter_map(|row| Some((row, row.force_rms_error?)));
    let (most, largest) = costs.max_by(|(_, a), (_, b)| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal))?;
    let coarse =
        camera.rows.iter().filter(|row| row.item == "resolution" && row.found == row.markers && row.refused == 0);
    let enough =
        coarse.filter(|row| row.force_largest_error <= Some(ASKED_ERROR)).find(|row| row.force_largest_error.is_some());
    let least = ASKED_ERROR * reference.noise_mm / worst.noise_mm;
    let [error, asked, least, largest] = [row.force_rms_error?, ASKED_ERROR, least, largest].map(percent_two_digits);
    let enough = enough.map_or_else(String::new, |row| {
        format!(" At a resolution of {} no sensed force errs by more than {asked}.", row.setting)
    });
    let (rms_mm, largest_mm) = (row.displacement_rms_mm?, row.displacement_largest_mm?);
    let Reference { name, noise_mm, about } = reference;
    let (node, needed_mm, item, setting) = (worst.node, worst.noise_mm, most.item, setting(most));
    Some(format!(
        "In rendered images node displacements err by {rms_mm:.4} mm rms ({largest_mm:.4} mm at most), and forces sensed from these displacements by \
         {error} rms. At node {node}, the worst node except the tip, an error of {asked} requires noise below {needed_mm:.3} mm. The noise of {name} \
         ({about} {noise_mm} mm) causes an error of at least {least}. Among the tested conditions, \
         {item} ({setting}) causes the largest error: {largest}.{enough}"
    ))
}
