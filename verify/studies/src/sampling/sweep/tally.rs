//! Running statistics of a cell's samples, in constant memory.

use super::Cell;
use crate::prelude::*;
use finray_model::sensor::SensedForce;

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
    /// Three counts: answers with a warning (`warned`), answers without a warning whose interval contains the true force (`covered`), and answers
    /// with a warning whose interval contains the true force (`covered_warned`).
    warned: usize,
    covered: usize,
    covered_warned: usize,
    /// Why the first refused sample was refused. The text has a single line, because rows are counted by their line ends.
    refusal: Option<String>,
}

impl Tally {
    /// Adds the sensed force of one sample; `force_n` is the true force, N.
    pub(super) fn answer(&mut self, sensed: &SensedForces, force_n: f64) {
        let [SensedForce { force_n: sensed_n, sigma_n, .. }] = sensed.forces[..] else { return };
        let error = sensed_n / force_n - 1.0;
        self.answered += 1;
        self.sum += error;
        self.absolute += error.abs();
        let from_mean = error - self.mean;
        self.mean += from_mean / self.answered as f64;
        self.squares += from_mean * (error - self.mean);
        self.variance_n2 += sigma_n * sigma_n;
        let covered = usize::from((sensed_n - force_n).abs() <= TWO_SIDED_95 * sigma_n);
        match sensed.warnings.is_empty() {
            true => self.covered += covered,
            false => {
                self.warned += 1;
                self.covered_warned += covered;
            }
        }
    }

    pub(super) fn refuse(&mut self, refusal: &Refusal) {
        self.refusal.get_or_insert_with(|| refusal.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
    }

    /// Returns the cell, filled with the results over its `samples` samples.
    pub(super) fn fill(&self, cell: Cell, samples: usize) -> Cell {
        let count = self.answered as f64;
        let is_stated = self.answered > 0;
        let enough = |figure: f64| (self.answered > 0 && 2 * self.answered >= samples).then_some(figure);
        let spread = match self.answered {
            0 | 1 => (cell.noise_mm == 0.0).then_some(0.0),
            _ => Some((self.squares / (count - 1.0)).sqrt()),
        };
        let sigma_n = is_stated.then(|| (self.variance_n2 / count).sqrt());
        Cell {
            samples,
            answered: self.answered,
            mean_error: enough(self.absolute / count),
            bias: enough(self.sum / count),
            spread: spread.and_then(enough),
            sigma_n: sigma_n.and_then(enough),
            refusal: self.refusal.clone(),
            warned: is_stated.then_some(self.warned),
            covered: is_stated.then_some(self.covered),
            covered_warned: is_stated.then_some(self.covered_warned),
            ..cell
        }
    }
}
