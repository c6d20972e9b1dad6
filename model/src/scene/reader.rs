//! Reading typed values out of TOML with errors that name line, key and what was expected.

use super::SceneError;
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A parsed text and the line of each of its keys.
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

    pub(super) fn top(&self, known: &[&'static str]) -> Result<TableReader<'_, 't>, SceneError> {
        TableReader::open(self, String::new(), self.root.get_ref(), known)
    }

    /// Line of a key, or of the nearest table around it where the key itself is not written.
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

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// How near a key is to a known one: by letters in order and by letters to change, which see typing errors, and by pairs of letters,
/// which sees a part that was left out.
fn likeness(known: &str, key: &str) -> f64 {
    strsim::jaro_winkler(known, key)
        + strsim::normalized_damerau_levenshtein(known, key)
        + strsim::sorensen_dice(known, key)
}

/// One table, all of whose keys are known.
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
        known: &[&'static str],
    ) -> Result<TableReader<'d, 't>, SceneError> {
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

    fn value(&self, key: &str) -> Option<&'d DeValue<'t>> {
        self.table.get(key).map(Spanned::get_ref)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// The error for a value that is not what it should be.
    pub(super) fn wrong(&self, key: &str, expected: &str, found: &str) -> SceneError {
        let path = joined(&self.path, key);
        SceneError {
            line: self.document.line_of(&path),
            message: format!("{path}: expected {expected}, found {found}"),
        }
    }

    /// An error about a key whose message says what was expected.
    pub(super) fn at(&self, key: &str, message: &str) -> SceneError {
        SceneError { line: self.document.line_of(&joined(&self.path, key)), message: joined(&self.path, message) }
    }

    /// The error for a value that is not there.
    pub(super) fn missing(&self, key: &str, expected: &str) -> SceneError {
        let path = joined(&self.path, key);
        SceneError { line: self.document.line_of(&path), message: format!("{path} is missing: expected {expected}") }
    }

    /// A required table.
    pub(super) fn table(&self, key: &str, known: &[&'static str]) -> Result<TableReader<'d, 't>, SceneError> {
        self.optional_table(key, known)?.ok_or_else(|| self.missing(key, "a table"))
    }

    pub(super) fn optional_table(
        &self,
        key: &str,
        known: &[&'static str],
    ) -> Result<Option<TableReader<'d, 't>>, SceneError> {
        match self.value(key) {
            None => Ok(None),
            Some(DeValue::Table(table)) => {
                TableReader::open(self.document, joined(&self.path, key), table, known).map(Some)
            }
            Some(other) => Err(self.wrong(key, "a table", &described(other))),
        }
    }

    /// An array of tables, `[[key]]`; none if it is not there.
    pub(super) fn tables(&self, key: &str, known: &[&'static str]) -> Result<Vec<TableReader<'d, 't>>, SceneError> {
        let expected = format!("tables [[{}]]", joined(&self.path, key));
        let items = match self.value(key) {
            None => return Ok(Vec::new()),
            Some(DeValue::Array(items)) => items,
            Some(other) => return Err(self.wrong(key, &expected, &described(other))),
        };
        items
            .iter()
            .enumerate()
            .map(|(i, item)| match item.get_ref() {
                DeValue::Table(table) => {
                    let path = format!("{}[{}]", joined(&self.path, key), i + 1);
                    TableReader::open(self.document, path, table, known)
                }
                other => Err(self.wrong(key, &expected, &described(other))),
            })
            .collect()
    }

    pub(super) fn text(&self, key: &str) -> Result<String, SceneError> {
        match self.value(key) {
            Some(DeValue::String(text)) => Ok(text.to_string()),
            Some(other) => Err(self.wrong(key, "a text in quotes", &described(other))),
            None => Err(self.missing(key, "a text in quotes")),
        }
    }

    /// A required number; `what` names quantity and unit.
    pub(super) fn number(&self, key: &str, what: &str) -> Result<f64, SceneError> {
        self.optional_number(key, what)?.ok_or_else(|| self.missing(key, &format!("a {what}")))
    }

    pub(super) fn optional_number(&self, key: &str, what: &str) -> Result<Option<f64>, SceneError> {
        self.value(key)
            .map(|value| {
                number(value).ok_or_else(|| self.wrong(key, &format!("a {what}, as a plain number"), &described(value)))
            })
            .transpose()
    }

    pub(super) fn optional_count(&self, key: &str) -> Result<Option<usize>, SceneError> {
        self.value(key)
            .map(|value| {
                match value {
                    DeValue::Integer(integer) => usize::from_str_radix(integer.as_str(), integer.radix()).ok(),
                    _ => None,
                }
                .ok_or_else(|| self.wrong(key, "a whole number, zero or more", &described(value)))
            })
            .transpose()
    }

    pub(super) fn optional_switch(&self, key: &str) -> Result<Option<bool>, SceneError> {
        self.value(key)
            .map(|value| match value {
                DeValue::Boolean(switch) => Ok(*switch),
                other => Err(self.wrong(key, "true or false", &described(other))),
            })
            .transpose()
    }

    /// One of several values, each as it is written: a text in its quotes.
    pub(super) fn optional_value<T: Copy>(&self, key: &str, values: &[(&str, T)]) -> Result<Option<T>, SceneError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let written = match value {
            DeValue::String(text) => format!("{text:?}"),
            other => described(other),
        };
        let expected = || values.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(" or ");
        let found = values.iter().find(|(known, _)| *known == written).map(|(_, value)| *value);
        found.map(Some).ok_or_else(|| self.wrong(key, &expected(), &described(value)))
    }

    /// A list of `N` numbers; `what` names them and their unit.
    pub(super) fn optional_numbers<const N: usize>(
        &self,
        key: &str,
        what: &str,
    ) -> Result<Option<[f64; N]>, SceneError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let wrong = |found: &str| self.wrong(key, &format!("a list of {N} numbers, {what}"), found);
        let DeValue::Array(items) = value else { return Err(wrong(&described(value))) };
        let numbers: Option<Vec<f64>> = items.iter().map(|item| number(item.get_ref())).collect();
        let numbers = numbers.ok_or_else(|| wrong("a list of something else"))?;
        if let Some(other) = numbers.iter().find(|number| !number.is_finite()) {
            return Err(wrong(&format!("{other:?} in it")));
        }
        let found = numbers.len();
        <[f64; N]>::try_from(numbers).map(Some).map_err(|_| wrong(&format!("{found}")))
    }

    /// A required list of `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, key: &str, what: &str) -> Result<[f64; N], SceneError> {
        self.optional_numbers(key, what)?.ok_or_else(|| self.missing(key, &format!("a list of {N} numbers, {what}")))
    }

    /// A number that stands for two, or a list of two.
    pub(super) fn optional_number_or_pair(&self, key: &str, what: &str) -> Result<Option<[f64; 2]>, SceneError> {
        match self.value(key) {
            Some(DeValue::Array(_)) => self.optional_numbers(key, what),
            Some(value) => match number(value) {
                Some(both) => Ok(Some([both; 2])),
                None => Err(self.wrong(key, what, &described(value))),
            },
            None => Ok(None),
        }
    }

    /// Whether a list has lists in it.
    pub(super) fn is_list_of_lists(&self, key: &str) -> bool {
        let is_list = |item: &Spanned<DeValue>| matches!(item.get_ref(), DeValue::Array(_));
        matches!(self.value(key), Some(DeValue::Array(items)) if items.iter().any(is_list))
    }

    /// A list of pairs of numbers; `what` says of what, and the unit.
    pub(super) fn optional_pairs(&self, key: &str, what: &str) -> Result<Option<Vec<[f64; 2]>>, SceneError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        let pair = |item: &DeValue| match item {
            DeValue::Array(pair) => match pair.iter().map(|x| number(x.get_ref())).collect::<Option<Vec<_>>>()?[..] {
                [front, back] => Some([front, back]),
                _ => None,
            },
            _ => None,
        };
        let pairs = match value {
            DeValue::Array(items) => items.iter().map(|item| pair(item.get_ref())).collect::<Option<Vec<_>>>(),
            _ => None,
        };
        pairs.map(Some).ok_or_else(|| {
            let found = match value {
                DeValue::Array(_) => "a list of something else".to_owned(),
                other => described(other),
            };
            self.wrong(key, &format!("a list of pairs {what}"), &found)
        })
    }

    /// One of several words.
    pub(super) fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Result<T, SceneError> {
        let words: Vec<_> = choices.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        let expected = format!("one of {}", words.join(", "));
        match self.value(key) {
            None => Err(self.missing(key, &expected)),
            Some(value) => match value {
                DeValue::String(found) => choices.iter().find(|(word, _)| word == found).map(|(_, choice)| *choice),
                _ => None,
            }
            .ok_or_else(|| self.wrong(key, &expected, &described(value))),
        }
    }
}

fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64),
        _ => None,
    }
}

/// The value as it stands in the scene, on one line.
fn described(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text {text:?}"),
        DeValue::Integer(integer) => integer.as_str().to_owned(),
        DeValue::Float(float) => float.as_str().to_owned(),
        DeValue::Boolean(switch) => switch.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
