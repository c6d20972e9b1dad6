//! The straight line between the two ends of a beam, and the deformations measured against it.

use super::natural::Deformation;
use super::{Beam, ElementMatrix, ElementVector, EndMotion};
use crate::Vector;
use nalgebra::{SMatrix, Vector3};
use std::f64::consts::PI;

/// The chord of a beam in its current position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// Unit vector along the chord.
    pub along: Vector,
    /// Unit vector across the chord, a quarter turn from `along` in the positive sense.
    pub across: Vector,
    /// Current length, mm.
    pub length_mm: f64,
    /// 1 / current length, 1/mm.
    pub per_length: f64,
    /// Current minus undeformed length, mm.
    pub elongation_mm: f64,
    /// Rotation from the undeformed direction, rad, in (-pi, pi].
    pub rotation: f64,
}

impl Chord {
    /// The chord of the beam at rest.
    #[inline(always)]
    pub fn undeformed(beam: &Beam) -> Chord {
        Chord {
            along: beam.direction,
            across: quarter_turn(beam.direction),
            length_mm: beam.length_mm,
            per_length: 1.0 / beam.length_mm,
            elongation_mm: 0.0,
            rotation: 0.0,
        }
    }

    /// The chord between the displaced ends.
    ///
    /// Elongation and rotation are formed from the relative displacement of the ends rather than from differences of
    /// lengths and angles, so that displacements far smaller than the beam keep all their digits.
    #[inline(always)]
    pub fn deformed(beam: &Beam, motion: &[EndMotion; 2]) -> Chord {
        let relative = motion[1].displacement - motion[0].displacement;
        let forward = relative.dot(&beam.direction);
        let sideways = relative.dot(&quarter_turn(beam.direction));
        // Lengths of fingers are far from the ends of the number range: no need for hypot's care.
        let length_mm = ((beam.length_mm + forward).powi(2) + sideways * sideways).sqrt();
        let elongation_mm =
            (forward * (2.0 * beam.length_mm + forward) + sideways * sideways) / (length_mm + beam.length_mm);
        let per_length = 1.0 / length_mm;
        let along = (beam.direction * beam.length_mm + relative) * per_length;
        Chord {
            along,
            across: quarter_turn(along),
            length_mm,
            per_length,
            elongation_mm,
            rotation: sideways.atan2(beam.length_mm + forward),
        }
    }

    /// Natural deformations; the end rotations are brought into (-pi, pi], so that a finger may turn any number of times.
    #[inline(always)]
    pub(super) fn deformation(&self, motion: &[EndMotion; 2]) -> Deformation {
        Vector3::new(
            self.elongation_mm,
            wrapped(motion[0].rotation - self.rotation),
            wrapped(motion[1].rotation - self.rotation),
        )
    }

    /// Natural deformations for displacements small against the length: all linear.
    #[inline(always)]
    pub(super) fn linear_deformation(&self, motion: &[EndMotion; 2]) -> Deformation {
        let relative = motion[1].displacement - motion[0].displacement;
        let rotation = relative.dot(&self.across) * self.per_length;
        Vector3::new(relative.dot(&self.along), motion[0].rotation - rotation, motion[1].rotation - rotation)
    }

    /// Derivative of the chord's length by the end coordinates.
    pub(super) fn length_gradient(&self) -> ElementVector {
        ElementVector::new(-self.along.x, -self.along.y, 0.0, self.along.x, self.along.y, 0.0)
    }

    /// Derivative of the chord's rotation by the end coordinates.
    pub(super) fn rotation_gradient(&self) -> ElementVector {
        let v = self.across * self.per_length;
        ElementVector::new(-v.x, -v.y, 0.0, v.x, v.y, 0.0)
    }

    /// Derivatives of the three natural deformations, one in a row.
    pub(super) fn gradients(&self) -> SMatrix<f64, 3, 6> {
        let rotation = self.rotation_gradient();
        let mut first = -rotation;
        first[2] += 1.0;
        let mut second = -rotation;
        second[5] += 1.0;
        SMatrix::from_rows(&[self.length_gradient().transpose(), first.transpose(), second.transpose()])
    }

    /// Second derivative of the chord's rotation.
    pub(super) fn rotation_hessian(&self) -> ElementMatrix {
        let (along, across) = (self.length_gradient(), self.rotation_gradient());
        -(along * across.transpose() + across * along.transpose()) * self.per_length
    }
}

/// The vector turned by +90 degrees.
pub(crate) fn quarter_turn(v: Vector) -> Vector {
    Vector::new(-v.y, v.x)
}

/// The angle brought into (-pi, pi]; angles already there are returned unchanged, digit for digit.
fn wrapped(angle: f64) -> f64 {
    if angle > -PI && angle <= PI { angle } else { PI - (PI - angle).rem_euclid(2.0 * PI) }
}
