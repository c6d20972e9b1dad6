//! From camera to force: effect of each camera condition on the marker positions, mm, and on the sensed force.

use super::format::percent_two_digits;
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
    let [width, height] = camera.size_px;
    let numbers = context! {
        force_n => camera.force_n, width, height, scale => camera.px_a_mm, is_assumed => study.is_paper,
        nodes => camera.nodes.iter().map(|node| node.0).collect::<Vec<_>>(),
    };
    let mut blocks = vec![paragraph("camera.about", numbers)?];
    if let Some(FrameTimes { search_s, track_s }) = camera.times {
        blocks.push(paragraph("camera.times", context! { search_ms => 1e3 * search_s, track_ms => 1e3 * track_s })?);
    }
    let drawings: [(_, _, CameraQuantity); 2] = [
        ("Errors of displacements", "rms error of a coordinate, mm", |row| row.displacement_rms_mm),
        ("Errors of forces", "rms error of the force, %", |row| row.force_rms_error.map(|error| 100.0 * error)),
    ];
    let papers = [Some(CAMERA_NOISE_MM), camera.bound_rms(CAMERA_NOISE_MM).map(|error| 100.0 * error)];
    let asked = [None, Some(100.0 * ASKED_ERROR)];
    for (((title, axis, of), papers), asked) in drawings.into_iter().zip(papers).zip(asked) {
        if let Some(svg) = drawing(camera, (title, axis), of, papers, asked)? {
            let caption = format!("{title}, one row per condition of the camera.");
            blocks.push(Block::Figure(Figure::narrow(svg, caption, CSV)));
        }
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
    blocks.push(details("By condition", vec![Block::Table(columns.table(caption, CSV, &camera.rows))]));
    let needed = Columns::<&NeededNoise>::new().page("node", Format::Plain, |needed| needed.node.0).page(
        "noise, mm",
        Format::Fixed(4),
        |needed| needed.noise_mm,
    );
    let caption =
        format!("Noise of a coordinate at which {} N errs by {}", camera.force_n, percent_two_digits(ASKED_ERROR));
    blocks.push(Block::Table(needed.table(caption, NEEDED_CSV, &camera.needed)));
    Ok(Some(Section::new("camera", "From camera to force", blocks).saying(say("camera.says", in_words(camera))?)))
}

fn setting(row: &CameraRow) -> String {
    if row.is_rest_seen { format!("{}, image at rest", row.setting) } else { row.setting.to_owned() }
}

/// Reads a numeric column of the table from a row.
type CameraQuantity = fn(&CameraRow) -> Option<f64>;

/// Label of a row of the drawing. Camera conditions share a row if they differ only in the undeformed positions to which displacements refer.
fn line(row: &CameraRow) -> String {
    if row.item == AS_IT_IS { row.item.to_owned() } else { format!("{}: {}", row.item, row.setting) }
}

/// Chart of the errors, one row per condition, the paper's camera last. `None` if no error can be drawn on a logarithmic axis.
fn drawing(
    camera: &CameraStudy,
    (title, axis): (&str, &str),
    of: CameraQuantity,
    papers: Option<f64>,
    asked: Option<f64>,
) -> Result<Option<String>, FigureError> {
    // Rows are sorted so that conditions that vary the same property are adjacent.
    let first = |item: &str| camera.rows.iter().position(|row| row.item == item);
    let mut rows: Vec<&CameraRow> = camera.rows.iter().collect();
    rows.sort_by_key(|row| first(row.item));
    let mut lines: Vec<String> = rows.into_iter().map(line).collect();
    lines.dedup();
    lines.push("the paper's camera".to_owned());
    // Position of a row on the axis, which counts from the bottom.
    let at = |name: &str| (lines.len() - 1 - lines.iter().position(|other| other == name).unwrap_or(0)) as f64;
    let points = |is_rest_seen: bool| -> Vec<Point> {
        let rows = camera.rows.iter().filter(|row| row.is_rest_seen == is_rest_seen);
        let drawn = rows.filter_map(|row| Some([of(row).filter(|error| *error > 0.0)?, at(&line(row))]));
        drawn.collect()
    };
    let papers = papers.map(|papers| [papers, 0.0]).into_iter().collect();
    let named = [
        ("counted from the scene", points(false)),
        ("counted from an image at rest", points(true)),
        ("independent noise", papers),
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

/// Numbers for the sentence on the camera's accuracy, the required accuracy, and the condition with the largest error.
fn in_words(camera: &CameraStudy) -> Option<Value> {
    let row = camera.as_it_is()?;
    let worst = camera.worst()?;
    let costs = camera.rows.iter().filter(|row| row.force_rms_error.is_some());
    let most =
        costs.max_by(|a, b| a.force_rms_error.partial_cmp(&b.force_rms_error).unwrap_or(std::cmp::Ordering::Equal))?;
    let coarse =
        camera.rows.iter().filter(|row| row.item == "resolution" && row.found == row.markers && row.refused == 0);
    let enough =
        coarse.filter(|row| row.force_largest_error <= Some(ASKED_ERROR)).find(|row| row.force_largest_error.is_some());
    Some(context! {
        rms_mm => row.displacement_rms_mm?,
        largest_mm => row.displacement_largest_mm?,
        error => row.force_rms_error?,
        asked => ASKED_ERROR,
        node => worst.node.0,
        needed_mm => worst.noise_mm,
        paper_mm => CAMERA_NOISE_MM,
        papers => ASKED_ERROR * CAMERA_NOISE_MM / worst.noise_mm,
        most => context! { item => most.item, setting => setting(most), error => most.force_rms_error? },
        enough => enough.map(|row| row.setting),
    })
}
