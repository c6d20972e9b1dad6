//! Numbers and nodes in texts that users write.

use crate::NodeId;

/// Parses a finite number.
///
/// # Errors
/// A message that states the expected text.
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
/// A message that states the expected text.
pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if x >= 0.0 { Ok(x) } else { Err(format!("expected zero or more, found {x}")) })
}

/// Parses a finite number above zero.
///
/// # Errors
/// A message that states the expected text.
pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if x > 0.0 { Ok(x) } else { Err(format!("expected more than zero, found {x}")) })
}

/// Parses the number of a node.
///
/// # Errors
/// A message that states the expected text.
pub fn node(text: &str) -> Result<NodeId, String> {
    text.trim().parse().map(NodeId).map_err(|_| format!("expected the number of a node, found \"{text}\""))
}
