//! The straight line between the two ends of a beam, and the deformations measured against it.

use super::{Beam, ElementMatrix, ElementVector, EndMotion};
use crate::number::{Number, arctangent};
use nalgebra::{SMatrix, Vector2, Vector3};
use std::f64::consts::PI;

/// Natural deformations: elongation of the chord (mm), rotations of the first and second end against it (rad).
pub(super) type Deformation<R = f64> = Vector3<R>;

/// The chord of a beam in its current position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord<R = f64> {
    /// Unit vector along the chord.
    pub along: Vector2<R>,
    /// Unit vector across the chord, a quarter turn from `along` in the positive sense.
    pub across: Vector2<R>,
    /// Current length, mm.
    pub length_mm: R,
    /// 1 / current length, 1/mm.
    pub per_length: R,
    /// Current minus undeformed length, mm.
    pub elongation_mm: R,
    /// Rotation from the undeformed direction, rad, in (-pi, pi].
    pub rotation: R,
}

impl<R: Number> Chord<R> {
    /// The chord of the beam at rest.
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
    /// Elongation and rotation are formed from the relative displacement of the ends rather than from differences of
    /// lengths and angles, so that displacements far smaller than the beam keep all their digits.
    #[inline(always)]
    pub fn deformed(beam: &Beam<R>, motion: &[EndMotion<R>; 2]) -> Chord<R> {
        let relative = difference(motion);
        let (direction, across) = (beam.direction, quarter_turn(beam.direction));
        let forward = relative.x * direction.x + relative.y * direction.y;
        let sideways = relative.x * across.x + relative.y * across.y;
        let projected = forward + beam.length_mm;
        // Lengths of fingers are far from the ends of the number range: no need for hypot's care.
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

    /// Natural deformations; the end rotations are brought into (-pi, pi], so that a finger may turn any number of times.
    #[inline(always)]
    pub(super) fn deformation(&self, motion: &[EndMotion<R>; 2]) -> Deformation<R> {
        Vector3::new(
            self.elongation_mm,
            wrapped(motion[0].rotation - self.rotation),
            wrapped(motion[1].rotation - self.rotation),
        )
    }

    /// Natural deformations for displacements small against the length: all linear.
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

/// Displacement of the second end against the first.
#[inline(always)]
fn difference<R: Number>(motion: &[EndMotion<R>; 2]) -> Vector2<R> {
    let [from, to] = [&motion[0].displacement, &motion[1].displacement];
    Vector2::new(to.x - from.x, to.y - from.y)
}

/// The vector turned by +90 degrees.
#[inline(always)]
pub(crate) fn quarter_turn<R: Number>(v: Vector2<R>) -> Vector2<R> {
    Vector2::new(-v.y, v.x)
}

/// The angle brought into (-pi, pi]; angles already there are returned unchanged, digit for digit.
#[inline(always)]
fn wrapped<R: Number>(angle: R) -> R {
    let pi = angle.constant(PI);
    if angle.everywhere(angle.exceeds(-pi)) && !angle.anywhere(angle.exceeds(pi)) {
        return angle;
    }
    angle.each(|angle| if angle > -PI && angle <= PI { angle } else { PI - (PI - angle).rem_euclid(2.0 * PI) })
}
