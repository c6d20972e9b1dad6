//! Reading of typed values from TOML. Error messages name the line, the key and the expected value.

use super::SceneError;
use crate::keys::{Key, Kind, Need, SceneTable, TOP, Word, described, joined, with_article};
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A parsed scene text and the line number of each key.
pub(super) struct Document<'t> {
    root: Spanned<DeTable<'t>>,
    lines: BTreeMap<String, usize>,
    text: &'t str,
}

impl<'t> Document<'t> {
    pub(super) fn parse(text: &'t str) -> Result<Document<'t>, SceneError> {
        let root = DeTable::parse(text).map_err(|error| SceneError {
            line: error.span().map_or(1, |span| line_at(text, span.start)),
            message: format!("not valid TOML: {}", error.message()),
        })?;
        let mut lines = BTreeMap::new();
        note_lines(text, "", root.get_ref(), &mut lines);
        Ok(Document { root, lines, text })
    }

    pub(super) fn top(&self) -> Result<TableReader<'_, 't>, SceneError> {
        TableReader::open(self, String::new(), self.root.get_ref(), &TOP)
    }

    /// Line of a key, counted from 1. If the key is missing, returns the line of the innermost existing table that should contain the key.
    pub(super) fn line_of(&self, key: &str) -> usize {
        let mut key = key;
        loop {
            if let Some(line) = self.lines.get(key) {
                return *line;
            }
            match key.rfind(['.', '[']) {
                Some(end) => key = &key[..end],
                None => return 1,
            }
        }
    }
}

fn line_at(text: &str, byte: usize) -> usize {
    1 + text.as_bytes()[..byte.min(text.len())].iter().filter(|b| **b == b'\n').count()
}

fn note_lines(text: &str, path: &str, table: &DeTable, lines: &mut BTreeMap<String, usize>) {
    for (key, value) in table {
        let path = joined(path, key.get_ref());
        lines.insert(path.clone(), line_at(text, key.span().start));
        match value.get_ref() {
            DeValue::Table(inner) => note_lines(text, &path, inner, lines),
            DeValue::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    let path = format!("{path}[{}]", i + 1);
                    lines.insert(path.clone(), line_at(text, item.span().start));
                    if let DeValue::Table(inner) = item.get_ref() {
                        note_lines(text, &path, inner, lines);
                    }
                }
            }
            _ => {}
        }
    }
}

/// Similarity of an unknown key to a known key: the sum of three measures. The Jaro-Winkler and Damerau-Levenshtein measures detect typing errors.
/// The Sorensen-Dice measure counts common letter pairs and detects keys from which a part is missing.
fn likeness(known: &str, key: &str) -> f64 {
    strsim::jaro_winkler(known, key)
        + strsim::normalized_damerau_levenshtein(known, key)
        + strsim::sorensen_dice(known, key)
}

/// A table whose keys are all known; unknown keys have been rejected.
pub(super) struct TableReader<'d, 't> {
    document: &'d Document<'t>,
    path: String,
    table: &'d DeTable<'t>,
}

impl<'d, 't> TableReader<'d, 't> {
    fn open(
        document: &'d Document<'t>,
        path: String,
        table: &'d DeTable<'t>,
        of: &dyn SceneTable,
    ) -> Result<TableReader<'d, 't>, SceneError> {
        let known = of.known();
        for key in table.keys() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let nearest = known.iter().max_by(|a, b| likeness(a, name).total_cmp(&likeness(b, name)));
                let hint = nearest.map_or(String::new(), |nearest| format!("; the nearest known key is `{nearest}`"));
                return Err(SceneError {
                    line: line_at(document.text, key.span().start),
                    message: format!("unknown key `{}`{hint}", joined(&path, name).escape_debug()),
                });
            }
        }
        Ok(TableReader { document, path, table })
    }

    fn value(&self, name: &str) -> Option<&'d DeValue<'t>> {
        self.table.get(name).map(Spanned::get_ref)
    }

    pub(super) fn has<K: Kind>(&self, key: &Key<K>) -> bool {
        self.value(key.name).is_some()
    }

    /// The first of the given names that the table contains; `None` if it contains none.
    pub(super) fn first_of(&self, names: &[&'static str]) -> Option<&'static str> {
        names.iter().find(|name| self.value(name).is_some()).copied()
    }

    /// Makes the error for a wrong value.
    pub(super) fn wrong(&self, name: &str, expected: &str, found: &str) -> SceneError {
        self.at(name, &format!("expected {expected}, found {found}"))
    }

    /// Makes an error about a key; `message` states the expected value.
    pub(super) fn at(&self, name: &str, message: &str) -> SceneError {
        let path = joined(&self.path, name);
        SceneError { line: self.document.line_of(&path), message: format!("{path}: {message}") }
    }

    /// Makes the error for a missing value.
    pub(super) fn missing(&self, name: &str, expected: &str) -> SceneError {
        let path = joined(&self.path, name);
        SceneError { line: self.document.line_of(&path), message: format!("{path} is missing: expected {expected}") }
    }

    /// Reads a required table within this table.
    pub(super) fn table(&self, of: &dyn SceneTable) -> Result<TableReader<'d, 't>, SceneError> {
        self.optional_table(of)?.ok_or_else(|| self.missing(of.name(), "a table"))
    }

    pub(super) fn optional_table(&self, of: &dyn SceneTable) -> Result<Option<TableReader<'d, 't>>, SceneError> {
        match self.value(of.name()) {
            None => Ok(None),
            Some(DeValue::Table(table)) => {
                TableReader::open(self.document, joined(&self.path, of.name()), table, of).map(Some)
            }
            Some(other) => Err(self.wrong(of.name(), "a table", &described(other))),
        }
    }

    /// Reads an array of tables, written `[[name]]` in the scene. The result is empty if the scene has no such table.
    pub(super) fn tables(&self, of: &dyn SceneTable) -> Result<Vec<TableReader<'d, 't>>, SceneError> {
        let path = joined(&self.path, of.name());
        let wrong = |found: &DeValue| self.wrong(of.name(), &format!("tables [[{path}]]"), &described(found));
        let items = match self.value(of.name()) {
            None => return Ok(Vec::new()),
            Some(DeValue::Array(items)) => items,
            Some(other) => return Err(wrong(other)),
        };
        let open = |(i, item): (usize, &'d Spanned<DeValue<'t>>)| match item.get_ref() {
            DeValue::Table(table) => TableReader::open(self.document, format!("{path}[{}]", i + 1), table, of),
            other => Err(wrong(other)),
        };
        items.iter().enumerate().map(open).collect()
    }

    /// Reads the value of a key, or returns the key's default.
    pub(super) fn get<K: Kind>(&self, key: &Key<K>) -> Result<K::Value, SceneError> {
        match (self.optional(key)?, &key.need) {
            (Some(value), _) => Ok(value),
            (None, Need::Or(default)) => Ok(default.clone()),
            (None, _) => Err(self.missing(key.name, &key.kind.noun())),
        }
    }

    /// Reads the value of a key; `None` if the table does not contain the key.
    pub(super) fn optional<K: Kind>(&self, key: &Key<K>) -> Result<Option<K::Value>, SceneError> {
        let Some(value) = self.value(key.name) else { return Ok(None) };
        let value = key.kind.parse(value).and_then(|value| key.check(&value).map(|()| value));
        value.map(Some).map_err(|refused| self.at(key.name, &refused.to_string()))
    }

    /// Reads a word and returns the entry of `things` for this word. `things` has one entry for each word that the key accepts.
    pub(super) fn word<T: Copy, const N: usize>(&self, key: &Key<Word<N>>, things: [T; N]) -> Result<T, SceneError> {
        self.get(key).map(|word| things[word])
    }

    /// Reads the word `true` or `false` and returns its truth value.
    pub(super) fn is_true(&self, key: &Key<Word<2>>) -> Result<bool, SceneError> {
        self.word(key, [true, false])
    }

    /// Reads the shape that the table describes, and rejects keys that belong to other shapes.
    pub(super) fn shape<T: Copy, const N: usize>(
        &self,
        of: &dyn SceneTable,
        key: &Key<Word<N>>,
        shapes: [T; N],
    ) -> Result<T, SceneError> {
        let place = self.get(key)?;
        let own = key.kind.0[place];
        let is_foreign =
            |name: &&str, shape: Option<&str>| shape.is_some_and(|shape| shape != own) && self.value(name).is_some();
        match of.entries().iter().find(|entry| is_foreign(&entry.name, entry.shape)) {
            Some(entry) => Err(self.not_of(entry.name, &with_article(own))),
            None => Ok(shapes[place]),
        }
    }

    /// Makes the error for a key that does not belong to the described shape or object. `whose` names the described shape or object, for instance "a
    /// disc".
    pub(super) fn not_of(&self, name: &str, whose: &str) -> SceneError {
        self.wrong(name, "no such key", &format!("a key that {whose} does not have"))
    }
}
