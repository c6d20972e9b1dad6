//! The summary line that a command prints last on standard error: its result and the written files.

use finray_files::is_standard_stream;
use std::fmt::Display;
use std::path::Path;

/// Summary line of a command: its result, and the files that it wrote; standard output is not listed.
pub fn summary<F: AsRef<Path>>(result: impl Display, files: impl IntoIterator<Item = F>) -> String {
    let files = files.into_iter().filter(|file| !is_standard_stream(file.as_ref()));
    let files: Vec<String> = files.map(|file| file.as_ref().display().to_string()).collect();
    let written = if files.is_empty() { String::new() } else { format!("; written to {}", files.join(", ")) };
    format!("done: {result}{written}")
}

/// A count with its noun, in the plural unless the count is 1.
pub fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}
