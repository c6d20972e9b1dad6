//! One row a check, everywhere the same.

use serde::Serialize;

/// Whether a check holds what it promises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Within tolerance.
    Pass,
    /// Not within tolerance, or not a number.
    Fail,
}

/// A promise: our figure lies within `tolerance` of the reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What is solved.
    pub problem: String,
    /// The other party: "OpenSees", "closed form", ...
    pub source: String,
    /// What is compared, with its unit.
    pub quantity: String,
    /// Their figure.
    pub reference: f64,
    /// Our figure.
    pub ours: f64,
    /// Largest difference that passes, in the unit of the quantity.
    pub tolerance: f64,
    /// Whether it passes.
    pub verdict: Verdict,
}

impl Check {
    /// Compares our figure with a reference.
    pub fn new(
        problem: impl Into<String>,
        source: impl Into<String>,
        quantity: impl Into<String>,
        reference: f64,
        ours: f64,
        tolerance: f64,
    ) -> Check {
        // A figure that is not a number fails: it compares as false.
        let verdict = if (ours - reference).abs() <= tolerance { Verdict::Pass } else { Verdict::Fail };
        Check {
            problem: problem.into(),
            source: source.into(),
            quantity: quantity.into(),
            reference,
            ours,
            tolerance,
            verdict,
        }
    }

    /// Whether the check passes.
    pub fn passes(&self) -> bool {
        self.verdict == Verdict::Pass
    }
}

/// Tolerance of a count that must be met.
pub const EXACT_COUNT: f64 = 0.5;

/// The largest of some figures; not a number if one of them is not, so that it cannot hide behind the others.
pub fn worst(figures: impl IntoIterator<Item = f64>) -> f64 {
    figures.into_iter().fold(0.0, |worst: f64, figure| if worst.is_nan() || worst >= figure { worst } else { figure })
}

/// Two figures side by side where a difference is expected and nothing is promised.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// What is solved.
    pub problem: String,
    /// The other party.
    pub source: String,
    /// What is compared, with its unit.
    pub quantity: String,
    /// Their figure.
    pub reference: f64,
    /// Our figure.
    pub ours: f64,
}
