//! Reasons why a figure cannot be drawn, and the checks for them.

use std::fmt;

use plotters::drawing::DrawingAreaErrorKind;
use thiserror::Error;

/// Data that cannot be drawn correctly, or a drawing that failed. Each variant names the list in question.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FigureError {
    /// A list has no entries.
    #[error("nothing to draw: {0} is empty")]
    Empty(String),
    /// Two lists that belong together have different lengths.
    #[error("{0} has {2} entries, {1} expected")]
    Mismatch(String, usize, usize),
    /// A number is not a number or infinite.
    #[error("{0} holds a number that is not finite")]
    NotFinite(String),
    /// A number is below zero, or not above zero on a logarithmic scale.
    #[error("{0} holds a number that is too small for its scale")]
    NotPositive(String),
    /// Coordinates of a grid neither rise nor fall throughout.
    #[error("{0} must rise, or fall, from each entry to the next")]
    NotMonotone(String),
    /// The lower limit is not below the upper one.
    #[error("{0} leaves no room to draw: {1} to {2}")]
    NoRoom(String, f64, f64),
    /// The drawing could not be written.
    #[error("the drawing could not be written: {0}")]
    Drawing(String),
}

impl From<DrawingAreaErrorKind<fmt::Error>> for FigureError {
    fn from(error: DrawingAreaErrorKind<fmt::Error>) -> Self {
        Self::Drawing(error.to_string())
    }
}

/// `Ok` if `holds`; otherwise the refusal of the named list.
pub(super) fn require(holds: bool, refusal: fn(String) -> FigureError, what: &str) -> Result<(), FigureError> {
    if holds { Ok(()) } else { Err(refusal(what.to_owned())) }
}

/// Refuses numbers that are not finite.
pub(super) fn require_finite<'a>(what: &str, mut all: impl Iterator<Item = &'a f64>) -> Result<(), FigureError> {
    require(all.all(|number| number.is_finite()), FigureError::NotFinite, what)
}

/// Refuses a list whose length is not `expected`.
pub(super) fn require_len<T>(what: &str, list: &[T], expected: usize) -> Result<(), FigureError> {
    if list.len() == expected { Ok(()) } else { Err(FigureError::Mismatch(what.to_owned(), expected, list.len())) }
}

/// Refuses limits whose lower end is not below the upper one.
pub(super) fn require_limits(what: &str, [low, high]: [f64; 2]) -> Result<(), FigureError> {
    require_finite(what, [low, high].iter())?;
    if low < high { Ok(()) } else { Err(FigureError::NoRoom(what.to_owned(), low, high)) }
}
