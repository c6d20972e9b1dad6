//! The problem at a state: weighted residual and its derivatives.

use super::unknowns::Unknown;
use super::{NonlinearEstimator, State};
use crate::Vector;
use crate::measurement::Measurement;
use crate::sensing::{Contact, SensingError};
use crate::statics::StaticsError;
use nalgebra::{DMatrix, DVector};

/// Markers off by more than this many standard deviations count less (Cauchy's weight beyond it).
const OUTLIER_SIGMAS: f64 = 4.5;
/// Ratio of the median of a Rayleigh distribution to the standard deviation of one coordinate.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_6;

/// The problem linearised at a state: residual and derivatives, weighted.
pub(super) struct Linearised {
    pub residual: DVector<f64>,
    pub jacobian: DMatrix<f64>,
}

impl NonlinearEstimator<'_> {
    /// Weighted difference between what was measured and the state.
    pub(super) fn residual(&self, state: &State, measurement: &Measurement, weights: &[f64]) -> DVector<f64> {
        let markers = measurement.markers().iter().zip(weights);
        let differences = markers.flat_map(|(marker, weight)| {
            let difference = marker.displacement - state.motion.displacements[self.mesh.frame_node(marker.node)];
            [difference.x * weight * marker.weight, difference.y * weight * marker.weight]
        });
        DVector::from_iterator(measurement.coordinate_count(), differences)
    }

    /// A weight a marker: 1, and less for one that is wildly off (the square root of Cauchy's weight).
    pub(super) fn robust_weights(&self, state: &State, measurement: &Measurement, noise_mm: Option<f64>) -> Vec<f64> {
        let off: Vec<f64> = measurement
            .markers()
            .iter()
            .map(|m| m.weight * (m.displacement - state.motion.displacements[self.mesh.frame_node(m.node)]).norm())
            .collect();
        let mut sorted = off.clone();
        sorted.sort_by(f64::total_cmp);
        // The median also stands for what the model itself cannot explain.
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0) / RAYLEIGH_MEDIAN;
        let limit = OUTLIER_SIGMAS * noise_mm.unwrap_or(0.0).max(median);
        off.iter().map(|&off| if off > limit && limit > 0.0 { limit / off } else { 1.0 }).collect()
    }

    pub(super) fn linearise(
        &mut self,
        state: &State,
        measurement: &Measurement,
        weights: &[f64],
        unknowns: &[Unknown],
    ) -> Result<Linearised, SensingError> {
        if !self.statics.linearise(&state.motion, &state.loads) {
            return Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 }));
        }
        let finger = self.finger();
        let mut jacobian = DMatrix::zeros(measurement.coordinate_count(), unknowns.len());
        let mut moved = vec![Vector::zeros(); finger.key_node_count()];
        for (column, unknown) in unknowns.iter().enumerate() {
            let ladder = self.statics.equations_mut();
            match *unknown {
                Unknown::Force(i) => {
                    let unit = self.mesh.frame_load(&state.contacts[i].unit_load(finger))?;
                    ladder.added_load(&state.motion, &unit, &mut moved);
                }
                Unknown::Across(i) => {
                    let sideways = Contact { angle_deg: state.contacts[i].angle_deg + 90.0, ..state.contacts[i] };
                    let unit = self.mesh.frame_load(&sideways.unit_load(finger))?;
                    ladder.added_load(&state.motion, &unit, &mut moved);
                }
                Unknown::Place(i) => ladder.moved_load(&state.motion, &state.loads[i], &mut moved),
            }
            for (row, (marker, weight)) in measurement.markers().iter().zip(weights).enumerate() {
                let u = moved[marker.node.0 - 1] * (weight * marker.weight);
                jacobian[(2 * row, column)] = u.x;
                jacobian[(2 * row + 1, column)] = u.y;
            }
        }
        Ok(Linearised { residual: self.residual(state, measurement, weights), jacobian })
    }
}
