//! The last line of a command on standard error: what came out, and where.

use finray_files::is_standard_stream;
use std::fmt::{self, Display};
use std::path::Path;

/// What a command computed, and the files that it wrote.
pub struct Done {
    result: String,
    files: Vec<String>,
}

impl Done {
    pub fn new(result: impl Display) -> Done {
        Done { result: result.to_string(), files: Vec::new() }
    }

    /// Names a file that was written; standard output needs no name.
    pub fn to(mut self, file: &Path) -> Done {
        if !is_standard_stream(file) {
            self.files.push(file.display().to_string());
        }
        self
    }

    /// Names each of the files that were written.
    pub fn to_each<'f>(self, files: impl IntoIterator<Item = &'f Path>) -> Done {
        files.into_iter().fold(self, Done::to)
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

/// A number of things in words: the noun with an s, unless there is one.
pub fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}
