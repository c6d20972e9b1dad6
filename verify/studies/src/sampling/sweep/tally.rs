//! Running statistics of a cell's samples, in constant memory.

use super::Cell;
use crate::prelude::*;
use crate::sampling::intervals::IntervalCounts;
use statrs::function::erf::erf;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI, SQRT_2};

/// Number of standard deviations, times the square root of one half, beyond which a normal distribution has no rounding error's worth of weight.
const FAR: f64 = 6.0;

/// Sums over the samples of one cell.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    /// Relative standard deviation of the error that all forces of a finger share, dimensionless; the true finger of a sweep does not have this error.
    common_sd: f64,
    intervals: IntervalCounts,
    sum: f64,
    absolute: f64,
    /// Running mean of the errors, and sum of their squared deviations from it (Welford 1962).
    mean: f64,
    squares: f64,
    variance_n2: f64,
    /// Why the first refused sample was refused. The text has a single line, because rows are counted by their line ends.
    refusal: Option<String>,
}

impl Tally {
    pub(super) fn new(common_sd: f64) -> Tally {
        Tally { common_sd, ..Tally::default() }
    }

    /// Adds the sensed force of one sample; `force_n` is the true force, N.
    pub(super) fn answer(&mut self, sensed: &SensedForces, force_n: f64) {
        let [force] = &sensed.forces[..] else { return };
        self.intervals.count(Some(force), !sensed.warnings.is_empty(), force_n);
        let error = force.force_n / force_n - 1.0;
        self.sum += error;
        self.absolute += mean_absolute(error, self.common_sd);
        let from_mean = error - self.mean;
        self.mean += from_mean / self.intervals.answered() as f64;
        self.squares += from_mean * (error - self.mean);
        self.variance_n2 += force.sigma_n * force.sigma_n;
    }

    pub(super) fn refuse(&mut self, refusal: &Refusal) {
        self.refusal.get_or_insert_with(|| refusal.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
    }

    /// Returns the cell, filled with the results over its `samples` samples.
    pub(super) fn fill(&self, cell: Cell, samples: usize) -> Cell {
        let (answered, [[_, covered], [warned, covered_warned]]) = (self.intervals.answered(), self.intervals.answers);
        let count = answered as f64;
        let enough = |figure: f64| (answered > 0 && 2 * answered >= samples).then_some(figure);
        let spread = match answered {
            0 | 1 => (cell.noise_mm == 0.0).then_some(0.0),
            _ => Some((self.squares / (count - 1.0)).sqrt()),
        };
        let stated = |count: usize| (answered > 0).then_some(count);
        Cell {
            samples,
            answered,
            mean_error: enough(self.absolute / count),
            bias: enough(self.sum / count),
            spread: spread.and_then(enough),
            sigma_n: enough((self.variance_n2 / count).sqrt()),
            refusal: self.refusal.clone(),
            warned: stated(warned),
            covered: stated(covered),
            covered_warned: stated(covered_warned),
            ..cell
        }
    }
}

/// Mean of |x| for a normal x with this mean and standard deviation: the mean of the folded normal distribution (Leone, Nelson and Nottingham,
/// Technometrics 3, 1961).
pub(in crate::sampling) fn mean_absolute(mean: f64, sd: f64) -> f64 {
    let z = mean / (SQRT_2 * sd);
    // Beyond this, all of the distribution lies on one side of zero; without a standard deviation, z is infinite or not a number.
    if z.is_nan() || z.abs() >= FAR {
        return mean.abs();
    }
    sd * FRAC_2_SQRT_PI * FRAC_1_SQRT_2 * (-z * z).exp() + mean * erf(z)
}

#[cfg(test)]
#[path = "../../../tests/units/tally.rs"]
mod tests;
