//! Numbers that appear as a table of the page, a CSV file and an array of `summary.json`. Each column is defined once for the table, the CSV file and
//! the array.
//!
//! [`Columns`] define the key in files, and the heading and [`Format`] on the page. A [`Dataset`] adds rows to the columns.

mod value;

pub use value::{Format, Value};

use super::page::{self, Cell, Table};
use finray_files::csv_text;
use serde::ser::{Serialize, SerializeStruct, Serializer};

/// Columns of a table with rows of type `R`. The files and the page have separate lists of columns.
pub struct Columns<'c, R> {
    in_files: Vec<(&'static str, Accessor<'c, R, Value>)>,
    on_page: Vec<(page::Column, Accessor<'c, R, Cell>)>,
}

type Accessor<'c, R, T> = Box<dyn Fn(&R) -> T + 'c>;

impl<R> Default for Columns<'_, R> {
    fn default() -> Self {
        Columns { in_files: Vec::new(), on_page: Vec::new() }
    }
}

impl<'c, R: 'c> Columns<'c, R> {
    /// An empty list of columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column that only the files have; `key` is its name with the unit, and `of` gives its values.
    pub fn file<V: Into<Value>>(mut self, key: &'static str, of: impl Fn(&R) -> V + 'c) -> Self {
        self.in_files.push((key, Box::new(move |row: &R| of(row).into())));
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
        self.cells(heading, format, move |row| format.cell(&of(row).into()))
    }

    /// Adds a column that only the page has, with a function that makes the cells; `format` aligns the heading.
    pub fn cells(mut self, heading: impl Into<String>, format: Format, of: impl Fn(&R) -> Cell + 'c) -> Self {
        let heading = page::Column { name: heading.into(), numeric: format != Format::Words };
        self.on_page.push((heading, Box::new(of)));
        self
    }

    /// Adds one column for each of `things`; `add` makes the column.
    pub fn each<T>(self, things: impl IntoIterator<Item = T>, add: impl Fn(Self, T) -> Self) -> Self {
        things.into_iter().fold(self, add)
    }

    /// The page's table with these rows; `csv` names the file with the same numbers.
    pub fn table(&self, caption: impl Into<String>, csv: &str, rows: impl IntoIterator<Item = R>) -> Table {
        let cells = |row: R| self.on_page.iter().map(|(_, of)| of(&row)).collect();
        Table {
            caption: caption.into(),
            columns: self.on_page.iter().map(|(heading, _)| heading.clone()).collect(),
            rows: rows.into_iter().map(cells).collect(),
            csv: Some(csv.to_owned()),
        }
    }
}

/// Rows under a common name, for the summary and a CSV file.
pub struct Dataset<'s> {
    csv: String,
    rows: Box<dyn Rows + 's>,
    in_csv: bool,
    in_summary: bool,
}

/// Rows that can write themselves as CSV and JSON.
trait Rows {
    fn csv(&self) -> Result<String, csv::Error>;
    fn json(&self) -> Result<String, serde_json::Error>;
}

impl<T: Serialize> Rows for Vec<T> {
    fn csv(&self) -> Result<String, csv::Error> {
        csv_text(self)
    }

    fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

/// A row of values with the keys of their columns.
struct Fields(Vec<(&'static str, Value)>);

impl Serialize for Fields {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("row", self.0.len())?;
        self.0.iter().try_for_each(|(key, value)| fields.serialize_field(key, value))?;
        fields.end()
    }
}

impl<'s> Dataset<'s> {
    /// A dataset from columns and rows. `csv` is the name of the CSV file; without the suffix it is the key of the summary's array.
    pub fn new<R: 's>(csv: &str, columns: &Columns<'s, R>, rows: impl IntoIterator<Item = R>) -> Self {
        let fields = |row: R| Fields(columns.in_files.iter().map(|(key, of)| (*key, of(&row))).collect());
        Self::records(csv, rows.into_iter().map(fields))
    }

    /// A dataset as made by [`new`](Self::new), but with rows that serialise themselves.
    pub fn records<T: Serialize + 's>(csv: &str, rows: impl IntoIterator<Item = T>) -> Self {
        let rows: Vec<T> = rows.into_iter().collect();
        Dataset { csv: csv.to_owned(), in_csv: !rows.is_empty(), in_summary: true, rows: Box::new(rows) }
    }

    /// Restricts the dataset to its CSV file, without the summary's array.
    pub fn csv_alone(self) -> Self {
        Dataset { in_summary: false, ..self }
    }

    /// Restricts the dataset to the summary's array, without a CSV file.
    pub fn summary_alone(self) -> Self {
        Dataset { in_csv: false, ..self }
    }

    /// Name and text of the CSV file; `None` if the dataset has no rows or no CSV file.
    pub fn csv(&self) -> Result<Option<(String, String)>, csv::Error> {
        self.in_csv.then(|| self.rows.csv().map(|text| (self.csv.clone(), text))).transpose()
    }

    /// Key and JSON text of the summary's array, which may be empty; `None` if the dataset has no array.
    pub fn json(&self) -> Result<Option<(&str, String)>, serde_json::Error> {
        let key = self.csv.trim_end_matches(".csv");
        self.in_summary.then(|| self.rows.json().map(|text| (key, text))).transpose()
    }
}
