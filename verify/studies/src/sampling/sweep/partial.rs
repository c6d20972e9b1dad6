//! An unfinished table of a sweep, written row by row beside its final path.

use super::Head;
use super::request::lines_of_head;
use finray_files::{FileError, require_writable, write_from};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The file `OUT.partial`: a [`Head`], the table's header and the rows of finished blocks.
///
/// A stopped run leaves this file. The next run with the same request removes an incomplete last block from the file and continues. A run locks the
/// file.
#[derive(Debug)]
pub struct Partial {
    out: PathBuf,
    path: PathBuf,
    file: File,
    head: Head,
    /// Byte offset of the table's header.
    table_at: u64,
    blocks_done: usize,
}

impl Partial {
    /// Creates the file, or resumes a run of the same request.
    ///
    /// # Errors
    /// [`FileError::Content`] if the file belongs to another request or if another process is writing the file; [`FileError::Unwritable`] if the file
    /// cannot be written.
    pub fn open(out: &Path, head: Head) -> Result<Partial, FileError> {
        let mut path = out.as_os_str().to_owned();
        path.push(".partial");
        let path = PathBuf::from(path);
        let unwritable = |reason| FileError::Unwritable { path: path.clone(), reason };
        require_writable(out)?;
        let text = head.to_text().map_err(|error| unwritable(std::io::Error::other(error)))?;
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path).map_err(unwritable)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(FileError::content(
                    &path,
                    "another run is writing this file: wait until that run ends, or give another --out",
                ));
            }
            Err(TryLockError::Error(reason)) => return Err(unwritable(reason)),
        }
        let mut begin = Vec::new();
        (&file).take(text.len() as u64).read_to_end(&mut begin).map_err(unwritable)?;
        let blocks_done = if begin == text.as_bytes() {
            keep_whole_blocks(&mut file, text.len() as u64, head.request.rows_in_block()).map_err(unwritable)?
        } else if text.as_bytes().starts_with(&begin) {
            // The file is new, or an earlier run stopped before it had written a row.
            file.set_len(0).map_err(unwritable)?;
            file.rewind().and_then(|()| file.write_all(text.as_bytes())).map_err(unwritable)?;
            0
        } else {
            return Err(FileError::content(&path, of_another_request(&mut file, &head)));
        };
        let table_at = (text.len() - head.request.table.header().len()) as u64;
        Ok(Partial { out: out.to_owned(), path, file, head, table_at, blocks_done })
    }

    /// Number of blocks of this shard whose rows are in the file.
    pub fn blocks_done(&self) -> usize {
        self.blocks_done
    }

    /// Appends the rows of the next blocks.
    ///
    /// # Errors
    /// [`FileError::Unwritable`], for example if the disk is full; the run can be resumed later.
    pub fn append(&mut self, blocks: usize, rows: &str) -> Result<(), FileError> {
        // All rows are written in one call, so that a killed run usually leaves only whole rows.
        self.file
            .write_all(rows.as_bytes())
            .map_err(|reason| FileError::Unwritable { path: self.path.clone(), reason })?;
        self.blocks_done += blocks;
        Ok(())
    }

    /// The table so far, with its header.
    ///
    /// # Errors
    /// [`FileError::Unreadable`] if the file cannot be read.
    pub fn table(&mut self) -> Result<impl Read + '_, FileError> {
        let unreadable = |reason| FileError::Unreadable { path: self.path.clone(), reason };
        self.file.seek(SeekFrom::Start(self.table_at)).map_err(unreadable)?;
        Ok(BufReader::new(&self.file))
    }

    /// Moves the table to its final path and writes the files `beside` it; if one of these steps fails, none takes effect. A shard keeps its head.
    ///
    /// # Errors
    /// [`FileError`] if a file cannot be written; the rows stay for another attempt.
    pub fn finish(mut self, beside: &[(PathBuf, String)]) -> Result<(), FileError> {
        let unreadable = |reason| FileError::Unreadable { path: self.path.clone(), reason };
        let from = if self.head.shard.is_some() { 0 } else { self.table_at };
        self.file.seek(SeekFrom::Start(from)).map_err(unreadable)?;
        let mut texts: Vec<&[u8]> = beside.iter().map(|(_, text)| text.as_bytes()).collect();
        let mut sources: Vec<(&Path, &mut dyn Read)> = vec![(&self.out, &mut self.file)];
        sources.extend(beside.iter().zip(&mut texts).map(|((path, _), text)| (path.as_path(), text as &mut dyn Read)));
        write_from(sources)?;
        // If the removal fails, the next run finds all rows in this partial file and computes none of them again.
        std::fs::remove_file(&self.path).map_err(|reason| FileError::Unwritable { path: self.path.clone(), reason })
    }
}

/// Truncates the file after the last whole block and moves its cursor there. Returns the number of whole blocks.
fn keep_whole_blocks(file: &mut File, rows_at: u64, rows_in_block: usize) -> std::io::Result<usize> {
    file.seek(SeekFrom::Start(rows_at))?;
    let mut reader = BufReader::new(&*file);
    let (mut rows, mut at, mut whole_to, mut row) = (0, rows_at, rows_at, Vec::new());
    while reader.read_until(b'\n', &mut row)? > 0 && row.ends_with(b"\n") {
        at += row.len() as u64;
        rows += 1;
        if rows % rows_in_block == 0 {
            whole_to = at;
        }
        row.clear();
    }
    file.set_len(whole_to)?;
    file.seek(SeekFrom::Start(whole_to))?;
    Ok(rows / rows_in_block)
}

/// Error text for a file whose head belongs to another request.
fn of_another_request(file: &mut File, head: &Head) -> String {
    let theirs = file.rewind().and_then(|()| lines_of_head(&mut BufReader::new(&*file)));
    let difference = match theirs.ok().and_then(|lines| Head::from_lines(&lines)) {
        None => "it is not a table of finray".to_owned(),
        Some(theirs) if theirs.shard != head.shard => "another --shard".to_owned(),
        Some(theirs) => match theirs.request.difference(&head.request) {
            Some(what) => format!("another {what}"),
            None => "other columns".to_owned(),
        },
    };
    format!("belongs to another request ({difference}): move it, delete it, or give another --out")
}
