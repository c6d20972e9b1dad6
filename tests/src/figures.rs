//! Figures that guides quote. Each study writes the figures that it measures to a table, together with a digest of the measured code.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// Errors of a set of sensed forces, and coverage of their intervals.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Figure {
    /// Name of the study.
    pub study: String,
    /// First cell of the row in the guide's table.
    pub row: String,
    /// Quantities that are known to the estimator, such as the direction and the noise.
    pub question: String,
    /// Number of forces.
    pub cases: usize,
    /// Number of refused forces.
    pub refused: usize,
    /// Mean error, as a share of the true force.
    pub mean_error: f64,
    /// Largest error, as a share of the true force.
    pub largest_error: f64,
    /// Share of the 95 % intervals that contain the true force.
    pub within: f64,
    /// Standard error of the share `within`.
    pub standard_error: f64,
    /// [`state_of_code`] at the time of the measurement.
    pub state: String,
    /// Date of the measurement in UTC, such as 2026-11-26.
    pub date: String,
    /// Command that repeats the measurement.
    pub command: String,
}

/// Lock with which concurrent studies write to the table one after the other.
static WRITING: Mutex<()> = Mutex::new(());

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn file() -> PathBuf {
    root().join("fixtures/results/coverage.csv")
}

/// The recorded figures, in the order of the table.
///
/// # Panics
/// If the table cannot be read.
pub fn recorded_figures() -> Vec<Figure> {
    let mut table = csv::Reader::from_path(file()).expect("the table of figures");
    table.deserialize().collect::<Result<_, _>>().expect("rows of figures")
}

/// Replaces the figures of a study in the table. Fills in the study, state, date and command of each figure.
///
/// # Panics
/// If the table cannot be written.
pub fn record_figures(study: &str, command: &str, figures: Vec<Figure>) {
    let _one = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let (state, date) = (state_of_code(), today());
    let mut all = if file().exists() { recorded_figures() } else { Vec::new() };
    all.retain(|other| other.study != study);
    all.extend(figures.into_iter().map(|figure| Figure {
        study: study.to_owned(),
        state: state.clone(),
        date: date.clone(),
        command: command.to_owned(),
        ..figure
    }));
    all.sort_by(|a, b| a.study.cmp(&b.study));
    let mut table = csv::Writer::from_path(file()).expect("the table of figures");
    all.iter().for_each(|row| table.serialize(row).expect("a row"));
    table.flush().expect("the table of figures");
}

/// Digest of the measured code: the sources of model, imaging and numerics. Comment lines, blank lines and string literals within a line do not count.
pub fn state_of_code() -> String {
    let mut files = Vec::new();
    for folder in ["model/src", "model/imaging/src", "model/numerics/src"] {
        sources(&root().join(folder), &mut files);
    }
    files.sort();
    let mut digest = Sha256::new();
    for path in files {
        let text = fs::read_to_string(path).expect("a source file");
        let code = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
        code.for_each(|line| line.split('"').step_by(2).for_each(|part| digest.update(part)));
    }
    digest.finalize().iter().take(6).map(|byte| format!("{byte:02x}")).collect()
}

fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The present date in UTC, such as 2026-11-26.
///
/// # Reference
/// Source: Howard Hinnant, chrono-Compatible Low-Level Date Algorithms, function `civil_from_days`.
pub fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).expect("a time after 1970").as_secs();
    let days = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02}")
}
