//! Helpers for scenes that are refused.

use super::*;

/// Runs `solve` on the text of a scene, and returns the error message.
#[track_caller]
pub fn refused(scene: &str) -> String {
    let folder = Folder::new();
    let path = folder.put("scene.toml", scene);
    let message = finray(&["solve", &path, "--load", "2:0,-0.001"]).refused();
    message.strip_prefix(&format!("{path}: ")).unwrap_or_else(|| panic!("no file in: {message}")).to_owned()
}

/// Checks that the paper's scene with one changed text is refused. The message must state the reason and the number of the line that begins with
/// `at`.
#[track_caller]
pub fn assert_refused(from: &str, to: &str, at: &str, expected: &[&str]) {
    let scene = paper_with(&[(from, to)]);
    let line = 1 + scene.lines().position(|line| line.starts_with(at)).unwrap_or_else(|| panic!("no line {at}"));
    let message = refused(&scene);
    assert!(message.starts_with(&format!("line {line}: ")), "line {line} ({at}): {message}");
    assert_says(&message, expected);
}
