//! CSV tables whose columns are found by name.

use super::{FileError, read_text};
use finray_model::Vector;
use std::path::{Path, PathBuf};

/// A table with the wanted columns of a CSV file, in the wanted order.
pub struct Table<const N: usize> {
    path: PathBuf,
    text: String,
    columns: [&'static str; N],
    rows: Vec<Row<N>>,
}

/// One row and where it begins in the text.
pub struct Row<const N: usize> {
    byte: usize,
    /// The wanted cells, in the wanted order.
    pub cells: [String; N],
}

impl<const N: usize> Table<N> {
    /// Reads the named columns; further columns are ignored.
    ///
    /// # Errors
    /// [`FileError`] for short rows, missing columns and files without rows.
    pub fn read(path: &Path, columns: [&'static str; N]) -> Result<Table<N>, FileError> {
        Table::of_text(path, &read_text(path)?, columns)
    }

    /// As [`Table::read`], from the text of the file.
    ///
    /// # Errors
    /// As [`Table::read`].
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

    /// The rows, in the order of the file.
    pub fn rows(&self) -> &[Row<N>] {
        &self.rows
    }

    /// The error for something wrong in a row.
    pub fn wrong(&self, row: &Row<N>, message: impl ToString) -> FileError {
        FileError::content(&self.path, format!("line {}: {}", line_of(&self.text, row.byte), message.to_string()))
    }

    /// A finite number.
    ///
    /// # Errors
    /// [`FileError`] naming the line for anything else.
    pub fn number(&self, row: &Row<N>, column: usize) -> Result<f64, FileError> {
        let cell = &row.cells[column];
        cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
            self.wrong(row, format!("{}: expected a finite number, found {cell:?}", self.columns[column]))
        })
    }

    /// The vector of two columns; `None` where both are empty, as of a hidden marker.
    ///
    /// # Errors
    /// [`FileError`] naming the line where a cell is no finite number, or only one of the two is empty.
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

    /// A node number.
    pub(crate) fn node(&self, row: &Row<N>, column: usize) -> Result<finray_model::NodeId, FileError> {
        let cell = &row.cells[column];
        cell.parse().map(finray_model::NodeId).map_err(|_| {
            self.wrong(row, format!("{}: expected the number of a node, found {cell:?}", self.columns[column]))
        })
    }
}

/// Names of the columns of a CSV text; none if it has none.
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

/// Line of a record that the reader found at a byte. The reader starts a record where the last one ended, before the
/// second half of its line end and before empty lines, so its own count of lines is behind.
fn line_of(text: &str, byte: usize) -> usize {
    let ends = text[byte..].bytes().take_while(|b| matches!(b, b'\r' | b'\n')).count();
    1 + text[..byte + ends].bytes().filter(|b| *b == b'\n').count()
}
