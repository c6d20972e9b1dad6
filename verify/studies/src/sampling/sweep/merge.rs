//! Merges the shards of a sweep that several machines have computed independently.

use super::request::lines_of_head;
use super::{Head, Request, Shard};
use finray_files::FileError;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// All shards of one request. Only their heads are in memory.
#[derive(Debug)]
pub struct Shards {
    request: Request,
    /// Files and the byte offsets of their rows, by shard number.
    files: BTreeMap<usize, (PathBuf, u64)>,
}

/// Why shards cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A file is unreadable, incomplete, given twice, or belongs to another request.
    #[error(transparent)]
    File(#[from] FileError),
    /// At least one shard is missing.
    #[error("incomplete: of {of} shards, {found} were given; missing: {missing}")]
    Missing {
        /// Numbers of the first few missing shards, from 1.
        missing: String,
        /// Number of shards found.
        found: usize,
        /// Number of shards of the request.
        of: usize,
    },
    /// No file was given.
    #[error("expected at least one shard, found none")]
    Nothing,
}

/// A message lists at most this number of missing shards.
const NAMED: usize = 10;

impl Shards {
    /// Opens the shards of one request, and checks that each shard is given once and is complete.
    ///
    /// # Errors
    /// [`MergeError`] with the first invalid file, or the missing shards.
    pub fn open(paths: &[PathBuf]) -> Result<Shards, MergeError> {
        let first = paths.first().ok_or(MergeError::Nothing)?;
        let (request, Shard { of, .. }, _) = whole_shard(first)?;
        let mut files: BTreeMap<usize, (PathBuf, u64)> = BTreeMap::new();
        for path in paths {
            let (theirs, shard, rows_at) = whole_shard(path)?;
            let foreign = |what: &str| {
                let message = format!("is not a shard of the same table as {}: it has another {what}", first.display());
                Err(FileError::content(path, message).into())
            };
            if let Some(what) = request.difference(&theirs) {
                return foreign(what);
            }
            if shard.of != of {
                return foreign(&format!("number of shards ({} instead of {of})", shard.of));
            }
            if let Some((other, _)) = files.insert(shard.number, (path.clone(), rows_at)) {
                let message = format!("is shard {shard}, and so is {}: give each shard once", other.display());
                return Err(FileError::content(path, message).into());
            }
        }
        if files.len() < of {
            let numbers = (1..=of).filter(|number| !files.contains_key(number)).map(|number| number.to_string());
            let mut missing = numbers.take(NAMED).collect::<Vec<_>>().join(", ");
            if of - files.len() > NAMED {
                missing += ", ...";
            }
            return Err(MergeError::Missing { missing, found: files.len(), of });
        }
        Ok(Shards { request, files })
    }

    /// The request that the shards share.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The whole table with its header, read shard by shard.
    pub fn table(&self) -> impl Read + '_ {
        let header = Cursor::new(self.request.table.header());
        header.chain(Rows { rest: self.files.values(), open: None })
    }
}

/// Checks that a file is a complete shard. Returns its request, its number, and the byte offset of its rows.
fn whole_shard(path: &Path) -> Result<(Request, Shard, u64), FileError> {
    let unreadable = |reason| FileError::Unreadable { path: path.to_owned(), reason };
    let no_shard = || FileError::content(path, "is not a shard: expected a file written with --shard I/N");
    let mut reader = BufReader::new(File::open(path).map_err(unreadable)?);
    // A binary file has no head.
    let lines = lines_of_head(&mut reader).or_else(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => Ok(String::new()),
        _ => Err(unreadable(error)),
    })?;
    let head = Head::from_lines(&lines).ok_or_else(no_shard)?;
    let shard = head.shard.ok_or_else(no_shard)?;
    let header = head.request.table.header().as_bytes();
    let mut begin = Vec::new();
    reader.by_ref().take(header.len() as u64).read_to_end(&mut begin).map_err(unreadable)?;
    let (mut rows, mut last) = (0, b'\n');
    loop {
        let bytes = reader.fill_buf().map_err(unreadable)?;
        let Some(&end) = bytes.last() else { break };
        rows += bytes.iter().filter(|byte| **byte == b'\n').count();
        last = end;
        let read = bytes.len();
        reader.consume(read);
    }
    if begin != header || rows != head.row_count() || last != b'\n' {
        let message = format!(
            "is not a complete shard {shard}: expected {} rows, found {rows}; run its command again",
            head.row_count()
        );
        return Err(FileError::content(path, message));
    }
    Ok((head.request, shard, (lines.len() + header.len()) as u64))
}

/// Rows of all shards in sequence. One file is open at a time, because there may be more shards than a process may open files.
struct Rows<'s> {
    rest: std::collections::btree_map::Values<'s, usize, (PathBuf, u64)>,
    open: Option<File>,
}

impl Read for Rows<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        loop {
            if let Some(file) = &mut self.open {
                let read = file.read(into)?;
                if read > 0 || into.is_empty() {
                    return Ok(read);
                }
            }
            let Some((path, rows_at)) = self.rest.next() else { return Ok(0) };
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start(*rows_at))?;
            self.open = Some(file);
        }
    }
}
