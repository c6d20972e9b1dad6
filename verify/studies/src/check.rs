//! One row a check, everywhere the same.

use serde::Serialize;

/// Whether our figure is within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Within tolerance.
    Pass,
    /// Not within tolerance, or not a number.
    Fail,
}

/// Origin of the reference of a check.
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

/// A check: our figure lies within `tolerance` of the reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Origin of the reference.
    pub kind: Kind,
    /// The problem.
    pub problem: String,
    /// Whose the reference is: "OpenSees", "closed form", ...
    pub source: String,
    /// The quantity, with its unit.
    pub quantity: String,
    /// Their figure.
    pub reference: f64,
    /// Our figure.
    pub ours: f64,
    /// Largest difference that passes, in the unit of the quantity.
    pub tolerance: f64,
    /// Whether it passes.
    pub verdict: Verdict,
    /// Difference from an independent reference, external or analytical, as a share of it; where that is 0 the figure itself, which then
    /// is a ratio or in radians. Internal checks have none: many are balances, counts or multiples of a standard deviation.
    pub disagreement: Option<f64>,
}

impl Kind {
    /// Every kind, those with the most distance from us first.
    pub const ALL: [Kind; 3] = [Kind::External, Kind::Analytical, Kind::Internal];

    /// As it is written, in tables and `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            Kind::External => "external",
            Kind::Analytical => "analytical",
            Kind::Internal => "internal",
        }
    }
}

/// Source of the rows whose reference is a shape of our spring lattice that rapier2d steps until it rests. The program is another's, the
/// springs are ours. Forces that are sensed on the lattice are compared with the true ones and have another source.
pub const SETTLED_LATTICE: &str = "rapier2d lattice";

/// Whose figures checks are counted against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Against {
    /// Other programs with models of their own: [`Kind::External`] but for the lattice.
    OtherPrograms,
    /// Our lattice, settled by a physics engine: [`SETTLED_LATTICE`].
    SettledLattice,
    /// [`Kind::Analytical`].
    Literature,
    /// [`Kind::Internal`].
    Ourselves,
}

impl Against {
    /// All, those with the most distance from us first.
    pub const ALL: [Against; 4] =
        [Against::OtherPrograms, Against::SettledLattice, Against::Literature, Against::Ourselves];

    /// Within a sentence, after the number of checks.
    pub fn in_words(self) -> &'static str {
        match self {
            Against::OtherPrograms => "against other programs",
            Against::SettledLattice => "against our lattice settled by a physics engine",
            Against::Literature => "against closed forms and literature",
            Against::Ourselves => "of our own",
        }
    }
}

/// Checks against one reference: how many there are, and how many pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    /// The reference.
    pub against: Against,
    /// How many pass.
    pub passed: usize,
    /// How many there are.
    pub all: usize,
}

/// The checks counted by reference, references without checks left out: 50 comparisons with ourselves weigh less than one with another program.
pub fn tallies<'c>(checks: impl Iterator<Item = &'c Check> + Clone) -> Vec<Tally> {
    let tally = |against| {
        let counted = checks.clone().filter(move |check| check.against() == against);
        Tally { against, passed: counted.clone().filter(|check| check.passes()).count(), all: counted.count() }
    };
    Against::ALL.into_iter().map(tally).filter(|tally| tally.all > 0).collect()
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

    /// The check of a difference that is counted in the uncertainties which the reference states, and so says nothing of its size.
    pub fn in_stated_uncertainties(self) -> Check {
        Check { disagreement: None, ..self }
    }

    /// The check over cases of which some were refused, counted with the quantity: it fails, as no answer keeps no tolerance.
    pub fn with_refused(mut self, refused: usize, drawn: usize) -> Check {
        if refused > 0 {
            self.verdict = Verdict::Fail;
            self.quantity = format!("{}; {refused} of {drawn} refused", self.quantity);
        }
        self
    }

    /// Whose figures it is counted against.
    pub fn against(&self) -> Against {
        match self.kind {
            Kind::External if self.source == SETTLED_LATTICE => Against::SettledLattice,
            Kind::External => Against::OtherPrograms,
            Kind::Analytical => Against::Literature,
            Kind::Internal => Against::Ourselves,
        }
    }

    /// Whether the check passes.
    pub fn passes(&self) -> bool {
        self.verdict == Verdict::Pass
    }
}

/// What is checked, and against whom; makes the checks of its quantities.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    kind: Kind,
    problem: String,
    source: String,
}

impl Kind {
    /// A problem, and whose the reference of this kind is.
    pub fn on(self, problem: impl Into<String>, source: impl Into<String>) -> Subject {
        Subject { kind: self, problem: problem.into(), source: source.into() }
    }
}

impl Subject {
    /// Our figure is the reference's within a tolerance.
    pub fn is(&self, quantity: impl Into<String>, reference: f64, ours: f64, tolerance: f64) -> Check {
        Check::new(self.kind, self.problem.as_str(), self.source.as_str(), quantity, reference, ours, tolerance)
    }

    /// An error is nothing within a tolerance.
    pub fn vanishes(&self, quantity: impl Into<String>, ours: f64, tolerance: f64) -> Check {
        self.is(quantity, 0.0, ours, tolerance)
    }

    /// There are just so many of something.
    pub fn counts(&self, quantity: impl Into<String>, reference: usize, ours: usize) -> Check {
        self.is(quantity, reference as f64, ours as f64, EXACT_COUNT)
    }
}

/// Tolerance of a count that must be met.
pub const EXACT_COUNT: f64 = 0.5;

/// The largest of some figures; not a number if one of them is not, or there is none: a check over nothing must not pass.
pub fn worst(figures: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |worst: f64, figure: f64| if worst.is_nan() || worst >= figure { worst } else { figure };
    figures.into_iter().reduce(larger).unwrap_or(f64::NAN)
}

/// Two figures side by side where a difference is expected, or is the residual of a fit: no check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The problem.
    pub problem: String,
    /// Whose the reference is.
    pub source: String,
    /// The quantity, with its unit.
    pub quantity: String,
    /// Their figure.
    pub reference: f64,
    /// Our figure.
    pub ours: f64,
}
