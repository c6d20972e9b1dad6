//! The beam seen from its own chord: energy of elongation and end rotations.

use super::{Beam, Chord, ElementMatrix, ElementVector, EndMotion, Response};
use nalgebra::{Matrix3, Vector3};

/// Natural deformations in their order: elongation of the chord (mm), rotation of the first and of the second end
/// against the chord (rad).
pub(super) type Deformation = Vector3<f64>;

/// Energy of a beam as a function of its natural deformations, with both derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct NaturalResponse {
    energy: f64,
    gradient: Vector3<f64>,
    stiffness: Matrix3<f64>,
}

/// The axial strain, and its derivatives by the two end rotations times the length.
struct AxialStrain {
    strain: f64,
    by_rotations: [f64; 2],
}

/// 1 / 30 with bowing, 0 without.
fn arch(bowing: bool) -> f64 {
    if bowing { 1.0 / 30.0 } else { 0.0 }
}

impl Beam {
    /// Divisions are slow: one for all.
    #[inline(always)]
    fn per_length(&self) -> f64 {
        1.0 / self.length_mm
    }

    /// eps = e / L + (2 phi_a^2 - phi_a phi_b + 2 phi_b^2) / 30.
    ///
    /// The second part is the mean of w'^2 / 2 over the cubic deflection w (the shallow arch); without `bowing` it is
    /// left out and the strain is the chord's.
    #[inline(always)]
    fn axial_strain(&self, bowing: bool, deformation: &Deformation) -> AxialStrain {
        let (a, b) = (deformation[1], deformation[2]);
        let arch = arch(bowing);
        AxialStrain {
            strain: deformation[0] * self.per_length() + arch * (2.0 * a * a - a * b + 2.0 * b * b),
            by_rotations: [self.length_mm * arch * (4.0 * a - b), self.length_mm * arch * (4.0 * b - a)],
        }
    }

    /// The axial strain without its derivatives.
    pub(super) fn mean_strain(&self, bowing: bool, deformation: &Deformation) -> f64 {
        self.axial_strain(bowing, deformation).strain
    }

    /// U = EA L eps^2 / 2 + 2 EI / L (phi_a^2 + phi_a phi_b + phi_b^2) and its gradient: axial force (N) and end moments
    /// (N mm).
    #[inline(always)]
    fn natural_forces(&self, axial: &AxialStrain, deformation: &Deformation) -> (f64, Vector3<f64>) {
        let (a, b) = (deformation[1], deformation[2]);
        let flexural = self.bending_rigidity_nmm2 * self.per_length();
        let force = self.axial_rigidity_n * axial.strain;
        let energy = 0.5 * force * axial.strain * self.length_mm + 2.0 * flexural * (a * a + a * b + b * b);
        let [by_a, by_b] = axial.by_rotations;
        let gradient = Vector3::new(
            force,
            force * by_a + flexural * (4.0 * a + 2.0 * b),
            force * by_b + flexural * (2.0 * a + 4.0 * b),
        );
        (energy, gradient)
    }

    /// Energy U, its gradient and its second derivatives.
    #[inline(always)]
    pub(super) fn natural_response(&self, bowing: bool, deformation: &Deformation) -> NaturalResponse {
        let axial = self.axial_strain(bowing, deformation);
        let (energy, gradient) = self.natural_forces(&axial, deformation);
        let [by_a, by_b] = axial.by_rotations;
        let axial_stiffness = self.axial_rigidity_n * self.per_length();
        let flexural = self.bending_rigidity_nmm2 * self.per_length();
        let curvature = gradient[0] * self.length_mm * arch(bowing);
        let (with_a, with_b) = (axial_stiffness * by_a, axial_stiffness * by_b);
        let mixed = with_a * by_b + 2.0 * flexural - curvature;
        let bending = 4.0 * (flexural + curvature);
        #[rustfmt::skip]
        let stiffness = Matrix3::new(
            axial_stiffness, with_a, with_b,
            with_a, with_a * by_a + bending, mixed,
            with_b, mixed, with_b * by_b + bending,
        );
        NaturalResponse { energy, gradient, stiffness }
    }

    /// Energy (N mm) and nodal forces of a beam with small displacements: what [`response`](Beam::response) gives beside
    /// the tangent, which never changes.
    #[inline(always)]
    pub(crate) fn linear_forces(&self, motion: &[EndMotion; 2]) -> (f64, ElementVector) {
        let chord = Chord::undeformed(self);
        let deformation = chord.linear_deformation(motion);
        let (energy, gradient) = self.natural_forces(&self.axial_strain(false, &deformation), &deformation);
        (energy, chord.nodal_forces(&gradient))
    }
}

impl Chord {
    /// Nodal forces of the three natural ones.
    #[inline(always)]
    fn nodal_forces(&self, natural: &Vector3<f64>) -> ElementVector {
        let [axial, a, b] = (*natural).into();
        let force = self.along * axial - self.across * ((a + b) * self.per_length);
        ElementVector::new(-force.x, -force.y, a, force.x, force.y, b)
    }
}

impl NaturalResponse {
    /// Chain rule to the six end coordinates.
    ///
    /// The energy depends on the displacement d of the second end against the first and on the two end rotations, so
    /// four coordinates carry everything: d along and across the chord, theta_a, theta_b. By them the chord's length
    /// has the derivative (1, 0, 0, 0) and its rotation (0, 1 / l, 0, 0); with the end rotations against the chord,
    /// phi = theta - rotation, that gives all first derivatives. The second derivatives are those of the length,
    /// 1 / l across-across, and of the rotation, -1 / l^2 along-across; `curved` chooses whether they count (the
    /// linear beam has none).
    #[inline(always)]
    pub(super) fn on_chord(&self, chord: &Chord, curved: bool) -> Response {
        let [axial, a, b] = self.gradient.into();
        let k = &self.stiffness;
        let per_length = chord.per_length;
        let (axial_curvature, moment_curvature) =
            if curved { (axial * per_length, (a + b) * per_length * per_length) } else { (0.0, 0.0) };

        // By d: along, across; then mixed with each end rotation.
        let along_along = k[(0, 0)];
        let along_across = moment_curvature - (k[(0, 1)] + k[(0, 2)]) * per_length;
        let across_across = (k[(1, 1)] + 2.0 * k[(1, 2)] + k[(2, 2)]) * per_length * per_length + axial_curvature;
        let (e, n) = (chord.along, chord.across);
        let xx = e.x * e.x * along_along + 2.0 * e.x * n.x * along_across + n.x * n.x * across_across;
        let xy = e.x * e.y * along_along + (e.x * n.y + e.y * n.x) * along_across + n.x * n.y * across_across;
        let yy = e.y * e.y * along_along + 2.0 * e.y * n.y * along_across + n.y * n.y * across_across;
        let with_a = e * k[(0, 1)] - n * ((k[(1, 1)] + k[(1, 2)]) * per_length);
        let with_b = e * k[(0, 2)] - n * ((k[(1, 2)] + k[(2, 2)]) * per_length);

        #[rustfmt::skip]
        let tangent = ElementMatrix::new(
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
