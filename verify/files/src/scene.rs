//! Reads scene files and changes values in their text.

use super::{FileError, read_text};
use finray_model::Scene;
use std::path::Path;

/// Reads and checks a scene file; `-` is standard input.
///
/// # Errors
/// [`FileError`] with file, line and key of the first fault.
pub fn load_scene(path: &Path) -> Result<Scene, FileError> {
    load_scene_and_text(path).map(|(scene, _)| scene)
}

/// Reads and checks a scene file as [`load_scene`] does, and also returns its text.
///
/// # Errors
/// [`FileError`] with file, line and key of the first fault.
pub fn load_scene_and_text(path: &Path) -> Result<(Scene, String), FileError> {
    let text = read_text(path)?;
    let scene = Scene::from_toml(&text).map_err(|error| FileError::content(path, error))?;
    Ok((scene, text))
}

/// The text of a scene after [`with_values`], with a comment behind each value. A comment replaces an earlier one that begins with the same word, and stands
/// before any other.
///
/// # Errors
/// The reason, as for [`with_values`].
pub fn with_comments(text: &str, values: &[(String, impl std::fmt::Display, String)]) -> Result<String, String> {
    let plain: Vec<_> = values.iter().map(|(path, value, _)| (path.clone(), Some(value))).collect();
    let changed = with_values(text, &plain)?;
    let mut document: toml_edit::DocumentMut =
        changed.parse().map_err(|error: toml_edit::TomlError| error.to_string())?;
    for (path, _, comment) in values {
        let item = path.split('.').try_fold(document.as_item_mut(), |item, name| item.get_mut(name));
        let Some(decor) = item.and_then(toml_edit::Item::as_value_mut).map(toml_edit::Value::decor_mut) else {
            continue;
        };
        let old = decor.suffix().and_then(toml_edit::RawString::as_str).unwrap_or_default();
        let old = old.trim().trim_start_matches('#').trim_start();
        let word = |text: &str| text.split(' ').next().map(str::to_owned);
        let kept = if old.is_empty() || word(old) == word(comment) { String::new() } else { format!("; {old}") };
        decor.set_suffix(format!(" # {comment}{kept}"));
    }
    Ok(document.to_string())
}

/// The text of a scene with some values changed; comments and all other values stay. A key is a path as in error messages, for instance
/// `finger.ribs.bracket_mm` or `base.reference[2].at_mm`. Missing tables are added; `None` removes a key.
///
/// # Errors
/// A message if the text or a value is not valid TOML. A key that leads through a missing array entry, or through a value that is not a table, also
/// yields a message.
pub fn with_values(text: &str, values: &[(String, Option<impl std::fmt::Display>)]) -> Result<String, String> {
    let mut document: toml_edit::DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| error.to_string())?;
    for (path, value) in values {
        let (tables, key) = path.rsplit_once('.').unwrap_or(("", path));
        let mut item = document.as_item_mut();
        for name in tables.split('.').filter(|name| !name.is_empty()) {
            item = match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
                None => item.as_table_like_mut().and_then(|table| {
                    table.entry(name).or_insert_with(toml_edit::table).is_table_like().then_some(())?;
                    table.get_mut(name)
                }),
                Some((name, number)) => {
                    number.parse().ok().and_then(|number: usize| item.get_mut(name)?.get_mut(number.checked_sub(1)?))
                }
            }
            .ok_or_else(|| format!("expected a table {name} for {path}"))?;
        }
        let table = item.as_table_like_mut().ok_or_else(|| format!("expected a table for {path}"))?;
        let Some(value) = value else {
            table.remove(key);
            continue;
        };
        let value: toml_edit::Value =
            value.to_string().parse().map_err(|error: toml_edit::TomlError| error.to_string())?;
        match table.get_mut(key).and_then(toml_edit::Item::as_value_mut) {
            // Comments behind the old value are kept.
            Some(old) => {
                let decor = old.decor().clone();
                *old = value;
                *old.decor_mut() = decor;
            }
            None => {
                table.insert(key, toml_edit::Item::Value(value));
            }
        }
    }
    Ok(document.to_string())
}
