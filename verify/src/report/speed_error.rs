//! What an answer costs, and how far it is off.

use super::ReportError;
use super::figures::{self, Axis, Dash, FigureError, Frame, Hue, LineChart, Reference, Series};
use super::page::{Block, Cell, Column, Figure, Row, Section, Shade, Table};
use super::sections::{self, text};
use super::tables::percent;
use crate::speed_error::{SENSED_N, SOLVED_N, SpeedErrorPoint, Task};
use crate::study::Study;

pub(super) const CSV: &str = "speed_error.csv";

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    let points = &study.speed_error;
    if points.is_empty() {
        return Ok(None);
    }
    let mut blocks = vec![text(format!(
        "Time of one answer, timed by this report on one core (median; what is prepared once for a finger, a mesh or a contact is not \
         counted), against its error. Shapes: under {SOLVED_N} N at nodes along the front plate in three directions, worst difference of a displacement from \
         beams of 32 elements a member. Forces: {} to {} N from pictures of the large-rotation finger with {} mm noise, mean error. The dotted line \
         joins what nothing else beats in both. Criterion's benches (cargo bench -p finray-bench) time the same steps more closely; other programs were \
         not timed.",
        SENSED_N[0], SENSED_N[1], study.noise_mm
    ))];
    let floor = study.convergence.left(SOLVED_N).filter(|left| *left > 0.0);
    for (task, title) in [
        (Task::Solve, "the shape under a load"),
        (Task::SenseOne, "one force from a picture"),
        (Task::SenseNeighbours, "two neighbouring forces from a picture"),
    ] {
        let points: Vec<&SpeedErrorPoint> = points.iter().filter(|point| point.task == task).collect();
        // An error of nothing has no place on a logarithmic axis.
        if points.iter().any(|point| point.error > 0.0) {
            let floor = if task == Task::Solve { floor } else { None };
            blocks.push(Block::Figure(Figure {
                svg: picture(&points, title, floor)?,
                caption: format!("Time and error of {title}."),
                csv: Some(CSV.to_owned()),
                wide: true,
            }));
        }
    }
    blocks.push(Block::Table(table(points)));
    Ok(Some(sections::section("speed-error", "What an answer costs", blocks)))
}

fn in_words(task: Task) -> &'static str {
    match task {
        Task::Solve => "shape",
        Task::SenseOne => "one force",
        Task::SenseNeighbours => "two neighbours",
    }
}

fn place(point: &SpeedErrorPoint) -> [f64; 2] {
    [1e6 * point.seconds, 100.0 * point.error]
}

fn picture(points: &[&SpeedErrorPoint], title: &str, floor: Option<f64>) -> Result<String, FigureError> {
    let drawn: Vec<&SpeedErrorPoint> =
        points.iter().copied().filter(|point| point.error > 0.0 && point.seconds > 0.0).collect();
    let mut series: Vec<Series> = Vec::new();
    for group in drawn.chunk_by(|a, b| a.model == b.model) {
        let one = Series::nth(series.len(), group[0].model.clone(), group.iter().map(|point| place(point)).collect());
        let labels = group.iter().map(|point| match point.failed {
            0 => point.setting.clone(),
            failed => format!("{} ({failed} of {} failed)", point.setting, point.asked),
        });
        series.push(Series { labels: labels.collect(), dash: None, ..one });
    }
    let mut front: Vec<[f64; 2]> = drawn.iter().filter(|point| point.on_front).map(|point| place(point)).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    series.push(Series {
        hue: Hue::Neutral,
        dash: Some(Dash::Dotted),
        marker: None,
        ..Series::nth(0, "nothing is faster and nearer", front)
    });
    let references =
        floor.map(|left| Reference { value: 100.0 * left, label: "may be left in the reference".to_owned() });
    figures::lines(&LineChart {
        frame: Frame::full("", format!("Error of {title} over the time that it takes, both axes logarithmic."))
            .with_plot_height(360.0),
        x: Axis::log("time of one answer, us"),
        y: Axis::log(if title.contains("shape") { "error / largest displacement, %" } else { "mean error, %" }),
        series,
        references: references.into_iter().collect(),
    })
}

fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.3} us", 1e6 * s),
        s if s < 1.0 => format!("{:.3} ms", 1e3 * s),
        s => format!("{s:.2} s"),
    }
}

fn table(points: &[SpeedErrorPoint]) -> Table {
    let row = |point: &SpeedErrorPoint| {
        let failed = format!("{} of {}", point.failed, point.asked);
        Row {
            cells: vec![
                Cell::plain(in_words(point.task)),
                Cell::plain(point.model.clone()),
                Cell::plain(point.setting.clone()),
                Cell::plain(seconds(point.seconds)),
                Cell::plain(percent(point.error)),
                if point.failed > 0 { Cell::shaded(failed, Shade::Grey) } else { Cell::plain(failed) },
                if point.on_front { Cell::shaded("yes", Shade::Pass) } else { Cell::plain("") },
            ],
        }
    };
    Table {
        caption: "Time and error of every model and estimator".to_owned(),
        columns: vec![
            Column::words("answer"),
            Column::words("model"),
            Column::words("setting"),
            Column::numbers("time"),
            Column::numbers("error"),
            Column::numbers("failed"),
            Column::words("unbeaten"),
        ],
        rows: points.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(model: &str, seconds: f64, error: f64, failed: usize) -> SpeedErrorPoint {
        SpeedErrorPoint {
            task: Task::Solve,
            model: model.to_owned(),
            setting: format!("{model} set"),
            seconds,
            error,
            failed,
            asked: 5,
            on_front: failed == 0,
        }
    }

    #[test]
    fn every_point_is_named_and_failures_are_marked() {
        let points = [point("beams", 1e-5, 1e-2, 0), point("lattice", 1e-2, 1e-4, 2), point("exact", 1e-6, 0.0, 0)];
        let svg = picture(&points.each_ref(), "the shape under a load", Some(1e-6)).unwrap();
        for words in [">beams set<", ">lattice set (2 of 5 failed)<", "may be left"] {
            assert!(svg.contains(words), "{words}");
        }
        assert!(!svg.contains("exact set"), "an error of nothing has no place");
        let rows = table(&points).rows;
        assert_eq!(rows[1].cells[5], Cell::shaded("2 of 5", Shade::Grey));
        assert_eq!(rows[0].cells[3].text, "10.000 us");
    }
}
