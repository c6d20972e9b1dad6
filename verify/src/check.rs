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

/// Who stands behind the reference of a check.
///
/// External and analytical references verify solvers and kinematics: OpenSees, MuJoCo and rapier are given the same EA and EI as the
/// beams, and the elastica has them in its equation. No reference here tests Euler-Bernoulli theory itself against a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Figures of another program or author: exports from OpenSees and MuJoCo, shapes that rapier steps, tables of a publication.
    External,
    /// A closed form, a theoretical order, or a solution known from the literature, whoever evaluated it.
    Analytical,
    /// Our own other formulation, mesh, balance, bound or fit.
    Internal,
}

/// A promise: our figure lies within `tolerance` of the reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Who stands behind the reference.
    pub kind: Kind,
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
        kind: Kind,
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
            kind,
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
