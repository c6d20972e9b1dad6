//! Tests the report's maps on the lattice.

use super::shared::*;
use crate::kit::*;

/// The lattice is one of the simulated true fingers in the maps. On the lattice, least squares has nearly the same error as on the co-rotational
/// finger, and the nonlinear estimator has hardly any error.
#[test]
fn the_lattice_is_sensed_as_the_corotational_finger_is() {
    let cells = |name: &str| Csv::of(&PAPERS.read(name));
    let biases = |name: &str| {
        let cells = cells(name);
        let keys = cells.texts("s_mm").into_iter().zip(cells.texts("angle_deg")).zip(cells.texts("force_n"));
        let keys = keys.map(|((s_mm, angle_deg), force_n)| format!("{s_mm} {angle_deg} {force_n}"));
        keys.zip(cells.numbers("bias")).collect::<std::collections::HashMap<_, _>>()
    };
    let (ours, theirs) = (biases("map_lattice_without_noise.csv"), biases("map_corotational_without_noise.csv"));
    let apart = ours.iter().map(|(key, ours)| (ours - theirs[key]).abs()).fold(0.0, f64::max);
    let worst = cells("map_lattice_nonlinear_without_noise.csv").numbers("mean_error").into_iter().fold(0.0, f64::max);
    assert!(apart < 2e-3 && worst < 2e-3 && ours.values().any(|bias| bias.abs() > 0.1), "{apart} {worst}");
    assert!(PAPERS.pages().contains("id=\"lattice\"") && !SPRING_STEELS.pages().contains("id=\"lattice\""));
    assert!(array(&SPRING_STEELS.summary(), "lattice").is_empty());
}
