//! Numbers that appear as a table of the page, a CSV file and an array of `summary.json`. Each column is defined once for all three.
//!
//! [`Columns`] define the key in files, and the heading and [`Format`] on the page. A [`Dataset`] adds rows to the columns.

mod value;

pub use value::{Format, Value};

use super::page::{self, Cell, Table};
use finray_files::csv_text;
use serde::{Serialize, Serializer};

/// Columns of a table with rows of type `R`.
pub struct Columns<'c, R>(Vec<Column<'c, R>>);

struct Column<'c, R> {
    in_files: Option<(&'static str, Accessor<'c, R, Value>)>,
    on_page: Option<(page::Column, Accessor<'c, R, Cell>)>,
}

type Accessor<'c, R, T> = Box<dyn Fn(&R) -> T + 'c>;

impl<R> Default for Columns<'_, R> {
    fn default() -> Self {
        Columns(Vec::new())
    }
}

impl<'c, R: 'c> Columns<'c, R> {
    /// An empty list of columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column that only the files have: its key, which includes the unit, and its values.
    pub fn file<V: Into<Value>>(mut self, key: &'static str, of: impl Fn(&R) -> V + 'c) -> Self {
        let value = move |row: &R| of(row).into();
        self.0.push(Column { in_files: Some((key, Box::new(value))), on_page: None });
        self
    }

    /// Adds a column that both the files and the page have.
    pub fn both<V: Into<Value>>(
        self,
        key: &'static str,
        heading: impl Into<String>,
        format: Format,
        of: impl Fn(&R) -> V + Copy + 'c,
    ) -> Self {
        self.file(key, of).page(heading, format, of)
    }

    /// Adds a column that only the page has.
    pub fn page<V: Into<Value>>(self, heading: impl Into<String>, format: Format, of: impl Fn(&R) -> V + 'c) -> Self {
        self.cells(heading_of(heading, format), move |row| format.cell(&of(row).into()))
    }

    /// Adds a column that only the page has, with a function that makes the cells.
    pub fn cells(mut self, heading: page::Column, of: impl Fn(&R) -> Cell + 'c) -> Self {
        self.0.push(Column { in_files: None, on_page: Some((heading, Box::new(of))) });
        self
    }

    /// Adds one column for each of `things`; `add` makes the column.
    pub fn each<T>(self, things: impl IntoIterator<Item = T>, add: impl Fn(Self, T) -> Self) -> Self {
        things.into_iter().fold(self, add)
    }

    /// The page's table with these rows; `csv` names the file with the same numbers.
    pub fn table(&self, caption: impl Into<String>, csv: &str, rows: impl IntoIterator<Item = R>) -> Table {
        let shown = || self.0.iter().filter_map(|column| column.on_page.as_ref());
        let rows = rows.into_iter().map(|row| shown().map(|(_, of)| of(&row)).collect());
        Table {
            caption: caption.into(),
            columns: shown().map(|(heading, _)| heading.clone()).collect(),
            rows: rows.collect(),
            csv: Some(csv.to_owned()),
        }
    }
}

fn heading_of(heading: impl Into<String>, format: Format) -> page::Column {
    page::Column { name: heading.into(), numeric: format != Format::Words }
}

/// Rows under a common name, for the summary and a CSV file.
pub struct Dataset<'s> {
    csv: String,
    rows: Box<dyn Rows + 's>,
    is_empty: bool,
    table: Table,
    goes_to: GoesTo,
}

#[derive(Clone, Copy, PartialEq)]
enum GoesTo {
    Both,
    CsvAlone,
    SummaryAlone,
}

/// Rows that can write themselves as CSV and JSON.
trait Rows {
    fn csv(&self) -> Result<String, csv::Error>;
    fn json(&self) -> Result<String, serde_json::Error>;
}

/// Rows that are serialised by their own type.
struct Records<T>(Vec<T>);

impl<T: Serialize> Rows for Records<T> {
    fn csv(&self) -> Result<String, csv::Error> {
        csv_text(&self.0)
    }

    fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(&self.0)
    }
}

/// Rows of values, with the keys of their columns.
struct Values {
    keys: Vec<&'static str>,
    rows: Vec<Vec<Value>>,
}

impl Rows for Values {
    fn csv(&self) -> Result<String, csv::Error> {
        // A CSV file has a list in a single field.
        let flat = |value: &Value| match value {
            Value::List(_) => Value::Text(value.in_words()),
            other => other.clone(),
        };
        let header = self.keys.iter().map(|key| Value::from(*key)).collect();
        let rows = self.rows.iter().map(|row| row.iter().map(flat).collect());
        csv_text(std::iter::once(header).chain(rows).collect::<Vec<Vec<Value>>>())
    }

    fn json(&self) -> Result<String, serde_json::Error> {
        let rows: Vec<Fields> = self.rows.iter().map(|row| Fields(&self.keys, row)).collect();
        serde_json::to_string_pretty(&rows)
    }
}

/// A row as a JSON object, with the fields in the order of the keys.
struct Fields<'v>(&'v [&'static str], &'v [Value]);

impl Serialize for Fields<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().zip(self.1))
    }
}

impl<'s> Dataset<'s> {
    /// A dataset from columns and rows. `csv` names the CSV file; without its suffix it names the summary's array.
    pub fn new<R: 's>(csv: &str, columns: &Columns<'s, R>, rows: impl IntoIterator<Item = R>) -> Self {
        let rows: Vec<R> = rows.into_iter().collect();
        let in_files = || columns.0.iter().filter_map(|column| column.in_files.as_ref());
        let values = Values {
            keys: in_files().map(|(key, _)| *key).collect(),
            rows: rows.iter().map(|row| in_files().map(|(_, of)| of(row)).collect()).collect(),
        };
        let is_empty = rows.is_empty();
        let table = columns.table("", csv, rows);
        Dataset { csv: csv.to_owned(), rows: Box::new(values), is_empty, table, goes_to: GoesTo::Both }
    }

    /// A dataset as of [`new`](Self::new), with rows that are serialised by their own type.
    pub fn records<T: Serialize + 's>(csv: &str, rows: impl IntoIterator<Item = T>) -> Self {
        let rows = Records(rows.into_iter().collect());
        let (csv, is_empty) = (csv.to_owned(), rows.0.is_empty());
        Dataset { csv, rows: Box::new(rows), is_empty, table: Table::default(), goes_to: GoesTo::Both }
    }

    /// Restricts the dataset to its CSV file, without the summary's array.
    pub fn csv_alone(self) -> Self {
        Dataset { goes_to: GoesTo::CsvAlone, ..self }
    }

    /// Restricts the dataset to the summary's array, without a CSV file.
    pub fn summary_alone(self) -> Self {
        Dataset { goes_to: GoesTo::SummaryAlone, ..self }
    }

    /// The page's table, with the columns shown there.
    pub fn table(self, caption: impl Into<String>) -> Table {
        Table { caption: caption.into(), ..self.table }
    }

    /// Name and text of the CSV file; `None` if the dataset has no rows or no CSV file.
    pub fn csv(&self) -> Result<Option<(String, String)>, csv::Error> {
        if self.is_empty || self.goes_to == GoesTo::SummaryAlone {
            return Ok(None);
        }
        Ok(Some((self.csv.clone(), self.rows.csv()?)))
    }

    /// Key and JSON text of the summary's array, which may be empty; `None` if the dataset has no array.
    pub fn json(&self) -> Result<Option<(&str, String)>, serde_json::Error> {
        if self.goes_to == GoesTo::CsvAlone {
            return Ok(None);
        }
        Ok(Some((self.csv.trim_end_matches(".csv"), self.rows.json()?)))
    }
}
