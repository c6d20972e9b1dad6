//! The keys of scene files, one entry per key. The entry determines the key's reader, error messages, text in the reference, and range checks in [`Finger`].
//!
//! Each table of a scene is a static variable ([`FINGER`], [`CAMERA`], ...) whose fields are the table's keys. A new key needs an entry in `tables`
//! and a line of code that reads the key.
//!
//! [`Finger`]: crate::Finger

mod kinds;
mod reference;
mod tables;

pub(crate) use kinds::described;
pub use kinds::*;
pub use reference::reference;
pub use tables::*;

/// Whether a scene must have a key, and the value that applies to a scene without the key.
#[derive(Debug, Clone, PartialEq)]
pub enum Need<V> {
    /// The key is required.
    Required,
    /// The key is required in the stated case, for instance "unless ribs are rigid".
    RequiredIf(&'static str),
    /// The key is required if the table's key `shape` has this value, and rejected with any other value of `shape`.
    Of(&'static str),
    /// The key is optional and has this default.
    Or(V),
    /// The key is optional and has no default.
    Optional,
}

/// A key of a table: its name, the kind of its values, whether it is required, and its meaning.
#[derive(Debug)]
pub struct Key<K: Kind> {
    table: &'static str,
    /// Name of the key in its table.
    pub name: &'static str,
    /// Kind and range of the key's values.
    pub kind: K,
    /// Whether a scene must have the key, and the key's default.
    pub need: Need<K::Value>,
    /// Meaning of the key, as the reference prints it.
    pub says: &'static str,
}

impl<K: Kind> Key<K> {
    /// Path of the key in the scene as errors print it, for instance `finger.ribs.count`.
    pub fn path(&self) -> String {
        joined(self.table, self.name)
    }

    /// Path of the key in one of several tables, numbered from 1, for instance `finger.zone[2].to_mm`.
    pub fn path_in(&self, number: usize) -> String {
        format!("{}[{number}].{}", self.table, self.name)
    }

    /// Checks whether a value lies in the range of the key.
    ///
    /// # Errors
    /// [`Refused`] with the range and the value, if the value lies outside the range.
    pub fn check(&self, value: &K::Value) -> Result<(), Refused> {
        match self.kind.outside(value) {
            None => Ok(()),
            Some(found) => Err(Refused { expected: self.kind.expected(), found }),
        }
    }

    /// Description of the key for the reference.
    fn entry(&self) -> Entry {
        let need = match &self.need {
            Need::Required => "required".to_owned(),
            Need::RequiredIf(case) => format!("required {case}"),
            Need::Of(shape) => format!("required for {}", with_article(shape)),
            Need::Or(value) => format!("default {}", self.kind.written(value)),
            Need::Optional => "optional".to_owned(),
        };
        let shape = if let Need::Of(shape) = self.need { Some(shape) } else { None };
        let is_required = matches!(self.need, Need::Required);
        Entry { name: self.name, values: self.kind.described(), need, is_required, shape, says: self.says }
    }
}

/// Description of a key for the reference, independent of the type of its values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Name of the key in its table.
    pub name: &'static str,
    /// Quantity, unit and range of the key's values, in words.
    pub values: String,
    /// Whether a scene must have the key, and the key's default, in words.
    pub need: String,
    /// Whether every scene with this table must have the key.
    pub is_required: bool,
    /// The only value of `shape` with which the key is allowed; `None` if the key is allowed with every value of `shape`.
    pub shape: Option<&'static str>,
    /// Meaning of the key, as the reference prints it.
    pub says: &'static str,
}

/// Number of times that a scene may contain a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occurs {
    /// A scene contains the table exactly once.
    Once,
    /// A scene contains the table at most once.
    Optional,
    /// A scene contains the table any number of times, as in `[[finger.zone]]`.
    Many,
}

/// A table of the scene. The keys of the table are the fields of the type that implements this trait.
pub trait SceneTable: Sync {
    /// Path of the table, for instance `finger.ribs`; empty for the top-level keys, which belong to no table.
    fn path(&self) -> &'static str;
    /// Number of times that a scene may contain the table.
    fn occurs(&self) -> Occurs;
    /// Meaning of the table, as the reference prints it.
    fn says(&self) -> &'static str;
    /// Entries of the table's keys, in the order of the reference.
    fn entries(&self) -> Vec<Entry>;

    /// Name of the table within its parent table.
    fn name(&self) -> &'static str {
        self.path().rsplit('.').next().unwrap_or_default()
    }

    /// Names of all keys, then of all tables, that the table may contain.
    fn known(&self) -> Vec<&'static str> {
        let inner = TABLES.iter().filter(|table| {
            let around = table.path().rsplit_once('.').map_or("", |(around, _)| around);
            !table.path().is_empty() && around == self.path()
        });
        self.entries().into_iter().map(|entry| entry.name).chain(inner.map(|table| table.name())).collect()
    }

    /// Text that messages print for a missing table: its name in brackets (`[gripper]`) with its required keys.
    fn outline(&self) -> String {
        let required = self.entries().into_iter().filter(|entry| entry.is_required).map(|entry| entry.name);
        self.with(&required.collect::<Vec<_>>())
    }

    /// Text that messages print for the table and some of its keys: `[grasp] with motor_deg`.
    fn with(&self, names: &[&str]) -> String {
        match names {
            [] => format!("[{}]", self.path()),
            [only] => format!("[{}] with {only}", self.path()),
            [others @ .., last] => format!("[{}] with {} and {last}", self.path(), others.join(", ")),
        }
    }
}

/// Path of a key or table named `name` within a table.
pub(crate) fn joined(table: &str, name: &str) -> String {
    if table.is_empty() { name.to_owned() } else { format!("{table}.{name}") }
}

/// The noun with its indefinite article.
pub(crate) fn with_article(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" };
    format!("{article} {noun}")
}
