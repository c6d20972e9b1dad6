//! Reports shared by all tests, and helpers that read them.

use crate::kit::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::LazyLock;

/// A report, and the output of its command. Each report takes seconds, so the tests share the reports.
pub struct Report {
    pub folder: PathBuf,
    pub said: String,
    pub noted: String,
}

/// The report for the paper's finger.
pub static PAPERS: LazyLock<Report> = LazyLock::new(|| Report::of("paper", &[], Some(OPENER)));
/// The report for the spring-steel finger, under other forces than the paper's.
pub static SPRING_STEELS: LazyLock<Report> =
    LazyLock::new(|| Report::of("spring-steel", &[SPRING_STEEL, "--force-n", "2.4"], None));

/// A script that replaces the browser. It records the page, runs for a while as a browser does, and records its end unless a later run has started.
pub const OPENER: &str = r#"#!/bin/sh
echo "$1" > "${0%/*}/opened"
echo $$ > "${0%/*}/last"
/bin/sleep 60
read -r last < "${0%/*}/last"
[ "$last" = $$ ] && : > "${0%/*}/left"
"#;

#[cfg(unix)]
pub fn executable(file: &Path) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(file, std::fs::Permissions::from_mode(0o755)).expect("a program");
}

#[cfg(not(unix))]
pub fn executable(_: &Path) {}

impl Report {
    /// Runs `report --quick --open`; the search path for programs contains only the opener, or no program if no opener is given.
    pub fn of(name: &str, scene: &[&str], opener: Option<&str>) -> Report {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("report-of-{name}"));
        // Removes the folder of an earlier run.
        let _ = std::fs::remove_dir_all(&place);
        // The command creates the folder and its parent folders.
        let folder = place.join("made/report");
        let out = folder.to_str().expect("a UTF-8 path");
        let programs = place.join("programs");
        std::fs::create_dir_all(&programs).expect("a folder");
        if let Some(script) = opener {
            let opener = programs.join("xdg-open");
            std::fs::write(&opener, script).expect("a file");
            executable(&opener);
        }
        let open: &[&str] = if cfg!(target_os = "linux") { &["--open"] } else { &[] };
        let mut command = command(&[&["report"], scene, &["--quick", "--out", out], open].concat());
        let answer = command.env("PATH", &programs).stdin(Stdio::null()).output().expect("finray ends");
        let [said, noted] = [answer.stdout, answer.stderr].map(|text| String::from_utf8(text).expect("UTF-8"));
        assert_eq!(answer.status.code(), Some(0), "{noted}");
        let (noted, done) = noted.split_at(noted.find("done: ").expect("a last line"));
        assert!(done.lines().count() == 1, "{done}");
        assert!(!programs.join("left").exists(), "the report waited for the opener");
        Report { folder, said, noted: noted.to_owned() }
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn names(&self) -> Vec<String> {
        names_in(&self.folder)
    }

    pub fn summary(&self) -> Value {
        serde_json::from_str(&self.read("summary.json")).expect("JSON")
    }

    /// Names of the pages, beginning with the first page.
    pub fn page_names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.names().into_iter().filter(|name| name.ends_with(".html")).collect();
        names.sort_by_key(|name| name != "index.html");
        names
    }

    /// Text of all pages, beginning with the first page.
    pub fn pages(&self) -> String {
        self.page_names().iter().map(|name| self.read(name)).collect()
    }

    /// The links of a page: the values of `href`.
    pub fn links(&self, page: &str) -> Vec<String> {
        let page = self.read(page);
        page.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or_default().to_owned()).collect()
    }
}

#[track_caller]
pub fn array<'v>(summary: &'v Value, key: &str) -> &'v Vec<Value> {
    summary[key].as_array().unwrap_or_else(|| panic!("no array {key}"))
}

#[track_caller]
pub fn assert_keys(entries: &[Value], texts: &[&str], numbers: &[&str]) {
    assert!(!entries.is_empty());
    for entry in entries {
        for key in texts {
            assert!(entry[key].as_str().is_some_and(|text| !text.is_empty()), "{key} in {entry}");
        }
        for key in numbers {
            assert!(entry[key].as_f64().is_some_and(f64::is_finite), "{key} in {entry}");
        }
    }
}

pub fn verdicts_pass(summary: &Value) {
    let checks = array(summary, "checks");
    assert_keys(checks, &["problem", "source", "quantity", "verdict"], &["reference", "ours", "tolerance"]);
    for check in checks {
        assert_eq!(check["verdict"], "pass", "{check}");
        let number = |key: &str| check[key].as_f64().expect("a number");
        assert!((number("ours") - number("reference")).abs() <= number("tolerance"), "{check}");
        assert!(number("tolerance") > 0.0);
    }
}

pub fn sources(summary: &Value) -> Vec<&str> {
    let mut sources: Vec<_> = array(summary, "checks").iter().filter_map(|check| check["source"].as_str()).collect();
    sources.sort();
    sources.dedup();
    sources
}

/// The page as a reader sees it: HTML entities are replaced by their characters, and each question and its answer are in one line.
pub fn as_read(page: &str) -> String {
    let entities = [("&#x27;", "'"), ("&quot;", "\""), ("&#x2f;", "/"), ("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")];
    entities.iter().fold(page.replace("</dt>\n<dd>", " "), |page, (entity, letter)| page.replace(entity, letter))
}
