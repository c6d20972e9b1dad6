//! Verdicts on the position error and the frame rate of the camera.

use crate::experiments::speed_error::point;
use finray_studies::claims::camera::{position_error, sensing_rate};
use finray_studies::claims::{ClaimVerdict, Words};
use finray_studies::experiments::camera::{AS_IT_IS, CameraRow, CameraStudy};
use finray_studies::experiments::speed_error::{SpeedErrorPoint, Task};

fn verdict(camera: Option<&CameraStudy>) -> ClaimVerdict {
    let words = Words::shipped().expect("words of the claims");
    position_error(camera, &words).expect("all numbers").verdict
}

fn with(largest_mm: f64, found: usize) -> ClaimVerdict {
    let row = CameraRow {
        item: AS_IT_IS,
        setting: "",
        in_images: true,
        is_rest_seen: false,
        markers: 46,
        found,
        displacement_rms_mm: Some(0.001),
        displacement_largest_mm: Some(largest_mm),
        stated_mm: Some(0.001),
        forces: 2,
        refused: 0,
        force_rms_error: Some(0.001),
        force_largest_error: Some(0.001),
        first_order_rms_error: Some(0.001),
    };
    let study = CameraStudy {
        rows: vec![row],
        force_n: 1.5,
        nodes: Vec::new(),
        needed: Vec::new(),
        size_px: [1600, 1400],
        px_a_mm: Some(8.0),
        times: None,
    };
    verdict(Some(&study))
}

#[test]
fn a_marker_that_is_lost_or_far_off_betters_nothing() {
    assert_eq!(with(0.004, 46), ClaimVerdict::LessInSimulation);
    assert_eq!(with(0.15, 46), ClaimVerdict::NotReproduced);
    assert_eq!(with(0.004, 45), ClaimVerdict::NotReproduced);
    assert_eq!(verdict(None), ClaimVerdict::NotTested);
}

/// A frame rate that excludes vision never counts as better than a rate that includes vision.
#[test]
fn a_rate_without_vision_is_not_better() {
    let words = Words::shipped().expect("words of the claims");
    let rate = |points: &[SpeedErrorPoint]| sensing_rate(points, None, &words).expect("all numbers");
    let fast = rate(&[point(Task::SenseOne, 133, 1e-4, 0.01, 0.1)]);
    assert_eq!(fast.verdict, ClaimVerdict::NotTested);
    assert!(
        fast.ours.contains("0.10 ms a frame (0.25 % of 40 ms, 95 % within 0.20 ms)") && fast.how.contains("not tested"),
        "{fast:?}"
    );
    let slow = rate(&[point(Task::SenseOne, 133, 0.05, 0.01, 0.1)]);
    assert_eq!(slow.verdict, ClaimVerdict::Refuted);
    let biased = rate(&[point(Task::SenseOne, 25, 1e-4, 0.01, 3.0)]);
    assert_eq!((biased.verdict, biased.ours.as_str()), (ClaimVerdict::NotTested, "-"));
}
