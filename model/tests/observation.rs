//! Conversion of observations to measurements: the noise of the markers, and markers on clamped nodes.

mod pose_errors;

use finray_model::measurement::MarkerErrors;
use finray_model::observation::{EstimatedNoise, Observation, ObservationError, ObservedMarker};
use finray_model::{Finger, NodeId, Scene, Vector};
use finray_tests::{case_count, random_stream};
use rand::RngExt;

/// The paper's finger with these errors of its markers.
fn scene(marker_errors: MarkerErrors) -> Scene {
    Scene { marker_errors, ..Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene") }
}

/// All free markers at rest, each with the standard deviation that `sd_mm` states, and a clamped marker that moved by `moved_mm`.
fn observed(finger: &Finger, moved_mm: f64, sd_mm: impl Fn(NodeId) -> Option<f64>) -> Observation {
    let [clamped, _] = finger.clamped_nodes();
    let free = finger.free_nodes().map(|node| (node, Vector::zeros()));
    let markers = free.chain([(clamped, Vector::new(0.0, moved_mm))]).map(|(node, displacement)| ObservedMarker {
        sd_mm: sd_mm(node),
        ..ObservedMarker::displaced(node, displacement)
    });
    Observation { markers: markers.collect(), ..Observation::default() }
}

/// A clamped marker may move by six standard deviations and by 0.05 mm. The standard deviation is the stated noise or, without it, that of the marker,
/// times the noise factor, together with the calibration error. A stated noise replaces those of the markers, smaller or larger, and applies to all.
#[test]
fn noise_of_free_and_clamped_markers_includes_the_errors_of_the_scene() {
    for case in 0..case_count(60, 600) as u64 {
        let mut chance = random_stream(472, case);
        let errors = MarkerErrors {
            noise_factor: chance.random_range(0.2..5.0),
            calibration_error_mm: chance.random_range(0.0..0.2),
            ..MarkerErrors::default()
        };
        let scene = scene(errors);
        let [of_marker_mm, stated_mm] = [(); 2].map(|()| chance.random_range(0.005..0.2));
        for stated in [None, Some(stated_mm)] {
            let sd_mm = stated.unwrap_or(of_marker_mm);
            let with_errors_mm = ((errors.noise_factor * sd_mm).powi(2) + errors.calibration_error_mm.powi(2)).sqrt();
            let largest_mm = (6.0 * with_errors_mm).max(0.05);
            let sense = |moved_mm: f64| {
                observed(&scene.finger, moved_mm, |_| Some(of_marker_mm)).for_sensing(&scene, true, stated)
            };
            let found = sense(0.99 * largest_mm).expect("within noise");
            let noise_mm = found.marker_noise_mm.expect("stated");
            assert!((noise_mm / with_errors_mm - 1.0).abs() < 1e-12, "{noise_mm} {with_errors_mm}");
            assert!(found.measurement.markers().iter().all(|marker| (marker.weight - 1.0).abs() < 1e-12));
            assert!(matches!(sense(1.01 * largest_mm), Err(ObservationError::Marker { .. })), "{errors:?} {stated:?}");
        }
    }
}

/// A stated noise gives all markers the same weight, although the markers state different standard deviations; zero noise, too.
#[test]
fn a_stated_noise_applies_to_all_markers() {
    let scene = scene(MarkerErrors::default());
    let seen = observed(&scene.finger, 0.0, |node| Some(0.01 * node.0 as f64));
    let weights = |stated: Option<f64>| -> Vec<f64> {
        let found = seen.for_sensing(&scene, true, stated).expect("fits");
        found.measurement.markers().iter().map(|marker| marker.weight).collect()
    };
    assert!(weights(Some(0.05)).iter().chain(&weights(Some(0.0))).all(|weight| *weight == 1.0));
    let own = weights(None);
    assert!((own[0] / own[9] - 11.0 / 2.0).abs() < 1e-12, "{own:?}");
}

/// Two images with the same noise have its degrees of freedom, because their estimates err alike, and sqrt(2) of its shared error. An image without
/// compression adds variance that is known.
#[test]
fn the_noise_of_two_images_is_that_of_their_difference() {
    let noise = EstimatedNoise { degrees_of_freedom: 9.0, shared_sd_mm: 0.02 };
    let of_two = EstimatedNoise::of_difference([(Some(noise), 0.3), (Some(noise), 0.3)]).expect("estimated");
    assert!((of_two.degrees_of_freedom - 9.0).abs() < 1e-12);
    assert!((of_two.shared_sd_mm - 0.02 * 2.0_f64.sqrt()).abs() < 1e-15);
    // Half of the variance is known: the relative standard deviation halves, and the degrees of freedom are four times as many.
    let of_one = EstimatedNoise::of_difference([(None, 0.3), (Some(noise), 0.3)]).expect("estimated");
    assert!((of_one.degrees_of_freedom - 36.0).abs() < 1e-12 && of_one.shared_sd_mm == 0.02);
    assert_eq!(EstimatedNoise::of_difference([(Some(noise), 0.3), (None, 0.0)]), Some(noise));
    assert_eq!(EstimatedNoise::of_difference([(None, 0.3), (None, 0.3)]), None);
}
