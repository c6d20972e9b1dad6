//! The beam seen from its own chord: energy of elongation and end rotations.

use super::{Beam, ElementMatrix, Response};
use nalgebra::{Matrix3, SMatrix, Vector3};

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
    pub(super) fn axial_force(&self) -> f64 {
        self.gradient[0]
    }

    pub(super) fn end_moments(&self) -> f64 {
        self.gradient[1] + self.gradient[2]
    }

    /// Chain rule to the six end coordinates, without the second derivatives of the deformations.
    pub(super) fn pulled_back(&self, deformation_gradients: &SMatrix<f64, 3, 6>) -> Response {
        let transposed = deformation_gradients.transpose();
        let tangent: ElementMatrix = transposed * self.stiffness * deformation_gradients;
        Response { energy: self.energy, gradient: transposed * self.gradient, tangent }
    }
}
