//! Sentences of the page: templates of `words.toml`, filled with numbers from the sections.

use super::ReportError;
use super::format::{percent, percent_two_digits, percent_with, time};
use super::page::{Block, text};
use finray_studies::templates::templates;
use minijinja::{Environment, Value};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Templates: section name, then sentence name, then text.
type Sentences = BTreeMap<String, BTreeMap<String, String>>;

static WORDS: LazyLock<Result<Environment<'static>, String>> = LazyLock::new(|| {
    let sections: Sentences = toml::from_str(include_str!("words.toml")).map_err(|error| error.to_string())?;
    let sentences = sections.into_iter().flat_map(|(section, sentences)| {
        sentences.into_iter().map(move |(name, text)| (format!("{section}.{name}"), text))
    });
    let mut words = templates(sentences).map_err(|error| error.to_string())?;
    words.add_filter("percent", percent);
    words.add_filter("percent_fixed", percent_with);
    words.add_filter("percent_two_digits", percent_two_digits);
    words.add_filter("time", time);
    Ok(words)
});

/// A paragraph with its numbers filled in.
pub(super) fn paragraph(sentences: &str, numbers: Value) -> Result<Block, ReportError> {
    Ok(text(say(sentences, Some(numbers))?.unwrap_or_default()))
}

/// A sentence with its numbers filled in; `None` without numbers.
pub(super) fn say(sentence: &str, numbers: Option<Value>) -> Result<Option<String>, ReportError> {
    let Some(numbers) = numbers else { return Ok(None) };
    let words = WORDS.as_ref().map_err(|error| ReportError::Words(error.clone()))?;
    Ok(Some(words.get_template(sentence)?.render(numbers)?))
}
