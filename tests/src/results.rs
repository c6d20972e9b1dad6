//! Results files that the report shows. A full study writes them; every other run checks that they are up to date.

use crate::chance::is_full_study;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Lock with which concurrent tests use the files one after the other.
static FILES: Mutex<()> = Mutex::new(());

/// Path of a file in `fixtures/results`.
pub fn results_file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/results").join(name)
}

/// Rows of a table in `fixtures/results` (CSV); none if there is no such table.
///
/// # Panics
/// If the table cannot be read.
pub fn recorded<R: DeserializeOwned>(table: &str) -> Vec<R> {
    let read = |mut table: csv::Reader<_>| table.deserialize().collect::<Result<_, _>>().expect("rows of results");
    csv::Reader::from_path(results_file(table)).map(read).unwrap_or_default()
}

/// Compares `rows` with the rows of the same group in a table in `fixtures/results` (CSV). `same` states whether a computed and a recorded row agree.
/// A full study replaces the recorded rows of the group instead, at their place in the table.
///
/// # Panics
/// If the recorded rows are stale, or the table cannot be read or written.
#[track_caller]
pub fn assert_recorded<R>(table: &str, in_group: impl Fn(&R) -> bool, rows: Vec<R>, same: impl Fn(&R, &R) -> bool)
where
    R: Serialize + DeserializeOwned + Debug,
{
    let _one = FILES.lock().unwrap_or_else(PoisonError::into_inner);
    let file = results_file(table);
    let recorded: Vec<R> = recorded(table);
    if !is_full_study() {
        let recorded: Vec<&R> = recorded.iter().filter(|row| in_group(row)).collect();
        let agree =
            recorded.len() == rows.len() && rows.iter().zip(&recorded).all(|(row, recorded)| same(row, recorded));
        assert!(
            agree,
            "fixtures/results/{table} is stale: run this test with FINRAY_TEST_CASES=full. {rows:?}, recorded {recorded:?}"
        );
        return;
    }
    let place = recorded.iter().position(&in_group).unwrap_or(recorded.len());
    let mut all: Vec<R> = recorded.into_iter().filter(|row| !in_group(row)).collect();
    all.splice(place..place, rows);
    let mut table = csv::Writer::from_path(&file).expect("the folder of results");
    all.iter().for_each(|row| table.serialize(row).expect("a row"));
    table.flush().expect("the table of results");
}

#[derive(Debug, Serialize, Deserialize)]
struct Sentence {
    section: String,
    shown: String,
    sentence: String,
}

/// Checks or records a sentence of a section of the report, which begins like this one. `shown` is `says` for a conclusion, `text` for a paragraph.
///
/// # Panics
/// As [`assert_recorded`].
#[track_caller]
pub fn assert_said(section: &str, shown: &str, sentence: String) {
    let begins: String = sentence.chars().take(30).collect();
    let row = Sentence { section: section.to_owned(), shown: shown.to_owned(), sentence };
    let group = |row: &Sentence| row.section == section && row.sentence.starts_with(&begins);
    assert_recorded("sentences.csv", group, vec![row], |a, b| a.sentence == b.sentence && a.shown == b.shown);
}
