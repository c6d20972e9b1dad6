//! Axial strain and curvature along a beam with dead loads between its ends.

use super::chord::Deformation;
use super::{Beam, Chord, EndMotion, Kinematics};
use crate::Vector;

/// A station: axial strain and curvature at one position of a beam. The axial strain may jump at a load, so one station is just before and one just
/// after each load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Position as a fraction of the beam's length, 0..1.
    pub xi: f64,
    /// Axial strain of the centre line, dimensionless.
    pub axial_strain: f64,
    /// Curvature of the centre line, 1/mm.
    pub curvature_per_mm: f64,
}

/// A dead force between the ends of a beam, with components along and across the chord, N.
#[derive(Debug, Clone, Copy)]
struct ChordLoad {
    xi: f64,
    along: f64,
    across: f64,
}

impl Beam {
    /// Stations from the first end to the second: two for each segment into which the loads divide the beam. Within a segment, axial strain is
    /// constant and curvature is linear, so the stations include the largest values.
    ///
    /// The motion of the ends gives the deflection w of the cubic beam, w'' = ((6 xi - 4) psi_a + (6 xi - 2) psi_b) / L, with the end slopes psi of
    /// the axis. A force between the ends adds the solution of a beam clamped at both ends. Let q = 1 - p. A force P across the chord at xi = p = 1 -
    /// q adds bending moments EI w'': P L p q^2 at the first end, -2 P L p^2 q^2 at the force and P L p^2 q at the second end. With the sway factor
    /// r, shear deformation under a force P at xi = p = 1 - q adds the moment -P L p q (q - p) (1 - r) (1 - 2 xi) / 2. A force F along the chord at
    /// xi = p = 1 - q adds the axial force F q before this position and -F p after it. For small displacements, the sum of the parts due to the end
    /// motions and the loads is exact.
    ///
    /// Source without shear: Young and Budynas, Roark's Formulas, table 8.1, case 1d.
    pub(crate) fn stations(
        &self,
        kinematics: Kinematics,
        motion: &[EndMotion; 2],
        loads: &[(f64, Vector)],
    ) -> Vec<Station> {
        let linear = kinematics == Kinematics::Linear;
        let chord = if linear { Chord::at_rest(self) } else { Chord::deformed(self, motion) };
        let deformation = if linear { chord.linear_deformation(motion) } else { chord.deformation(motion) };
        let mut loads: Vec<ChordLoad> = loads
            .iter()
            .map(|&(xi, force)| ChordLoad { xi, along: force.dot(&chord.along), across: force.dot(&chord.across) })
            .collect();
        loads.sort_by(|a, b| a.xi.total_cmp(&b.xi));
        let ends: Vec<f64> = std::iter::once(0.0).chain(loads.iter().map(|load| load.xi)).chain([1.0]).collect();
        let (strain, _) = self.axial_strain(kinematics == Kinematics::Corotational, &deformation);
        let segments = ends.windows(2).enumerate().flat_map(|(nth, ends)| {
            // The first `nth` loads lie before segment `nth` (from 0).
            let (before, after) = loads.split_at(nth);
            let axial_n = after.iter().map(|load| load.along * (1.0 - load.xi)).sum::<f64>()
                - before.iter().map(|load| load.along * load.xi).sum::<f64>();
            let axial_strain = strain + axial_n / self.axial_rigidity_n;
            [ends[0], ends[1]].map(|xi| {
                let curvature_per_mm = self.curvature_of_ends(&deformation, xi) + self.curvature_of_loads(&loads, xi);
                Station { xi, axial_strain, curvature_per_mm }
            })
        });
        segments.collect()
    }

    fn curvature_of_ends(&self, deformation: &Deformation, xi: f64) -> f64 {
        let [by_first, by_second] = self.by_rotations([6.0 * xi - 4.0, 6.0 * xi - 2.0]);
        (by_first * deformation[1] + by_second * deformation[2]) / self.length_mm
    }

    fn curvature_of_loads(&self, loads: &[ChordLoad], xi: f64) -> f64 {
        let moment = |load: &ChordLoad| {
            let (p, q) = (load.xi, 1.0 - load.xi);
            // The moment is linear from the first end to the force, and from the force to the second end.
            let shape = if xi <= p {
                p * q * q - q * q * (1.0 + 2.0 * p) * xi
            } else {
                p * p * q - p * p * (1.0 + 2.0 * q) * (1.0 - xi)
            };
            let shear = 0.5 * p * q * (q - p) * (1.0 - self.sway_factor) * (1.0 - 2.0 * xi);
            load.across * self.length_mm * (shape - shear)
        };
        loads.iter().map(moment).sum::<f64>() / self.bending_rigidity_nmm2
    }
}
