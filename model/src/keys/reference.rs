//! The reference of scene files, printed as text.

use super::{Entry, Occurs, SceneTable, TABLES};

/// Width of the printed lines, characters.
const COLUMNS: usize = 100;

/// The reference in Markdown. The reference lists quantity, unit, range, default and meaning of every key of every table.
pub fn reference() -> String {
    let sections = TABLES.chunk_by(|one, next| one.says() == next.says());
    sections.map(section).collect::<Vec<_>>().join("\n")
}

/// Text of one section, which describes one or more tables with the same keys.
fn section(tables: &[&dyn SceneTable]) -> String {
    let Some(first) = tables.first() else { return String::new() };
    let names: Vec<_> = tables.iter().filter(|table| !table.path().is_empty()).map(|table| heading(*table)).collect();
    let heading = if names.is_empty() { String::new() } else { format!("## {}\n", names.join(", ")) };
    let keys: String = first.entries().iter().map(line).collect();
    format!("{heading}{}\n{keys}", wrapped(first.says(), ""))
}

fn heading(table: &dyn SceneTable) -> String {
    match table.occurs() {
        Occurs::Once => format!("[{}]", table.path()),
        Occurs::Optional => format!("[{}] (optional)", table.path()),
        Occurs::Many => format!("[[{}]] (optional, any number)", table.path()),
    }
}

fn line(entry: &Entry) -> String {
    wrapped(&format!("- {}: {}; {}. {}", entry.name, entry.values, entry.need, entry.says), "  ")
}

/// Wraps a paragraph into lines. All lines except the first are indented.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let full = lines.last().is_some_and(|line| !line.is_empty() && line.len() + 1 + word.len() > COLUMNS);
        if full {
            lines.push(indent.to_owned());
        }
        if let Some(line) = lines.last_mut() {
            let gap = if line.trim().is_empty() { "" } else { " " };
            *line += &format!("{gap}{word}");
        }
    }
    lines.join("\n") + "\n"
}
