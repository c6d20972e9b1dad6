//! How results are compared.

use finray_model::Kinematics;
use finray_model::frame::FrameMotion;
use finray_model::mesh::FingerShape;

/// All kinematics, where one property holds for each.
pub const KINEMATICS: [Kinematics; 3] = [Kinematics::Linear, Kinematics::Corotational, Kinematics::CorotationalChord];

/// The largest of some magnitudes, or NaN where one is: `f64::max` would pass over it.
fn worst(magnitudes: impl Iterator<Item = f64>) -> f64 {
    magnitudes.fold(0.0, |worst, next| if next.is_nan() || next > worst { next } else { worst })
}

/// The largest magnitude among some numbers, or NaN where one is.
pub fn largest<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> f64 {
    worst(numbers.into_iter().map(|number| number.abs()))
}

/// Largest difference of a node's displacement between two motions of a frame, as a share of the reference's largest.
pub fn motions_apart(ours: &FrameMotion, reference: &FrameMotion) -> f64 {
    let pairs = ours.displacements.iter().zip(&reference.displacements);
    worst(pairs.map(|(a, b)| (a - b).norm())) / reference.largest_displacement()
}

/// Largest difference of a key node's displacement between two shapes, as a share of the reference's largest.
pub fn shapes_apart(ours: &FingerShape, reference: &FingerShape) -> f64 {
    let pairs = ours.motions().iter().zip(reference.motions());
    worst(pairs.map(|(a, b)| (a.displacement - b.displacement).norm())) / reference.largest_displacement_mm()
}
