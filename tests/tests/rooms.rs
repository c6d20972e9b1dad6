//! Dependencies are acyclic, both between the files and between the folders of a crate.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules of the lowest level: they use no other module of their crate.
const FLOORS: [&str; 5] = ["figures", "settings", "check", "files", "statistics"];

/// Path of a module: the names from the crate's root to the module. The path of the root is empty.
type Place = Vec<String>;

/// For each module, the other modules that it uses.
type Arrows = BTreeMap<Place, BTreeSet<Place>>;

/// Imports and paths of a module's code.
#[derive(Debug, Default)]
struct Module {
    /// Path of each import, by the name that the module uses.
    imports: BTreeMap<String, Vec<String>>,
    /// Imported names that the module only re-exports.
    handed_on: BTreeSet<String>,
    /// Paths in the module's code.
    paths: Vec<Vec<String>>,
}

/// The modules of a crate; each file is a module.
struct Crate(BTreeMap<Place, Module>);

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
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The paths in code: names joined by `::`.
fn paths(code: &str) -> impl Iterator<Item = Vec<String>> {
    let is_of_path = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
    code.split(move |c| !is_of_path(c)).filter(|path| !path.is_empty()).map(|path| {
        let names = path.split("::").filter(|name| !name.is_empty());
        names.map(|name| name.trim_matches(':').to_owned()).collect()
    })
}

/// The names that a tree of imports defines, each with its path: `a::{self, b as c}` defines `a` and `c`.
fn imported(tree: &str, before: &[String]) -> Vec<(String, Vec<String>)> {
    let (path, inner) = tree.split_once('{').map_or((tree, None), |(path, inner)| (path, inner.rsplit_once('}')));
    let (path, alias) = path.split_once(" as ").unwrap_or((path, ""));
    let mut names = before.to_vec();
    names.extend(paths(path).flatten().filter(|name| name != "self" || before.is_empty()));
    let Some((inner, _)) = inner else {
        let own = if alias.is_empty() { names.last().cloned().unwrap_or_default() } else { alias.trim().to_owned() };
        return vec![(own, names)];
    };
    let mut depth = 0;
    let branches = inner.split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    branches.filter(|branch| !branch.trim().is_empty()).flat_map(|branch| imported(branch.trim(), &names)).collect()
}

impl Module {
    fn read(&mut self, code: &str) {
        let mut handed_on = BTreeSet::new();
        for statement in code.split_inclusive(';') {
            let import = statement.rfind("use ").map(|at| (statement[..at].trim_end(), &statement[at + 4..]));
            let is_import = |(before, _): &(&str, _)| before.is_empty() || before.ends_with(['}', ']', ')', 'b']);
            let Some((before, tree)) = import.filter(is_import) else {
                self.paths.extend(paths(statement));
                continue;
            };
            for (name, path) in imported(tree.trim_end_matches(';').trim(), &[]) {
                if before.ends_with(['b', ')']) {
                    handed_on.insert(name.clone());
                }
                self.imports.insert(name, path);
            }
            self.paths.extend(paths(before));
        }
        let used: BTreeSet<&String> = self.paths.iter().filter_map(|path| path.first()).collect();
        handed_on.retain(|name| !used.contains(name));
        self.handed_on.append(&mut handed_on);
    }
}

impl Crate {
    fn read(source: &Path) -> Crate {
        let mut modules = BTreeMap::<Place, Module>::new();
        for path in files(source) {
            let place = path.strip_prefix(source).expect("within the crate").with_extension("");
            let mut place: Place = place.iter().map(|name| name.to_string_lossy().into_owned()).collect();
            place.pop_if(|last| ["lib", "main", "mod"].contains(&last.as_str()));
            let text = fs::read_to_string(path).expect("a file of text");
            modules.entry(place).or_default().read(&code(&text));
        }
        Crate(modules)
    }

    /// The module to which a path in the module `from` leads; `None` for a path outside the crate.
    fn home(&self, from: &[String], path: &[String]) -> Option<Place> {
        let mut at = from.to_vec();
        for (i, name) in path.iter().enumerate() {
            let inner = [at.clone(), vec![name.clone()]].concat();
            match name.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => drop(at.pop()?),
                _ if self.0.contains_key(&inner) => at = inner,
                _ => {
                    let handed_on = self.0[&at].imports.get(name).filter(|import| import[..] != path[i..]);
                    return match handed_on {
                        Some(import) => self.home(&at, &[import, &path[i + 1..]].concat()),
                        None => (i > 0).then_some(at),
                    };
                }
            }
        }
        Some(at)
    }

    /// For each module, the modules that it uses. Enclosing modules are omitted, because a module and its submodules may use each other.
    fn arrows(&self) -> Arrows {
        let used = |(place, module): (&Place, &Module)| {
            let imports = module.imports.iter().filter(|(name, _)| !module.handed_on.contains(*name));
            let paths = imports.map(|(_, path)| path).chain(&module.paths);
            let homes = paths.filter_map(|path| self.home(place, path)).filter(|home| !place.starts_with(home));
            (place.clone(), homes.collect())
        };
        self.0.iter().map(used).collect()
    }
}

/// The dependencies between the direct submodules of a module. Each submodule includes everything inside it.
fn within(around: &[String], arrows: &Arrows) -> Arrows {
    let room =
        |place: &Place| place.starts_with(around).then(|| place.get(..=around.len()).map(<[_]>::to_vec)).flatten();
    let mut rooms = Arrows::new();
    for (place, used) in arrows {
        let Some(own) = room(place) else { continue };
        let others = used.iter().filter_map(room).filter(|other| *other != own);
        rooms.entry(own.clone()).or_default().extend(others);
    }
    rooms
}

/// Repeatedly removes all modules that use no module or that no module uses. The cycles remain, with the modules on paths from one cycle to another.
fn circles(mut arrows: Arrows) -> Arrows {
    loop {
        let before = arrows.len();
        let used: BTreeSet<Place> = arrows.values().flatten().cloned().collect();
        arrows.retain(|place, uses| !uses.is_empty() && used.contains(place));
        let left: BTreeSet<Place> = arrows.keys().cloned().collect();
        arrows.values_mut().for_each(|uses| uses.retain(|place| left.contains(place)));
        if arrows.len() == before {
            return arrows;
        }
    }
}

/// Source folders of the libraries below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let is_built = |path: &Path| ["target", "tests", "bench"].iter().any(|name| path.ends_with(name));
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let inner = entries.filter(|path| path.is_dir() && !path.ends_with(".git") && !is_built(path));
    let own = Some(folder.to_owned()).filter(|folder| folder.ends_with("src") && folder.join("lib.rs").is_file());
    own.map_or_else(|| inner.flat_map(|folder| sources(&folder)).collect(), |own| vec![own])
}

/// Dependencies of every library, by the source folder of the library.
fn crates() -> BTreeMap<PathBuf, Arrows> {
    let root = fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("the workspace");
    sources(&root).into_iter().map(|source| (source.clone(), Crate::read(&source).arrows())).collect()
}

fn named(place: &Place) -> String {
    place.join("::")
}

#[test]
fn arrows_run_down() {
    let crates = crates();
    let (modules, used): (Vec<usize>, Vec<usize>) =
        crates.values().map(|arrows| (arrows.len(), arrows.values().map(BTreeSet::len).sum::<usize>())).unzip();
    // The test must have read many modules; if it read none, it would find no cycle and pass.
    let read = [modules.len(), modules.iter().sum(), used.iter().sum()];
    assert!(read[0] >= 4 && read[1] >= 400 && read[2] >= 1000, "crates, modules, arrows: {read:?}");
    for (source, arrows) in &crates {
        let left = arrows.keys().flat_map(|around| circles(within(around, arrows)));
        let left: Vec<String> = left
            .flat_map(|(place, used)| used.into_iter().map(move |other| [named(&place), named(&other)]))
            .map(|ends| ends.join(" -> "))
            .collect();
        assert!(left.is_empty(), "{}: {left:#?}", source.display());
    }
}

#[test]
fn floors_use_nothing() {
    let crates = crates();
    let rooms = crates.values().flat_map(|arrows| within(&[], arrows));
    let floors: Vec<_> = rooms.filter(|(room, _)| FLOORS.contains(&named(room).as_str())).collect();
    assert!(floors.len() >= 3, "{floors:?}");
    for (floor, used) in floors {
        assert!(used.is_empty(), "{floor:?} uses {used:?}");
    }
}

/// Finds three kinds of cycles: of two files in a folder, across two folders, and hidden by a re-exported name.
#[test]
fn circles_are_found() {
    let crate_of = |files: &[(&str, &str)]| {
        let mut modules = BTreeMap::new();
        for (place, text) in files {
            let place: Place = place.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect();
            modules.entry(place).or_insert_with(Module::default).read(&code(text));
        }
        Crate(modules).arrows()
    };
    let left = |around: &[&str], files: &[(&str, &str)]| {
        let around: Place = around.iter().map(ToString::to_string).collect();
        circles(within(&around, &crate_of(files))).keys().map(named).collect::<Vec<_>>()
    };
    let folder =
        [("a", "mod x;\nmod y;\npub use x::X;"), ("a::y", "pub struct Y(u8); fn f() { super::super::b::f() }")];
    let inside = [folder[0], folder[1], ("a::x", "use super::y::Y;\npub struct X(Y);"), ("b", "")];
    assert!(left(&["a"], &inside).is_empty() && left(&[], &inside).is_empty());
    let hidden = [folder[0], ("a::y", "use super::X;\npub struct Y(X);"), inside[2], ("b", "")];
    assert_eq!(left(&["a"], &hidden), ["a::x", "a::y"]);
    let across = [folder[0], folder[1], inside[2], ("b", "use crate::a::{self, X as Other};")];
    assert!(left(&["a"], &across).is_empty());
    assert_eq!(left(&[], &across), ["a", "b"]);
    // Paths in comments and tests do not count.
    let said =
        [folder[0], folder[1], inside[2], ("b", "//! crate::a::X\n#[cfg(test)]\nmod tests { use crate::a::X; }")];
    assert!(left(&[], &said).is_empty());
}
