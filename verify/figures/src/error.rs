//! Reasons why a figure cannot be drawn, and the checks for them.

use std::fmt;

use plotters::drawing::DrawingAreaErrorKind;
use thiserror::Error;

/// Reason why a figure cannot be drawn. The text in most variants names the list or axis at fault.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FigureError {
    /// A list that must have entries is empty.
    #[error("nothing to draw: {0} is empty")]
    Empty(String),
    /// Two lists that must have equal lengths have different lengths.
    #[error("{0}: expected {1} entries, found {2}")]
    Mismatch(String, usize, usize),
    /// A value is infinite or not a number.
    #[error("{0}: expected finite numbers, found one that is infinite or not a number")]
    NotFinite(String),
    /// A value is below zero; on a logarithmic scale, zero or below.
    #[error(
        "{0}: expected numbers that the scale can show (0 or more; above 0 on a logarithmic axis), found a smaller one"
    )]
    NotPositive(String),
    /// Positions of a grid neither increase nor decrease from each entry to the next.
    #[error("{0}: expected numbers that only increase or only decrease from each entry to the next")]
    NotMonotone(String),
    /// The lower limit is not below the upper one.
    #[error("{0}: expected a lower limit below the upper one, found {1} to {2}")]
    NoRoom(String, f64, f64),
    /// Plotters could not draw the figure.
    #[error("cannot draw the figure: {0}")]
    Drawing(String),
}

impl From<DrawingAreaErrorKind<fmt::Error>> for FigureError {
    fn from(error: DrawingAreaErrorKind<fmt::Error>) -> Self {
        Self::Drawing(error.to_string())
    }
}

/// Returns `Ok` if `holds` is true; otherwise the error `refusal` for the list named `what`.
pub(super) fn require(holds: bool, refusal: fn(String) -> FigureError, what: &str) -> Result<(), FigureError> {
    if holds { Ok(()) } else { Err(refusal(what.to_owned())) }
}

/// Rejects lists with a value that is infinite or not a number.
pub(super) fn require_finite<'a>(what: &str, mut all: impl Iterator<Item = &'a f64>) -> Result<(), FigureError> {
    require(all.all(|number| number.is_finite()), FigureError::NotFinite, what)
}

/// Rejects a list whose length is not `expected`.
pub(super) fn require_len<T>(what: &str, list: &[T], expected: usize) -> Result<(), FigureError> {
    if list.len() == expected { Ok(()) } else { Err(FigureError::Mismatch(what.to_owned(), expected, list.len())) }
}

/// Rejects limits whose lower end is not below the upper end.
pub(super) fn require_limits(what: &str, [low, high]: [f64; 2]) -> Result<(), FigureError> {
    require_finite(what, [low, high].iter())?;
    if low < high { Ok(()) } else { Err(FigureError::NoRoom(what.to_owned(), low, high)) }
}
