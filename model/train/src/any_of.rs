//! Estimates forces by ridge regression on the linear finger, for any subset of the contacts. A network for any subset of the contacts learns the
//! difference between the true forces and the forces of ridge regression.

use crate::samples::Samples;
use finray_model::compliance::Compliance;
use finray_model::sensing::network::ridge_gain;
use nalgebra::{DMatrix, DVector};
use std::collections::HashMap;

/// Gain matrices of ridge regression for every subset of contacts that occurs in the samples.
pub(super) struct RidgeForces {
    /// Compliance, n x contacts for n displacement coordinates, mm/N.
    pub(super) compliance: DMatrix<f64>,
    ridge_mm_per_n: f64,
    pub(super) prior_n: f64,
    gains: HashMap<Vec<bool>, DMatrix<f64>>,
}

impl RidgeForces {
    pub(super) fn new(compliance: &Compliance, samples: &Samples, noise_mm: f64, prior_n: f64) -> RidgeForces {
        let displacement = |row: usize, load: usize| compliance.displacement(samples.markers[row / 2], load)[row % 2];
        let compliance = DMatrix::from_fn(2 * samples.markers.len(), compliance.load_count(), displacement);
        let mut ridge = RidgeForces { compliance, ridge_mm_per_n: noise_mm / prior_n, prior_n, gains: HashMap::new() };
        for touching in &samples.touching {
            if !ridge.gains.contains_key(touching) {
                ridge.gains.insert(touching.clone(), ridge.gain(touching));
            }
        }
        ridge
    }

    fn gain(&self, touching: &[bool]) -> DMatrix<f64> {
        ridge_gain(&self.compliance, touching, self.ridge_mm_per_n)
    }

    /// Force of each contact, N. Zero for contacts at which no force acts.
    pub(super) fn forces_n(&self, touching: &[bool], displacements: &DVector<f64>) -> DVector<f64> {
        match self.gains.get(touching) {
            Some(gain) => gain * displacements,
            None => self.gain(touching) * displacements,
        }
    }

    /// Root mean square difference between true force and ridge-regression force at each contact, N, over the cases with a force at this contact.
    pub(super) fn left_over_n(&self, samples: &Samples) -> Vec<f64> {
        let contacts = self.compliance.ncols();
        let (mut squares, mut counts) = (vec![0.0; contacts], vec![0_usize; contacts]);
        for (case, touching) in samples.touching.iter().enumerate() {
            let ridge_n = self.forces_n(touching, &samples.displacements.column(case).into_owned());
            for i in (0..contacts).filter(|&i| touching[i]) {
                squares[i] += (samples.forces[(i, case)] - ridge_n[i]).powi(2);
                counts[i] += 1;
            }
        }
        squares.iter().zip(&counts).map(|(square, count)| (square / (*count).max(1) as f64).sqrt()).collect()
    }
}
