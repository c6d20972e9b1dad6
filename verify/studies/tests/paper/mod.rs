//! Studies that concern only the paper's finger: its Tables I and II, one fit of Table I, its claims, causes of errors, meshes, and the finger as a
//! lattice. `FINRAY_TEST_CASES=full cargo test --release -p finray-studies --test studies -- --test-threads=1 paper::` records their results in
//! `fixtures/results`, and the report shows these files. Without the variable, the studies compare figures that take seconds with the record.

mod causes;
mod claims;
mod convergence;
mod lattice;
mod networks;
mod observations;
mod table_one;
mod table_two;
mod twin;

use finray_studies::check::{Check, Kind};
use finray_tests::assert_recorded;
use serde::{Deserialize, Serialize};

/// Forces of the paper's weights of 50 to 300 g, N (sec. V-A and V-B).
const WEIGHTS_N: [f64; 6] = [0.4903325, 0.980665, 1.4709975, 1.96133, 2.4516625, 2.941995];
/// Two machines give the same figure up to this share of the figure.
const SAME: f64 = 1e-5;

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(1e-3)
}

/// A share in percent, as in the report's sentences: two decimals below 1 %, one below 10 %.
fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        p if p < 0.95 => format!("{:.2} %", 100.0 * share),
        p if p < 9.95 => format!("{:.1} %", 100.0 * share),
        _ => format!("{:.0} %", 100.0 * share),
    }
}

/// A share in percent with at least two significant digits.
fn percent_two_digits(share: f64) -> String {
    format!("{:.*} %", (1.0 - (100.0 * share).log10().floor()).max(0.0) as usize, 100.0 * share)
}

/// Least and greatest of some figures.
fn ends(figures: impl IntoIterator<Item = f64>) -> [f64; 2] {
    figures.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], it| [least.min(it), most.max(it)])
}

fn joined<T: ToString>(items: impl IntoIterator<Item = T>, between: &str) -> String {
    items.into_iter().map(|item| item.to_string()).collect::<Vec<_>>().join(between)
}

/// A check or comparison of the report's page of checks; `fixtures/README.md` describes the columns.
#[derive(Debug, Serialize, Deserialize)]
struct CheckRow {
    kind: Kind,
    problem: String,
    source: String,
    quantity: String,
    reference: f64,
    ours: f64,
    /// `None` for a figure that is expected to differ from its reference.
    tolerance: Option<f64>,
}

impl From<Check> for CheckRow {
    fn from(check: Check) -> CheckRow {
        let Check { kind, problem, source, quantity, reference, ours, tolerance, .. } = check;
        CheckRow { kind, problem, source, quantity, reference, ours, tolerance: Some(tolerance) }
    }
}

#[track_caller]
fn assert_all_pass(checks: &[Check]) {
    let failed: Vec<&Check> = checks.iter().filter(|check| !check.passes()).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Records the checks against some sources.
#[track_caller]
fn record_checks(sources: &[&str], rows: Vec<CheckRow>) {
    let near = |a: f64, b: f64| (a - b).abs() <= 0.01 * b.abs() + 1e-9;
    let agree =
        |a: &CheckRow, b: &CheckRow| a.problem == b.problem && a.tolerance == b.tolerance && near(a.ours, b.ours);
    assert_recorded("paper_checks.csv", |row: &CheckRow| sources.contains(&&*row.source), rows, agree);
}
