//! CSV tables whose columns are found by name.

use super::{FileError, read_text};
use std::path::{Path, PathBuf};

/// A table with the wanted columns of a CSV file, in the wanted order.
pub(super) struct Table<const N: usize> {
    path: PathBuf,
    columns: [&'static str; N],
    rows: Vec<Row<N>>,
}

/// One row and the line it stands on.
pub(super) struct Row<const N: usize> {
    pub line: u64,
    pub cells: [String; N],
}

impl<const N: usize> Table<N> {
    /// Reads the named columns; further columns are ignored, short rows and files without rows refused.
    pub(super) fn read(path: &Path, columns: [&'static str; N]) -> Result<Table<N>, FileError> {
        let text = read_text(path)?;
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.trim_start_matches('\u{feff}').as_bytes());
        let wrong = |error: csv::Error| FileError::content(path, described(&error));
        let header = reader.headers().map_err(wrong)?.clone();
        let mut places = [0; N];
        for (place, column) in places.iter_mut().zip(columns) {
            let mut found = header.iter().enumerate().filter(|(_, name)| *name == column).map(|(i, _)| i);
            *place = found.next().ok_or_else(|| {
                let names = header.iter().collect::<Vec<_>>().join(",");
                FileError::content(path, format!("line 1: expected a column {column}, found the columns {names}"))
            })?;
            if found.next().is_some() {
                return Err(FileError::content(path, format!("line 1: the column {column} stands there twice")));
            }
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(wrong)?;
            let line = record.position().map_or(0, csv::Position::line);
            rows.push(Row { line, cells: places.map(|place| record[place].to_owned()) });
        }
        if rows.is_empty() {
            return Err(FileError::content(path, format!("expected rows of {}, found none", columns.join(","))));
        }
        Ok(Table { path: path.to_owned(), columns, rows })
    }

    pub(super) fn rows(&self) -> &[Row<N>] {
        &self.rows
    }

    /// The error for something wrong in a row.
    pub(super) fn wrong(&self, row: &Row<N>, message: impl ToString) -> FileError {
        FileError::content(&self.path, format!("line {}: {}", row.line, message.to_string()))
    }

    /// A finite number.
    pub(super) fn number(&self, row: &Row<N>, column: usize) -> Result<f64, FileError> {
        let cell = &row.cells[column];
        cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
            self.wrong(row, format!("{}: expected a finite number, found \"{cell}\"", self.columns[column]))
        })
    }

    /// A node number.
    pub(super) fn node(&self, row: &Row<N>, column: usize) -> Result<finray_model::NodeId, FileError> {
        let cell = &row.cells[column];
        cell.parse().map(finray_model::NodeId).map_err(|_| {
            self.wrong(row, format!("{}: expected the number of a node, found \"{cell}\"", self.columns[column]))
        })
    }
}

fn described(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: expected {expected_len} columns as in the header, found {len}")
        }
        _ => error.to_string(),
    }
}
