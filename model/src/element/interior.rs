//! A dead load between the two ends of a beam.

use super::{Beam, Chord, ElementMatrix, ElementVector, EndMotion, Kinematics, Response};
use crate::Vector;

impl Beam {
    /// Work of a dead force at the fraction `xi` (0..1) of the undeformed length, with its derivatives: the
    /// consistent nodal loads and their change with the motion.
    ///
    /// The loaded point lies at p = (1 - xi) p_a + xi p_b + w n, n across the chord, with the cubic deflection
    /// w = L (phi_a xi (1 - xi)^2 - phi_b xi^2 (1 - xi)). With linear kinematics the derivatives are the well-known
    /// equivalent loads of the cubic beam, so displacements at the ends are exact.
    pub fn interior_work(&self, kinematics: Kinematics, xi: f64, force: Vector, motion: &[EndMotion; 2]) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let chord = if linear { Chord::undeformed(self) } else { Chord::deformed(self, motion) };
        let deformation = if linear { chord.linear_deformation(motion) } else { chord.deformation(motion) };
        let gradients = chord.gradients();

        // Deflection w and its gradient.
        let lever = [self.length_mm * xi * (1.0 - xi).powi(2), -self.length_mm * xi.powi(2) * (1.0 - xi)];
        let deflection = lever[0] * deformation[1] + lever[1] * deformation[2];
        let by_deflection = (gradients.row(1) * lever[0] + gradients.row(2) * lever[1]).transpose();

        let (along, across) = (force.dot(&chord.along), force.dot(&chord.across));
        let chord_point = motion[0].displacement * (1.0 - xi) + motion[1].displacement * xi;
        let ends = force * (1.0 - xi);
        let energy = force.dot(&chord_point) + across * deflection;
        let mut gradient =
            ElementVector::new(ends.x, ends.y, 0.0, force.x * xi, force.y * xi, 0.0) + by_deflection * across;
        let mut tangent = ElementMatrix::zeros();
        if !linear {
            // The chord turns with the ends: d(across) = -along d(rotation), d(along) = across d(rotation); and the
            // end rotations against it, phi = theta - rotation, have its second derivative with the opposite sign.
            let turning = chord.rotation_gradient();
            gradient -= turning * (along * deflection);
            tangent = -(by_deflection * turning.transpose() + turning * by_deflection.transpose()) * along
                - turning * turning.transpose() * (across * deflection)
                - chord.rotation_hessian() * (along * deflection + across * (lever[0] + lever[1]));
        }
        Response { energy, gradient, tangent }
    }
}
