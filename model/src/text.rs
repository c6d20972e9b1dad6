//! Parses numbers and node numbers from text that users write.

use crate::NodeId;

/// Parses a finite number.
///
/// # Errors
/// If the text is not a finite number: a message that states what was expected.
pub fn finite(text: &str) -> Result<f64, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite())
        .ok_or_else(|| format!("expected a finite number, found \"{text}\""))
}

/// Parses a finite number, zero or more.
///
/// # Errors
/// If the text is not a finite number of at least zero: a message that states what was expected.
pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if x >= 0.0 { Ok(x) } else { Err(format!("expected zero or more, found {x}")) })
}

/// Parses a finite number above zero.
///
/// # Errors
/// If the text is not a finite number above zero: a message that states what was expected.
pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if x > 0.0 { Ok(x) } else { Err(format!("expected more than zero, found {x}")) })
}

/// Parses the number of a node.
///
/// # Errors
/// If the text is not a node number: a message that states what was expected.
pub fn node(text: &str) -> Result<NodeId, String> {
    text.trim().parse().map(NodeId).map_err(|_| format!("expected the number of a node, found \"{text}\""))
}
