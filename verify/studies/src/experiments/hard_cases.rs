//! Hard cases: fingers, loads, measurements and inputs at the limits of computation. The tests of `finray-model` compute and record them.

use super::Context;
use crate::prelude::*;

/// A recorded figure of a hard case; `fixtures/README.md` describes the columns.
#[derive(Deserialize)]
struct Recorded {
    case: String,
    source: String,
    quantity: String,
    reference: f64,
    ours: f64,
    tolerance: f64,
}

/// Checks of the recorded hard cases, which are variants of the paper's finger; empty for any other finger.
pub(crate) fn recorded(context: &Context) -> Vec<Check> {
    let rows = csv::Reader::from_reader(finray_fixtures::results("hard_cases.csv").as_bytes()).into_deserialize();
    let check = |row: Recorded| {
        Check::new(Kind::Internal, row.case, row.source, row.quantity, row.reference, row.ours, row.tolerance)
    };
    rows.filter_map(Result::ok).map(check).filter(|_| context.is_paper).collect()
}
