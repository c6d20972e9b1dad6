//! Results files that the report shows. A full study writes them; every other run checks that they are up to date.

use crate::chance::is_full_study;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Lock with which concurrent tests use the files one after the other.
static FILES: Mutex<()> = Mutex::new(());

/// Path of a file in `fixtures/results`.
pub fn results_file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures/results").join(name)
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
    let read = |mut table: csv::Reader<_>| table.deserialize().collect::<Result<Vec<R>, _>>().expect("rows of results");
    let recorded = csv::Reader::from_path(&file).map(read).unwrap_or_default();
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
