//! Helpers that run `finray` as users do and parse its output.

pub mod browser;

use finray_fixtures::PAPER_SCENE;
use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use tempfile::TempDir;

/// Scene of the paper's finger.
pub const PAPER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/paper.toml");
/// Scene of the spring-steel finger.
pub const SPRING_STEEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/spring-steel.toml");
/// Tolerance between two computations of the same linear result. The condition number of the finger, 1e4, amplifies rounding errors.
pub const LINEAR_ROUNDING: f64 = 1e-9;

/// Result of a run.
#[derive(Debug, Clone)]
pub struct Answer {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
    /// The last line of standard error, if it summarises the run; `err` excludes this line.
    pub summary: Option<String>,
}

/// The `finray` command with its arguments.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_finray"));
    command.args(arguments);
    command
}

/// Runs `finray`.
pub fn finray(arguments: &[&str]) -> Answer {
    finray_reading(b"", arguments)
}

/// Starts `finray` with bytes on standard input.
pub fn started(input: &[u8], arguments: &[&str], stdout: Stdio) -> Child {
    let mut command = command(arguments);
    command.stdin(Stdio::piped()).stdout(stdout).stderr(Stdio::piped());
    let mut child = command.spawn().expect("finray starts");
    // A run that refuses its arguments closes its input without reading it, so the write may fail.
    let _ = child.stdin.take().expect("standard input").write_all(input);
    child
}

/// Runs `finray` with bytes on standard input.
pub fn finray_reading(input: &[u8], arguments: &[&str]) -> Answer {
    let output = started(input, arguments, Stdio::piped()).wait_with_output().expect("finray ends");
    let text = |bytes| String::from_utf8(bytes).expect("finray writes UTF-8");
    let (mut err, mut summary) = (text(output.stderr), None);
    let last = err.trim_end().rfind('\n').map_or(0, |end| end + 1);
    if err[last..].starts_with("done: ") {
        summary = Some(err.split_off(last).trim_end().to_owned());
    }
    Answer { code: output.status.code(), out: text(output.stdout), err, summary }
}

impl Answer {
    /// Standard output of a successful run; checks that standard error is empty.
    #[track_caller]
    pub fn done(self) -> String {
        assert_eq!((self.code, self.err.as_str()), (Some(0), ""));
        self.out
    }

    /// Standard output of a successful run, with or without warnings.
    #[track_caller]
    pub fn computed(self) -> String {
        if self.err.is_empty() { self.done() } else { self.warned().0 }
    }

    /// Standard output and warnings of a successful run; checks that standard error contains nothing else.
    #[track_caller]
    pub fn warned(self) -> (String, Vec<String>) {
        assert_eq!(self.code, Some(0), "{}", self.err);
        let warnings: Vec<String> = self.err.lines().map(str::to_owned).collect();
        assert!(!warnings.is_empty() && warnings.iter().all(|line| line.starts_with("warning: ")), "{warnings:?}");
        (self.out, warnings)
    }

    /// The error message of a run that refused its input.
    #[track_caller]
    pub fn refused(self) -> String {
        self.message(2)
    }

    /// The error message of a run that could not compute or write its result.
    #[track_caller]
    pub fn failed(self) -> String {
        self.message(1)
    }

    /// Checks the exit code, and that standard error contains only one message. For an error in the arguments, the parser `clap` adds a hint to
    /// `--help`; any other message has one line.
    #[track_caller]
    fn message(self, code: i32) -> String {
        assert_eq!((self.code, self.out.as_str()), (Some(code), ""), "{}", self.err);
        let message = self.err.strip_prefix("error: ").unwrap_or_else(|| panic!("no message: {:?}", self.err));
        assert!(!message.contains("error:"), "more than one message: {message}");
        assert!(!message.contains("panicked"), "{message}");
        let (first, rest) = message.split_once('\n').expect("a whole line");
        assert!(rest.is_empty() || rest.contains("--help"), "more than one line: {message}");
        assert!(first.len() > 10, "says nothing: {message}");
        message.trim_end().to_owned()
    }
}

/// Checks that a message contains all parts.
#[track_caller]
pub fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "\"{part}\" is not in: {message}");
    }
}

/// A folder that is removed after the test.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    /// The path of a file in the folder, as an argument.
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("a UTF-8 path").to_owned()
    }

    /// Writes a file and returns its path.
    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        std::fs::write(&path, content).expect("a file");
        path
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Sorted names of all files in the folder, including hidden files.
    pub fn names(&self) -> Vec<String> {
        names_in(self.0.path())
    }
}

/// Sorted names of all files in a folder, including hidden files.
pub fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder");
    let mut names: Vec<_> =
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a UTF-8 name")).collect();
    names.sort();
    names
}

/// A text with all occurrences of some parts replaced.
#[track_caller]
pub fn replaced(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the text has no {from}");
        text.replace(from, to)
    })
}

/// The paper's scene with all occurrences of some texts replaced.
#[track_caller]
pub fn paper_with(changes: &[(&str, &str)]) -> String {
    replaced(PAPER_SCENE, changes)
}

/// Header and rows of a CSV text.
#[derive(Debug, Clone, PartialEq)]
pub struct Csv {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Csv {
    #[track_caller]
    pub fn of(text: &str) -> Csv {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let cells = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect();
        let header = cells(reader.headers().expect("a header"));
        let rows = reader.records().map(|record| cells(&record.expect("rows as long as the header"))).collect();
        Csv { header, rows }
    }

    /// The cells of a column.
    #[track_caller]
    pub fn texts(&self, column: &str) -> Vec<&str> {
        let place = self.header.iter().position(|name| name == column);
        let place = place.unwrap_or_else(|| panic!("no column {column} in {:?}", self.header));
        self.rows.iter().map(|row| row[place].as_str()).collect()
    }

    /// The numbers of a column.
    #[track_caller]
    pub fn numbers(&self, column: &str) -> Vec<f64> {
        self.texts(column).iter().map(|cell| cell.parse().unwrap_or_else(|_| panic!("{column}: {cell}"))).collect()
    }
}

/// Checks that two lists of numbers agree within a tolerance, relative to the largest number.
#[track_caller]
pub fn assert_close(ours: &[f64], reference: &[f64], tolerance: f64) {
    assert_eq!(ours.len(), reference.len());
    let scale = reference.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    assert!(scale > 0.0, "nothing to compare with");
    for (i, (a, b)) in ours.iter().zip(reference).enumerate() {
        assert!((a - b).abs() <= tolerance * scale, "number {i}: {a} against {b}, largest {scale}");
    }
}

/// Displacements of a shape that `solve` wrote: ux and uy of each row.
pub fn displacements(csv: &Csv) -> Vec<f64> {
    let (ux, uy) = (csv.numbers("ux_mm"), csv.numbers("uy_mm"));
    ux.into_iter().zip(uy).flat_map(|(x, y)| [x, y]).collect()
}

/// Columns of a table of measured shapes under known loads.
pub const WEIGHTS: &str = "case,load_node,fx_n,fy_n,node,ux_mm,uy_mm\n";

/// Displacements of all key nodes of a finger as a table for `calibrate`, one case for each load: node, and force in N.
pub fn weighed(scene: &str, options: &[&str], loads: &[(usize, [f64; 2])]) -> String {
    let case = |(case, (load_node, [fx, fy])): (usize, &(usize, [f64; 2]))| {
        let load = format!("{load_node}:{fx},{fy}");
        let shape = Csv::of(&finray(&[&["solve", scene, "--load", &load], options].concat()).computed());
        let row = |row: &Vec<String>| format!("weight {case},{load_node},{fx},{fy},{},{},{}\n", row[0], row[3], row[4]);
        shape.rows.iter().map(row).collect::<String>()
    };
    WEIGHTS.to_owned() + &loads.iter().enumerate().map(case).collect::<String>()
}

/// Components of a force in the frame of the paper's finger. The force is given by magnitude (N) and angle from the inward normal (degrees).
pub fn paper_force(force_n: f64, angle_deg: f64) -> [f64; 2] {
    // The front plate is inclined to the x axis by asin(29 / 153).
    let (lean, angle) = ((29.0_f64 / 153.0).asin(), angle_deg.to_radians());
    let (tangent, inward) = ([lean.cos(), -lean.sin()], [-lean.sin(), -lean.cos()]);
    [0, 1].map(|i| force_n * (inward[i] * angle.cos() + tangent[i] * angle.sin()))
}

/// Argument of `--load` for a force on the paper's finger.
pub fn paper_load(node: usize, force_n: f64, angle_deg: f64) -> String {
    let [fx, fy] = paper_force(force_n, angle_deg);
    format!("{node}:{fx},{fy}")
}

/// Runs `solve` for forces on the paper's finger, each given by node, magnitude (N) and angle (degrees).
pub fn paper_shape(forces: &[(usize, f64, f64)], options: &[&str]) -> Answer {
    let loads: Vec<_> = forces.iter().map(|&(node, force_n, angle_deg)| paper_load(node, force_n, angle_deg)).collect();
    let loads: Vec<_> = loads.iter().flat_map(|load| ["--load", load.as_str()]).collect();
    finray(&[&["solve", PAPER], options, &loads[..]].concat())
}
