//! Energy of a beam as a function of its natural deformations: elongation of the chord, and end rotations relative to the chord.

use super::chord::{Chord, Deformation};
use super::{Beam, EndMotion, Response};
use crate::number::Number;
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Energy of a beam as a function of its natural deformations, with first and second derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct NaturalResponse<R> {
    /// Energy, N mm.
    energy: R,
    /// First derivatives: axial force (N) and moments at both ends (N mm).
    gradient: Vector3<R>,
    /// Second derivatives by the natural deformations; N/mm, N and N mm.
    stiffness: Matrix3<R>,
}

/// Axial strain of a beam with its derivatives.
struct AxialStrain<R> {
    /// Axial strain, dimensionless.
    strain: R,
    /// Derivatives of the strain by the two end rotations, multiplied by the beam's length, mm.
    by_rotations: [R; 2],
}

/// Coefficient of the end rotations in the axial strain, dimensionless: 1 / 30 with bowing, 0 without.
fn arch(bowing: bool) -> f64 {
    if bowing { 1.0 / 30.0 } else { 0.0 }
}

impl<R: Number> Beam<R> {
    /// Reciprocal length, 1/mm, computed only once because divisions are slow.
    #[inline(always)]
    pub(super) fn per_length(&self) -> R {
        self.length_mm.constant(1.0) / self.length_mm
    }

    /// Vector from the first to the second end of the undeformed beam, mm.
    #[inline(always)]
    pub(crate) fn rest(&self) -> Vector2<R> {
        Vector2::new(self.direction.x * self.length_mm, self.direction.y * self.length_mm)
    }

    /// Axial strain eps = e / L + (2 phi_a^2 - phi_a phi_b + 2 phi_b^2) / 30.
    ///
    /// The second term is the mean of w'^2 / 2 over the cubic deflection w (shallow arch). It is zero without `bowing`.
    #[inline(always)]
    fn axial_strain(&self, bowing: bool, deformation: &Deformation<R>) -> AxialStrain<R> {
        let (a, b) = (deformation[1], deformation[2]);
        let arch = arch(bowing);
        AxialStrain {
            strain: deformation[0] * self.per_length() + (a * 2.0 * a - a * b + b * 2.0 * b) * arch,
            by_rotations: [(a * 4.0 - b) * (self.length_mm * arch), (b * 4.0 - a) * (self.length_mm * arch)],
        }
    }

    /// Axial strain as in [`axial_strain`](Beam::axial_strain), dimensionless, without its derivatives.
    pub(super) fn mean_strain(&self, bowing: bool, deformation: &Deformation<R>) -> R {
        self.axial_strain(bowing, deformation).strain
    }

    /// Energy U = EA L eps^2 / 2 + 2 EI / L (phi_a^2 + phi_a phi_b + phi_b^2), N mm. Its gradient holds the axial force (N) and the end moments (N mm).
    #[inline(always)]
    fn natural_forces(&self, axial: &AxialStrain<R>, deformation: &Deformation<R>) -> (R, Vector3<R>) {
        let (a, b) = (deformation[1], deformation[2]);
        let flexural = self.bending_rigidity_nmm2 * self.per_length();
        let force = axial.strain * self.axial_rigidity_n;
        let energy = force * 0.5 * axial.strain * self.length_mm + (a * a + a * b + b * b) * (flexural * 2.0);
        let [by_a, by_b] = axial.by_rotations;
        let gradient = Vector3::new(
            force,
            force * by_a + (a * 4.0 + b * 2.0) * flexural,
            force * by_b + (a * 2.0 + b * 4.0) * flexural,
        );
        (energy, gradient)
    }

    /// Energy U with its gradient and second derivatives.
    #[inline(always)]
    pub(super) fn natural_response(&self, bowing: bool, deformation: &Deformation<R>) -> NaturalResponse<R> {
        let axial = self.axial_strain(bowing, deformation);
        let (energy, gradient) = self.natural_forces(&axial, deformation);
        let [by_a, by_b] = axial.by_rotations;
        let axial_stiffness = self.axial_rigidity_n * self.per_length();
        let flexural = self.bending_rigidity_nmm2 * self.per_length();
        let curvature = gradient[0] * self.length_mm * arch(bowing);
        let (with_a, with_b) = (by_a * axial_stiffness, by_b * axial_stiffness);
        let mixed = with_a * by_b + flexural * 2.0 - curvature;
        let bending = (curvature + flexural) * 4.0;
        #[rustfmt::skip]
        let stiffness = Matrix3::new(
            axial_stiffness, with_a, with_b,
            with_a, with_a * by_a + bending, mixed,
            with_b, mixed, with_b * by_b + bending,
        );
        NaturalResponse { energy, gradient, stiffness }
    }

    /// Energy (N mm) and nodal forces (N, N mm) for small displacements: [`response`](Beam::response) without the tangent stiffness.
    #[inline(always)]
    pub(crate) fn linear_forces(&self, motion: &[EndMotion<R>; 2]) -> (R, SVector<R, 6>) {
        let chord = Chord::at_rest(self);
        let deformation = chord.linear_deformation(motion);
        let (energy, gradient) = self.natural_forces(&self.axial_strain(false, &deformation), &deformation);
        (energy, chord.nodal_forces(&gradient))
    }
}

impl<R: Number> Chord<R> {
    /// Nodal forces (N, N mm) that are equivalent to the three natural forces.
    #[inline(always)]
    fn nodal_forces(&self, natural: &Vector3<R>) -> SVector<R, 6> {
        let (axial, a, b) = (natural.x, natural.y, natural.z);
        let transverse = (a + b) * self.per_length;
        let x = self.along.x * axial - self.across.x * transverse;
        let y = self.along.y * axial - self.across.y * transverse;
        SVector::<R, 6>::new(-x, -y, a, x, y, b)
    }
}

impl<R: Number> NaturalResponse<R> {
    /// Chain rule from the natural deformations to the six end coordinates.
    ///
    /// The energy depends only on the displacement d of the second end relative to the first and on the two end rotations. Four coordinates therefore
    /// suffice: d along and across the chord, theta_a and theta_b. By these the chord's length has the derivative (1, 0, 0, 0) and its rotation
    /// (0, 1 / l, 0, 0). With the relative end rotations phi = theta - rotation, all first derivatives follow. The second derivative of the length is 1 / l
    /// (across-across), that of the rotation -1 / l^2 (along-across); both count only if `curved`.
    #[inline(always)]
    pub(super) fn on_chord(&self, chord: &Chord<R>, curved: bool) -> Response<R> {
        let (axial, a, b) = (self.gradient.x, self.gradient.y, self.gradient.z);
        let k = &self.stiffness;
        let per_length = chord.per_length;
        let (axial_curvature, moment_curvature) =
            if curved { (axial * per_length, (a + b) * per_length * per_length) } else { (axial.zero(), axial.zero()) };

        // Second derivatives by d along and across the chord, then mixed derivatives with each end rotation.
        let along_along = k[(0, 0)];
        let along_across = moment_curvature - (k[(0, 1)] + k[(0, 2)]) * per_length;
        let across_across = (k[(1, 1)] + k[(1, 2)] * 2.0 + k[(2, 2)]) * per_length * per_length + axial_curvature;
        let (e, n) = (chord.along, chord.across);
        let xx = e.x * e.x * along_along + e.x * 2.0 * n.x * along_across + n.x * n.x * across_across;
        let xy = e.x * e.y * along_along + (e.x * n.y + e.y * n.x) * along_across + n.x * n.y * across_across;
        let yy = e.y * e.y * along_along + e.y * 2.0 * n.y * along_across + n.y * n.y * across_across;
        let with_rotation = |axial: R, bending: R| {
            let bending = bending * per_length;
            Vector2::new(e.x * axial - n.x * bending, e.y * axial - n.y * bending)
        };
        let with_a = with_rotation(k[(0, 1)], k[(1, 1)] + k[(1, 2)]);
        let with_b = with_rotation(k[(0, 2)], k[(1, 2)] + k[(2, 2)]);

        #[rustfmt::skip]
        let tangent = SMatrix::<R, 6, 6>::new(
            xx, xy, -with_a.x, -xx, -xy, -with_b.x,
            xy, yy, -with_a.y, -xy, -yy, -with_b.y,
            -with_a.x, -with_a.y, k[(1, 1)], with_a.x, with_a.y, k[(1, 2)],
            -xx, -xy, with_a.x, xx, xy, with_b.x,
            -xy, -yy, with_a.y, xy, yy, with_b.y,
            -with_b.x, -with_b.y, k[(1, 2)], with_b.x, with_b.y, k[(2, 2)],
        );
        Response { energy: self.energy, gradient: chord.nodal_forces(&self.gradient), tangent }
    }
}
