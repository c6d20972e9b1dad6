//! The pictures of a cell, counted one by one in constant memory.

use super::cell::{Errors, Outcome};
use crate::estimators::EstimatorError;

/// Sums over the pictures of one cell.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    answered: usize,
    sum: f64,
    absolute: f64,
    /// Running mean of the errors, and the sum of their squared differences from it (Welford 1962).
    mean: f64,
    squares: f64,
    variance_n2: f64,
    /// Answers that come with a standard deviation.
    stated: usize,
    /// Why the first picture that was refused gave no answer.
    refusal: Option<String>,
}

impl Tally {
    /// An answer: its error as a share of the force, and its stated standard deviation, N.
    pub(super) fn answer(&mut self, error: f64, sigma_n: Option<f64>) {
        self.answered += 1;
        self.sum += error;
        self.absolute += error.abs();
        let from_mean = error - self.mean;
        self.mean += from_mean / self.answered as f64;
        self.squares += from_mean * (error - self.mean);
        if let Some(sigma_n) = sigma_n {
            self.stated += 1;
            self.variance_n2 += sigma_n * sigma_n;
        }
    }

    /// A picture without an answer.
    pub(super) fn refuse(&mut self, error: &EstimatorError) {
        self.refusal.get_or_insert_with(|| error.to_string());
    }

    /// What came out of so many pictures.
    pub(super) fn outcome(&self, pictures: usize) -> Outcome {
        let count = self.answered as f64;
        let enough = self.answered > 0 && 2 * self.answered >= pictures;
        let errors = enough.then(|| Errors {
            mean_error: self.absolute / count,
            bias: self.sum / count,
            spread: if self.answered > 1 { (self.squares / (count - 1.0)).sqrt() } else { 0.0 },
            sigma_n: (self.stated == self.answered).then(|| (self.variance_n2 / count).sqrt()),
        });
        Outcome { pictures, answered: self.answered, errors, refusal: self.refusal.clone() }
    }
}
