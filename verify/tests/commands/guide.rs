//! Guides and references that the command prints.

use crate::kit::*;
use finray_model::keys::TABLES;

#[test]
fn the_topics_are_listed() {
    assert_says(&finray(&["guide"]).done(), &["scene: "]);
    assert_says(&finray(&["guide", "scenes"]).refused(), &["expected one of scene, found \"scenes\""]);
}

#[test]
fn the_scene_reference_has_every_table_and_key() {
    let text = finray(&["guide", "scene"]).done();
    for table in TABLES.iter().filter(|table| !table.path().is_empty()) {
        let heads =
            |section: &&str| section.lines().next().is_some_and(|line| line.contains(&format!("[{}]", table.path())));
        let section = text.split("\n## ").find(heads).unwrap_or_else(|| panic!("{}", table.path()));
        for entry in table.entries() {
            assert!(section.contains(&format!("\n- {}: ", entry.name)), "{}.{}", table.path(), entry.name);
        }
    }
    // The example is a scene.
    let (_, example) = text.split_once("## Example\n").expect("an example");
    let folder = Folder::new();
    finray(&["solve", &folder.put("scene.toml", example), "--load", "19:0,-1"]).done();
}
