//! From camera to force: what each property of the camera costs in millimetres, and these in the force.

use super::dataset::{Columns, Dataset, Format};
use super::format::{nodes_in_words, percent_two_digits};
use super::page::{Block, Figure, Section, text};
use super::{ReportError, Results};
use crate::experiments::camera::{ASKED_ERROR, CameraRow, CameraStudy, FORCE_N, NeededNoise};
use crate::figures::{Axis, Chart, Dash, FigureError, Frame, Series};
use crate::settings::CAMERA_NOISE_MM;

const CSV: &str = "camera.csv";
const NEEDED_CSV: &str = "camera_needed.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![
        Dataset::records(CSV, study.camera.iter().flat_map(|camera| &camera.rows)),
        Dataset::records(NEEDED_CSV, study.camera.iter().flat_map(|camera| &camera.needed)).csv_alone(),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(camera) = &study.camera else { return Ok(None) };
    let [width, height] = camera.size_px;
    let assumed = match study.is_paper {
        true => " Its focal length, colours and light are assumed: the paper gives the image's size and the distance.",
        false => "",
    };
    let mut blocks = vec![text(format!(
        "In simulation: {FORCE_N} N along the normal at {} in turn, seen in a rendered image of {width} x {height} px ({:.1} px a mm), found \
         in it, and sensed by the nonlinear estimator with the beams that bent the finger.{assumed} What the camera is only taken for (lens, \
         pose, height) is projected without an image.",
        nodes_in_words(&camera.nodes.iter().map(|node| node.0).collect::<Vec<_>>()),
        camera.px_a_mm,
    ))];
    if camera.rows.iter().any(is_drawn) {
        blocks.push(Block::Figure(Figure {
            svg: drawing(camera)?,
            caption: "Errors of displacements and of the forces sensed from them, one point a condition.".to_owned(),
            csv: Some(CSV.to_owned()),
            wide: true,
        }));
    }
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
    let caption = "Error of a displacement's coordinate (rms, largest, as stated) and of the force (rms over the nodes, largest, and rms to first \
                   order from the errors of the displacements)";
    blocks.push(Block::Table(columns.table(caption, CSV, &camera.rows)));
    let needed = Columns::<&NeededNoise>::new().page("node", Format::Plain, |needed| needed.node.0).page(
        "noise, mm",
        Format::Fixed(4),
        |needed| needed.noise_mm,
    );
    let caption = format!("Noise of a coordinate at which {FORCE_N} N errs by {}", percent_two_digits(ASKED_ERROR));
    blocks.push(Block::Table(needed.table(caption, NEEDED_CSV, &camera.needed)));
    Ok(Some(Section::new("camera", "From camera to force", blocks).saying(in_words(camera))))
}

fn setting(row: &CameraRow) -> String {
    if row.is_rest_seen { format!("{}, image at rest", row.setting) } else { row.setting.to_owned() }
}

/// Both errors have a place on logarithmic axes.
fn is_drawn(row: &CameraRow) -> bool {
    place(row).is_some_and(|place| place.iter().all(|x| *x > 0.0))
}

/// Millimetres and percent.
fn place(row: &CameraRow) -> Option<[f64; 2]> {
    Some([row.displacement_rms_mm?, 100.0 * row.force_rms_error?])
}

fn drawing(camera: &CameraStudy) -> Result<String, FigureError> {
    let drawn: Vec<&CameraRow> = camera.rows.iter().filter(|row| is_drawn(row)).collect();
    let mut items: Vec<&str> = Vec::new();
    for row in &drawn {
        if !items.contains(&row.item) {
            items.push(row.item);
        }
    }
    let series = items.iter().enumerate().map(|(n, item)| {
        let of_item: Vec<&&CameraRow> = drawn.iter().filter(|row| row.item == *item).collect();
        let points = of_item.iter().filter_map(|row| place(row)).collect();
        let labels = of_item.iter().map(|row| setting(row)).collect();
        Series { labels, dash: Dash::None, ..Series::nth(n, *item, points) }
    });
    let mut series: Vec<Series> = series.collect();
    // Where independent errors of a coordinate lead at the worst node, over the whole figure.
    if let Some(worst) = camera.worst() {
        let places = drawn.iter().filter_map(|row| place(row)).map(|place| place[0]);
        let [low, high] =
            [f64::min, f64::max].map(|of| places.clone().chain([CAMERA_NOISE_MM]).fold(CAMERA_NOISE_MM, of));
        let at = |mm: f64| [mm, 100.0 * ASKED_ERROR * mm / worst.noise_mm];
        series.push(Series::guide(format!("independent noise, node {}", worst.node), vec![at(low), at(high)]));
        let papers = Series::guide("the paper's camera, 0.067 mm", vec![at(CAMERA_NOISE_MM)]);
        series.push(Series { labels: vec!["0.2 mm at worst".to_owned()], ..papers });
    }
    let alt = "Error of the sensed force over the error of the displacements, both axes logarithmic, a point a condition of the camera";
    let frame = Frame::full("What the camera's errors cost", alt).with_plot_height(400.0);
    let axes = [Axis::log("rms error of a displacement's coordinate, mm"), Axis::log("rms error of the force, %")];
    Chart::new(frame, axes, series).compared([(100.0 * ASKED_ERROR, percent_two_digits(ASKED_ERROR))]).svg()
}

/// What the camera reaches, what it needs, and what costs most.
fn in_words(camera: &CameraStudy) -> Option<String> {
    let row = camera.as_it_is()?;
    let worst = camera.worst()?;
    let found = format!(
        "In rendered images node displacements err by {:.4} mm rms ({:.4} mm at most), and forces sensed from them by {} rms.",
        row.displacement_rms_mm?,
        row.displacement_largest_mm?,
        percent_two_digits(row.force_rms_error?),
    );
    let needed = format!(
        "{} at the worst node ({}) needs {:.4} mm; the paper's camera (0.2 mm at worst, {CAMERA_NOISE_MM} mm as a standard deviation) gives {}.",
        percent_two_digits(ASKED_ERROR),
        worst.node,
        worst.noise_mm,
        percent_two_digits(ASKED_ERROR * CAMERA_NOISE_MM / worst.noise_mm),
    );
    let costs = camera.rows.iter().filter(|row| row.force_rms_error.is_some());
    let most =
        costs.max_by(|a, b| a.force_rms_error.partial_cmp(&b.force_rms_error).unwrap_or(std::cmp::Ordering::Equal))?;
    let most = format!(
        "Of what was tried, {} ({}) costs most: {}.",
        most.item,
        setting(most),
        percent_two_digits(most.force_rms_error?),
    );
    let coarse =
        camera.rows.iter().filter(|row| row.item == "resolution" && row.found == row.markers && row.refused == 0);
    let enough =
        coarse.filter(|row| row.force_largest_error <= Some(ASKED_ERROR)).find(|row| row.force_largest_error.is_some());
    let enough = enough.map_or_else(String::new, |row| {
        format!(" With {} no sensed force errs by more than {}.", row.setting, percent_two_digits(ASKED_ERROR))
    });
    Some(format!("{found} {needed} {most}{enough}"))
}
