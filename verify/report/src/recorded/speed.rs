//! Time and error of each solver and estimator, which the bench `speed_error` records.

use super::{Recorded, Row, number, section};
use crate::format::time;
use crate::prelude::*;

pub(super) const CSV: &str = "speed_error.csv";
const TASKS: [(&str, &str); 3] = [
    ("solve", "the shape under a load"),
    ("sense-one", "one force from a frame"),
    ("sense-neighbours", "two neighbouring forces from a frame"),
];
/// Largest model error of a setting whose stated intervals hold, in standard deviations of the noise; see the bench.
const LARGEST_BIAS_SIGMAS: f64 = 0.4;

/// Median time in which an estimator senses one force of the paper's finger, s: with the smallest time among settings with a small model error, if
/// there are any.
pub(crate) fn seconds(estimator: EstimatorId) -> Option<f64> {
    let all = Recorded::of(CSV).ok()?;
    let is_asked = |row: &Row| {
        is_ours(row) && row["task"].in_words() == "sense-one" && row["model"].in_words() == estimator.name()
    };
    let all = all.keeping(|row| is_asked(row) && row["start"].in_words() != "cold");
    let least = |holds: &dyn Fn(&Row) -> bool| {
        all.rows.iter().filter(|row| holds(row)).filter_map(|row| number(row, "seconds")).reduce(f64::min)
    };
    least(&|row| number(row, "bias_sigmas") <= Some(LARGEST_BIAS_SIGMAS)).or_else(|| least(&|_| true))
}

fn is_ours(row: &Row) -> bool {
    row["timed_by"].in_words() == "criterion"
}

/// Name of the model, with its start, and with the program's name if the program is not finray.
fn name(row: &Row) -> String {
    match (row["start"].in_words().as_str(), is_ours(row)) {
        ("none", true) => row["model"].in_words(),
        (start, true) => format!("{}, {start} start", row["model"].in_words()),
        (_, false) => format!("{}: {}", row["timed_by"].in_words(), row["model"].in_words()),
    }
}

/// Mesh or other setting. The text says `mesh nodes`, to distinguish them from the finger's key nodes.
fn setting(row: &Row) -> String {
    row["setting"].in_words().replace(" nodes", " mesh nodes")
}

/// Time (microseconds) and error (shapes: relative, forces: percent) of a row with an error above 0, which a logarithmic axis can show.
fn point(row: &Row) -> Option<Point> {
    let scale = if row["task"].in_words() == "solve" { 1.0 } else { 100.0 };
    Some([1e6 * number(row, "seconds")?, scale * number(row, "error").filter(|error| *error > 0.0)?])
}

/// Chart of error over time, one point per setting, with the front of finray's points that no other point beats in both.
fn drawing(rows: &[&Row], title: &str, axis: &str) -> Result<String, FigureError> {
    let ours: Vec<Point> = rows.iter().filter(|row| is_ours(row)).filter_map(|row| point(row)).collect();
    let on_front = |at: &Point| !ours.iter().any(|by| by != at && by[0] <= at[0] && by[1] <= at[1]);
    let mut series: Vec<Series> = Vec::new();
    for group in rows.chunk_by(|a, b| name(a) == name(b)) {
        let drawn: Vec<(Point, &Row)> = group.iter().filter_map(|row| Some((point(row)?, *row))).collect();
        // A program of which only the time is known has no point.
        if drawn.is_empty() {
            continue;
        }
        let label = |(at, row): &(Point, &Row)| match number(row, "failed") {
            Some(failed) if failed > 0.0 => {
                format!("{} ({failed} of {} failed)", setting(row), row["asked"].in_words())
            }
            _ if on_front(at) && is_ours(row) => setting(row),
            _ => String::new(),
        };
        let labels = drawn.iter().map(label).collect();
        let one = Series::nth(series.len(), name(group[0]), drawn.iter().map(|(at, _)| *at).collect());
        series.push(Series { labels, dash: Dash::None, ..one });
    }
    let mut front: Vec<Point> = ours.iter().copied().filter(on_front).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    series.push(Series::guide("best trade-off", front));
    let alt = format!("Error of {title} against computation time, both axes logarithmic.");
    let frame = Frame::full(format!("Time and error of {title}"), alt).with_plot_height(360.0);
    Chart::new(frame, [Axis::log("time of one answer, \u{b5}s"), Axis::log(axis)], series).svg()
}

pub(crate) fn speed(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["speed-error", "What an answer costs"], || {
        let all = Recorded::of(CSV)?;
        let mut blocks = Vec::new();
        for (task, title) in TASKS {
            let rows: Vec<&Row> = all.rows.iter().filter(|row| row["task"].in_words() == task).collect();
            let axis = if task == "solve" { "error / largest displacement" } else { "mean error, %" };
            blocks.push(Block::Figure(Figure::wide(
                drawing(&rows, title, axis)?,
                format!("Time and error of {title}."),
                CSV,
            )));
        }
        let columns = Columns::<&Row>::new()
            .page("answer", Format::Words, |row| row["task"].clone())
            .page("model", Format::Words, |row| name(row))
            .page("setting", Format::Words, |row| setting(row))
            .page("time", Format::Plain, |row| number(row, "seconds").map(time))
            .page("95 % within", Format::Plain, |row| number(row, "seconds_95").map(time))
            .page("preparation", Format::Plain, |row| number(row, "preparation_seconds").map(time))
            .page("error", Format::Percent, |row| number(row, "error"))
            .cells("model error", Format::Plain, |row| match number(row, "bias_sigmas") {
                Some(bias) => Cell {
                    shade: (bias > LARGEST_BIAS_SIGMAS).then_some(Shade::Amber),
                    ..Cell::plain(format!("{bias:.2}"))
                },
                None => Cell::plain(""),
            })
            .page("failed", Format::Plain, |row| row["failed"].clone())
            .page("machine", Format::Words, |row| row["machine"].clone());
        let caption = "Model error: largest error without noise, in standard deviations of the noise";
        let count = format!("All {} points", all.rows.len());
        blocks.push(details(count, vec![Block::Table(columns.table(caption, CSV, &all.rows))]));
        Ok(blocks)
    })
}
