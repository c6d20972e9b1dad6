//! Kinds of values that keys accept. Each implementation of [`Kind`] reads values from TOML, checks their range, and describes them in words.

mod numbers;

pub use numbers::*;

use std::fmt::Debug;
use toml::de::DeValue;

/// Error for a value of the wrong type, or outside the range of its key.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, found {found}")]
pub struct Refused {
    /// Description of the valid values, in words.
    pub expected: String,
    /// Description of the value in the scene, in words.
    pub found: String,
}

/// A kind of value that a key accepts.
pub trait Kind {
    /// Type of the value after reading.
    type Value: Clone + Debug;

    /// Name of the quantity with its unit, for the error about a missing value.
    fn noun(&self) -> String;

    /// Name of the quantity with its unit and range, for the error about a value outside the range.
    fn expected(&self) -> String {
        self.noun()
    }

    /// Name of the quantity with its unit and range, for the reference.
    fn described(&self) -> String {
        self.expected()
    }

    /// Reads a value from TOML without checking its range.
    ///
    /// # Errors
    /// [`Refused`] for a value of another type.
    fn parse(&self, value: &DeValue) -> Result<Self::Value, Refused>;

    /// Text of a value outside the range: the whole value, or its first part outside the range. `None` for a value within the range.
    fn outside(&self, _value: &Self::Value) -> Option<String> {
        None
    }

    /// The value written in TOML notation.
    fn written(&self, value: &Self::Value) -> String {
        format!("{value:?}")
    }
}

/// A whole number between two limits, both included. The text names the things that are counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Count(pub &'static str, pub usize, pub usize);

impl Kind for Count {
    type Value = usize;

    fn noun(&self) -> String {
        "a whole number, zero or more".to_owned()
    }

    fn expected(&self) -> String {
        let Count(of, least, most) = self;
        if of.is_empty() { format!("a whole number, {least} to {most}") } else { format!("{least} to {most} {of}") }
    }

    fn parse(&self, value: &DeValue) -> Result<usize, Refused> {
        let count = match value {
            DeValue::Integer(integer) => usize::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        count.ok_or_else(|| refused(self.noun(), value))
    }

    fn outside(&self, value: &usize) -> Option<String> {
        (!(self.1..=self.2).contains(value)).then(|| value.to_string())
    }
}

/// A text in quotation marks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Text();

impl Kind for Text {
    type Value = String;

    fn noun(&self) -> String {
        "a text in quotes".to_owned()
    }

    fn parse(&self, value: &DeValue) -> Result<String, Refused> {
        match value {
            DeValue::String(text) => Ok(text.to_string()),
            other => Err(refused(self.noun(), other)),
        }
    }
}

/// One of `N` words, in quotation marks except `true` and `false`. The value is the index of the word in the list of the `N` words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Word<const N: usize>(pub [&'static str; N]);

/// A word written in TOML notation.
fn literal(word: &str) -> String {
    if ["true", "false"].contains(&word) { word.to_owned() } else { format!("{word:?}") }
}

impl<const N: usize> Kind for Word<N> {
    type Value = usize;

    fn noun(&self) -> String {
        let words = self.0.map(literal);
        if self.0.contains(&"true") { words.join(" or ") } else { format!("one of {}", words.join(", ")) }
    }

    fn parse(&self, value: &DeValue) -> Result<usize, Refused> {
        let written = match value {
            DeValue::String(text) => format!("{text:?}"),
            other => described(other),
        };
        self.0.iter().position(|word| literal(word) == written).ok_or_else(|| refused(self.noun(), value))
    }

    fn written(&self, value: &usize) -> String {
        literal(self.0[*value])
    }
}

fn refused(expected: String, found: &DeValue) -> Refused {
    Refused { expected, found: described(found) }
}

/// Description of a TOML value, in words on one line.
pub(crate) fn described(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text {text:?}"),
        DeValue::Integer(integer) => integer.as_str().to_owned(),
        DeValue::Float(float) => float.as_str().to_owned(),
        DeValue::Boolean(switch) => switch.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
