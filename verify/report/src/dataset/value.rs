//! A value of a table, as written in files and as shown on the page.

use crate::format::{NOTHING, error, percent, percent_two_digits};
use crate::page::Cell;
use serde::Serialize;

/// A value in a file. CSV has numbers in their shortest exact form, and an empty field for a missing value.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// Text.
    Text(String),
    /// A count.
    Integer(usize),
    /// A real number.
    Number(f64),
    /// True or false.
    Bool(bool),
    /// No value.
    None,
}

macro_rules! value_from {
    ($($from:ty => $to:expr),*) => {
        $(impl From<$from> for Value {
            fn from(value: $from) -> Value {
                $to(value)
            }
        })*
    };
}
value_from!(String => Value::Text, usize => Value::Integer, f64 => Value::Number, bool => Value::Bool);

impl From<&str> for Value {
    fn from(text: &str) -> Value {
        Value::Text(text.to_owned())
    }
}

impl<V: Into<Value>> From<Option<V>> for Value {
    fn from(value: Option<V>) -> Value {
        value.map_or(Value::None, V::into)
    }
}

impl Value {
    /// The value that a field of a file states.
    pub(crate) fn parsed(text: &str) -> Value {
        match (text.parse(), text.parse()) {
            _ if text.is_empty() => Value::None,
            (Ok(integer), _) => Value::Integer(integer),
            (_, Ok(number)) => Value::Number(number),
            _ => text.parse().map_or_else(|_| text.into(), Value::Bool),
        }
    }

    /// The value as plain text.
    pub(crate) fn in_words(&self) -> String {
        match self {
            Value::Text(text) => text.clone(),
            Value::Integer(integer) => integer.to_string(),
            Value::Number(number) => number.to_string(),
            Value::Bool(holds) => holds.to_string(),
            Value::None => NOTHING.to_owned(),
        }
    }
}

/// Format of a value on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Format {
    /// Left-aligned text.
    Words,
    /// A right-aligned number in its shortest form.
    Plain,
    /// A number with this many decimals.
    Fixed(usize),
    /// A share in percent.
    Percent,
    /// A share in percent with at least two significant digits, down to 0.000001 %.
    PercentTwoDigits,
    /// An error: a share in percent, amber above 10 % and red above 25 %.
    Error,
}

impl Format {
    /// The value as a cell of the page's table.
    pub(super) fn cell(self, value: &Value) -> Cell {
        let Value::Number(number) = *value else { return Cell::plain(value.in_words()) };
        match self {
            Format::Words | Format::Plain => Cell::plain(value.in_words()),
            Format::Fixed(decimals) => Cell::plain(format!("{number:.decimals$}")),
            Format::Percent => Cell::plain(percent(number)),
            Format::PercentTwoDigits => Cell::plain(percent_two_digits(number)),
            Format::Error => error(number),
        }
    }
}
