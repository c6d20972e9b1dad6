//! Measures of the difference between two results.

use finray_model::Kinematics;
use finray_model::frame::FrameMotion;
use finray_model::mesh::FingerShape;

/// Every kind of kinematics, for tests of a property that all kinds have.
pub const KINEMATICS: [Kinematics; 3] = [Kinematics::Linear, Kinematics::Corotational, Kinematics::CorotationalChord];

/// The largest of some magnitudes, or NaN if one magnitude is NaN; `f64::max` would ignore NaN.
fn worst(magnitudes: impl Iterator<Item = f64>) -> f64 {
    magnitudes.fold(0.0, |worst, next| if next.is_nan() || next > worst { next } else { worst })
}

/// The largest magnitude of some numbers, or NaN if one number is NaN.
pub fn largest<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> f64 {
    worst(numbers.into_iter().map(|number| number.abs()))
}

/// Largest difference between the displacements of a node in two motions of a frame, divided by the largest displacement of `reference`.
pub fn motions_apart(ours: &FrameMotion, reference: &FrameMotion) -> f64 {
    let pairs = ours.displacements.iter().zip(&reference.displacements);
    worst(pairs.map(|(a, b)| (a - b).norm())) / reference.largest_displacement()
}

/// Largest difference between the displacements of a key node in two shapes, divided by the largest displacement of `reference`.
pub fn shapes_apart(ours: &FingerShape, reference: &FingerShape) -> f64 {
    let pairs = ours.motions().iter().zip(reference.motions());
    worst(pairs.map(|(a, b)| (a.displacement - b.displacement).norm())) / reference.largest_displacement_mm()
}
