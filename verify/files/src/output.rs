//! Writes result files whole or not at all.

use super::{FileError, is_standard_stream};
use serde::Serialize;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// Rows as CSV text. The header has the field names of `R`; each number is written in the shortest form that is read back as the same number.
///
/// # Errors
/// A `csv::Error` from the CSV writer; none is expected, because the text is written to memory.
pub fn csv_text<R: Serialize>(rows: impl IntoIterator<Item = R>) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Writes text or bytes to a file, or to standard output for `-`. A closed pipe on standard output, as left by `head`, is no error.
///
/// # Errors
/// [`FileError::Unwritable`] if the file cannot be written; the file is then unchanged.
pub fn write_file(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), FileError> {
    if is_standard_stream(path) {
        let mut out = std::io::stdout().lock();
        return streamed(path, out.write_all(contents.as_ref()).and_then(|()| out.flush()));
    }
    write_all_or_nothing(&[(path.to_owned(), contents)])
}

/// Writes several files. Each file is first written under a temporary name in its folder; then all files are renamed. The umask determines the mode
/// of a new file. An existing file keeps its mode, and a symbolic link is followed. If standard output is among the paths, the files are written one
/// after the other.
///
/// # Errors
/// [`FileError::Unwritable`] for the first file that cannot be written, for instance a read-only one; no file is left half-written.
pub fn write_all_or_nothing<C: AsRef<[u8]>>(files: &[(PathBuf, C)]) -> Result<(), FileError> {
    if files.iter().any(|(path, _)| is_standard_stream(path)) {
        return files.iter().try_for_each(|(path, contents)| write_file(path, contents.as_ref()));
    }
    let mut contents: Vec<&[u8]> = files.iter().map(|(_, contents)| contents.as_ref()).collect();
    let sources = files.iter().zip(&mut contents).map(|((path, _), bytes)| (path.as_path(), bytes as &mut dyn Read));
    write_from(sources.collect())
}

/// Writes several files as [`write_all_or_nothing`] does, each from a reader.
///
/// # Errors
/// [`FileError::Unwritable`] for the first file that cannot be written, or whose source cannot be read.
pub fn write_from(sources: Vec<(&Path, &mut dyn Read)>) -> Result<(), FileError> {
    let mut ready = Vec::with_capacity(sources.len());
    for (path, source) in sources {
        let unwritable = |reason| FileError::Unwritable { path: path.to_owned(), reason };
        let target = link_target(path).map_err(unwritable)?;
        let existing = writable_metadata(&target).map_err(unwritable)?;
        // A device or pipe is written to directly: renaming a file onto its path would replace the device.
        if existing.as_ref().is_some_and(|existing| !existing.is_file()) {
            let mut there = File::create(&target).map_err(unwritable)?;
            std::io::copy(source, &mut there).map_err(unwritable)?;
            continue;
        }
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // `File::create_new` reports errors without the name of the temporary file, which tempfile's own errors contain.
        let made = tempfile::Builder::new().prefix(".finray-").make_in(folder, |at| File::create_new(at));
        let mut file = made.map_err(unwritable)?;
        if let Some(existing) = existing {
            keep_owner(file.as_file(), &existing);
            file.as_file().set_permissions(existing.permissions()).map_err(unwritable)?;
        }
        std::io::copy(source, file.as_file_mut()).map_err(unwritable)?;
        ready.push((file, target, path));
    }
    for (file, target, path) in ready {
        let unwritable = |reason| FileError::Unwritable { path: path.to_owned(), reason };
        file.persist(target).map_err(|error| unwritable(error.error))?;
    }
    Ok(())
}

/// Checks before a long computation that an existing file can be written. A path without a file passes.
///
/// # Errors
/// [`FileError::Unwritable`] if the path is a folder, or a file that is read-only or otherwise not writable.
pub fn require_writable(path: &Path) -> Result<(), FileError> {
    if is_standard_stream(path) {
        return Ok(());
    }
    let existing = link_target(path).and_then(|target| writable_metadata(&target));
    let writable = existing.and_then(|existing| match existing {
        Some(existing) if existing.is_dir() => Err(ErrorKind::IsADirectory.into()),
        _ => Ok(()),
    });
    writable.map_err(|reason| FileError::Unwritable { path: path.to_owned(), reason })
}

/// Largest number of symbolic links that are followed; operating systems follow at most 40.
const MOST_LINKS: usize = 40;

/// The path to which symbolic links lead, whether or not a file exists there.
fn link_target(path: &Path) -> std::io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&target) {
            Ok(next) => target = target.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(std::io::Error::other("its symbolic links form a loop"))
}

/// Metadata of an existing file; `None` if no file exists. A read-only file is refused even for a superuser, who could write it.
fn writable_metadata(target: &Path) -> std::io::Result<Option<Metadata>> {
    let Ok(existing) = target.metadata() else { return Ok(None) };
    if existing.is_file() {
        if existing.permissions().readonly() {
            return Err(std::io::Error::new(ErrorKind::PermissionDenied, "the file is read-only"));
        }
        OpenOptions::new().write(true).open(target)?;
    }
    Ok(Some(existing))
}

/// Gives a file the owner and group of an existing file, as far as the system permits.
#[cfg(unix)]
fn keep_owner(file: &File, existing: &Metadata) {
    use std::os::unix::fs::MetadataExt;
    // Only a superuser can change the owner; other users can still set a group to which they belong.
    if std::os::unix::fs::fchown(file, Some(existing.uid()), Some(existing.gid())).is_err() {
        let _ = std::os::unix::fs::fchown(file, None, Some(existing.gid()));
    }
}

#[cfg(not(unix))]
fn keep_owner(_: &File, _: &Metadata) {}

/// Whether a path is standard output, a device or a pipe. A renamed temporary file cannot replace a stream.
pub fn is_stream(out: &Path) -> bool {
    is_standard_stream(out) || out.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// Opens a path for which [`is_stream`] is true, to write a result piece by piece.
///
/// # Errors
/// [`FileError::Unwritable`] if the path cannot be opened for writing.
pub fn open_stream(out: &Path) -> Result<Box<dyn Write>, FileError> {
    if is_standard_stream(out) {
        return Ok(Box::new(std::io::stdout()));
    }
    let there = File::create(out).map_err(|reason| FileError::Unwritable { path: out.to_owned(), reason })?;
    Ok(Box::new(there))
}

/// Result of writing to a stream. A closed pipe, as left by `head` after its last line, is no error.
///
/// # Errors
/// [`FileError::Unwritable`] for any other error.
pub fn streamed(out: &Path, written: std::io::Result<()>) -> Result<(), FileError> {
    let path = if is_standard_stream(out) { Path::new("standard output") } else { out };
    match written {
        Err(reason) if reason.kind() != ErrorKind::BrokenPipe => {
            Err(FileError::Unwritable { path: path.to_owned(), reason })
        }
        _ => Ok(()),
    }
}

/// Checks before a long computation that neither the path of a folder nor a parent of that path is a file.
///
/// # Errors
/// [`FileError::Unwritable`] if the path of the folder or a parent of that path is a file.
pub fn require_folder(folder: &Path) -> Result<(), FileError> {
    match folder.ancestors().find(|part| part.exists()) {
        Some(part) if !part.is_dir() => {
            Err(FileError::Unwritable { path: folder.to_owned(), reason: ErrorKind::NotADirectory.into() })
        }
        _ => Ok(()),
    }
}

/// Writes files into a folder, which is created if needed; either all files are written or none.
///
/// # Errors
/// [`FileError::Unwritable`] for the first file that cannot be written.
pub fn write_folder<P: AsRef<Path>, C: AsRef<[u8]>>(folder: &Path, files: &[(P, C)]) -> Result<(), FileError> {
    std::fs::create_dir_all(folder).map_err(|reason| FileError::Unwritable { path: folder.to_owned(), reason })?;
    let files: Vec<_> = files.iter().map(|(name, contents)| (folder.join(name), contents.as_ref())).collect();
    write_all_or_nothing(&files)
}
