//! Input and output: scenes, displacements, observations and images from files, and results written as whole files.
#![forbid(unsafe_code)]

mod images;
mod lens;
mod networks;
mod origin;
mod outline;
mod output;
mod scene;
pub mod table;
mod video;

pub mod displacements;
pub mod frames;
pub mod live;
pub mod measurements;
pub mod observations;
pub mod positions;
pub mod recording;
pub mod views;

pub use images::{image_named, image_names, load_image};
pub use lens::load_lens;
pub use networks::load_network;
pub use origin::{Elsewhere, of_another_finger};
pub use outline::outline_corners;
pub use output::{
    csv_text, is_stream, open_stream, require_folder, require_writable, streamed, write_all_or_nothing, write_file,
    write_folder, write_from,
};
pub use scene::{load_scene, load_scene_and_text, with_comments, with_values};
pub use video::DecodedVideo;

use std::io::Read;
use std::path::{Path, PathBuf};

/// Reason why a file cannot be read, understood or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {reason}", name_of(path))]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The content of the file is invalid.
    #[error("{}: {message}", name_of(path))]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// Line, key or column of the fault, and the expected content.
        message: String,
    },
    /// The file cannot be written.
    #[error("{}: cannot be written: {reason}", name_of(path))]
    Unwritable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
}

impl FileError {
    /// The error for invalid content of a file. The message states line, key or column, and the expected content.
    pub fn content(path: &Path, message: impl ToString) -> FileError {
        FileError::Content { path: path.to_owned(), message: message.to_string() }
    }

    /// Whether the error lies in the user's input, and not in the writing of results.
    pub fn is_bad_input(&self) -> bool {
        !matches!(self, FileError::Unwritable { .. })
    }
}

/// Whether a path is `-`, which stands for standard input or output.
pub fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Name of a file in messages: `standard input` for `-`, otherwise the path.
pub fn name_of(path: &Path) -> String {
    if is_standard_stream(path) { "standard input".to_owned() } else { path.display().to_string() }
}

/// Bytes of a file, or of standard input for `-`.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    let unreadable = |reason| FileError::Unreadable { path: path.to_owned(), reason };
    if !is_standard_stream(path) {
        return std::fs::read(path).map_err(unreadable);
    }
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

/// Text of a file, or of standard input for `-`.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let line = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count();
        FileError::content(path, format!("line {line}: expected text in UTF-8"))
    })
}
