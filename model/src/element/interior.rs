//! A dead load between the two ends of a beam.

use super::{Beam, Chord, ElementMatrix, ElementVector, EndMotion, Kinematics, Response};
use crate::Vector;

/// Derivatives of the motion of a point between the ends by the motions of the ends.
#[derive(Debug, Clone, Copy)]
struct Shape {
    /// Shares of the ends' displacements in the displacement of the point, dimensionless.
    shares: [f64; 2],
    /// Deflection of the point per unit rotation of each end relative to the chord, mm.
    levers: [f64; 2],
}

impl Shape {
    /// The shape for the point at the fraction `xi` of the beam's length.
    fn at(xi: f64, beam: &Beam) -> Shape {
        let (rest, length_mm) = (1.0 - xi, beam.length_mm);
        let of_slopes = [length_mm * xi * rest * rest, -length_mm * xi * xi * rest];
        Shape { shares: [rest, xi], levers: beam.by_rotations(of_slopes) }
    }

    /// Derivative of [`at`](Shape::at) by `xi`.
    fn slope_at(xi: f64, beam: &Beam) -> Shape {
        let (rest, length_mm) = (1.0 - xi, beam.length_mm);
        let of_slopes = [length_mm * rest * (1.0 - 3.0 * xi), -length_mm * xi * (2.0 - 3.0 * xi)];
        Shape { shares: [-1.0, 1.0], levers: beam.by_rotations(of_slopes) }
    }
}

impl Beam {
    /// Work of a dead force (N) at the fraction `xi` of the undeformed length, N mm. The derivatives of the work are the consistent nodal loads.
    ///
    /// The loaded point is p = (1 - xi) p_a + xi p_b + w n, with n the unit vector across the chord. The deflection w is cubic, w = L (psi_a xi (1 -
    /// xi)^2 - psi_b xi^2 (1 - xi)), with the end slopes psi of the axis. With linear kinematics, the derivatives of the work are the classical
    /// equivalent nodal loads of the beam, with or without shear deformation. Displacements at the ends are therefore exact.
    pub fn interior_work(&self, kinematics: Kinematics, xi: f64, force: Vector, motion: &[EndMotion; 2]) -> Response {
        self.work_on(kinematics, Shape::at(xi, self), force, motion)
    }

    /// Derivative of the nodal loads of [`interior_work`](Beam::interior_work) by the position of the force, in N/mm and N.
    pub fn interior_load_slope(
        &self,
        kinematics: Kinematics,
        xi: f64,
        force: Vector,
        motion: &[EndMotion; 2],
    ) -> ElementVector {
        // The work and its derivatives are linear in the `Shape`.
        self.work_on(kinematics, Shape::slope_at(xi, self), force, motion).gradient / self.length_mm
    }

    /// Rotation of the beam's axis at the fraction `xi` of its length, rad: the rotation of the chord plus the slope of the deflection.
    pub fn interior_rotation(&self, xi: f64, motion: &[EndMotion; 2]) -> f64 {
        let chord = Chord::deformed(self, motion);
        let deformation = chord.deformation(motion);
        let levers = Shape::slope_at(xi, self).levers;
        // The rotation of the first end counts full turns; `chord.rotation` does not.
        let chord_rotation = motion[0].rotation - deformation[1];
        chord_rotation + (levers[0] * deformation[1] + levers[1] * deformation[2]) / self.length_mm
    }

    /// Converts derivatives by the end slopes psi of the axis to derivatives by the end rotations phi. With the sway factor r, the shear angle of the whole
    /// beam is (1 - r) / 2 times the sum of the rotations: psi = phi - (1 - r) (phi_a + phi_b) / 2.
    pub(super) fn by_rotations(&self, by_slopes: [f64; 2]) -> [f64; 2] {
        let by_shear = 0.5 * (1.0 - self.sway_factor) * (by_slopes[0] + by_slopes[1]);
        by_slopes.map(|by_slope| by_slope - by_shear)
    }

    fn work_on(&self, kinematics: Kinematics, shape: Shape, force: Vector, motion: &[EndMotion; 2]) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let chord = if linear { Chord::at_rest(self) } else { Chord::deformed(self, motion) };
        let deformation = if linear { chord.linear_deformation(motion) } else { chord.deformation(motion) };
        let gradients = chord.gradients();

        // Deflection w across the chord, mm, and its gradient.
        let Shape { shares, levers } = shape;
        let deflection = levers[0] * deformation[1] + levers[1] * deformation[2];
        let by_deflection = (gradients.row(1) * levers[0] + gradients.row(2) * levers[1]).transpose();

        let (along, across) = (force.dot(&chord.along), force.dot(&chord.across));
        let chord_point = motion[0].displacement * shares[0] + motion[1].displacement * shares[1];
        let ends = shares.map(|share| force * share);
        let energy = force.dot(&chord_point) + across * deflection;
        let mut gradient =
            ElementVector::new(ends[0].x, ends[0].y, 0.0, ends[1].x, ends[1].y, 0.0) + by_deflection * across;
        let mut tangent = ElementMatrix::zeros();
        if !linear {
            // The chord rotates with the ends: d(across) = -along d(rotation), d(along) = across d(rotation). The second derivative of the relative
            // end rotations phi = theta - rotation is minus the second derivative of the chord's rotation.
            let turning = chord.rotation_gradient();
            gradient -= turning * (along * deflection);
            tangent = -(by_deflection * turning.transpose() + turning * by_deflection.transpose()) * along
                - turning * turning.transpose() * (across * deflection)
                - chord.rotation_hessian() * (along * deflection + across * (levers[0] + levers[1]));
        }
        Response { energy, gradient, tangent }
    }
}
