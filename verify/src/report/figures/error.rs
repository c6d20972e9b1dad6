//! Why a figure was not drawn.

use thiserror::Error;

/// Data that cannot be drawn honestly, or a drawing that went wrong.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FigureError {
    /// A list that the figure is made of has no entries.
    #[error("nothing to draw: {what} is empty")]
    Empty {
        /// The list in question.
        what: String,
    },
    /// Two lists that belong together have different lengths.
    #[error("{what} has {found} entries, {expected} expected")]
    Mismatch {
        /// The list in question.
        what: String,
        /// The length that the rest of the data calls for.
        expected: usize,
        /// The length found.
        found: usize,
    },
    /// A number is not-a-number or infinite.
    #[error("{what} holds a number that is not finite")]
    NotFinite {
        /// The list in question.
        what: String,
    },
    /// A logarithmic scale met zero or a negative number.
    #[error("{what} holds a number that is not above zero, on a logarithmic scale")]
    NotPositive {
        /// The list in question.
        what: String,
    },
    /// Grid places that neither rise nor fall all the way.
    #[error("{what} must rise, or fall, from each entry to the next")]
    NotMonotone {
        /// The list in question.
        what: String,
    },
    /// Limits whose lower end is not below the upper one, or a size too small to draw in.
    #[error("{what} leaves no room to draw: {low} to {high}")]
    NoRoom {
        /// The limits in question.
        what: String,
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
    },
    /// The SVG writer failed.
    #[error("the drawing could not be written: {0}")]
    Drawing(String),
}

/// Refuses an empty list.
pub(super) fn require_some<T>(what: &str, list: &[T]) -> Result<(), FigureError> {
    if list.is_empty() {
        return Err(FigureError::Empty { what: what.into() });
    }
    Ok(())
}

/// Refuses a list of another length than `expected`.
pub(super) fn require_len<T>(what: &str, list: &[T], expected: usize) -> Result<(), FigureError> {
    if list.len() != expected {
        return Err(FigureError::Mismatch { what: what.into(), expected, found: list.len() });
    }
    Ok(())
}

/// Refuses numbers that are not finite.
pub(super) fn require_finite<'a>(what: &str, numbers: impl IntoIterator<Item = &'a f64>) -> Result<(), FigureError> {
    if numbers.into_iter().all(|number| number.is_finite()) {
        return Ok(());
    }
    Err(FigureError::NotFinite { what: what.into() })
}

/// Refuses limits that are not finite or whose lower end is not below the upper one.
pub(super) fn require_limits(what: &str, [low, high]: [f64; 2]) -> Result<(), FigureError> {
    require_finite(what, &[low, high])?;
    if low < high {
        return Ok(());
    }
    let what = what.into();
    Err(FigureError::NoRoom { what, low, high })
}
