//! Run time and error of each solver and estimator.

use super::format::{NOTHING, list, or_nothing, percent, percent_two_digits, time};
use crate::prelude::*;
use finray_studies::experiments::speed_error::recommendation::{LARGEST_BIAS_SIGMAS, recommended, ways};
use finray_studies::experiments::speed_error::sensing::FRAMES_A_PERIOD;
use finray_studies::experiments::speed_error::{SpeedErrorPoint, Task, TimedBy};
use finray_studies::settings::TWO_FORCES_N;

const CSV: &str = "speed_error.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, &study.speed_error)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let points = &study.speed_error;
    if points.is_empty() {
        return Ok(None);
    }
    let (solved_n, sensed_n) = (study.checked_forces().drawn_n(), study.checked_forces().scaled(TWO_FORCES_N));
    let mut blocks = vec![text(about(solved_n, sensed_n, study.noise_mm))];
    blocks.extend(study.timing_notes.iter().map(text));
    if !points.iter().any(is_peer) {
        blocks.push(text(
            "Other programs were not timed. To add the times that bench/peers/peers.py writes, run finray report \
                --peers peers.csv.",
        ));
    }
    let floor = study.convergence.left(solved_n).filter(|left| *left > 0.0);
    for (task, title) in [
        (Task::Solve, "the shape under a load"),
        (Task::SenseOne, "one force from a frame"),
        (Task::SenseNeighbours, "two neighbouring forces from a frame"),
    ] {
        let points: Vec<&SpeedErrorPoint> = points.iter().filter(|point| point.task == task).collect();
        // An error of 0 has no position on a logarithmic axis.
        if points.iter().any(|point| point.error > 0.0) {
            let floor = if task == Task::Solve { floor } else { None };
            let svg = drawing(task, &points, title, floor)?;
            blocks.push(Block::Figure(Figure::wide(svg, format!("Time and error of {title}."), CSV)));
        }
    }
    blocks.push(details(format!("All {} points", points.len()), vec![Block::Table(table(points))]));
    let section = Section::new("speed-error", "What an answer costs", blocks);
    Ok(Some(section.saying(says(study).into_iter().chain(sensing(points)))))
}

/// Text on the forces and the noise of the timed tasks, and on which times are included.
fn about(solved_n: f64, sensed_n: [f64; 2], noise_mm: f64) -> String {
    let sensed_n = list(sensed_n, " to ");
    format!(
        "Each point shows the median time of one answer on one core, and the error of the answer. Shapes are \
            computed under {solved_n} N along the front plate in three directions, and compared with beams of 32 \
            elements per member. Forces of {sensed_n} N along the normal are sensed over {FRAMES_A_PERIOD} frames, \
            with {noise_mm} mm noise. A warm start begins at the previous frame's answer, a cold start at the \
            least-squares answer. Times for meshing, for preparing a contact and for the model error are not \
            included."
    )
}

/// A shape counts as accurate if its relative error is at most this value, which is also the tolerance of the paper's mesh of key nodes.
const GOOD_SHAPE: f64 = 0.01;

/// Sentence on three models of the finger: the fastest model that is accurate enough, the most accurate model, and the fastest model.
fn says(study: &Study) -> Option<String> {
    let points = study.speed_error.iter().filter(|point| point.task == Task::Solve && !is_peer(point));
    let points: Vec<&SpeedErrorPoint> = points.filter(|point| point.error.is_finite()).collect();
    let faster = |a: &&&SpeedErrorPoint, b: &&&SpeedErrorPoint| a.seconds.total_cmp(&b.seconds);
    let good = points.iter().filter(|point| point.error <= GOOD_SHAPE).min_by(faster)?;
    let nearest = points.iter().min_by(|a, b| a.error.total_cmp(&b.error))?;
    let fastest = points.iter().min_by(faster)?;
    let [good, nearest, fastest] = [good, nearest, fastest].map(|point| {
        let SpeedErrorPoint { model, seconds, error, .. } = point;
        format!("{model} ({}) in {}, error {}", setting(point), time(*seconds), percent_two_digits(*error))
    });
    let (force_n, good_shape) = (study.checked_forces().drawn_n(), percent(GOOD_SHAPE));
    Some(format!(
        "For the shape under {force_n} N, the fastest model with an error of at most {good_shape} is {good}. The \
            most accurate model is {nearest}. The fastest model is {fastest}."
    ))
}

/// Sentence on the time to sense one force with the recommended estimator, and with the fastest estimator.
fn sensing(points: &[SpeedErrorPoint]) -> Option<String> {
    let of = |point: &SpeedErrorPoint| {
        let (name, setting, seconds, error) = (name(point), setting(point), time(point.seconds), percent(point.error));
        format!("{name} ({setting}), takes {seconds} with a mean error of {error}")
    };
    let (way, all) = (recommended(points)?, ways(points));
    let fastest = all.iter().min_by(|a, b| a.one.seconds.total_cmp(&b.one.seconds))?;
    Some(format!(
        "To sense one force, the recommended estimator, {}; the fastest estimator, {}.",
        of(way.one),
        of(fastest.one)
    ))
}

fn is_peer(point: &SpeedErrorPoint) -> bool {
    matches!(point.timed_by, TimedBy::OtherProgram { .. })
}

/// Name of the model, with the program's name if the program is not finray.
fn name(point: &SpeedErrorPoint) -> String {
    match &point.timed_by {
        TimedBy::OtherProgram { program, .. } => format!("{program}: {}", point.model),
        _ => {
            let model = point.estimator.map_or(point.model.as_str(), |estimator| estimator.label());
            format!("{model}{}", point.start.suffix())
        }
    }
}

/// Mesh or other setting of a point. The text says `mesh nodes`, to distinguish them from the finger's key nodes.
pub(super) fn setting(point: &SpeedErrorPoint) -> String {
    point.mesh().replace(" nodes", " mesh nodes")
}

/// Coordinates of a point in the chart: time (microseconds) and error. Errors of forces are in percent.
fn place(point: &SpeedErrorPoint) -> [f64; 2] {
    [1e6 * point.seconds, if point.task == Task::Solve { 1.0 } else { 100.0 } * point.error]
}

/// Chart of error over time, one point per setting; labels state the number of failures.
pub fn drawing(
    task: Task,
    points: &[&SpeedErrorPoint],
    title: &str,
    floor: Option<f64>,
) -> Result<String, FigureError> {
    let drawn: Vec<&SpeedErrorPoint> =
        points.iter().copied().filter(|point| point.error > 0.0 && point.seconds > 0.0).collect();
    let mut series: Vec<Series> = Vec::new();
    for group in drawn.chunk_by(|a, b| name(a) == name(b)) {
        let one = Series::nth(series.len(), name(group[0]), group.iter().map(|point| place(point)).collect());
        // A point that is worse than another point in both time and error has a label only if some of its answers failed. The table names all points.
        let labels = group.iter().map(|point| match point.failed {
            0 if point.on_front => setting(point),
            0 => String::new(),
            failed => format!("{} ({failed} of {} failed)", setting(point), point.asked),
        });
        series.push(Series { labels: labels.collect(), dash: Dash::None, ..one });
    }
    let mut front: Vec<[f64; 2]> = drawn.iter().filter(|point| point.on_front).map(|point| place(point)).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    series.push(Series::guide("best trade-off", front));
    let alt = format!("Error of {title} against computation time, both axes logarithmic.");
    let y = Axis::log(if task == Task::Solve { "error / largest displacement" } else { "mean error, %" });
    let axes = [Axis::log("time of one answer, \u{b5}s"), y];
    let chart =
        Chart::new(Frame::full(format!("Time and error of {title}"), alt).with_plot_height(360.0), axes, series);
    chart.compared(floor.map(|left| (left, "uncertainty of the reference".to_owned()))).svg()
}

/// All points with their times, errors and failures.
pub fn table(points: &[SpeedErrorPoint]) -> Table {
    // Amber marks a value that is a disadvantage.
    let amber_if = |amber: bool, words: String| Cell { shade: amber.then_some(Shade::Amber), ..Cell::plain(words) };
    Columns::<&SpeedErrorPoint>::new()
        .page("answer", Format::Words, |point| match point.task {
            Task::Solve => "shape",
            Task::SenseOne => "one force",
            Task::SenseNeighbours => "two neighbours",
        })
        .page("model", Format::Words, |point| name(point))
        .page("setting", Format::Words, |point| setting(point))
        .page("time", Format::Plain, |point| time(point.seconds))
        .page("error", Format::Percent, |point| Some(point.error).filter(|error| error.is_finite()))
        .cells("model error", Format::Plain, move |point| {
            let words = or_nothing(point.bias_sigmas.map(|bias| format!("{bias:.2}")));
            amber_if(point.bias_sigmas > Some(LARGEST_BIAS_SIGMAS), words)
        })
        .cells("failed", Format::Plain, move |point| match point.asked {
            0 => Cell::plain(NOTHING),
            _ if point.failed == 0 => Cell::plain("0"),
            asked => amber_if(true, format!("{} of {asked}", point.failed)),
        })
        .page("timed by", Format::Words, |point| match point.timed_by {
            TimedBy::Report => String::new(),
            ref other => other.to_string(),
        })
        .table("Model error: largest error without noise, in standard deviations of the noise", CSV, points)
}
