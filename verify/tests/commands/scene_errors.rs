//! Commands refuse invalid scenes with exit code 2 and one message that names file and line. `finray-model` tests the messages themselves.

use crate::kit::*;

#[test]
fn files_that_are_no_scene_are_refused_by_name() {
    let folder = Folder::new();
    let path = folder.put("scene.toml", [paper_with(&[]).as_bytes(), b"# \xe9\n"].concat());
    assert_says(&finray(&["solve", &path, "--load", "19:0,-1"]).refused(), &[&path, "line 27: expected text in UTF-8"]);
    for path in [folder.path("missing.toml"), folder.path("")] {
        assert_says(&finray(&["solve", &path, "--load", "19:0,-1"]).refused(), &[&path, "cannot be read"]);
    }
    assert_says(&finray_reading(b"[", &["solve", "-", "--load", "19:0,-1"]).refused(), &["standard input: line 1: "]);
}

/// Every command that reads a scene refuses an invalid scene.
#[test]
fn every_command_refuses_a_bad_scene() {
    let folder = Folder::new();
    let bad = folder.put("bad.toml", paper_with(&[("58.0", "-58.0")]));
    let out = folder.path("out");
    for command in [
        vec!["solve", &bad, "--load", "19:0,-1"],
        vec!["sense", &bad, "--displacements", PAPER, "--contact", "19"],
        vec!["calibrate", &bad, "--measurements", PAPER],
        vec!["map", &bad],
        vec!["press", &bad],
        vec!["report", &bad],
    ] {
        let message = finray(&[&command[..], &["--out", &out]].concat()).refused();
        assert_says(&message, &[&bad, "line 9: finger.base_width_mm: expected a positive length in mm, found -58.0"]);
    }
    assert_eq!(folder.names(), ["bad.toml"]);
}
