//! The exceptions of the package.

use pyo3::exceptions::PyException;
use pyo3::{PyErr, create_exception};
use std::fmt::Display;

create_exception!(
    finray,
    FinrayError,
    PyException,
    "The input is wrong, or a result cannot be computed. The message says why."
);
create_exception!(
    finray,
    Refused,
    FinrayError,
    "The input has the right form, but yields no estimate, because an image shows no finger or because the forces \
        are not identifiable."
);

/// The exception for wrong input or a result that cannot be computed.
pub fn failed(reason: impl Display) -> PyErr {
    FinrayError::new_err(argument_named(reason.to_string()))
}

/// The exception for valid input that yields no estimate.
pub fn refused(reason: impl Display) -> PyErr {
    Refused::new_err(argument_named(reason.to_string()))
}

/// A message about a wrong option, such as `--mesh-nodes: ...`, with the name of the argument instead of the option.
fn argument_named(message: String) -> String {
    match message.strip_prefix("--").and_then(|message| message.split_once(": ")) {
        Some((option, reason)) if option.chars().all(|c| c.is_ascii_lowercase() || c == '-') => {
            format!("{}: {reason}", option.replace('-', "_"))
        }
        _ => message,
    }
}
