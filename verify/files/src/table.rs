//! Tables as text: CSV with columns that are found by name, as whole files or as single lines of a stream.
//!
//! Commas, semicolons or tabs separate cells, as in the header; numbers may then have decimal commas, unless commas separate cells. Quotes around cells,
//! both kinds of line ends and a byte order mark are accepted.

use super::{FileError, read_text};
use csv::StringRecord;
use finray_model::{NodeId, Vector};
use std::path::{Path, PathBuf};

/// Column and key of a marker's node.
pub(crate) const NODE: &str = "node";
/// Separators of cells; the first that occurs in the header separates the cells of the table.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];
/// Contents of a cell without a value, as NumPy, pandas, R and JavaScript write them, in lower case.
const NO_VALUE: [&str; 5] = ["", "nan", "na", "null", "none"];

/// Header of a table: the names of its columns, and the separator of its cells.
#[derive(Debug, Clone)]
pub struct Columns {
    names: StringRecord,
    separator: u8,
}

impl Columns {
    /// The columns in the first line of a table.
    ///
    /// # Errors
    /// A message for a line that is not CSV.
    pub(crate) fn of_line(line: &str) -> Result<Columns, String> {
        let line = without_mark(line);
        let mut columns = Columns { names: StringRecord::new(), separator: separator_of(line) };
        let mut names = StringRecord::new();
        columns.split(line, &mut names)?;
        columns.names = names;
        Ok(columns)
    }

    /// Splits a line of the table into cells.
    ///
    /// # Errors
    /// A message for a line that is not CSV, or with another number of cells than the header.
    pub(crate) fn split(&self, line: &str, cells: &mut StringRecord) -> Result<(), String> {
        cells.clear();
        if line.contains('"') {
            let mut reader = reader(line, self.separator, false);
            reader.read_record(cells).map_err(|error| error.to_string())?;
        } else {
            // A line without quotes needs no parser of CSV, which would have to be built for each line.
            line.split(char::from(self.separator)).for_each(|cell| cells.push_field(cell.trim()));
        }
        match self.names.len() {
            expected if expected > 0 && expected != cells.len() => Err(unequal(expected, cells.len())),
            _ => Ok(()),
        }
    }

    /// Number of a column, from 0.
    fn index(&self, column: &str) -> Option<usize> {
        self.names.iter().position(|name| name == column)
    }

    /// Whether the table has all these columns.
    pub fn has(&self, columns: &[&str]) -> bool {
        columns.iter().all(|column| self.index(column).is_some())
    }

    /// Checks that the table has all columns in `required`, and that no column in `required` or `optional` occurs twice.
    ///
    /// # Errors
    /// A message that names the missing or repeated column.
    pub(crate) fn require(&self, required: &[&str], optional: &[&str]) -> Result<(), String> {
        for column in required.iter().chain(optional) {
            match self.names.iter().filter(|name| name == column).count() {
                0 if required.contains(column) => {
                    return Err(format!("expected a column {column}, found the columns {}", self.listed()));
                }
                0 | 1 => {}
                _ => return Err(format!("expected the column {column} once, found it twice")),
            }
        }
        Ok(())
    }

    /// Names of the columns, for messages.
    pub(crate) fn listed(&self) -> String {
        let separator = char::from(self.separator).to_string();
        let names = self.names.iter().collect::<Vec<_>>().join(&separator);
        names.escape_debug().take(LONGEST_QUOTE).collect()
    }

    /// The cell of a row in a column; empty if the table lacks the column.
    pub fn cell<'r>(&self, row: &'r StringRecord, column: &str) -> &'r str {
        self.index(column).and_then(|i| row.get(i)).unwrap_or_default()
    }

    /// Whether a cell has no value: it is empty, NaN, NA, null or None.
    pub fn is_missing(&self, row: &StringRecord, column: &str) -> bool {
        let cell = self.cell(row, column);
        NO_VALUE.iter().any(|word| cell.eq_ignore_ascii_case(word))
    }

    /// The finite number in a cell.
    ///
    /// # Errors
    /// A message with column and node for a cell that is not a finite number.
    pub fn number(&self, row: &StringRecord, column: &str) -> Result<f64, String> {
        let cell = self.cell(row, column);
        let number = match self.separator {
            b',' => cell.parse().ok(),
            _ => cell.replace(',', ".").parse().ok(),
        };
        number
            .filter(|x: &f64| x.is_finite())
            .ok_or_else(|| format!("{column}: expected a finite number, found {cell:?}{}", self.of_node(row, column)))
    }

    /// The vector with its components in two columns; `None` if both cells have no value, as for a hidden marker.
    ///
    /// # Errors
    /// A message with column and node if a cell is not a finite number, or if only one of the two has a value.
    pub fn vector(&self, row: &StringRecord, [x, y]: [&str; 2]) -> Result<Option<Vector>, String> {
        let is_half = |empty: &str, given: &str| {
            let (found, node) = (self.cell(row, empty), self.of_node(row, empty));
            Err(format!(
                "{empty}: expected a finite number, found {found:?} beside {given}{node}: for a hidden marker, leave both cells empty"
            ))
        };
        match [x, y].map(|column| self.is_missing(row, column)) {
            [true, true] => Ok(None),
            [true, false] => is_half(x, y),
            [false, true] => is_half(y, x),
            [false, false] => Ok(Some(Vector::new(self.number(row, x)?, self.number(row, y)?))),
        }
    }

    /// The node number in a cell.
    ///
    /// # Errors
    /// A message with the column for a cell that is no number of a node.
    pub(crate) fn node(&self, row: &StringRecord, column: &str) -> Result<NodeId, String> {
        let cell = self.cell(row, column);
        let wrong = |_| format!("{column}: expected the number of a node, found {cell:?}");
        cell.parse().map(NodeId).map_err(wrong)
    }

    /// Addition to a message about a cell: the node of the row, if the row states it.
    fn of_node(&self, row: &StringRecord, column: &str) -> String {
        match self.cell(row, NODE) {
            node if !node.is_empty() && column != NODE => format!(" (node {node})"),
            _ => String::new(),
        }
    }
}

/// Largest number of characters of a header that a message quotes.
const LONGEST_QUOTE: usize = 200;

/// The text without a byte order mark, which PowerShell and spreadsheets write.
pub(crate) fn without_mark(text: &str) -> &str {
    text.trim_start_matches('\u{feff}')
}

fn separator_of(text: &str) -> u8 {
    let header = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    SEPARATORS.into_iter().find(|separator| header.as_bytes().contains(separator)).unwrap_or(b',')
}

fn reader(text: &str, separator: u8, has_headers: bool) -> csv::Reader<&[u8]> {
    let mut builder = csv::ReaderBuilder::new();
    builder.trim(csv::Trim::All).delimiter(separator).has_headers(has_headers).from_reader(text.as_bytes())
}

fn unequal(expected: usize, found: usize) -> String {
    format!("expected {expected} columns as in the header, found {found}")
}

/// A file with a table.
pub struct Table {
    /// Path of the file, for messages.
    pub path: PathBuf,
    text: String,
    columns: Columns,
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
        let text = without_mark(text).to_owned();
        let separator = separator_of(&text);
        let mut reader = reader(&text, separator, true);
        let wrong = |error: csv::Error| FileError::content(path, described(&text, &error));
        let names = reader.headers().map_err(wrong)?.clone();
        let rows = reader.records().collect::<Result<_, _>>().map_err(wrong)?;
        Ok(Table { path: path.to_owned(), text, columns: Columns { names, separator }, rows })
    }

    /// Checks that the table has rows and all columns in `required`, and that no column in `required` or `optional` occurs twice.
    ///
    /// # Errors
    /// [`FileError`] that names the missing or repeated column.
    pub fn require(&self, required: &[&str], optional: &[&str]) -> Result<(), FileError> {
        let wrong = |message: String| Err(FileError::content(&self.path, message));
        if self.columns.names.is_empty() {
            return wrong(format!("expected the columns {}, found nothing", required.join(",")));
        }
        let line = line_of(&self.text, byte_of(self.columns.names.position()));
        self.columns
            .require(required, optional)
            .map_err(|message| FileError::content(&self.path, format!("line {line}: {message}")))?;
        if self.rows.is_empty() {
            wrong(format!("expected rows of {}, found none", required.join(",")))
        } else {
            Ok(())
        }
    }

    /// Whether the table has all these columns.
    pub fn has(&self, columns: &[&str]) -> bool {
        self.columns.has(columns)
    }

    /// The cell of a row in a column; empty if the table lacks the column.
    pub fn cell<'r>(&self, row: &'r StringRecord, column: &str) -> &'r str {
        self.columns.cell(row, column)
    }

    /// Whether a cell has no value; see [`Columns::is_missing`].
    pub fn is_missing(&self, row: &StringRecord, column: &str) -> bool {
        self.columns.is_missing(row, column)
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
        self.columns.number(row, column).map_err(|message| self.wrong(row, message))
    }

    /// The vector with its components in two columns; `None` if both cells have no value, as for a hidden marker.
    ///
    /// # Errors
    /// [`FileError`] with the line if a cell is not a finite number, or if only one of the two has a value.
    pub fn vector(&self, row: &StringRecord, columns: [&str; 2]) -> Result<Option<Vector>, FileError> {
        self.columns.vector(row, columns).map_err(|message| self.wrong(row, message))
    }

    /// The node number in a cell.
    pub(crate) fn node(&self, row: &StringRecord, column: &str) -> Result<NodeId, FileError> {
        self.columns.node(row, column).map_err(|message| self.wrong(row, message))
    }
}

fn described(text: &str, error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = line_of(text, byte_of(pos.as_ref()));
            format!("line {line}: {}", unequal(*expected_len as usize, *len as usize))
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
