//! Messages, opening of the page, omitted sections, and refusals of `finray report`.

use super::shared::*;
use crate::kit::*;
use serde_json::Value;
use std::path::{Path, PathBuf};

#[test]
fn what_exists_for_the_papers_finger_alone_is_left_out_for_others() {
    let summary = SPRING_STEELS.summary();
    assert_eq!(summary["scene"], "spring-steel");
    verdicts_pass(&summary);
    // OpenSees verified the scene's features on other fingers, and the page names these features.
    let of_opensees = |check: &&Value| check["source"] == "OpenSees";
    let problems =
        || array(&summary, "checks").iter().filter(of_opensees).filter_map(|check| check["problem"].as_str());
    assert!(problems().count() > 0 && problems().all(|problem| problem.starts_with("finger ")), "{summary}");
    let said = "Reference values of other programs for the finger itself, the paper's Table I, the spring lattice and the hard cases exist only for the paper's finger";
    let page = SPRING_STEELS.pages();
    assert!(page.contains("hinged ribs, undeformable ribs"), "the features");
    assert!(page.replace("&#x27;", "'").contains(said) && !page.contains("id=\"table-one\""));
    assert!(!SPRING_STEELS.names().contains(&"table_one.csv".to_owned()));
    assert!(!page.contains("id=\"hard-cases\"") && !SPRING_STEELS.names().contains(&"hard_cases.csv".to_owned()));
    let page = PAPERS.pages();
    assert!(!page.replace("&#x27;", "'").contains(said) && page.contains("id=\"table-one\""));
    assert!(PAPERS.names().contains(&"table_one.csv".to_owned()));
}

#[test]
fn what_was_found_is_said_on_page_summary_and_standard_output() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let lines: Vec<_> = report.said.lines().collect();
        let summary = report.summary();
        let short: Vec<_> = array(&summary, "short").iter().filter_map(Value::as_str).collect();
        assert_eq!(lines[..lines.len() - 1], short);
        assert!(lines[lines.len() - 1].ends_with("made/report/index.html"), "{lines:?}");
        // With the line "done: " on standard error, the output has at most ten lines. It begins with the unknown contact and ends with its place.
        assert!((4..=9).contains(&lines.len()), "{lines:?}");
        assert_says(lines[0], &[" % of positions and directions trusted, contact unknown: ", "limited by "]);
        assert!(lines[0].contains("Mean error of answers: ") || lines[0].contains("No force is answered"), "{lines:?}");
        let first = as_read(&report.read("index.html")).replace("</strong>", "");
        for line in short {
            let (question, answer) = line.split_once(": ").expect("an answer");
            assert!(first.contains(line) || first.contains(&format!("<dt>{question} {answer}")), "{line}");
        }
        let page = as_read(&report.pages());
        for sentence in array(&summary, "verdict").iter().filter_map(Value::as_str) {
            assert!(page.contains(sentence), "{sentence}");
        }
    }
}

#[cfg(target_os = "linux")]
fn opened_by(report: &Report) -> PathBuf {
    report.folder.join("../../programs/opened")
}

/// The command passes the page to the program that opens it, and does not wait for that program.
#[cfg(target_os = "linux")]
#[test]
fn the_page_is_opened_and_left_to_its_opener() {
    let opened = std::fs::read_to_string(opened_by(&PAPERS)).expect("the opener was started");
    assert_eq!(Path::new(opened.trim()), PAPERS.folder.join("index.html"));
    assert_eq!(PAPERS.noted, "");
}

/// If no program can open the page, the command prints the path of the page, and the report is still made.
#[cfg(target_os = "linux")]
#[test]
fn a_page_that_nothing_opens_is_still_a_report() {
    let page = SPRING_STEELS.folder.join("index.html");
    assert!(page.is_file());
    assert_says(&SPRING_STEELS.said, &[&format!("The report is in {}", page.display())]);
    let note = &SPRING_STEELS.noted;
    assert!(note.starts_with("note: the page could not be opened (") && note.lines().count() == 1, "{note}");
    assert_says(note, &[&format!("open {} in a browser", page.display())]);
}

#[test]
fn a_report_that_cannot_be_made_leaves_nothing() {
    let folder = Folder::new();
    let bad = folder.put("bad.toml", paper_with(&[("58.0", "400.0")]));
    let out = folder.path("report");
    assert_says(&finray(&["report", &bad, "--quick", "--out", &out]).refused(), &["bad.toml: line 9"]);
    let missing = folder.path("missing.toml");
    assert_says(&finray(&["report", &missing, "--out", &out]).refused(), &["missing.toml: cannot be read"]);
    // A finger whose stiffness underflows cannot be solved.
    let soft = folder.put("soft.toml", paper_with(&[("47.976", "1e-307")]));
    finray(&["report", &soft, "--quick", "--out", &out]).failed();
    assert_eq!(folder.names(), ["bad.toml", "soft.toml"]);
}

/// A finger 50 times softer than the paper's finger was once mapped for forces of up to 3 N, which it does not carry.
#[test]
fn a_finger_is_reported_under_the_force_that_is_asked() {
    assert_says(&SPRING_STEELS.said, &["for 0.4, 0.8, 1.6, 2.4 N"]);
    let summary = SPRING_STEELS.summary();
    assert_says(array(&summary, "verdict")[0].as_str().expect("words"), &["for forces of 0.4, 0.8, 1.6, 2.4 N in"]);
    let asked = [serde_json::json!([2.4]), serde_json::json!([0.4, 0.8, 1.6, 2.4])];
    for map in array(&summary, "maps") {
        assert!(asked.contains(&map["forces_n"]), "{map}");
    }
    assert!(array(&summary, "explanations").iter().all(|entry| entry["force_n"] == 2.4));
    // No page mentions 3 N, the force of the paper's finger.
    let pages = SPRING_STEELS.pages();
    assert!(pages.contains("At rest and under 2.4 N") && !pages.contains(" 3 N"));
    for bad in ["0", "-1", "inf", "nan", "much"] {
        let message = finray(&["report", SPRING_STEEL, "--quick", &format!("--force-n={bad}")]).refused();
        assert_says(&message, &["--force-n", bad]);
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = Folder::new();
    let ribless = folder.put("scene.toml", paper_with(&[("count = 11", "count = 0"), ("47.976", "47976.0")]));
    let file = folder.put("file", "kept");
    for out in [file.clone(), folder.path("file/report")] {
        assert_says(&finray(&["report", &ribless, "--quick", "--out", &out]).failed(), &[&out, "cannot be written"]);
    }
    assert_eq!(folder.names(), ["file", "scene.toml"]);
    assert_eq!(folder.read("file"), "kept");
}
