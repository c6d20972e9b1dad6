//! Scene files.

use super::{FileError, read_text};
use finray_model::Scene;
use std::path::Path;

/// Reads and checks a scene file; `-` is standard input.
///
/// # Errors
/// [`FileError`] naming file, line and key.
pub fn load_scene(path: &Path) -> Result<Scene, FileError> {
    load_scene_and_text(path).map(|(scene, _)| scene)
}

/// Reads and checks a scene file as [`load_scene`], and keeps its text.
///
/// # Errors
/// [`FileError`] naming file, line and key.
pub fn load_scene_and_text(path: &Path) -> Result<(Scene, String), FileError> {
    let text = read_text(path)?;
    let scene = Scene::from_toml(&text).map_err(|error| FileError::content(path, error))?;
    Ok((scene, text))
}

/// The text of a scene with some values changed, all else as it stands there. A key is a path as errors name it, `finger.ribs.bracket_mm` or
/// `base.reference[2].at_mm`; tables that are missing are added.
///
/// # Errors
/// What is wrong with the text: none where it was read as a scene before.
pub fn with_values(text: &str, values: &[(String, Option<toml_edit::Value>)]) -> Result<String, String> {
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
        match table.get_mut(key).and_then(toml_edit::Item::as_value_mut) {
            // What stands behind a value, as a comment, stays there.
            Some(old) => {
                let decor = old.decor().clone();
                *old = value.clone();
                *old.decor_mut() = decor;
            }
            None => {
                table.insert(key, toml_edit::Item::Value(value.clone()));
            }
        }
    }
    Ok(document.to_string())
}
