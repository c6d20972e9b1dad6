//! Verdicts on the position error of the camera.

use finray_studies::claims::camera::position_error;
use finray_studies::claims::{ClaimVerdict, Words};
use finray_studies::experiments::camera::{AS_IT_IS, CameraRow, CameraStudy};

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
