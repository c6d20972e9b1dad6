//! Statistical tests of stated standard deviations. A full study records its figures. Runs with fewer cases also check that the record of the full
//! study is up to date.

use crate::chance::{STANDARD_ERRORS, TWO_SIDED_95, is_full_study, share_error};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

const TABLE: &str = "studies.csv";
const HEADER: &str = "study,mean_square_of_first,cases,share_within_95,mean_square";
/// Number of errors, from the start of a study, that are compared with the record; a run with few cases has the same first errors as the full study.
/// The record is stale if the mean square of the first errors differs from the recorded mean square by more than the share `FRESH`.
const FIRST: usize = 30;
const FRESH: f64 = 0.01;

fn mean_square(errors: &[f64]) -> f64 {
    errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64
}

/// Checks errors that are given in stated standard deviations. The share of errors within the 95 % interval must be 0.95, up to three standard errors
/// for the number of cases. The mean square of the errors must be 1 within four standard errors. The full study writes its figures to
/// `fixtures/results/studies.csv`. A run with fewer cases fails if the record of the full study is stale.
///
/// # Panics
/// If errors are larger or smaller than stated, or the record is stale.
#[track_caller]
pub fn assert_standardised(study: &str, errors: &[f64]) {
    let count = errors.len();
    let within = errors.iter().filter(|error| error.abs() <= TWO_SIDED_95).count();
    let (share, square) = (within as f64 / count as f64, mean_square(errors));
    println!("{study}: {share} of {count} within 95 %, mean square {square}");
    assert!((share - 0.95).abs() <= 3.0 * share_error(0.95, count), "{study}: {share} of {count} within 95 %");
    // The mean square of n standard normal errors has the standard deviation sqrt(2 / n).
    let chance = STANDARD_ERRORS * (2.0 / count as f64).sqrt();
    assert!((square - 1.0).abs() <= chance, "{study}: mean square {square} of {count}");
    let Some(first) = errors.get(..FIRST).map(mean_square) else { return };
    if is_full_study() {
        return record_row(TABLE, HEADER, study, &format!("{first:.4},{count},{share:.4},{square:.4}"));
    }
    let recorded = rows(TABLE).get(study).and_then(|row| row.split(',').next()?.parse::<f64>().ok());
    assert!(
        recorded.is_some_and(|recorded| (first / recorded - 1.0).abs() <= FRESH),
        "{study}: the first {FIRST} errors have a mean square of {first:.4}, in fixtures/results/studies.csv {recorded:?}: \
         run this test with FINRAY_TEST_CASES=full"
    );
}

/// Rows of a table in `fixtures/results`, by the first column. A table that does not exist has no rows.
fn rows(table: &str) -> BTreeMap<String, String> {
    let text = fs::read_to_string(file(table)).unwrap_or_default();
    let rows = text.lines().skip(1).filter_map(|line| line.split_once(','));
    rows.map(|(name, figures)| (name.to_owned(), figures.to_owned())).collect()
}

fn file(table: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/results").join(table)
}

/// Lock with which concurrent tests write their records one after the other.
static WRITING: Mutex<()> = Mutex::new(());

/// Writes the row `name` of a table in `fixtures/results`, or replaces this row.
///
/// # Panics
/// If the table cannot be written.
pub fn record_row(table: &str, header: &str, name: &str, figures: &str) {
    let _one = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut rows = rows(table);
    rows.insert(name.to_owned(), figures.to_owned());
    let rows: String = rows.iter().map(|(name, figures)| format!("{name},{figures}\n")).collect();
    fs::write(file(table), format!("{header}\n{rows}")).expect("the folder of results");
}
