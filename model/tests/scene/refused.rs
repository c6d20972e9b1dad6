//! Checks of scenes that are refused.

use finray_model::Scene;

/// The error message for the text of a scene.
#[track_caller]
pub fn refused(scene: &str) -> String {
    Scene::from_toml(scene).expect_err(scene).to_string()
}

/// Checks that the text of a scene is refused, and that the message contains a text.
#[track_caller]
pub fn assert_refused(scene: &str, expected: &str) {
    let message = refused(scene);
    assert!(message.contains(expected), "\"{expected}\" is not in: {message}");
}

/// A scene with all occurrences of a text replaced.
#[track_caller]
pub fn changed(scene: &str, from: &str, to: &str) -> String {
    assert!(scene.contains(from), "the scene has no {from}");
    scene.replace(from, to)
}

/// Checks changes of a scene that are refused, one in each row, in cells separated by ` | `: a text of the scene, its replacement, the line that the
/// message must name (number or beginning; empty for any line), and a part of the message. `\n` is the end of a line.
#[track_caller]
pub fn assert_all_refused(scene: &str, rows: &str) {
    assert_all_refused_in("", scene, rows);
}

/// As [`assert_all_refused`], but changes only the second part of a scene.
#[track_caller]
pub fn assert_all_refused_in(first: &str, second: &str, rows: &str) {
    for row in rows.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let cells: Vec<String> = row.split(" | ").map(|cell| cell.replace("\\n", "\n")).collect();
        let [from, to, at, expected] = &cells[..] else { panic!("four cells: {row}") };
        let text = first.to_owned() + &changed(second, from, to);
        let line = at.parse().ok().or_else(|| Some(1 + text.lines().position(|line| line.starts_with(at.as_str()))?));
        let line = line.unwrap_or_else(|| panic!("no line {at}"));
        let message = refused(&text);
        let start = if at.is_empty() { "line ".to_owned() } else { format!("line {line}: ") };
        assert!(message.starts_with(&start) && message.contains(expected.as_str()), "{row}: {message}");
        assert!(!message.contains('\n'), "one line: {message}");
    }
}
