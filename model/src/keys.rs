//! The keys of scene files: one entry a key, from which the reader, its errors, the reference and the checks of [`Finger`] follow.
//!
//! A table of the scene is a static ([`FINGER`], [`CAMERA`], ...) of its keys. To add a key: an entry in `tables`, and a line where it is read.
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

/// Whether a scene must have a key, and what holds without it.
#[derive(Debug, Clone, PartialEq)]
pub enum Need<V> {
    /// It must.
    Required,
    /// It must in the case that is said, as "unless rigid".
    RequiredIf(&'static str),
    /// It must where the table's `shape` is this one, and must not where it is another.
    Of(&'static str),
    /// This value holds without it.
    Or(V),
    /// It may be left out.
    Optional,
}

/// A key of a table.
#[derive(Debug)]
pub struct Key<K: Kind> {
    table: &'static str,
    /// Its name in the table.
    pub name: &'static str,
    /// Which values it takes.
    pub kind: K,
    /// Whether it must be there.
    pub need: Need<K::Value>,
    /// What it means.
    pub says: &'static str,
}

impl<K: Kind> Key<K> {
    /// Its path in the scene, as errors name it: `finger.ribs.count`.
    pub fn path(&self) -> String {
        joined(self.table, self.name)
    }

    /// Its path in one of several tables, counted from 1: `finger.zone[2].to_mm`.
    pub fn path_in(&self, number: usize) -> String {
        format!("{}[{number}].{}", self.table, self.name)
    }

    /// What holds without it, where that is fixed.
    pub fn default(&self) -> Option<&K::Value> {
        match &self.need {
            Need::Or(value) => Some(value),
            _ => None,
        }
    }

    /// Checks a value against the key's range.
    ///
    /// # Errors
    /// [`Refused`] with the range and the value.
    pub fn check(&self, value: &K::Value) -> Result<(), Refused> {
        match self.kind.outside(value) {
            None => Ok(()),
            Some(found) => Err(Refused { expected: self.kind.expected(), found }),
        }
    }

    /// What the reference says of it.
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

/// A key without its type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Its name in the table.
    pub name: &'static str,
    /// Which values it takes: quantity, unit and range.
    pub values: String,
    /// Whether it must be there, and its default.
    pub need: String,
    /// Whether it must be there in any case.
    pub is_required: bool,
    /// The shape that has it, where others have not.
    pub shape: Option<&'static str>,
    /// What it means.
    pub says: &'static str,
}

/// How often a table stands in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occurs {
    /// Once.
    Once,
    /// Once or not at all.
    Optional,
    /// Any number of times, as `[[finger.zone]]`.
    Many,
}

/// A table of the scene. Its keys are fields.
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
    /// All of them, in the order of the reference.
    fn entries(&self) -> Vec<Entry>;
}

/// A table of the scene, whatever its keys.
pub trait SceneTable: Sync {
    /// Its path, `finger.ribs`; empty for the keys above all tables.
    fn path(&self) -> &'static str;
    /// How often it stands in a scene.
    fn occurs(&self) -> Occurs;
    /// What it describes.
    fn says(&self) -> &'static str;
    /// Its keys.
    fn entries(&self) -> Vec<Entry>;

    /// Its name in the table around it.
    fn name(&self) -> &'static str {
        self.path().rsplit('.').next().unwrap_or_default()
    }

    /// Names of all that may stand in it: keys, then tables.
    fn known(&self) -> Vec<&'static str> {
        let inner = TABLES.iter().filter(|table| {
            let around = table.path().rsplit_once('.').map_or("", |(around, _)| around);
            !table.path().is_empty() && around == self.path()
        });
        self.entries().into_iter().map(|entry| entry.name).chain(inner.map(|table| table.name())).collect()
    }

    /// What is missing where a scene lacks the table: `[gripper]` with its required keys.
    fn outline(&self) -> String {
        let required = self.entries().into_iter().filter(|entry| entry.is_required).map(|entry| entry.name);
        self.with(&required.collect::<Vec<_>>())
    }

    /// The table with some of its keys: `[grasp] with motor_deg`.
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

/// The path of a name in a table.
pub(crate) fn joined(table: &str, name: &str) -> String {
    if table.is_empty() { name.to_owned() } else { format!("{table}.{name}") }
}

/// A noun with its indefinite article.
pub(crate) fn with_article(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
    format!("{article} {noun}")
}
