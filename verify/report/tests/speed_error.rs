//! Tests of the chart of error over time: every point has a name, and failures are marked.

use finray_report::page::{Cell, Shade};
use finray_report::speed_error::{drawing, table};
use finray_studies::experiments::speed_error::{SpeedErrorPoint, Start, Task, TimedBy};

fn point(model: &str, seconds: f64, error: f64, failed: usize) -> SpeedErrorPoint {
    SpeedErrorPoint {
        task: Task::Solve,
        model: model.to_owned(),
        estimator: None,
        setting: format!("{model} set"),
        start: Start::None,
        seconds,
        seconds_95: Some(2.0 * seconds),
        preparation_seconds: None,
        error,
        bias_sigmas: None,
        failed,
        asked: 5,
        on_front: failed == 0,
        timed_by: TimedBy::Report,
    }
}

#[test]
fn every_point_is_named_and_failures_are_marked() {
    let points = [point("beams", 1e-5, 1e-2, 0), point("lattice", 1e-2, 1e-4, 2), point("exact", 1e-6, 0.0, 0)];
    let svg = drawing(Task::Solve, &points.each_ref(), "the shape under a load", Some(1e-6)).unwrap();
    for words in [">beams set<", ">lattice set (2 of 5 failed)<", "uncertainty"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(!svg.contains("exact set"), "an error of nothing has no place");
    let rows = table(&points).rows;
    assert_eq!(rows[1][6], Cell::shaded("2 of 5", Shade::Amber));
    assert_eq!([3, 4, 7].map(|cell| rows[0][cell].text.as_str()), ["10.0 \u{b5}s", "1.0 %", ""]);
}
