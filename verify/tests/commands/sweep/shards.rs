//! Shards and their merging.

use super::{BLOCKS, MAP, SWEEP, SWEPT, merged, shards, with};
use crate::kit::*;

#[test]
fn merged_shards_are_the_bytes_of_one_run() {
    let folder = Folder::new();
    let map = folder.path("map.csv");
    finray(&with(&MAP, &["--out", &map])).done();
    // The last number of shards is larger than the number of blocks, so some shards have no rows.
    for of in [1, 3, 7, BLOCKS + 2] {
        let out = folder.path("merged.csv");
        let parts = shards(&folder, &SWEEP, of);
        assert_eq!(merged(&parts, &out).done(), "");
        assert!(folder.read("merged.csv") == *SWEPT, "{of} shards");
        assert!(merged(&parts, "-").done() == *SWEPT, "{of} shards");
        if of > 7 {
            continue;
        }
        assert_eq!(merged(&shards(&folder, &MAP, of), &out).done(), "");
        assert!(folder.read("merged.csv") == folder.read("map.csv"), "{of} shards");
        assert!(folder.read("merged.svg") == folder.read("map.svg"), "{of} shards");
    }
    let names = folder.names();
    assert!(names.iter().all(|name| !name.contains("partial")), "{names:?}");
    assert!(!names.contains(&"1-of-3.svg".to_owned()), "a shard has no figure");
}

/// The head of a shard contains the exact text of the scene, with any line ends and quotes.
#[test]
fn shards_of_any_scene_fit() {
    let folder = Folder::new();
    let scene = paper_with(&[("\n", "\r\n"), ("\"paper\"", "Q'a \"\"\" \\ # b'Q")]).replace('Q', "''") + "\t# the end";
    let scene = folder.put("scene.toml", scene);
    let mut command = MAP;
    command[1] = &scene;
    let out = folder.path("out.csv");
    finray(&with(&command, &["--out", &out])).done();
    merged(&shards(&folder, &command, 2), &folder.path("merged.csv")).done();
    assert!(folder.read("merged.csv") == folder.read("out.csv") && folder.read("merged.svg") == folder.read("out.svg"));
}

#[test]
fn shards_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let out = folder.put("out.csv", "kept");
    let parts = shards(&folder, &SWEEP, 3);
    let foreign = folder.path("foreign.csv");
    finray(&with(&SWEEP, &["--seed", "2", "--shard", "1/3", "--out", &foreign])).done();
    let fourth = folder.path("fourth.csv");
    finray(&with(&SWEEP, &["--shard", "1/4", "--out", &fourth])).done();
    let map = folder.path("map.csv");
    finray(&with(&MAP, &["--shard", "1/3", "--out", &map])).done();
    let first = folder.read("1-of-3.csv");
    let torn = folder.put("torn.csv", &first[..first.len() - 9]);
    let short = folder.put("short.csv", first.trim_end().rsplit_once('\n').expect("rows").0.to_owned() + "\n");
    let whole = folder.put("whole.csv", SWEPT.as_str());
    let bytes = folder.put("bytes.csv", [b'#', 0xff, 0xfe]);
    let missing = folder.path("missing.csv");
    let [third, second, one] = [&parts[0], &parts[1], &parts[2]].map(String::as_str);
    for (shards, expected) in [
        (vec![one, third], vec!["of 3 shards, 2 were given", "missing: 2"]),
        (vec![third], vec!["missing: 1, 2"]),
        (vec![one, second, third, second], vec!["2-of-3.csv", "is shard 2/3", "give each shard once"]),
        (vec![one, one, third], vec!["is shard 1/3"]),
        (vec![second, &foreign, third], vec!["foreign.csv", "another --seed"]),
        (vec![one, second, third, &fourth], vec!["fourth.csv", "another number of shards"]),
        (vec![second, &map, third], vec!["map.csv", "another command"]),
        (vec![&torn, second, third], vec!["torn.csv", "not a complete shard 1/3"]),
        (vec![&short, second, third], vec!["short.csv", "expected 320 rows, found 319"]),
        (vec![one, second, &whole], vec!["whole.csv", "is not a shard"]),
        (vec![one, second, &bytes], vec!["bytes.csv", "is not a shard"]),
        (vec![one, second, PAPER], vec!["paper.toml", "is not a shard"]),
        (vec![one, second, &missing], vec!["missing.csv", "cannot be read"]),
    ] {
        let message = finray(&[&["merge"], &shards[..], &["--out", &out]].concat()).refused();
        assert_says(&message, &expected);
        assert_eq!(folder.read("out.csv"), "kept");
    }
    finray(&["merge"]).refused();
    for shard in ["0/3", "4/3", "1", "1/0", "a/b", "-1/2"] {
        assert_says(&finray(&with(&SWEEP, &[&format!("--shard={shard}")])).refused(), &["expected I/N"]);
    }
}
