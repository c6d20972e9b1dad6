//! The commands of `finray`: arguments, input and output of each.

pub mod calibrate;
pub mod grasp;
pub mod gripper;
pub mod guide;
pub mod lens;
pub mod live;
pub mod locate;
pub mod map;
pub mod merge;
pub mod press;
pub mod render;
pub mod report;
pub mod sense;
pub mod setup;
pub mod solve;
pub mod sweep;
#[cfg(feature = "train")]
pub mod train;
pub mod words;

mod contacts;
mod frames;
mod grid;
mod hints;
mod loads;
mod parse;
mod prelude;
mod scenes;

use finray_contact::ContactError;
use finray_files::{FileError, is_standard_stream};
use finray_lattice::LatticeError;
use finray_model::checked_shape::CheckedShapeError;
use finray_model::estimators::EstimatorError;
use finray_model::sensing::SensingError;
use finray_model::sensing::network::NetworkError;
use finray_model::sensor::Refusal;
use finray_model::statics::StaticsError;
use finray_studies::sampling::sweep::MergeError;
use finray_studies::truths::{NotExported, TruthError, TwinError};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Reason why a command ends without a result.
pub enum Failure {
    /// The input is bad or does not determine a unique answer: exit code 2.
    BadInput(String),
    /// The input is valid, but the computation failed or a result could not be written: exit code 1.
    NotComputed(String),
}

impl Failure {
    /// Message that says what failed and why.
    pub fn reason(&self) -> &str {
        match self {
            Failure::BadInput(message) | Failure::NotComputed(message) => message,
        }
    }

    /// Prints the message on standard error, and returns the exit code.
    pub fn report(&self) -> ExitCode {
        let (message, code) = match self {
            Failure::BadInput(message) => (message, 2),
            Failure::NotComputed(message) => (message, 1),
        };
        print_message(format_args!("error: {message}"));
        ExitCode::from(code)
    }
}

/// Beginning of a message that `--quiet` omits.
const NOTE: &str = "note: ";
/// Whether notes are omitted.
static OMITS_NOTES: AtomicBool = AtomicBool::new(false);

/// Omits all later notes, for `--quiet`.
pub fn omit_notes() {
    OMITS_NOTES.store(true, Ordering::Relaxed);
}

/// Prints a message on standard error, unless it is a note and notes are omitted.
pub fn print_message(message: impl Display) {
    let message = message.to_string();
    if !(message.starts_with(NOTE) && OMITS_NOTES.load(Ordering::Relaxed)) {
        print_line(message);
    }
}

/// Prints a line on standard error. A failed write, for example on a full disk, changes neither result nor exit code.
pub fn print_line(line: impl Display) {
    let _ = io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// Prints clap's output (help, version or usage error) and returns its exit code. If help or version cannot be written to standard output, the exit
/// code is 1; a usage error that cannot be written is ignored.
pub fn print_answer(answer: &clap::Error) -> ExitCode {
    match answer.print().and_then(|()| io::stdout().flush()) {
        Err(reason) if !answer.use_stderr() && reason.kind() != io::ErrorKind::BrokenPipe => {
            Failure::from(FileError::Unwritable { path: PathBuf::from("standard output"), reason }).report()
        }
        _ => u8::try_from(answer.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from),
    }
}

/// Summary line of a command: its result, and the files that it wrote; standard output is not listed.
fn summary<F: AsRef<Path>>(result: impl Display, files: impl IntoIterator<Item = F>) -> String {
    let files = files.into_iter().filter(|file| !is_standard_stream(file.as_ref()));
    let files: Vec<String> = files.map(|file| file.as_ref().display().to_string()).collect();
    let written = if files.is_empty() { String::new() } else { format!("; written to {}", files.join(", ")) };
    format!("done: {result}{written}")
}

/// A count with its noun, in the plural unless the count is 1.
fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

/// A progress bar with the remaining time; hidden if standard error is not a terminal.
fn progress_bar(steps: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(steps);
    // `with_template` fails only for an invalid template, and this template is a valid constant.
    if let Ok(style) = ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len} {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}

/// Failure because of bad input.
pub(crate) fn bad_input(reason: impl ToString) -> Failure {
    Failure::BadInput(reason.to_string())
}

/// Failure because a result could not be computed.
pub(crate) fn not_computed(reason: impl ToString) -> Failure {
    Failure::NotComputed(reason.to_string())
}

/// Path of the figure written beside a table: the same name with suffix svg.
fn figure_path(table: &Path) -> PathBuf {
    table.with_extension("svg")
}

/// Path of a table; the suffix becomes csv if the figure would have the same path as the table.
fn path_beside_figure(table: &Path) -> PathBuf {
    if figure_path(table) == table { table.with_extension("csv") } else { table.to_owned() }
}

/// Fails if more than one input is standard input, which can be read only once.
fn require_one_standard_input<'p>(inputs: impl IntoIterator<Item = &'p PathBuf>) -> Result<(), Failure> {
    match inputs.into_iter().filter(|input| is_standard_stream(input)).count() {
        0 | 1 => Ok(()),
        _ => Err(bad_input("two inputs cannot both be -: standard input can be read only once")),
    }
}

/// Checks that each output is a separate file: neither an input nor another output, even if different paths lead to the same file. Standard streams
/// and devices pass.
fn require_separate_files<'p>(
    outputs: impl IntoIterator<Item = &'p Path>,
    inputs: impl IntoIterator<Item = &'p Path>,
) -> Result<(), Failure> {
    let file = |path: &Path| -> Option<PathBuf> {
        if is_standard_stream(path) {
            return None;
        }
        match path.canonicalize() {
            Ok(found) => Some(found).filter(|found| found.is_file() || found.is_dir()),
            Err(_) => Some(path.parent()?.join(".").canonicalize().ok()?.join(path.file_name()?)),
        }
    };
    let mut known: Vec<PathBuf> = inputs.into_iter().filter_map(file).collect();
    for output in outputs {
        let Some(found) = file(output) else { continue };
        if known.contains(&found) {
            let path = output.display();
            return Err(bad_input(format!(
                "{path}: expected a separate file for each output, found a file that is also an input or another \
                    output"
            )));
        }
        known.push(found);
    }
    Ok(())
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        if error.is_bad_input() { bad_input(error) } else { not_computed(error) }
    }
}

/// For each type of error: the variants that hold another error of this list, then the kind of failure of the other variants.
macro_rules! failures {
    ($($error:ident($($inner:ident),*) { $($variants:pat => $kind:ident,)* })*) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Failure {
                match error {
                    $($error::$inner(inner) => inner.into(),)*
                    $($variants => $kind(error),)*
                }
            }
        }
    )*};
}

failures! {
    StaticsError() {
        StaticsError::Load(_) | StaticsError::LoadNotFinite => bad_input,
        StaticsError::NotHeld | StaticsError::TooFewDigits { .. } | StaticsError::NoEquilibrium { .. } => not_computed,
    }
    SensingError(Statics) { _ => bad_input, }
    NetworkError(Sensing) { _ => bad_input, }
    CheckedShapeError(Mesh, Statics) {}
    LatticeError(Contact) {
        LatticeError::NotSettled { .. } | LatticeError::NoEquilibrium { .. } => not_computed,
        _ => bad_input,
    }
    ContactError(Statics) {
        ContactError::Tapered | ContactError::Overlap { .. } => bad_input,
        _ => not_computed,
    }
    TruthError(Mesh, Statics, Lattice) {
        TruthError::NotExported(_, NotExported::Table(_)) | TruthError::Twin(TwinError::Scene(_)) => not_computed,
        TruthError::NotExported(..) | TruthError::Twin(_) => bad_input,
    }
    EstimatorError(Mesh, Sensing, Network) { _ => bad_input, }
    Refusal(Estimator) { _ => bad_input, }
    MergeError(File) { _ => bad_input, }
}

#[cfg(feature = "train")]
impl From<finray_train::TrainError> for Failure {
    fn from(error: finray_train::TrainError) -> Failure {
        use finray_train::TrainError;
        use finray_train::samples::SamplesError;
        match error {
            TrainError::Samples(SamplesError::Contacts(inner)) => inner.into(),
            TrainError::Samples(SamplesError::Recipe { .. }) => bad_input(error),
            TrainError::Samples(_) | TrainError::Network(_) | TrainError::Backend(_) => not_computed(error),
        }
    }
}

impl From<finray_model::mesh::MeshSizeError> for Failure {
    fn from(error: finray_model::mesh::MeshSizeError) -> Failure {
        bad_input(format!("--mesh-nodes: {error}"))
    }
}

/// Results are written to memory, so the CSV writer is not expected to fail.
impl From<csv::Error> for Failure {
    fn from(error: csv::Error) -> Failure {
        not_computed(error)
    }
}
