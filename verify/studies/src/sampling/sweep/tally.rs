//! Running statistics of a cell's samples, in constant memory.

use super::cell::{Covered, Errors, Outcome};
use crate::prelude::*;

/// Sums over the samples of one cell.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    answered: usize,
    sum: f64,
    absolute: f64,
    /// Running mean of the errors, and sum of their squared deviations from it (Welford 1962).
    mean: f64,
    squares: f64,
    variance_n2: f64,
    /// Number of answers with a standard deviation.
    stated: usize,
    covered: Covered,
    /// Reason of the first refused sample.
    refusal: Option<String>,
}

impl Tally {
    /// Adds an answer to a sample with true force `force_n` (N).
    pub(super) fn answer(&mut self, sensed: &Sensed, force_n: f64) {
        let error = sensed.forces_n[0] / force_n - 1.0;
        self.answered += 1;
        self.sum += error;
        self.absolute += error.abs();
        let from_mean = error - self.mean;
        self.mean += from_mean / self.answered as f64;
        self.squares += from_mean * (error - self.mean);
        if let Some(sigma_n) = sensed.sigmas_n.as_ref().and_then(|sigmas_n| sigmas_n.first()) {
            self.stated += 1;
            self.variance_n2 += sigma_n * sigma_n;
            let covered = usize::from((sensed.forces_n[0] - force_n).abs() <= TWO_SIDED_95 * sigma_n);
            self.covered.warned += usize::from(sensed.warned);
            match sensed.warned {
                false => self.covered.covered += covered,
                true => self.covered.covered_warned += covered,
            }
        }
    }

    pub(super) fn refuse(&mut self, error: &EstimatorError) {
        self.refusal.get_or_insert_with(|| error.to_string());
    }

    pub(super) fn outcome(&self, samples: usize) -> Outcome {
        let count = self.answered as f64;
        let enough = self.answered > 0 && 2 * self.answered >= samples;
        let errors = enough.then(|| Errors {
            mean_error: self.absolute / count,
            bias: self.sum / count,
            spread: if self.answered > 1 { (self.squares / (count - 1.0)).sqrt() } else { 0.0 },
            sigma_n: (self.stated == self.answered).then(|| (self.variance_n2 / count).sqrt()),
        });
        let covered = (self.answered > 0 && self.stated == self.answered).then_some(self.covered);
        Outcome { samples, answered: self.answered, errors, covered, refusal: self.refusal.clone() }
    }
}
