//! CSV tables whose columns are found by name.

use super::{FileError, read_text};
use finray_model::Vector;
use std::path::{Path, PathBuf};

/// The requested columns of a CSV file, in the requested order.
pub struct Table<const N: usize> {
    path: PathBuf,
    text: String,
    columns: [&'static str; N],
    rows: Vec<Row<N>>,
}

/// One row of a table, and the byte at which the row begins in the text.
pub struct Row<const N: usize> {
    byte: usize,
    /// The requested cells, in the requested order.
    pub cells: [String; N],
}

impl<const N: usize> Table<N> {
    /// Reads the named columns of a file; further columns are ignored.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be read, lacks a column, has a row with too few or too many cells, or has no rows.
    pub fn read(path: &Path, columns: [&'static str; N]) -> Result<Table<N>, FileError> {
        Table::of_text(path, &read_text(path)?, columns)
    }

    /// Reads the named columns as [`Table::read`] does, but from `text`; `path` names the file in errors.
    ///
    /// # Errors
    /// As for [`Table::read`], apart from reading the file.
    pub fn of_text(path: &Path, text: &str, columns: [&'static str; N]) -> Result<Table<N>, FileError> {
        let text = text.trim_start_matches('\u{feff}').to_owned();
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let wrong = |error: csv::Error| FileError::content(path, described(&text, &error));
        let header = reader.headers().map_err(wrong)?.clone();
        if header.is_empty() {
            return Err(FileError::content(path, format!("expected the columns {}, found nothing", columns.join(","))));
        }
        let header_line = line_of(&text, byte_of(header.position()));
        let mut places = [0; N];
        for (place, column) in places.iter_mut().zip(columns) {
            let mut found = header.iter().enumerate().filter(|(_, name)| *name == column).map(|(i, _)| i);
            *place = found.next().ok_or_else(|| {
                let names = header.iter().collect::<Vec<_>>().join(",").escape_debug().to_string();
                let message = format!("line {header_line}: expected a column {column}, found the columns {names}");
                FileError::content(path, message)
            })?;
            if found.next().is_some() {
                let message = format!("line {header_line}: expected the column {column} once, found it twice");
                return Err(FileError::content(path, message));
            }
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            rows.push(Row { byte: byte_of(record.position()), cells: places.map(|place| record[place].to_owned()) });
        }
        if rows.is_empty() {
            return Err(FileError::content(path, format!("expected rows of {}, found none", columns.join(","))));
        }
        Ok(Table { path: path.to_owned(), text, columns, rows })
    }

    /// Rows of the table, in the order of the file.
    pub fn rows(&self) -> &[Row<N>] {
        &self.rows
    }

    /// The error for an invalid row; the message is preceded by file and line.
    pub fn wrong(&self, row: &Row<N>, message: impl ToString) -> FileError {
        FileError::content(&self.path, format!("line {}: {}", line_of(&self.text, row.byte), message.to_string()))
    }

    /// The finite number in a cell; `column` is an index into the requested columns.
    ///
    /// # Errors
    /// [`FileError`] with the line of a cell that is not a finite number.
    pub fn number(&self, row: &Row<N>, column: usize) -> Result<f64, FileError> {
        let cell = &row.cells[column];
        cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
            self.wrong(row, format!("{}: expected a finite number, found {cell:?}", self.columns[column]))
        })
    }

    /// The vector with its components in two columns; `None` if both cells are empty, as for a hidden marker.
    ///
    /// # Errors
    /// [`FileError`] with the line if a cell is not a finite number, or if only one of the two is empty.
    pub fn vector(&self, row: &Row<N>, columns: [usize; 2]) -> Result<Option<Vector>, FileError> {
        let [x, y] = columns;
        let is_half = |empty: usize, given: usize| {
            let [empty, given] = [empty, given].map(|column| self.columns[column]);
            let message = format!(
                "{empty}: expected a finite number, found \"\" beside {given}: a hidden marker leaves both empty"
            );
            Err(self.wrong(row, message))
        };
        match columns.map(|column| row.cells[column].is_empty()) {
            [true, true] => Ok(None),
            [true, false] => is_half(x, y),
            [false, true] => is_half(y, x),
            [false, false] => Ok(Some(Vector::new(self.number(row, x)?, self.number(row, y)?))),
        }
    }

    /// The node number in a cell.
    pub(crate) fn node(&self, row: &Row<N>, column: usize) -> Result<finray_model::NodeId, FileError> {
        let cell = &row.cells[column];
        cell.parse().map(finray_model::NodeId).map_err(|_| {
            self.wrong(row, format!("{}: expected the number of a node, found {cell:?}", self.columns[column]))
        })
    }
}

/// Names of the columns of a CSV text; empty if the text has no header.
pub fn header(text: &str) -> Vec<String> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    reader.headers().map_or_else(|_| Vec::new(), |header| header.iter().map(str::to_owned).collect())
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

/// Number of the line with the record that the CSV reader found at a byte. The reader's own line count is too small: its record starts before the
/// preceding line end and empty lines.
fn line_of(text: &str, byte: usize) -> usize {
    let ends = text[byte..].bytes().take_while(|b| matches!(b, b'\r' | b'\n')).count();
    1 + text[..byte + ends].bytes().filter(|b| *b == b'\n').count()
}
