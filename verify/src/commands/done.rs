//! The summary line that a command prints last on standard error: its result and the written files.

use finray_files::is_standard_stream;
use std::fmt::{self, Display};
use std::path::Path;

/// Summary line of a command: its result, and the files that it wrote.
pub struct Done {
    result: String,
    files: Vec<String>,
}

impl Done {
    /// A summary of a result, without files.
    pub fn new(result: impl Display) -> Done {
        Done { result: result.to_string(), files: Vec::new() }
    }

    /// Adds a written file; standard output is not listed.
    pub fn with_file(mut self, file: &Path) -> Done {
        if !is_standard_stream(file) {
            self.files.push(file.display().to_string());
        }
        self
    }

    /// Adds several written files.
    pub fn with_files<'f>(self, files: impl IntoIterator<Item = &'f Path>) -> Done {
        files.into_iter().fold(self, Done::with_file)
    }
}

impl Display for Done {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "done: {}", self.result)?;
        match &self.files[..] {
            [] => Ok(()),
            files => write!(f, "; written to {}", files.join(", ")),
        }
    }
}

/// A count with its noun, in the plural unless the count is 1.
pub fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}
