//! Time against error: Pareto fronts, failures, test cases, and the recommended setting.

mod sensing;

use finray_model::estimators::EstimatorId;
use finray_studies::experiments::speed_error::criterion::{CriterionTimes, take_times};
use finray_studies::experiments::speed_error::recommendation::recommended;
use finray_studies::experiments::speed_error::{SpeedErrorPoint, Start, Task, TimedBy, asked, solved_point};
use finray_studies::settings::ReportForces;
use finray_tests::paper;

/// A point of the nonlinear estimator with warm start, on a mesh of `nodes` nodes.
pub fn point(task: Task, nodes: usize, seconds: f64, error: f64, bias_sigmas: f64) -> SpeedErrorPoint {
    SpeedErrorPoint {
        task,
        model: EstimatorId::Nonlinear.name().to_owned(),
        estimator: Some(EstimatorId::Nonlinear),
        setting: format!("{nodes} nodes{}", Start::Warm.suffix()),
        start: Start::Warm,
        seconds,
        seconds_95: Some(2.0 * seconds),
        preparation_seconds: Some(10.0 * seconds),
        error,
        bias_sigmas: Some(bias_sigmas),
        failed: 0,
        asked: 100,
        on_front: true,
        timed_by: TimedBy::Report,
    }
}

/// The recommendation excludes settings whose model error exceeds 0.4 standard deviations of the noise, and settings that refused a frame.
#[test]
fn a_setting_outside_its_stated_deviation_is_never_recommended() {
    let mut points = vec![
        point(Task::SenseOne, 25, 1e-5, 0.010, 3.0),
        point(Task::SenseOne, 61, 2e-5, 0.009, 0.5),
        point(Task::SenseOne, 133, 4e-5, 0.009, 0.1),
        point(Task::SenseOne, 277, 8e-5, 0.009, 0.05),
    ];
    let nodes = |points: &[SpeedErrorPoint]| recommended(points).map(|way| way.one.mesh().to_owned());
    assert_eq!(nodes(&points).as_deref(), Some("133 nodes"));
    points.push(point(Task::SenseNeighbours, 133, 4e-5, 0.05, 0.6));
    assert_eq!(nodes(&points).as_deref(), Some("277 nodes"), "neighbours count");
    points[3].failed = 1;
    assert_eq!(nodes(&points), None);
    // A network is never recommended, because it supports only the contacts of its training.
    let network =
        SpeedErrorPoint { estimator: Some(EstimatorId::Network), ..point(Task::SenseOne, 1, 1e-6, 0.009, 0.1) };
    assert_eq!(nodes(&[network]), None);
}

#[test]
fn the_front_is_what_nothing_beats() {
    let of = |seconds: f64, error: f64| SpeedErrorPoint {
        error,
        ..solved_point("", String::new(), vec![seconds], error, 1)
    };
    let mut points = [of(1.0, 1.0), of(2.0, 0.5), of(3.0, 0.6), of(1.0, 2.0), of(f64::NAN, 0.1)];
    // The first point is as fast as the fourth and has a smaller error, but the fourth has another task.
    points[3].task = Task::SenseOne;
    // Without times from the benchmark library `criterion`, `take_times` only marks the fronts.
    take_times(&mut points, &CriterionTimes::default());
    assert_eq!(points.map(|point| point.on_front), [true, true, false, true, false]);
}

#[test]
fn what_fails_is_counted_and_has_no_error() {
    let failed = solved_point("", String::new(), Vec::new(), 0.0, 3);
    assert!(failed.error.is_nan() && failed.seconds.is_nan() && failed.failed == 3);
}

/// `bench/peers` writes the same descriptions for the other programs, which solve the same tasks.
#[test]
fn what_is_asked_is_said() {
    let said = Task::ALL
        .map(|task| asked(&paper(), ReportForces::PAPER, task))
        .map(|asked| [asked.nodes, asked.forces_n].join(" at "));
    assert_eq!(said, ["14-24 at 3", "14-24 at 0.3-3", "19-20 at 0.3-3"]);
}
