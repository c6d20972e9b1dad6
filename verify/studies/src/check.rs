//! Checks: one row for each comparison of a computed figure with a reference.

use finray_model::mesh::FingerShape;
use serde::{Deserialize, Serialize};

/// Verdict of a check: whether the computed figure is within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The figure is within the tolerance.
    Pass,
    /// The figure is not within the tolerance, or is NaN.
    Fail,
}

/// Origin of the reference of a check.
///
/// External and analytical references verify solvers and kinematics. OpenSees, MuJoCo and the equation of the elastica use the same EA and EI as the
/// beams. No reference here tests Euler-Bernoulli theory against a real material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Figures of another program or author: exports from OpenSees and MuJoCo, tables of a publication.
    External,
    /// A closed form, a theoretical order of convergence, or a solution from the literature, regardless of who evaluated it.
    Analytical,
    /// Another formulation, mesh, inverse, balance, bound or fit within this project, for example the spring lattice, which rapier brings to rest.
    #[default]
    Internal,
}

/// Checks that a computed figure lies within `tolerance` of a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Origin of the reference.
    pub kind: Kind,
    /// Name of the problem.
    pub problem: String,
    /// Source of the reference: "OpenSees", "closed form", ...
    pub source: String,
    /// Name of the compared quantity, with its unit.
    pub quantity: String,
    /// Figure of the reference, in the unit of the quantity.
    pub reference: f64,
    /// Figure computed by finray, in the unit of the quantity.
    pub ours: f64,
    /// Largest difference that passes, in the unit of the quantity.
    pub tolerance: f64,
    /// Whether the check passes.
    pub verdict: Verdict,
    /// Difference relative to an external or analytical reference, dimensionless. If the reference is 0, the disagreement is the magnitude of the
    /// computed figure, which is then a ratio or an angle in radians. `None` for internal checks, because many of them compare balances, counts or
    /// multiples of a standard deviation.
    pub disagreement: Option<f64>,
}

impl Kind {
    /// Every kind, the most independent first.
    pub const ALL: [Kind; 3] = [Kind::External, Kind::Analytical, Kind::Internal];

    /// Phrase that follows the number of checks in a sentence.
    pub fn in_words(self) -> &'static str {
        match self {
            Kind::External => "against other programs",
            Kind::Analytical => "against closed forms and literature",
            Kind::Internal => "of our own",
        }
    }

    /// Name of the kind in tables and in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Kind::External => "external",
            Kind::Analytical => "analytical",
            Kind::Internal => "internal",
        }
    }
}

/// Source of checks against shapes of finray's spring lattice at rest, as simulated by rapier2d. finray defines the springs, so these checks are
/// internal. Checks of forces sensed on the lattice name another source, because their references are the true forces.
pub const SETTLED_LATTICE: &str = "rapier2d lattice";
/// Source of checks whose reference is the lattice solved by finray's Newton method, which finds the shapes of least energy without rapier.
pub const NEWTON_LATTICE: &str = "spring lattice, Newton";

/// Counts of the checks with one kind of reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    /// Kind of the references.
    pub kind: Kind,
    /// Number of checks that pass.
    pub passed: usize,
    /// Number of all checks.
    pub all: usize,
}

/// Counts the checks of each kind. Kinds without checks are omitted.
pub fn tallies<'c>(checks: impl Iterator<Item = &'c Check> + Clone) -> Vec<Tally> {
    let tally = |kind| {
        let counted = checks.clone().filter(move |check| check.kind == kind);
        Tally { kind, passed: counted.clone().filter(|check| check.passes()).count(), all: counted.count() }
    };
    Kind::ALL.into_iter().map(tally).filter(|tally| tally.all > 0).collect()
}

impl Check {
    /// Compares a computed figure with a reference; `reference`, `ours` and `tolerance` have the unit of the quantity.
    pub fn new(
        kind: Kind,
        problem: impl Into<String>,
        source: impl Into<String>,
        quantity: impl Into<String>,
        reference: f64,
        ours: f64,
        tolerance: f64,
    ) -> Check {
        // NaN fails: its comparison is false.
        let verdict = if (ours - reference).abs() <= tolerance { Verdict::Pass } else { Verdict::Fail };
        let scale = if reference == 0.0 { 1.0 } else { reference.abs() };
        Check {
            kind,
            problem: problem.into(),
            source: source.into(),
            quantity: quantity.into(),
            reference,
            ours,
            tolerance,
            verdict,
            disagreement: (kind != Kind::Internal).then(|| (ours - reference).abs() / scale),
        }
    }

    /// The check without its disagreement, because a difference in multiples of stated uncertainties has no meaningful relative size.
    pub fn in_stated_uncertainties(self) -> Check {
        Check { disagreement: None, ..self }
    }

    /// This check, in which `refused` of `drawn` cases were refused. If any case was refused, the check fails and its quantity states both numbers.
    pub fn with_refused(mut self, refused: usize, drawn: usize) -> Check {
        if refused > 0 {
            self.verdict = Verdict::Fail;
            self.quantity = format!("{}; {refused} of {drawn} refused", self.quantity);
        }
        self
    }

    /// Whether the check passes.
    pub fn passes(&self) -> bool {
        self.verdict == Verdict::Pass
    }
}

/// Subject of checks: problem, kind and source of the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    kind: Kind,
    problem: String,
    source: String,
}

impl Kind {
    /// Subject for a problem whose reference is of this kind and comes from `source`.
    pub fn on(self, problem: impl Into<String>, source: impl Into<String>) -> Subject {
        Subject { kind: self, problem: problem.into(), source: source.into() }
    }
}

impl Subject {
    /// Checks that a figure equals the reference within a tolerance; all three in the unit of the quantity.
    pub fn is(&self, quantity: impl Into<String>, reference: f64, ours: f64, tolerance: f64) -> Check {
        Check::new(self.kind, self.problem.as_str(), self.source.as_str(), quantity, reference, ours, tolerance)
    }

    /// Checks that an error is zero within a tolerance, both in the unit of the quantity.
    pub fn vanishes(&self, quantity: impl Into<String>, ours: f64, tolerance: f64) -> Check {
        self.is(quantity, 0.0, ours, tolerance)
    }

    /// Checks that a count equals the reference exactly.
    pub fn counts(&self, quantity: impl Into<String>, reference: usize, ours: usize) -> Check {
        self.is(quantity, reference as f64, ours as f64, EXACT_COUNT)
    }
}

/// Tolerance of an exact count, dimensionless: any value between 0 and 1 admits only the exact number.
pub const EXACT_COUNT: f64 = 0.5;

/// Largest difference of a key node's displacement between two shapes, relative to the reference's largest displacement, dimensionless.
pub fn difference(reference: &FingerShape, other: &FingerShape) -> f64 {
    let pairs = reference.motions().iter().zip(other.motions());
    worst(pairs.map(|(a, b)| (a.displacement - b.displacement).norm())) / reference.largest_displacement_mm()
}

/// The largest of some figures, in their unit. NaN if a figure is NaN or `figures` is empty, so that a check without figures fails.
pub fn worst(figures: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |worst: f64, figure: f64| if worst.is_nan() || worst >= figure { worst } else { figure };
    figures.into_iter().reduce(larger).unwrap_or(f64::NAN)
}

/// A computed figure beside a reference, without a verdict. There is no verdict because a difference is expected, or because the figure was fitted to
/// the reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the problem.
    pub problem: String,
    /// Source of the reference.
    pub source: String,
    /// Name of the compared quantity, with its unit.
    pub quantity: String,
    /// Figure of the reference, in the unit of the quantity.
    pub reference: f64,
    /// Figure computed by finray, in the unit of the quantity.
    pub ours: f64,
}
