//! The table of scene keys agrees with the scene reader and the shipped scenes.

use finray_model::Scene;
use finray_model::keys::{Entry, TABLES, reference};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use toml::{Table, Value};

/// Scenes that together contain every key except `force_n`, the force that ends a press.
const SCENES: [&str; 6] = [
    include_str!("scenes/pressed.toml"),
    include_str!("scenes/grasped.toml"),
    include_str!("scenes/path.toml"),
    include_str!("scenes/tapered.toml"),
    include_str!("scenes/one_piece.toml"),
    include_str!("scenes/short_rib.toml"),
];

/// Path to a value in a scene: the names of the keys and, for each array of tables, the index from 0.
type Way = Vec<(String, Option<usize>)>;

/// The scenes [`SCENES`], and one scene in which a force ends the press.
fn scenes() -> Vec<Table> {
    let by_force = SCENES[0].replace("travel_mm = 8.0", "force_n = 5.0");
    SCENES.into_iter().chain([by_force.as_str()]).map(parsed).collect()
}

fn parsed(text: &str) -> Table {
    text.parse().expect("TOML")
}

fn text(scene: &Table) -> String {
    toml::to_string(scene).expect("a scene")
}

/// The paths to all values that are not tables.
fn ways(table: &Table) -> Vec<Way> {
    let inner = |name: &str, number, inner: &Table| -> Vec<Way> {
        ways(inner).into_iter().map(|way| [vec![(name.to_owned(), number)], way].concat()).collect()
    };
    let of = |(name, value): (&String, &Value)| match value {
        Value::Table(table) => inner(name, None, table),
        Value::Array(items) if items.iter().any(Value::is_table) => {
            let tables = items.iter().enumerate();
            tables.flat_map(|(i, item)| inner(name, Some(i), item.as_table().expect("a table"))).collect()
        }
        _ => vec![vec![(name.clone(), None)]],
    };
    table.iter().flat_map(of).collect()
}

/// The path in two notations: as in the table of keys, and as in error messages.
fn paths(way: &Way) -> [String; 2] {
    let named = |(name, number): &(String, Option<usize>)| match number {
        Some(i) => format!("{name}[{}]", i + 1),
        None => name.clone(),
    };
    [
        way.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>().join("."),
        way.iter().map(named).collect::<Vec<_>>().join("."),
    ]
}

/// The scene with another value at a path or, if `value` is `None`, without a value.
fn with(scene: &Table, way: &Way, value: Option<Value>) -> Table {
    let mut scene = scene.clone();
    let (last, before) = way.split_last().expect("a name");
    let table = before.iter().fold(&mut scene, |table, (name, number)| {
        let inner = &mut table[name];
        let inner = if let Some(i) = number { &mut inner[*i] } else { inner };
        inner.as_table_mut().expect("a table")
    });
    match value {
        Some(value) => table.insert(last.0.clone(), value),
        None => table.remove(&last.0),
    };
    scene
}

fn entries() -> Vec<(String, Entry)> {
    let of = |table: &&dyn finray_model::keys::SceneTable| {
        let path = table.path();
        let path_of =
            |entry: &Entry| if path.is_empty() { entry.name.into() } else { format!("{path}.{}", entry.name) };
        table.entries().into_iter().map(|entry| (path_of(&entry), entry)).collect::<Vec<_>>()
    };
    TABLES.iter().flat_map(of).collect()
}

fn entry(path: &str) -> Entry {
    let found = entries().into_iter().find(|(known, _)| known == path);
    found.unwrap_or_else(|| panic!("{path} is not in the table of keys")).1
}

fn shipped(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("fixtures").map(|entry| entry.expect("an entry").path());
    let of = |path: std::path::PathBuf| match path.is_dir() {
        true => shipped(&path),
        false if path.extension().is_some_and(|is| is == "toml") && !path.ends_with("Cargo.toml") => {
            vec![fs::read_to_string(&path).expect("a text")]
        }
        false => Vec::new(),
    };
    entries.flat_map(of).collect()
}

#[test]
fn every_key_of_every_scene_is_in_the_table_and_the_other_way_round() {
    let shipped = shipped(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures")));
    assert!(shipped.len() > 25);
    let known: BTreeSet<String> = entries().into_iter().map(|(path, _)| path).collect();
    assert_eq!(known.len(), entries().len(), "a key stands twice");
    let mut met = BTreeSet::new();
    for scene in shipped.iter().map(String::as_str).chain(SCENES) {
        Scene::from_toml(scene).unwrap_or_else(|error| panic!("{error}\n{scene}"));
        met.extend(ways(&parsed(scene)).iter().map(|way| paths(way)[0].clone()));
    }
    assert_eq!(met, known);
}

/// A value of a type that no key accepts is refused. Every key is therefore read.
#[test]
fn every_key_is_read() {
    let never = Value::Datetime("1979-05-27".parse().expect("a date"));
    for scene in scenes() {
        for way in ways(&scene) {
            let [_, path] = paths(&way);
            let wrong = text(&with(&scene, &way, Some(never.clone())));
            let message = Scene::from_toml(&wrong).expect_err(&path).message;
            assert!(message.starts_with(&format!("{path}: expected ")), "{path}: {message}");
        }
    }
}

#[test]
fn defaults_hold_where_a_key_is_left_out() {
    let mut checked = BTreeSet::new();
    for scene in scenes() {
        for way in ways(&scene) {
            let [path, _] = paths(&way);
            let Some(default) = entry(&path).need.strip_prefix("default ").map(str::to_owned) else { continue };
            let value = parsed(&format!("value = {default}")).remove("value");
            let [stated, left_out] = [value, None].map(|value| {
                let scene = text(&with(&scene, &way, value));
                Scene::from_toml(&scene).unwrap_or_else(|error| panic!("{path}: {error}"))
            });
            assert_eq!(stated, left_out, "{path}");
            checked.insert(path);
        }
    }
    assert_eq!(checked.len(), entries().iter().filter(|(_, entry)| entry.need.starts_with("default ")).count());
}

#[test]
fn required_keys_are_missed() {
    for scene in scenes() {
        for way in ways(&scene) {
            let [path, named] = paths(&way);
            let entry = entry(&path);
            if entry.is_required || entry.shape.is_some() {
                let message = Scene::from_toml(&text(&with(&scene, &way, None))).expect_err(&path).message;
                assert!(message.starts_with(&format!("{named} is missing: expected ")), "{path}: {message}");
            }
        }
    }
}

#[test]
fn the_reference_says_all_of_every_key() {
    let text = reference();
    assert!(text.lines().all(|line| line.chars().count() <= 100));
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for table in TABLES {
        assert!(text.contains(&format!("[{}]", table.path())) || table.path().is_empty(), "{}", table.path());
        for Entry { name, values, need, says, .. } in table.entries() {
            let line = format!("- {name}: {values}; {need}. {says}");
            assert!(text.contains(&line), "{line}");
        }
    }
}
