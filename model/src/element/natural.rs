//! Energy of a beam as a function of its natural deformations: elongation of the chord, and end rotations relative to the chord.

use super::chord::{Chord, Deformation};
use super::{Beam, EndMotion, Response};
use crate::number::Number;
use nalgebra::{SMatrix, SVector, Vector2, Vector3};

/// Coefficients of a quadratic form of the two end rotations: one for both squares, one for the product.
type EndForm<R> = [R; 2];

/// Coefficient of the end rotations in the axial strain, dimensionless: 1 / 30 with bowing, 0 without.
fn arch(bowing: bool) -> f64 {
    if bowing { 1.0 / 30.0 } else { 0.0 }
}

/// Derivatives of a beam's energy by its natural deformations: axial force (N), and moments at the first and second end (N mm).
pub(super) type NaturalForces<R = f64> = Vector3<R>;

/// Elastic response of a beam.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elastic<R = f64> {
    /// Energy, forces and tangent stiffness.
    pub response: Response<R>,
    /// Force on the second end whose rotation is part of the tangent stiffness, N.
    pub turning_force: Vector2<R>,
}

impl<R: Number> Beam<R> {
    /// Reciprocal length, 1/mm, because multiplication by it is faster than division by the length.
    #[inline(always)]
    pub(super) fn per_length(&self) -> R {
        self.length_mm.constant(1.0) / self.length_mm
    }

    /// Vector from the first to the second end of the undeformed beam, mm.
    #[inline(always)]
    pub(crate) fn rest(&self) -> Vector2<R> {
        Vector2::new(self.direction.x * self.length_mm, self.direction.y * self.length_mm)
    }

    /// With the sway factor r, the end moments per end rotation, in units of EI / L, are 1 + 3 r at the rotated end and 3 r - 1 at the other end.
    #[inline(always)]
    fn end_stiffness(&self) -> [R; 2] {
        let one = self.sway_factor.constant(1.0);
        let sway = self.sway_factor * 3.0;
        [sway + one, sway - one]
    }

    /// The form 2 psi_a^2 - psi_a psi_b + 2 psi_b^2 of the axis' end slopes psi, in terms of the end rotations phi. The sum of the slopes is r times the
    /// sum of the rotations, with the sway factor r; their difference equals the difference of the rotations.
    #[inline(always)]
    fn slope_form(&self) -> EndForm<R> {
        let five = self.sway_factor.constant(5.0);
        let sway = self.sway_factor * self.sway_factor * 3.0;
        [(sway + five) * 0.25, (sway - five) * 0.5]
    }

    /// Axial strain eps = e / L + (2 psi_a^2 - psi_a psi_b + 2 psi_b^2) / 30, with the end slopes psi of the axis relative to the chord. Without
    /// shear deformation, the end slopes psi equal the end rotations phi.
    ///
    /// The term in psi is the mean of w'^2 / 2 over the cubic deflection w (shallow arch). It is zero without `bowing`. Where the elastic axis lies
    /// beside the chord, by c_a and c_b at the ends, rotations of the ends elongate it by c_a phi_a - c_b phi_b. Returns the strain
    /// (dimensionless), and its derivatives by the two end rotations, multiplied by the beam's length, mm.
    #[inline(always)]
    pub(super) fn axial_strain(&self, bowing: bool, deformation: &Deformation<R>) -> (R, [R; 2]) {
        let (a, b) = (deformation[1], deformation[2]);
        let arch = arch(bowing);
        let [square, product] = self.slope_form();
        let [axis_a, axis_b] = self.axis_mm;
        let elongation_mm = deformation[0] + (axis_a * a - axis_b * b);
        let strain = elongation_mm * self.per_length() + (a * square * a + a * product * b + b * square * b) * arch;
        let twice = square * 2.0;
        let lever_mm = self.length_mm * arch;
        (strain, [(a * twice + b * product) * lever_mm + axis_a, (b * twice + a * product) * lever_mm - axis_b])
    }

    /// Energy U = EA L eps^2 / 2 + EI / (2 L) (k phi_a^2 + 2 k' phi_a phi_b + k phi_b^2), N mm, with k and k' of [`end_stiffness`](Beam::end_stiffness):
    /// 4 and 2 without shear deformation. The gradient of U consists of the axial force (N) and the end moments (N mm).
    #[inline(always)]
    pub(super) fn natural_forces(
        &self,
        (strain, [by_a, by_b]): (R, [R; 2]),
        deformation: &Deformation<R>,
    ) -> (R, Vector3<R>) {
        let (a, b) = (deformation[1], deformation[2]);
        let flexural = self.bending_rigidity_nmm2 * self.per_length();
        let force = strain * self.axial_rigidity_n;
        let [near, far] = self.end_stiffness();
        let half = near * 0.5;
        let energy = force * 0.5 * strain * self.length_mm + (a * a * half + a * b * far + b * b * half) * flexural;
        let gradient = Vector3::new(
            force,
            force * by_a + (a * near + b * far) * flexural,
            force * by_b + (a * far + b * near) * flexural,
        );
        (energy, gradient)
    }

    /// Energy U with its gradient and second derivatives, by the chain rule from the natural deformations to the six end coordinates.
    ///
    /// The energy depends only on the displacement d of the second end relative to the first and on the two end rotations. Four coordinates therefore
    /// suffice: d along and across the chord, theta_a and theta_b. Let l be the length of the deformed chord. The first derivatives by d along, d
    /// across, theta_a and theta_b are (1, 0, 0, 0) for the chord's length and (0, 1 / l, 0, 0) for the chord's rotation. The first derivatives of
    /// the relative end rotations follow from phi = theta - rotation. The second derivative of the length is 1 / l (twice by d across), and that of
    /// the rotation is -1 / l^2 (by d along and d across). The two second derivatives are included only if `curved` is true.
    #[inline(always)]
    pub(super) fn response_on(
        &self,
        chord: &Chord<R>,
        deformation: &Deformation<R>,
        (bowing, curved): (bool, bool),
        extrapolated: Option<NaturalForces<R>>,
    ) -> Elastic<R> {
        let strain = self.axial_strain(bowing, deformation);
        let (energy, natural) = self.natural_forces(strain, deformation);
        let turning = if let Some(forces) = extrapolated { forces } else { natural };
        let [axial_stiffness, axial_a, axial_b, bending_a, bending_b, mixed] =
            self.natural_stiffness(bowing, strain.1, turning.x);

        let (axial, a, b) = (turning.x, turning.y, turning.z);
        let per_length = chord.per_length;
        let (axial_curvature, moment_curvature) =
            if curved { (axial * per_length, (a + b) * per_length * per_length) } else { (axial.zero(), axial.zero()) };

        // Second derivatives of the energy by the relative displacement of the ends along and across the chord, then mixed derivatives with each end
        // rotation.
        let along_across = moment_curvature - (axial_a + axial_b) * per_length;
        let across_across = (bending_a + mixed * 2.0 + bending_b) * per_length * per_length + axial_curvature;
        let (e, n) = (chord.along, chord.across);
        let xx = e.x * e.x * axial_stiffness + e.x * 2.0 * n.x * along_across + n.x * n.x * across_across;
        let xy = e.x * e.y * axial_stiffness + (e.x * n.y + e.y * n.x) * along_across + n.x * n.y * across_across;
        let yy = e.y * e.y * axial_stiffness + e.y * 2.0 * n.y * along_across + n.y * n.y * across_across;
        let with_a = chord.in_plane(axial_a, (bending_a + mixed) * per_length);
        let with_b = chord.in_plane(axial_b, (mixed + bending_b) * per_length);

        #[rustfmt::skip]
        let tangent = SMatrix::<R, 6, 6>::new(
            xx, xy, -with_a.x, -xx, -xy, -with_b.x,
            xy, yy, -with_a.y, -xy, -yy, -with_b.y,
            -with_a.x, -with_a.y, bending_a, with_a.x, with_a.y, mixed,
            -xx, -xy, with_a.x, xx, xy, with_b.x,
            -xy, -yy, with_a.y, xy, yy, with_b.y,
            -with_b.x, -with_b.y, mixed, with_b.x, with_b.y, bending_b,
        );
        Elastic {
            response: Response { energy, gradient: chord.nodal_forces(&natural), tangent },
            turning_force: chord.end_force(&turning),
        }
    }

    /// Second derivatives of the energy U by the natural deformations: by elongation twice (N/mm), by elongation and each rotation (N), by each
    /// rotation twice (N mm), and by both rotations (N mm). The arguments are the derivatives of the axial strain by the two rotations, mm, and the
    /// axial force, N.
    #[inline(always)]
    pub(super) fn natural_stiffness(&self, bowing: bool, [by_a, by_b]: [R; 2], axial_force: R) -> [R; 6] {
        let axial = self.axial_rigidity_n * self.per_length();
        let flexural = self.bending_rigidity_nmm2 * self.per_length();
        let curvature = axial_force * self.length_mm * arch(bowing);
        let (axial_a, axial_b) = (by_a * axial, by_b * axial);
        let ([near, far], [square, product]) = (self.end_stiffness(), self.slope_form());
        let mixed = axial_a * by_b + flexural * far + curvature * product;
        let bending = curvature * (square * 2.0) + flexural * near;
        [axial, axial_a, axial_b, axial_a * by_a + bending, axial_b * by_b + bending, mixed]
    }

    /// Energy (N mm) and nodal forces (N, N mm) for small displacements: [`response`](Beam::response) without the tangent stiffness.
    #[inline(always)]
    pub(crate) fn linear_forces(&self, motion: &[EndMotion<R>; 2]) -> (R, SVector<R, 6>) {
        let chord = Chord::at_rest(self);
        let deformation = chord.linear_deformation(motion);
        let (energy, gradient) = self.natural_forces(self.axial_strain(false, &deformation), &deformation);
        (energy, chord.nodal_forces(&gradient))
    }
}

impl<R: Number> Chord<R> {
    /// Nodal forces (N, N mm) that are equivalent to the three natural forces.
    #[inline(always)]
    fn nodal_forces(&self, natural: &NaturalForces<R>) -> SVector<R, 6> {
        let (force, a, b) = (self.end_force(natural), natural.y, natural.z);
        SVector::<R, 6>::new(-force.x, -force.y, a, force.x, force.y, b)
    }

    /// Force on the second end, N.
    #[inline(always)]
    fn end_force(&self, natural: &NaturalForces<R>) -> Vector2<R> {
        self.in_plane(natural.x, (natural.y + natural.z) * self.per_length)
    }

    /// The vector `forward` times `along` minus `sideways` times `across`.
    #[inline(always)]
    fn in_plane(&self, forward: R, sideways: R) -> Vector2<R> {
        let (e, n) = (self.along, self.across);
        Vector2::new(e.x * forward - n.x * sideways, e.y * forward - n.y * sideways)
    }
}
