//! Checks of the paper's finger that tests compute and record: hard cases, meshes, and the finger as a lattice.

use super::Context;
use crate::prelude::*;
use crate::problems::ProblemResults;

/// A recorded figure; `fixtures/README.md` describes the columns.
#[derive(Deserialize)]
struct Recorded {
    #[serde(default)]
    kind: Kind,
    #[serde(alias = "case")]
    problem: String,
    source: String,
    quantity: String,
    reference: f64,
    ours: f64,
    /// `None` for a figure that is expected to differ from its reference.
    tolerance: Option<f64>,
}

/// The recorded checks and comparisons; none for a finger that is not the paper's.
pub(crate) fn results(context: &Context) -> ProblemResults {
    let mut results = ProblemResults::default();
    let files = ["hard_cases.csv", "paper_checks.csv"].into_iter().filter(|_| context.is_paper);
    let rows =
        files.flat_map(|file| csv::Reader::from_reader(finray_fixtures::results(file).as_bytes()).into_deserialize());
    for Recorded { kind, problem, source, quantity, reference, ours, tolerance } in rows.filter_map(Result::ok) {
        match tolerance {
            Some(tolerance) => {
                results.checks.push(Check::new(kind, problem, source, quantity, reference, ours, tolerance));
            }
            None => results.comparisons.push(Comparison { problem, source, quantity, reference, ours }),
        }
    }
    results
}
