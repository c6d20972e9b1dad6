//! Counts of stated intervals that contain the true force, over the noise samples of a cell or of many cells.

use finray_model::sensor::SensedForce;
use std::ops::Add;

/// Number of samples, answers and intervals that contain the true force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct IntervalCounts {
    /// Number of samples.
    pub samples: usize,
    /// For answers without a warning, then with a warning: number of answers, and number of answers whose 95 % interval contains the true force.
    pub answers: [[usize; 2]; 2],
    /// Sums over the answers with a warning: squared errors and squared stated standard deviations, N^2.
    pub warned_squares_n2: [f64; 2],
}

impl IntervalCounts {
    /// Adds a sample: the sensed force, or `None` if it is refused. `is_warned` states whether the answer has a warning; `force_n` is the true force, N.
    pub fn count(&mut self, sensed: Option<&SensedForce>, is_warned: bool, force_n: f64) {
        self.samples += 1;
        let Some(sensed) = sensed else { return };
        let [least_n, most_n] = sensed.interval_n();
        let [answers, covered] = &mut self.answers[usize::from(is_warned)];
        *answers += 1;
        *covered += usize::from((least_n..=most_n).contains(&force_n));
        if is_warned {
            for (sum, figure) in self.warned_squares_n2.iter_mut().zip([sensed.force_n - force_n, sensed.sigma_n]) {
                *sum += figure * figure;
            }
        }
    }

    /// Number of answers.
    pub fn answered(&self) -> usize {
        self.answers[0][0] + self.answers[1][0]
    }
}

impl Add for IntervalCounts {
    type Output = IntervalCounts;

    fn add(self, other: IntervalCounts) -> IntervalCounts {
        IntervalCounts {
            samples: self.samples + other.samples,
            answers: [0, 1].map(|k| [0, 1].map(|i| self.answers[k][i] + other.answers[k][i])),
            warned_squares_n2: [0, 1].map(|i| self.warned_squares_n2[i] + other.warned_squares_n2[i]),
        }
    }
}
