//! A frame of positions as one line of JSON.

use super::time::TimeName;
use super::{AT, FINGER, FingerObservation, Fingers, IMAGE, SIGMA, marker};
use crate::table::{NODE, without_mark};
use finray_model::{NodeId, Vector};
use serde_json::{Map, Value};
use std::borrow::Cow;

/// Largest number of characters of a value that a message quotes.
const LONGEST_QUOTE: usize = 40;

/// The object on a line.
///
/// # Errors
/// A message that begins with the column of the fault.
pub(super) fn object(line: &str) -> Result<Map<String, Value>, String> {
    serde_json::from_str(&without_nan(without_mark(line))).map_err(|error| {
        let reason = error.to_string();
        let reason = reason.split(" at line ").next().unwrap_or_default();
        format!(", column {}: {reason}", error.column())
    })
}

/// Time of a frame, s; `None` if the frame states none.
///
/// # Errors
/// A message that names the key.
pub(super) fn time_s(frame: &Map<String, Value>) -> Result<Option<f64>, String> {
    let Some(time) = TimeName::first(|name| frame.get(name).is_some_and(|value| !value.is_null())) else {
        return Ok(None);
    };
    match &frame[time.name] {
        Value::String(text) => time.seconds(text),
        other => time.seconds(&other.to_string()),
    }
    .map(Some)
}

/// The markers of each finger in a frame.
///
/// # Errors
/// A message that names key and node.
pub(super) fn observations(frame: &Map<String, Value>) -> Result<Vec<FingerObservation>, String> {
    let Some(Value::Array(markers)) = frame.get("markers") else {
        return Err(format!("markers: expected a list of markers, found {}", found(frame.get("markers"))));
    };
    let mut fingers = Fingers::default();
    for (i, value) in markers.iter().enumerate() {
        let of = value
            .as_object()
            .ok_or_else(|| format!("markers[{i}]: expected an object, found {}", found(Some(value))))?;
        let node = of.get(NODE).and_then(Value::as_u64).and_then(|node| usize::try_from(node).ok());
        let node = node.ok_or_else(|| {
            format!("markers[{i}]: {NODE}: expected the number of a node, found {}", found(of.get(NODE)))
        })?;
        let in_node = |reason: String| format!("node {node}: {reason}");
        let at = [coordinate(of, AT[0]).map_err(in_node)?, coordinate(of, AT[1]).map_err(in_node)?];
        let at = match at {
            [Some(x), Some(y)] => Some(Vector::new(x, y)),
            [None, None] => None,
            _ => return Err(in_node("expected two coordinates, or two times null".to_owned())),
        };
        let sigma_mm = if of.contains_key(SIGMA) { coordinate(of, SIGMA).map_err(in_node)? } else { None };
        let finger = text(of, FINGER).map_err(in_node)?;
        fingers.add(finger, at.map(|at| marker(NodeId(node), at, sigma_mm))).map_err(in_node)?;
    }
    Ok(fingers.observations(text(frame, IMAGE)?))
}

/// The number of a key, which must be present; `None` for null.
fn coordinate(of: &Map<String, Value>, key: &str) -> Result<Option<f64>, String> {
    match of.get(key) {
        Some(Value::Null) => Ok(None),
        value => match value.and_then(Value::as_f64) {
            Some(number) => Ok(Some(number)),
            None => Err(format!("{key}: expected a number, or null for a hidden marker, found {}", found(value))),
        },
    }
}

/// The text of a key; empty if the key is missing or null.
fn text<'v>(of: &'v Map<String, Value>, key: &str) -> Result<&'v str, String> {
    match of.get(key) {
        None | Some(Value::Null) => Ok(""),
        Some(Value::String(text)) => Ok(text),
        other => Err(format!("{key}: expected a text, found {}", found(other))),
    }
}

fn found(value: Option<&Value>) -> String {
    value.map_or_else(|| "nothing".to_owned(), |value| value.to_string().chars().take(LONGEST_QUOTE).collect())
}

/// The line with null for NaN, which Python writes for a missing number and which is no JSON.
fn without_nan(line: &str) -> Cow<'_, str> {
    if !line.contains("NaN") {
        return Cow::Borrowed(line);
    }
    let (mut text, mut rest, mut in_string) = (String::with_capacity(line.len() + 8), line, false);
    while let Some(first) = rest.chars().next() {
        let taken = match first {
            '\\' if in_string => 1 + rest[1..].chars().next().map_or(0, char::len_utf8),
            '"' => {
                in_string = !in_string;
                1
            }
            'N' if !in_string && rest.starts_with("NaN") => {
                text.push_str("null");
                rest = &rest[3..];
                continue;
            }
            other => other.len_utf8(),
        };
        text.push_str(&rest[..taken]);
        rest = &rest[taken..];
    }
    Cow::Owned(text)
}
