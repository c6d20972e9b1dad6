//! Results are written whole or not at all.

use super::{FileError, is_standard_stream};
use serde::Serialize;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// Rows as CSV text with a header from the field names; numbers in the shortest form that reads back the same.
///
/// # Errors
/// None in memory; the signature is the CSV writer's.
pub fn csv_text<R: Serialize>(rows: impl IntoIterator<Item = R>) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Writes text to a file, or to standard output for `-`. A reader of standard output that has seen enough, as `head`,
/// is no error.
///
/// # Errors
/// [`FileError::Unwritable`], with the file as it was before.
pub fn write_text(path: &Path, text: &str) -> Result<(), FileError> {
    write_bytes(path, text.as_bytes())
}

/// Writes bytes as [`write_text`] writes text.
///
/// # Errors
/// [`FileError::Unwritable`], with the file as it was before.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    if is_standard_stream(path) {
        let unwritable = |reason| FileError::Unwritable { path: PathBuf::from("standard output"), reason };
        let mut out = std::io::stdout().lock();
        return match out.write_all(bytes).and_then(|()| out.flush()) {
            Err(reason) if reason.kind() == ErrorKind::BrokenPipe => Ok(()),
            written => written.map_err(unwritable),
        };
    }
    write_all_or_nothing(&[(path.to_owned(), bytes)])
}

/// Writes several files: each first under a temporary name beside its place, then all are moved there. A new file has the mode that the umask
/// leaves; one that is there keeps its mode, and a link leads to it. With standard output among them, one after the other.
///
/// # Errors
/// [`FileError::Unwritable`] for the first file that cannot be written, as a read-only one; no file is left half-written.
pub fn write_all_or_nothing<C: AsRef<[u8]>>(files: &[(PathBuf, C)]) -> Result<(), FileError> {
    if files.iter().any(|(path, _)| is_standard_stream(path)) {
        return files.iter().try_for_each(|(path, contents)| write_bytes(path, contents.as_ref()));
    }
    let mut contents: Vec<&[u8]> = files.iter().map(|(_, contents)| contents.as_ref()).collect();
    let sources = files.iter().zip(&mut contents).map(|((path, _), bytes)| (path.as_path(), bytes as &mut dyn Read));
    write_from(sources.collect())
}

/// Writes several files as [`write_all_or_nothing`], each from what is read.
///
/// # Errors
/// [`FileError::Unwritable`] for the first file that cannot be written, or whose source cannot be read.
pub fn write_from(sources: Vec<(&Path, &mut dyn Read)>) -> Result<(), FileError> {
    let mut ready = Vec::with_capacity(sources.len());
    for (path, source) in sources {
        let unwritable = |reason| FileError::Unwritable { path: path.to_owned(), reason };
        let target = link_target(path).map_err(unwritable)?;
        let existing = writable_metadata(&target).map_err(unwritable)?;
        // A device or pipe is written to; replacing it by a file would take it away.
        if existing.as_ref().is_some_and(|existing| !existing.is_file()) {
            let mut there = File::create(&target).map_err(unwritable)?;
            std::io::copy(source, &mut there).map_err(unwritable)?;
            continue;
        }
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // Made and written without tempfile's own errors, which name the temporary file.
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

/// Refuses a file that is there and cannot be written: better known before hours of work than after.
///
/// # Errors
/// [`FileError::Unwritable`].
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

/// Links that are followed; systems follow 40 or fewer.
const MOST_LINKS: usize = 40;

/// The file that a path leads to through symbolic links, whether it is there or not.
fn link_target(path: &Path) -> std::io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&target) {
            Ok(next) => target = target.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(std::io::Error::other("its symbolic links go round in a circle"))
}

/// What is at a path already. A read-only file is refused for a superuser too, who could write it.
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

/// Gives a file the owner and group of another, as far as the system lets.
#[cfg(unix)]
fn keep_owner(file: &File, existing: &Metadata) {
    use std::os::unix::fs::MetadataExt;
    // Only a superuser gives files away, but a member of the group may give it the file.
    if std::os::unix::fs::fchown(file, Some(existing.uid()), Some(existing.gid())).is_err() {
        let _ = std::os::unix::fs::fchown(file, None, Some(existing.gid()));
    }
}

#[cfg(not(unix))]
fn keep_owner(_: &File, _: &Metadata) {}

/// Whether a path is standard output, a device or a pipe: nothing can stand beside it, and nothing can take its place.
pub fn is_stream(out: &Path) -> bool {
    is_standard_stream(out) || out.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// Standard output, a device or a pipe, written bit by bit.
pub struct Stream {
    name: PathBuf,
    to: Box<dyn Write>,
}

/// Whether anybody still reads a [`Stream`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reader {
    /// There is one.
    Listens,
    /// It has seen enough, as `head`.
    Left,
}

impl Stream {
    /// Opens what [`is_stream`] is true for.
    ///
    /// # Errors
    /// [`FileError::Unwritable`].
    pub fn open(out: &Path) -> Result<Stream, FileError> {
        if is_standard_stream(out) {
            return Ok(Stream { name: PathBuf::from("standard output"), to: Box::new(std::io::stdout()) });
        }
        let unwritable = |reason| FileError::Unwritable { path: out.to_owned(), reason };
        let there = File::create(out).map_err(unwritable)?;
        Ok(Stream { name: out.to_owned(), to: Box::new(there) })
    }

    /// Writes bytes at once.
    ///
    /// # Errors
    /// [`FileError::Unwritable`]; that nobody reads any more is none.
    pub fn write(&mut self, bytes: &[u8]) -> Result<Reader, FileError> {
        match self.to.write_all(bytes).and_then(|()| self.to.flush()) {
            Ok(()) => Ok(Reader::Listens),
            Err(reason) if reason.kind() == ErrorKind::BrokenPipe => Ok(Reader::Left),
            Err(reason) => Err(FileError::Unwritable { path: self.name.clone(), reason }),
        }
    }
}

/// Refuses a folder that cannot be made because a file is in the way: better known before minutes of work than after.
///
/// # Errors
/// [`FileError::Unwritable`].
pub fn require_folder(folder: &Path) -> Result<(), FileError> {
    match folder.ancestors().find(|part| part.exists()) {
        Some(part) if !part.is_dir() => {
            Err(FileError::Unwritable { path: folder.to_owned(), reason: ErrorKind::NotADirectory.into() })
        }
        _ => Ok(()),
    }
}

/// Writes files into a folder, which is made if it does not exist; either all of them or none.
///
/// # Errors
/// [`FileError::Unwritable`] for the first file that cannot be written.
pub fn write_folder<C: AsRef<[u8]>>(folder: &Path, files: &[(PathBuf, C)]) -> Result<(), FileError> {
    std::fs::create_dir_all(folder).map_err(|reason| FileError::Unwritable { path: folder.to_owned(), reason })?;
    let files: Vec<_> = files.iter().map(|(name, contents)| (folder.join(name), contents.as_ref())).collect();
    write_all_or_nothing(&files)
}
