//! Arrows between rooms run down: no modules of a crate use each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Which rooms each room uses: top-level modules, by the paths from `crate` in their files, tests left out.
type Rooms = BTreeMap<String, BTreeSet<String>>;

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .flat_map(|path| match path.is_dir() {
            true => files(&path),
            false => vec![path],
        })
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .collect()
}

/// Code without comments and without the tests at its end.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("a file of text");
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

fn rooms(source: &Path) -> Rooms {
    let mut rooms = Rooms::new();
    for path in files(source) {
        let place = path.strip_prefix(source).expect("within the crate");
        let first = place.iter().next().expect("a name").to_string_lossy();
        let room = first.trim_end_matches(".rs").to_owned();
        // The crate's front door names every room.
        if ["lib", "main"].contains(&room.as_str()) {
            continue;
        }
        let used = rooms.entry(room.clone()).or_default();
        let text = code(&path);
        for after in text.split("crate::").skip(1) {
            let name: String = after.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
            // Types at the front door, like crate::Vector, belong to no room.
            if name.chars().next().is_some_and(|c| c.is_ascii_lowercase()) && name != room {
                used.insert(name);
            }
        }
    }
    let known: BTreeSet<String> = rooms.keys().cloned().collect();
    for used in rooms.values_mut() {
        used.retain(|name| known.contains(name));
    }
    rooms
}

/// Rooms that are left when those that use nothing but rooms taken away before are taken away, again and again: those of circles, and
/// those above them.
fn circles(mut rooms: Rooms) -> Rooms {
    loop {
        let Some(floor) = rooms.iter().find(|(_, used)| used.is_empty()).map(|(room, _)| room.clone()) else {
            return rooms;
        };
        rooms.remove(&floor);
        for used in rooms.values_mut() {
            used.remove(&floor);
        }
    }
}

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src")
}

#[test]
fn arrows_run_down() {
    // Crates, how many rooms each has at least, and the most that one of them uses at least.
    for (name, least, used_by_one) in [
        ("model", 12, 4),
        ("model/imaging", 2, 0),
        ("verify/files", 8, 0),
        ("verify/lattice", 7, 3),
        ("verify/studies", 10, 4),
    ] {
        let rooms = rooms(&source(name));
        let most_used = rooms.values().map(BTreeSet::len).max();
        assert!(rooms.len() >= least && most_used >= Some(used_by_one), "{name}: {rooms:?}");
        let circles = circles(rooms);
        assert!(circles.is_empty(), "{name}: {circles:?}");
    }
}

/// What everything rests on uses nothing of the crate.
#[test]
fn floors_use_nothing() {
    let rooms = rooms(&source("verify/studies"));
    for floor in ["settings", "check", "statistics"] {
        assert_eq!(rooms.get(floor), Some(&BTreeSet::new()), "{floor}");
    }
}

#[test]
fn a_circle_is_found() {
    let of = |pairs: &[(&str, &[&str])]| -> Rooms {
        pairs.iter().map(|(room, used)| (room.to_string(), used.iter().map(ToString::to_string).collect())).collect()
    };
    let left = circles(of(&[("a", &["b"]), ("b", &["c", "d"]), ("c", &["b"]), ("d", &[])]));
    assert_eq!(left.keys().collect::<Vec<_>>(), ["a", "b", "c"]);
    assert!(circles(of(&[("a", &["b"]), ("b", &[])])).is_empty());
}
