//! The keys of scene files, one entry per key. The reader, its errors, the reference and the checks of [`Finger`] follow from the entry.
//!
//! Each table of a scene is a static ([`FINGER`], [`CAMERA`], ...) whose fields are its keys. A new key needs an entry in `tables` and a line that reads it.
//!
//! [`Finger`]: crate::Finger

mod kinds;
mod reference;
mod tables;

pub(crate) use kinds::described;
pub use kinds::{
    BracketLengths, Count, Kind, Number, Numbers, OfRibs, Pairs, Quantity, Range, Refused, RibLengths, RibNumbers,
    Rows, SideLengths, Text, Word,
};
pub use reference::reference;
pub use tables::*;

use std::ops::Deref;

/// Whether a scene must have a key, and the value without it.
#[derive(Debug, Clone, PartialEq)]
pub enum Need<V> {
    /// The key is required.
    Required,
    /// The key is required in the stated case, for instance "unless rigid".
    RequiredIf(&'static str),
    /// The key is required if the table's `shape` is this one, and rejected for other shapes.
    Of(&'static str),
    /// The key has this default.
    Or(V),
    /// The key is optional and has no default.
    Optional,
}

/// A key of a table, with its kind of value, need and meaning.
#[derive(Debug)]
pub struct Key<K: Kind> {
    table: &'static str,
    /// Name in the table.
    pub name: &'static str,
    /// Kind and range of its values.
    pub kind: K,
    /// Whether a scene must have it, and its default.
    pub need: Need<K::Value>,
    /// Meaning of the key, as the reference prints it.
    pub says: &'static str,
}

impl<K: Kind> Key<K> {
    /// Path in the scene, as in errors: `finger.ribs.count`.
    pub fn path(&self) -> String {
        joined(self.table, self.name)
    }

    /// Path in one of several tables, numbered from 1: `finger.zone[2].to_mm`.
    pub fn path_in(&self, number: usize) -> String {
        format!("{}[{number}].{}", self.table, self.name)
    }

    /// Default value, if the key has one.
    pub fn default(&self) -> Option<&K::Value> {
        match &self.need {
            Need::Or(value) => Some(value),
            _ => None,
        }
    }

    /// Checks a value against the range of the key.
    ///
    /// # Errors
    /// [`Refused`] with the range and the value, if the value lies outside.
    pub fn check(&self, value: &K::Value) -> Result<(), Refused> {
        match self.kind.outside(value) {
            None => Ok(()),
            Some(found) => Err(Refused { expected: self.kind.expected(), found }),
        }
    }

    /// The entry of the reference.
    fn entry(&self) -> Entry {
        let need = match &self.need {
            Need::Required => "required".to_owned(),
            Need::RequiredIf(case) => format!("required {case}"),
            Need::Of(shape) => format!("required for {}", with_article(shape)),
            Need::Or(value) => format!("default {}", self.kind.written(value)),
            Need::Optional => "optional".to_owned(),
        };
        let shape = match self.need {
            Need::Of(shape) => Some(shape),
            _ => None,
        };
        let is_required = matches!(self.need, Need::Required);
        Entry { name: self.name, values: self.kind.described(), need, is_required, shape, says: self.says }
    }
}

/// Description of a key for the reference, independent of its type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Name in the table.
    pub name: &'static str,
    /// Quantity, unit and range of its values.
    pub values: String,
    /// Whether a scene must have it, and its default, in words.
    pub need: String,
    /// Whether every scene with the table must have it.
    pub is_required: bool,
    /// The only shape that has the key; `None` if all have it.
    pub shape: Option<&'static str>,
    /// Meaning of the key, as the reference prints it.
    pub says: &'static str,
}

/// Number of times that a table may occur in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occurs {
    /// Exactly once.
    Once,
    /// At most once.
    Optional,
    /// Any number of times, as `[[finger.zone]]`.
    Many,
}

/// A table of the scene; its keys are the fields of `K`.
#[derive(Debug)]
pub struct Table<K> {
    path: &'static str,
    occurs: Occurs,
    says: &'static str,
    keys: K,
}

impl<K> Deref for Table<K> {
    type Target = K;

    fn deref(&self) -> &K {
        &self.keys
    }
}

/// The keys of a table as a list.
pub trait KeyList {
    /// Entries of all keys, in the order of the reference.
    fn entries(&self) -> Vec<Entry>;
}

/// A table of the scene, independent of the type of its keys.
pub trait SceneTable: Sync {
    /// Path, for instance `finger.ribs`; empty for the keys above all tables.
    fn path(&self) -> &'static str;
    /// Number of times that it may occur in a scene.
    fn occurs(&self) -> Occurs;
    /// Meaning of the table, as the reference prints it.
    fn says(&self) -> &'static str;
    /// Entries of its keys, in the order of the reference.
    fn entries(&self) -> Vec<Entry>;

    /// Name within its parent table.
    fn name(&self) -> &'static str {
        self.path().rsplit('.').next().unwrap_or_default()
    }

    /// Names of all keys, then of all tables, that it may contain.
    fn known(&self) -> Vec<&'static str> {
        let inner = TABLES.iter().filter(|table| {
            let around = table.path().rsplit_once('.').map_or("", |(around, _)| around);
            !table.path().is_empty() && around == self.path()
        });
        self.entries().into_iter().map(|entry| entry.name).chain(inner.map(|table| table.name())).collect()
    }

    /// Text for a missing table: `[gripper]` with its required keys.
    fn outline(&self) -> String {
        let required = self.entries().into_iter().filter(|entry| entry.is_required).map(|entry| entry.name);
        self.with(&required.collect::<Vec<_>>())
    }

    /// Text for the table with some of its keys: `[grasp] with motor_deg`.
    fn with(&self, names: &[&str]) -> String {
        match names {
            [] => format!("[{}]", self.path()),
            [only] => format!("[{}] with {only}", self.path()),
            [others @ .., last] => format!("[{}] with {} and {last}", self.path(), others.join(", ")),
        }
    }
}

impl<K: KeyList + Sync> SceneTable for Table<K> {
    fn path(&self) -> &'static str {
        self.path
    }

    fn occurs(&self) -> Occurs {
        self.occurs
    }

    fn says(&self) -> &'static str {
        self.says
    }

    fn entries(&self) -> Vec<Entry> {
        self.keys.entries()
    }
}

/// Path of a name in a table.
pub(crate) fn joined(table: &str, name: &str) -> String {
    if table.is_empty() { name.to_owned() } else { format!("{table}.{name}") }
}

/// A noun with its indefinite article.
pub(crate) fn with_article(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
    format!("{article} {noun}")
}
