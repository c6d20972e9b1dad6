//! The beam seen from its own chord: energy of elongation and end rotations.

use super::{Beam, Chord, ElementMatrix, ElementVector, Response};
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

impl Beam {
    /// U = EA L eps^2 / 2 + 2 EI / L (phi_a^2 + phi_a phi_b + phi_b^2), with the axial strain
    /// eps = e / L + (2 phi_a^2 - phi_a phi_b + 2 phi_b^2) / 30.
    ///
    /// The second part of the strain is the mean of w'^2 / 2 over the cubic deflection w (the shallow arch); without
    /// `bowing` it is left out and the strain is the chord's.
    pub(super) fn natural_response(&self, bowing: bool, deformation: Deformation) -> NaturalResponse {
        let [elongation, a, b] = deformation.into();
        let length = self.length_mm;
        let ea = self.axial_rigidity_n;
        let flexural = self.bending_rigidity_nmm2 / length;
        let arch = if bowing { 1.0 / 30.0 } else { 0.0 };

        let strain = elongation / length + arch * (2.0 * a * a - a * b + 2.0 * b * b);
        // Derivatives of the strain, times the length.
        let by_a = length * arch * (4.0 * a - b);
        let by_b = length * arch * (4.0 * b - a);
        let axial_force = ea * strain;

        let energy = 0.5 * axial_force * strain * length + 2.0 * flexural * (a * a + a * b + b * b);
        let gradient = Vector3::new(
            axial_force,
            axial_force * by_a + flexural * (4.0 * a + 2.0 * b),
            axial_force * by_b + flexural * (2.0 * a + 4.0 * b),
        );
        let strain_gradient = Vector3::new(1.0, by_a, by_b);
        let arch_curvature = axial_force * length * arch;
        let stiffness = strain_gradient * strain_gradient.transpose() * (ea / length)
            + Matrix3::new(
                0.0,
                0.0,
                0.0,
                0.0,
                4.0 * (flexural + arch_curvature),
                2.0 * flexural - arch_curvature,
                0.0,
                2.0 * flexural - arch_curvature,
                4.0 * (flexural + arch_curvature),
            );
        NaturalResponse { energy, gradient, stiffness }
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
    pub(super) fn on_chord(&self, chord: &Chord, curved: bool) -> Response {
        let [axial, a, b] = self.gradient.into();
        let k = &self.stiffness;
        let per_length = 1.0 / chord.length_mm;
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
        let force = e * axial - n * ((a + b) * per_length);

        #[rustfmt::skip]
        let tangent = ElementMatrix::new(
            xx, xy, -with_a.x, -xx, -xy, -with_b.x,
            xy, yy, -with_a.y, -xy, -yy, -with_b.y,
            -with_a.x, -with_a.y, k[(1, 1)], with_a.x, with_a.y, k[(1, 2)],
            -xx, -xy, with_a.x, xx, xy, with_b.x,
            -xy, -yy, with_a.y, xy, yy, with_b.y,
            -with_b.x, -with_b.y, k[(1, 2)], with_b.x, with_b.y, k[(2, 2)],
        );
        let gradient = ElementVector::new(-force.x, -force.y, a, force.x, force.y, b);
        Response { energy: self.energy, gradient, tangent }
    }
}
