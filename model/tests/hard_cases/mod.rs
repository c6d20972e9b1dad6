//! Fingers, loads, measurements and inputs at the limits of computation, each with an expected outcome.
//!
//! No expectation relies on the solver itself. Each expectation is a scaling law, another method, an energy balance, equilibrium of the reactions, a
//! known limit, or a refusal. The report of the paper's finger shows the figures, which `FINRAY_TEST_CASES=full` records in
//! `fixtures/results/hard_cases.csv`.

mod fingers;
mod input;
mod loads;
mod measurements;
mod soundness;

use finray_model::{Finger, NodeId};
use finray_tests::assert_recorded;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// A case fails if its computation takes longer than this.
const TIME_LIMIT: Duration = Duration::from_secs(5);
/// Two machines give the same figure up to this share of its tolerance, because their rounding errors differ.
const SAME_FIGURE: f64 = 0.1;
/// Tolerance of an exact count.
const EXACT_COUNT: f64 = 0.5;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A figure of a hard case, with its tolerance.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Figure {
    case: String,
    difficulty: String,
    expectation: String,
    source: String,
    quantity: String,
    reference: f64,
    ours: f64,
    tolerance: f64,
}

/// Figures of one hard case.
struct Case {
    name: [&'static str; 3],
    figures: Vec<Figure>,
    begun: Instant,
}

impl Case {
    /// A hard case, the reason why it is hard, and the expected outcome.
    fn new(name: &'static str, difficulty: &'static str, expectation: &'static str) -> Case {
        Case { name: [name, difficulty, expectation], figures: Vec::new(), begun: Instant::now() }
    }

    /// Adds a figure and its reference: another method, or a law that solutions obey.
    fn is(&mut self, source: &str, quantity: &str, reference: f64, ours: f64, tolerance: f64) {
        let [case, difficulty, expectation, source, quantity] =
            [self.name[0], self.name[1], self.name[2], source, quantity].map(str::to_owned);
        self.figures.push(Figure { case, difficulty, expectation, source, quantity, reference, ours, tolerance });
    }

    fn vanishes(&mut self, source: &str, quantity: &str, ours: f64, tolerance: f64) {
        self.is(source, quantity, 0.0, ours, tolerance);
    }

    fn counts(&mut self, source: &str, quantity: &str, reference: usize, ours: usize) {
        self.is(source, quantity, reference as f64, ours as f64, EXACT_COUNT);
    }

    /// Checks every figure, the time, and the recorded figures.
    #[track_caller]
    fn holds(self) -> Outcome {
        assert!(self.begun.elapsed() < TIME_LIMIT && !self.figures.is_empty());
        for figure in &self.figures {
            assert!((figure.ours - figure.reference).abs() <= figure.tolerance, "{figure:?}");
        }
        let same = |a: &Figure, b: &Figure| {
            let [texts, others] =
                [a, b].map(|f| (f.difficulty.clone(), f.expectation.clone(), f.source.clone(), f.quantity.clone()));
            texts == others
                && [a.reference, a.tolerance] == [b.reference, b.tolerance]
                && (a.ours - b.ours).abs() <= SAME_FIGURE * a.tolerance
        };
        assert_recorded("hard_cases.csv", |row: &Figure| row.case == self.name[0], self.figures, same);
        Ok(())
    }
}

fn middle(finger: &Finger) -> NodeId {
    let nodes: Vec<NodeId> = finger.contact_nodes().collect();
    nodes[nodes.len() / 2]
}

/// The largest of some figures; NaN if one is NaN, or there is none.
fn worst(figures: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |worst: f64, figure: f64| if worst.is_nan() || worst >= figure { worst } else { figure };
    figures.into_iter().reduce(larger).unwrap_or(f64::NAN)
}
