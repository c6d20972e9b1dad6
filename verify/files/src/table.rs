//! CSV tables whose columns are found by name.

use super::{FileError, read_text};
use csv::StringRecord;
use finray_model::{NodeId, Vector};
use std::path::{Path, PathBuf};

/// A CSV file.
pub struct Table {
    /// Path of the file, for messages.
    pub path: PathBuf,
    text: String,
    header: StringRecord,
    /// Rows of the table, in the order of the file.
    pub rows: Vec<StringRecord>,
}

impl Table {
    /// Reads the named columns of a file; further columns are ignored.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be read, lacks a column, has a row with too few or too many cells, or has no rows.
    pub fn read(path: &Path, columns: &[&str]) -> Result<Table, FileError> {
        let table = Table::of_text(path, &read_text(path)?)?;
        table.require(columns, &[])?;
        Ok(table)
    }

    /// Reads all columns of a text; `path` names the file in errors.
    ///
    /// # Errors
    /// [`FileError`] for a row with too few or too many cells.
    pub fn of_text(path: &Path, text: &str) -> Result<Table, FileError> {
        let text = text.trim_start_matches('\u{feff}').to_owned();
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let wrong = |error: csv::Error| FileError::content(path, described(&text, &error));
        let header = reader.headers().map_err(wrong)?.clone();
        let rows = reader.records().collect::<Result<_, _>>().map_err(wrong)?;
        Ok(Table { path: path.to_owned(), text, header, rows })
    }

    /// Checks that the table has rows and all columns in `required`, and that no column in `required` or `optional` occurs twice.
    ///
    /// # Errors
    /// [`FileError`] that names the missing or repeated column.
    pub fn require(&self, required: &[&str], optional: &[&str]) -> Result<(), FileError> {
        let wrong = |message: String| Err(FileError::content(&self.path, message));
        if self.header.is_empty() {
            return wrong(format!("expected the columns {}, found nothing", required.join(",")));
        }
        let line = line_of(&self.text, byte_of(self.header.position()));
        for column in required.iter().chain(optional) {
            match self.header.iter().filter(|name| name == column).count() {
                0 if required.contains(column) => {
                    let names = self.header.iter().collect::<Vec<_>>().join(",").escape_debug().to_string();
                    return wrong(format!("line {line}: expected a column {column}, found the columns {names}"));
                }
                0 | 1 => {}
                _ => return wrong(format!("line {line}: expected the column {column} once, found it twice")),
            }
        }
        if self.rows.is_empty() {
            wrong(format!("expected rows of {}, found none", required.join(",")))
        } else {
            Ok(())
        }
    }

    /// Whether the table has all these columns.
    pub fn has(&self, columns: &[&str]) -> bool {
        columns.iter().all(|column| self.header.iter().any(|name| name == *column))
    }

    /// The cell of a row in a column; empty if the table lacks the column.
    pub fn cell<'r>(&self, row: &'r StringRecord, column: &str) -> &'r str {
        self.header.iter().position(|name| name == column).map_or("", |i| &row[i])
    }

    /// The error for an invalid row; the message is preceded by file and line.
    pub fn wrong(&self, row: &StringRecord, message: impl ToString) -> FileError {
        let line = line_of(&self.text, byte_of(row.position()));
        FileError::content(&self.path, format!("line {line}: {}", message.to_string()))
    }

    /// The finite number in a cell.
    ///
    /// # Errors
    /// [`FileError`] with the line of a cell that is not a finite number.
    pub fn number(&self, row: &StringRecord, column: &str) -> Result<f64, FileError> {
        let cell = self.cell(row, column);
        let number = cell.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.wrong(row, format!("{column}: expected a finite number, found {cell:?}")))
    }

    /// The vector with its components in two columns; `None` if both cells are empty, as for a hidden marker.
    ///
    /// # Errors
    /// [`FileError`] with the line if a cell is not a finite number, or if only one of the two is empty.
    pub fn vector(&self, row: &StringRecord, [x, y]: [&str; 2]) -> Result<Option<Vector>, FileError> {
        let is_half = |empty: &str, given: &str| {
            let message = format!(
                "{empty}: expected a finite number, found \"\" beside {given}: for a hidden marker, leave both cells empty"
            );
            Err(self.wrong(row, message))
        };
        match [x, y].map(|column| self.cell(row, column).is_empty()) {
            [true, true] => Ok(None),
            [true, false] => is_half(x, y),
            [false, true] => is_half(y, x),
            [false, false] => Ok(Some(Vector::new(self.number(row, x)?, self.number(row, y)?))),
        }
    }

    /// The node number in a cell.
    pub(crate) fn node(&self, row: &StringRecord, column: &str) -> Result<NodeId, FileError> {
        let cell = self.cell(row, column);
        let wrong = |_| self.wrong(row, format!("{column}: expected the number of a node, found {cell:?}"));
        cell.parse().map(NodeId).map_err(wrong)
    }
}

fn described(text: &str, error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = line_of(text, byte_of(pos.as_ref()));
            format!("line {line}: expected {expected_len} columns as in the header, found {len}")
        }
        _ => error.to_string(),
    }
}

fn byte_of(position: Option<&csv::Position>) -> usize {
    position.map_or(0, |position| position.byte() as usize)
}

/// Number of the line on which a record starts, from the byte at which the CSV reader found the record. The reader's own line count is too small,
/// because a record starts, for the reader, before the preceding line end and any empty lines.
fn line_of(text: &str, byte: usize) -> usize {
    let ends = text[byte..].bytes().take_while(|b| matches!(b, b'\r' | b'\n')).count();
    1 + text[..byte + ends].bytes().filter(|b| *b == b'\n').count()
}
