//! The chord of a beam (the straight line between its two ends), and deformations relative to the chord.

use super::{Beam, ElementMatrix, ElementVector, EndMotion};
use crate::number::{Number, arctangent};
use nalgebra::{SMatrix, Vector2, Vector3};
use std::f64::consts::PI;

/// Natural deformations: elongation of the chord (mm), and rotations of the first and second end relative to the chord (rad).
pub(crate) type Deformation<R = f64> = Vector3<R>;

/// The chord of a beam in its current position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord<R = f64> {
    /// Unit vector along the chord, from the first to the second end.
    pub along: Vector2<R>,
    /// Unit vector across the chord: `along` rotated by +90 degrees.
    pub across: Vector2<R>,
    /// Length of the deformed chord, mm.
    pub length_mm: R,
    /// Reciprocal of the deformed chord's length, 1/mm.
    pub per_length: R,
    /// Length of the deformed chord minus the length of the undeformed chord, mm.
    pub elongation_mm: R,
    /// Rotation of the chord from its undeformed direction, rad, in (-pi, pi].
    pub rotation: R,
}

impl<R: Number> Chord<R> {
    /// The chord of the undeformed beam.
    #[inline(always)]
    pub fn at_rest(beam: &Beam<R>) -> Chord<R> {
        let zero = beam.length_mm.zero();
        Chord {
            along: beam.direction,
            across: quarter_turn(beam.direction),
            length_mm: beam.length_mm,
            per_length: beam.per_length(),
            elongation_mm: zero,
            rotation: zero,
        }
    }

    /// The chord between the displaced ends.
    ///
    /// Elongation and rotation follow from the relative displacement of the ends, not from differences of lengths and angles. Displacements far
    /// smaller than the length of the beam therefore keep full precision.
    #[inline(always)]
    pub fn deformed(beam: &Beam<R>, motion: &[EndMotion<R>; 2]) -> Chord<R> {
        let relative = difference(motion);
        let (direction, across) = (beam.direction, quarter_turn(beam.direction));
        let forward = relative.x * direction.x + relative.y * direction.y;
        let sideways = relative.x * across.x + relative.y * across.y;
        let projected = forward + beam.length_mm;
        // The lengths of a finger are neither huge nor tiny, so their squares neither overflow nor underflow, and `hypot` is not needed.
        let length_mm = (projected * projected + sideways * sideways).sqrt();
        let elongation_mm =
            (forward * (forward + beam.length_mm * 2.0) + sideways * sideways) / (length_mm + beam.length_mm);
        let per_length = length_mm.constant(1.0) / length_mm;
        let rest = beam.rest();
        let along = Vector2::new((relative.x + rest.x) * per_length, (relative.y + rest.y) * per_length);
        Chord {
            along,
            across: quarter_turn(along),
            length_mm,
            per_length,
            elongation_mm,
            rotation: arctangent(sideways, projected),
        }
    }

    /// Natural deformations. End rotations are wrapped to (-pi, pi], so the finger may make any number of full turns.
    #[inline(always)]
    pub(super) fn deformation(&self, motion: &[EndMotion<R>; 2]) -> Deformation<R> {
        Vector3::new(
            self.elongation_mm,
            wrapped(motion[0].rotation - self.rotation),
            wrapped(motion[1].rotation - self.rotation),
        )
    }

    /// Natural deformations, linearised for displacements that are small compared with the length.
    #[inline(always)]
    pub(super) fn linear_deformation(&self, motion: &[EndMotion<R>; 2]) -> Deformation<R> {
        let relative = difference(motion);
        let forward = relative.x * self.along.x + relative.y * self.along.y;
        let sideways = relative.x * self.across.x + relative.y * self.across.y;
        let rotation = sideways * self.per_length;
        Vector3::new(forward, motion[0].rotation - rotation, motion[1].rotation - rotation)
    }
}

impl Chord {
    /// Derivative of the chord's length by the six end coordinates.
    pub(super) fn length_gradient(&self) -> ElementVector {
        ElementVector::new(-self.along.x, -self.along.y, 0.0, self.along.x, self.along.y, 0.0)
    }

    /// Derivative of the chord's rotation by the six end coordinates.
    pub(super) fn rotation_gradient(&self) -> ElementVector {
        let v = self.across * self.per_length;
        ElementVector::new(-v.x, -v.y, 0.0, v.x, v.y, 0.0)
    }

    /// Derivatives of the three natural deformations (rows) by the six end coordinates (columns).
    pub(super) fn gradients(&self) -> SMatrix<f64, 3, 6> {
        let rotation = self.rotation_gradient();
        let mut first = -rotation;
        first[2] += 1.0;
        let mut second = -rotation;
        second[5] += 1.0;
        SMatrix::from_rows(&[self.length_gradient().transpose(), first.transpose(), second.transpose()])
    }

    /// Second derivative of the chord's rotation by the six end coordinates.
    pub(super) fn rotation_hessian(&self) -> ElementMatrix {
        let (along, across) = (self.length_gradient(), self.rotation_gradient());
        -(along * across.transpose() + across * along.transpose()) * self.per_length
    }
}

/// Displacement of the second end relative to the first, mm.
#[inline(always)]
fn difference<R: Number>(motion: &[EndMotion<R>; 2]) -> Vector2<R> {
    let [from, to] = [&motion[0].displacement, &motion[1].displacement];
    Vector2::new(to.x - from.x, to.y - from.y)
}

/// The vector rotated by +90 degrees.
#[inline(always)]
pub(crate) fn quarter_turn<R: Number>(v: Vector2<R>) -> Vector2<R> {
    Vector2::new(-v.y, v.x)
}

/// The angle wrapped to (-pi, pi], rad. An angle in that range is returned bitwise unchanged.
#[inline(always)]
fn wrapped<R: Number>(angle: R) -> R {
    let pi = angle.constant(PI);
    if angle.everywhere(angle.exceeds(-pi)) && !angle.anywhere(angle.exceeds(pi)) {
        return angle;
    }
    angle.each(|angle| if angle > -PI && angle <= PI { angle } else { PI - (PI - angle).rem_euclid(2.0 * PI) })
}
