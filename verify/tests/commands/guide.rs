//! Guides and references that the command prints. Every console example in guides and README runs and prints the shown output.
//!
//! In a block ```` ```console ````, `sh` runs each line `$ COMMAND`, with the files written by earlier blocks of the page. The lines below the
//! command are its whole output on both streams. `...` stands for the rest of a number or line, and alone on a line for any number of lines.
//! A block ```` ```csv NAME ```` is the file NAME. Blocks of other languages (`sh`) are not run.

use crate::kit::*;
use crate::report::shared::PAPERS;
use finray_model::keys::TABLES;
use finray_tests::{Figure, recorded_figures, state_of_code};
use finray_verify::guide::GUIDES;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Command of the report. The report takes most of a minute, so the tests run its command only once.
const REPORT: &str = "finray report --quick";

/// Whether a line matches the expected line, in which `...` stands for any text.
fn line_matches(expected: &str, line: &str) -> bool {
    let Some((first, others)) = expected.split_once("...") else { return expected == line };
    let Some(mut line) = line.strip_prefix(first) else { return false };
    let mut parts: Vec<_> = others.split("...").collect();
    let last = parts.pop().unwrap_or_default();
    for part in parts {
        let Some((_, rest)) = line.split_once(part) else { return false };
        line = rest;
    }
    line.ends_with(last)
}

/// Whether lines match the expected lines, among which a line `...` stands for any number of lines.
fn lines_match(expected: &[&str], found: &[&str]) -> bool {
    match expected {
        [] => found.is_empty(),
        ["...", rest @ ..] => (0..=found.len()).any(|skipped| lines_match(rest, &found[skipped..])),
        [line, rest @ ..] => {
            found.first().is_some_and(|found| line_matches(line, found)) && lines_match(rest, &found[1..])
        }
    }
}

fn matches(expected: &str, found: &str) -> bool {
    lines_match(&expected.lines().collect::<Vec<_>>(), &found.lines().collect::<Vec<_>>())
}

/// For each fenced block of a page: the language with the file name, and the content.
fn blocks(page: &str) -> impl Iterator<Item = (&str, &str)> {
    page.split("\n```").skip(1).step_by(2).map(|block| block.split_once('\n').unwrap_or((block, "")))
}

/// The commands of a console block, each with the output in the block.
fn examples(block: &str) -> Vec<(String, String)> {
    let mut examples: Vec<(String, String)> = Vec::new();
    let mut continues = false;
    for line in block.lines() {
        let start = line.strip_prefix("$ ");
        match (start, examples.last_mut()) {
            (Some(command), _) => examples.push((command.to_owned(), String::new())),
            (None, Some((command, _))) if continues => *command += &format!("\n{line}"),
            (None, Some((_, output))) => *output += &format!("{line}\n"),
            (None, None) => {}
        }
        continues = line.ends_with(['\\', '|']) && (continues || start.is_some());
    }
    examples
}

/// Output of a command on both streams, in order, and whether the command succeeded.
fn output(command: &str, folder: &Path) -> (String, bool) {
    if command.starts_with(REPORT) {
        return (PAPERS.said.clone(), true);
    }
    let program = Path::new(env!("CARGO_BIN_EXE_finray")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("exec 2>&1\n{command}")]).current_dir(folder).env("PATH", path);
    let answer = shell.output().expect("a shell");
    (String::from_utf8(answer.stdout).expect("UTF-8"), answer.status.success())
}

/// Runs the examples of a page and returns their number.
#[track_caller]
fn run(name: &str, page: &str) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").canonicalize().expect("fixtures");
    std::os::unix::fs::symlink(fixtures, folder.path().join("fixtures")).expect("a link");
    let mut count = 0;
    for (head, block) in blocks(page) {
        match head.split_once(' ') {
            Some((_, file)) => std::fs::write(folder.path().join(file), block.to_owned() + "\n").expect("a file"),
            None if head == "console" => {
                for (command, expected) in examples(block) {
                    let (found, succeeded) = output(&command, folder.path());
                    assert!(matches(&expected, &found), "{name}:\n$ {command}\n{expected}--- found\n{found}");
                    assert_eq!(succeeded, !expected.contains("error: "), "{name}: {command}");
                    count += 1;
                }
            }
            None => {}
        }
    }
    count
}

macro_rules! pages_run {
    ($($test:ident: $name:literal),*) => {
        $(#[test]
        fn $test() {
            let guide = GUIDES.iter().find(|guide| guide.name == $name).expect("a guide");
            println!("{} commands", run(guide.name, guide.text));
        })*

        #[test]
        fn every_guide_is_run() {
            assert_eq!(GUIDES.iter().map(|guide| guide.name).collect::<Vec<_>>(), [$($name),*]);
        }
    };
}

/// A share in percent with two digits: 0.35 %, 5.5 %, 12 %.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let decimals = if percent < 0.995 {
        2
    } else if percent < 9.95 {
        1
    } else {
        0
    };
    format!("{percent:.decimals$} %")
}

/// A figure as in the guide: mean and largest error, and coverage of the intervals with its standard error.
fn stated(figure: &Figure) -> [String; 3] {
    let Figure { mean_error, largest_error, within, standard_error, .. } = figure;
    let within = format!("{:.0} +- {:.0} %", 100.0 * within, 100.0 * standard_error);
    [percent(*mean_error), percent(*largest_error), within]
}

fn cells(row: &str) -> Vec<&str> {
    row.trim_matches('|').split('|').map(str::trim).collect()
}

/// Whether a table of the guide contains the figure, in its row and in the columns of its question. Tables with one question do not name the question.
fn contains(table: &str, figure: &Figure) -> bool {
    let question = figure.question.split(", noise").next().expect("a question");
    let mut rows = table.lines().map(cells);
    let columns = rows.next().expect("a head");
    let starts = |head: String| columns.iter().position(|column| *column == head);
    let Some(start) = starts(format!("{question}: mean error")).or_else(|| starts("mean error".to_owned())) else {
        return false;
    };
    rows.any(|row| row[0] == figure.row && row.get(start..start + 3).is_some_and(|cells| cells == stated(figure)))
}

/// The guide contains each recorded figure in its row. For figures of an earlier state of the code, the test prints the command that repeats the
/// measurement.
#[test]
fn figures_of_the_guide_are_those_recorded() {
    let guide = GUIDES.iter().find(|guide| guide.name == "accuracy").expect("a guide");
    let state = state_of_code();
    let mut older = BTreeSet::new();
    for figure in recorded_figures() {
        let mut tables = guide.text.split("\n\n").filter(|table| table.starts_with('|'));
        assert!(tables.any(|table| contains(table, &figure)), "{figure:?}: expected {:?}", stated(&figure));
        if figure.state != state {
            older.insert(format!("{} ({}): {}", figure.study, figure.date, figure.command));
        }
    }
    older.iter().for_each(|study| println!("figures are older than the code: {study}"));
}

mod guides {
    use super::*;

    pages_run! {
        printed_finger: "printed-finger", your_finger: "your-finger", sense: "sense", photographs: "photographs", live: "live", python: "python",
        calibrate: "calibrate", lens: "lens", maps_and_sweeps: "maps-and-sweeps", clusters: "clusters", press_and_grasp: "press-and-grasp", networks: "networks",
        reading_the_report: "reading-the-report", accuracy: "accuracy", architecture: "architecture", files: "files"
    }

    #[test]
    fn readme() {
        let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
        let readme = std::fs::read_to_string(readme).expect("the README");
        assert!(readme.len() <= 9 * 1024 && readme.lines().count() <= 120, "{} bytes", readme.len());
        println!("{} commands", run("README", &readme));
    }

    #[test]
    fn a_placeholder_stands_for_the_rest_of_a_number_or_for_lines() {
        assert!(matches("a,1.99...,b\n", "a,1.9931,b\n") && matches("a\n...\nd\n", "a\nb\nc\nd\n"));
        assert!(!matches("a,1.99...,b\n", "a,2.0031,b\n") && !matches("a...\n", "a\nb\n") && !matches("a\n", "a\nb\n"));
    }
}

/// The columns that a page explains in its tables with the heading `| column`.
fn explained(section: &str) -> Vec<&str> {
    let tables = section.split("\n| column |").skip(1);
    let rows = tables.flat_map(|table| table.split("\n\n").next().into_iter().flat_map(str::lines));
    rows.filter_map(|row| row.strip_prefix("| ")?.split('|').next())
        .flat_map(|cell| cell.split('`').skip(1).step_by(2))
        .collect()
}

#[test]
fn the_reference_of_files_explains_the_columns_that_are_there_and_no_others() {
    let page = GUIDES.iter().find(|guide| guide.name == "files").expect("the page").text;
    let sections: Vec<_> = page.split("\n## ").filter(|section| section.contains("\n| column |")).collect();
    assert!(sections.len() > 9, "{}", sections.len());
    for section in sections {
        let (name, _) = section.split_once('\n').expect("a head");
        let shown = blocks(section).flat_map(|(head, block)| match head.split_once(' ') {
            Some(_) => block.lines().next().map(str::to_owned).into_iter().collect(),
            None => {
                let columns = |(_, output): (_, String)| {
                    output.lines().find(|line| !line.starts_with("done: ")).map(str::to_owned)
                };
                examples(block).into_iter().filter_map(columns).collect::<Vec<_>>()
            }
        });
        let shown: Vec<_> = shown.flat_map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>()).collect();
        let shown: BTreeSet<_> = shown.iter().map(String::as_str).filter(|column| !column.is_empty()).collect();
        assert_eq!(shown, explained(section).into_iter().collect(), "{name}");
    }
}

/// All sources below a folder as one text, in which string literals with line breaks are joined.
fn sources(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let text = |path: PathBuf| match path.is_dir() {
        true => sources(&path),
        false => std::fs::read_to_string(path).expect("a source"),
    };
    let lines = entries.map(text).collect::<String>();
    lines.split("\\\n").map(str::trim_start).collect()
}

/// The table of refusals quotes messages, which must still exist in the program.
#[test]
fn the_messages_that_the_guide_explains_are_those_of_the_program() {
    let page = GUIDES.iter().find(|guide| guide.name == "sense").expect("the page").text;
    let (_, table) = page.split_once("| the message has |").expect("the table");
    let rows =
        table.lines().take_while(|line| !line.is_empty()).filter_map(|row| row.strip_prefix("| `")?.split('`').next());
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let said: String = ["../model/src", "src", "files/src"].map(|folder| sources(&root.join(folder))).concat();
    let words: Vec<_> = rows.collect();
    assert!(words.len() > 9, "{words:?}");
    for message in words {
        assert!(said.contains(message), "{message}");
    }
}

#[test]
fn the_topics_are_listed() {
    let list = finray(&["guide"]).done();
    for guide in GUIDES {
        assert_says(&list, &[guide.name, guide.task]);
        assert_eq!(finray(&["guide", guide.name]).done(), guide.text);
    }
    assert_says(&list, &["scene  "]);
    let refusal = finray(&["guide", "scenes"]).refused();
    assert_says(&refusal, &["expected one of printed-finger, your-finger, sense, ", ", scene, found \"scenes\""]);
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
    // The example is a valid scene.
    let (_, example) = text.split_once("## Example\n").expect("an example");
    let folder = Folder::new();
    finray(&["solve", &folder.put("scene.toml", example), "--load", "19:0,-1"]).done();
}
