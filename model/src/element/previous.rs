//! Forces for the tangent of Newton's method, extrapolated from the shape before the last correction.
//!
//! Newton's correction moves the nodes along straight lines. A correction that rotates a beam by the angle `a` therefore also elongates it by the strain
//! a^2 / 2. A beam is stiff against elongation, so its forces at the corrected motion are far from those at equilibrium. These forces cause geometric
//! stiffness in the next tangent. The next tangent is computed instead with the forces that follow to first order from the correction, which contain no
//! such elongation. The residual remains exact, so the solution does not change. The convergence remains quadratic, because the forces agree to first
//! order.
//!
//! Reference: Magisano, Leonetti, Garcea, How to improve efficiency and robustness of the Newton method in geometrically non-linear structural problem
//! discretized via displacement-based finite elements, Comput. Methods Appl. Mech. Engrg. 313 (2017) 986-1005: mixed integration points.

use super::Beam;
use super::chord::Deformation;
use super::natural::NaturalForces;
use crate::number::Number;
use nalgebra::{Vector2, Vector3};

/// Shape of a beam at the motion that was linearised last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Previous<R = f64> {
    /// Natural deformations.
    pub(super) deformation: Deformation<R>,
    /// Unit vector along the chord.
    pub(super) along: Vector2<R>,
}

impl<R: Number> Previous<R> {
    /// The shape of the undeformed beam.
    #[inline(always)]
    pub(crate) fn at_rest(beam: &Beam<R>) -> Previous<R> {
        Previous { along: beam.direction, ..Previous::none(beam.length_mm) }
    }

    /// All numbers zero, in the number type of `like`.
    #[inline(always)]
    pub(crate) fn none(like: R) -> Previous<R> {
        let zero = like.zero();
        Previous { deformation: Vector3::new(zero, zero, zero), along: Vector2::new(zero, zero) }
    }

    /// Natural forces at the shape `now`, to first order in the correction that led from this shape to `now`. `straight` says whether both ends moved along
    /// straight lines. If they did not, the nodes rotated with the chord, so their rotations relative to the chord are already free of errors.
    #[inline(always)]
    pub(super) fn extrapolated_forces(
        &self,
        beam: &Beam<R>,
        bowing: bool,
        now: &Previous<R>,
        straight: bool,
    ) -> NaturalForces<R> {
        let (before, after) = (&self.deformation, &now.deformation);
        let (length_mm, length_now_mm) = (beam.length_mm + before.x, beam.length_mm + after.x);
        let cosine = self.along.x * now.along.x + self.along.y * now.along.y;
        // To first order the chord elongates by the relative displacement of its ends along its direction before the correction.
        let e = length_now_mm * cosine - length_mm;
        let (mut a, mut b) = (after.y - before.y, after.z - before.z);
        if straight {
            // The chord's rotation (its sine's arc, to fifth order), minus its rotation to first order.
            let sine = self.along.x * now.along.y - self.along.y * now.along.x;
            let square = sine * sine;
            let surplus = sine * ((square * 0.075 + 1.0 / 6.0) * square + (length_mm - length_now_mm) / length_mm);
            a += surplus;
            b += surplus;
        }
        let strain = beam.axial_strain(bowing, before);
        let (_, natural) = beam.natural_forces(strain, before);
        let [axial, axial_a, axial_b, bending_a, bending_b, mixed] =
            beam.natural_stiffness(bowing, strain.1, natural.x);
        Vector3::new(
            natural.x + (axial * e + axial_a * a + axial_b * b),
            natural.y + (axial_a * e + bending_a * a + mixed * b),
            natural.z + (axial_b * e + mixed * a + bending_b * b),
        )
    }

    /// Sets one SIMD lane.
    #[inline(always)]
    pub(crate) fn set_lane(&mut self, lane: usize, one: &Previous) {
        for i in 0..3 {
            self.deformation[i].set_lane(lane, one.deformation[i]);
        }
        self.along.x.set_lane(lane, one.along.x);
        self.along.y.set_lane(lane, one.along.y);
    }

    /// Copies one SIMD lane to `one`.
    #[inline(always)]
    pub(crate) fn copy_lane(&self, lane: usize, one: &mut Previous) {
        for i in 0..3 {
            one.deformation[i] = self.deformation[i].lane(lane);
        }
        (one.along.x, one.along.y) = (self.along.x.lane(lane), self.along.y.lane(lane));
    }
}
