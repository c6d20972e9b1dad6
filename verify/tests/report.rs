//! `finray report`: the page, the summary for machines and a CSV behind every figure.

mod common;

use common::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::LazyLock;

/// A report and what was said while it was made. Each takes seconds, so the tests share them.
struct Report {
    folder: PathBuf,
    said: String,
    noted: String,
}

/// The paper's, with results of criterion and of other programs.
static PAPERS: LazyLock<Report> = LazyLock::new(|| {
    let folder = criterion_folder();
    let criterion = folder.path().to_str().expect("a UTF-8 path");
    let peers = folder.path().join("peers.csv");
    std::fs::write(&peers, PEERS).expect("a file");
    Report::of("paper", &["--criterion", criterion, "--peers", peers.to_str().expect("a UTF-8 path")], Some(OPENER))
});
static SPRING_STEELS: LazyLock<Report> = LazyLock::new(|| Report::of("spring-steel", &[SPRING_STEEL], None));

/// Notes which page it is given, stays for a while, as a browser does, and notes that it has left.
const OPENER: &str = r#"#!/bin/sh
echo "$1" > "${0%/*}/opened"
/bin/sleep 60
: > "${0%/*}/left"
"#;

/// The last row is for other nodes than ours.
const PEERS: &str = "task,model,setting,seconds,error,program,version,nodes,forces_n,machine
solve,corotational frame,684 nodes,0.15,0.0002,OpenSees,3.7.1.2,14-24,3,\"a desk, one core\"
sense-one,untrained network,46-150-1,0.00004,,Torch,2.1,14-24,0.3-3,\"a desk, one core\"
solve,corotational frame,25 nodes,0.01,0.02,OpenSees,3.7.1.2,14 18 22,3,\"a desk, one core\"
";

/// Criterion's times of two of our points, one of them broken, and of a bench that is none.
fn criterion_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |bench: &str, [group, function, value]: [&str; 3], estimates: &str| {
        let place = folder.path().join(bench).join("new");
        std::fs::create_dir_all(&place).expect("a folder");
        let names = serde_json::json!({ "group_id": group, "function_id": function, "value_str": value });
        std::fs::write(place.join("benchmark.json"), names.to_string()).expect("a file");
        std::fs::write(place.join("estimates.json"), estimates).expect("a file");
    };
    let median = |ns: f64| format!(r#"{{"mean":{{"point_estimate":1.0}},"median":{{"point_estimate":{ns}}}}}"#);
    put("solve/large rotations/25 nodes", ["speed_error/solve", "large rotations", "25 nodes"], &median(123456.75));
    put("solve/large rotations/61 nodes", ["speed_error/solve", "large rotations", "61 nodes"], "{\"median\": 1");
    put("corotational/ladder/25", ["corotational", "large rotations", "25 nodes"], &median(1.0));
    folder
}

#[cfg(unix)]
fn executable(file: &Path) {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(file, std::fs::Permissions::from_mode(0o755)).expect("a program");
}

#[cfg(not(unix))]
fn executable(_: &Path) {}

impl Report {
    /// Runs `report --quick --open` where nothing but the opener can be found, if there is one.
    fn of(name: &str, scene: &[&str], opener: Option<&str>) -> Report {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("report-of-{name}"));
        // From an earlier run, if there was one.
        let _ = std::fs::remove_dir_all(&place);
        // The folder is made, with those above it.
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
        assert!(!programs.join("left").exists(), "the report waited for the opener");
        Report { folder, said, noted }
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn names(&self) -> Vec<String> {
        names_in(&self.folder)
    }

    fn summary(&self) -> Value {
        serde_json::from_str(&self.read("summary.json")).expect("JSON")
    }

    /// What the page links to: the values of `href`.
    fn links(&self) -> Vec<String> {
        let page = self.read("index.html");
        page.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or_default().to_owned()).collect()
    }
}

#[track_caller]
fn array<'v>(summary: &'v Value, key: &str) -> &'v Vec<Value> {
    summary[key].as_array().unwrap_or_else(|| panic!("no array {key}"))
}

#[track_caller]
fn assert_keys(entries: &[Value], texts: &[&str], numbers: &[&str]) {
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

fn verdicts_pass(summary: &Value) {
    let checks = array(summary, "checks");
    assert_keys(checks, &["problem", "source", "quantity", "verdict"], &["reference", "ours", "tolerance"]);
    for check in checks {
        assert_eq!(check["verdict"], "pass", "{check}");
        let number = |key: &str| check[key].as_f64().expect("a number");
        assert!((number("ours") - number("reference")).abs() <= number("tolerance"), "{check}");
        assert!(number("tolerance") > 0.0);
    }
}

fn sources(summary: &Value) -> Vec<&str> {
    let mut sources: Vec<_> = array(summary, "checks").iter().filter_map(|check| check["source"].as_str()).collect();
    sources.sort();
    sources.dedup();
    sources
}

#[test]
fn every_check_of_the_papers_finger_passes() {
    let summary = PAPERS.summary();
    assert_eq!(summary["scene"], "paper");
    verdicts_pass(&summary);
    let sources = sources(&summary);
    assert!(sources.contains(&"OpenSees") && sources.len() >= 3, "{sources:?}");
}

#[test]
fn comparisons_promise_nothing() {
    let summary = PAPERS.summary();
    let comparisons = array(&summary, "comparisons");
    assert_keys(comparisons, &["problem", "source", "quantity"], &["reference", "ours"]);
    assert!(comparisons.iter().all(|entry| entry.get("verdict").is_none() && entry.get("tolerance").is_none()));
}

#[test]
fn maps_come_with_their_figures_and_their_cells() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let summary = report.summary();
        let maps = array(&summary, "maps");
        let figures = ["mean_error", "share_above_10", "share_above_25"];
        let counts = ["cells", "answered", "refused", "without_equilibrium"];
        assert_keys(maps, &["truth", "estimator", "csv"], &[&["noise_mm"], &figures[..], &counts[..]].concat());
        for truth in ["linear", "corotational"] {
            for noisy in [false, true] {
                let wanted = |map: &&Value| map["truth"] == truth && (map["noise_mm"].as_f64() > Some(0.0)) == noisy;
                assert!(maps.iter().any(|map| wanted(&map)), "{truth}, noise: {noisy}");
            }
        }
        for map in maps {
            let cells = Csv::of(&report.read(map["csv"].as_str().expect("a name")));
            let forces: Vec<f64> =
                map["forces_n"].as_array().expect("forces").iter().filter_map(Value::as_f64).collect();
            if let [force] = forces[..] {
                // The figures of one force follow from the cells.
                let samples = cells.numbers("samples").into_iter().zip(cells.texts("mean_error"));
                let of_force = cells.numbers("force_n").into_iter().zip(samples).filter(|(f, _)| *f == force);
                // Without samples there is no equilibrium; without error among samples, the cell is refused.
                let bent: Vec<Option<f64>> =
                    of_force.clone().filter(|(_, (drawn, _))| *drawn > 0.0).map(|(_, (_, e))| e.parse().ok()).collect();
                let errors: Vec<f64> = bent.iter().copied().flatten().collect();
                let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                let is_above = |error: &Option<f64>, limit: f64| error.is_none_or(|error| error > limit);
                let above =
                    |limit: f64| bent.iter().filter(|error| is_above(error, limit)).count() as f64 / bent.len() as f64;
                let number = |key: &str| map[key].as_f64().expect("a number");
                assert_close(&figures.map(number), &[mean, above(0.1), above(0.25)], LINEAR_ROUNDING);
                let (all, refused) = (of_force.count(), bent.len() - errors.len());
                let counted = [all, errors.len(), refused, all - bent.len()].map(|count| count as f64);
                assert_eq!(counts.map(number), counted, "{map}");
            }
        }
    }
}

/// A network that refuses most of a map is not published by the mean over the few cells that it answers.
#[test]
fn refused_cells_count_as_not_trusted() {
    let summary = PAPERS.summary();
    let refusing: Vec<&Value> = array(&summary, "maps")
        .iter()
        .filter(|map| map["truth"] == "linear" && map["estimator"] == "network")
        .filter(|map| map["refused"].as_f64() > Some(0.0))
        .collect();
    assert!(refusing.len() >= 2, "the network was not trained on the linear finger");
    for map in refusing {
        let number = |key: &str| map[key].as_f64().expect("a number");
        assert!(number("share_above_10") >= number("refused") / (number("cells") - number("without_equilibrium")));
    }
    let page = PAPERS.read("index.html").replace("&#x27;", "'");
    // Where a share or mean of a map stands, its counts do as well.
    assert!(page.matches("without equilibrium").count() >= 15, "{}", page.matches("without equilibrium").count());
    for header in [">cells</th>", ">answered</th>", ">refused</th>", ">no equilibrium</th>"] {
        assert!(page.contains(header), "{header}");
    }
}

/// External, analytical and internal checks are counted apart, in the file, at the page's head and in what the command says.
#[test]
fn checks_are_counted_by_kind() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let summary = report.summary();
        let checks = array(&summary, "checks");
        let of_kind = |kind: &str| checks.iter().filter(|check| check["kind"] == kind).count();
        let counts = ["external", "analytical", "internal"].map(of_kind);
        assert_eq!(counts.iter().sum::<usize>(), checks.len());
        let [external, analytical, internal] = counts;
        let head = report.read("index.html");
        let head = head.split("<h2").next().expect("the first screen");
        let said = format!("external {external} of {external}, analytical {analytical} of {analytical}");
        assert!(head.contains(&said), "{said}");
        assert!(
            report.said.contains(&format!("{external} of {external} external checks (figures of another program)"))
        );
        assert!(report.said.contains(&format!("{internal} of {internal} internal ones")));
    }
    let summary = PAPERS.summary();
    let checks = array(&summary, "checks");
    for check in checks {
        let source = check["source"].as_str().expect("words");
        let other_program = ["OpenSees", "MuJoCo", "rapier2d lattice"].contains(&source);
        assert!(check["kind"] != "external" || other_program || source.starts_with("Newton"), "{check}");
        // The lattice's own equilibrium is no figure of rapier's.
        let problem = check["problem"].as_str().expect("words");
        assert!(!problem.contains("in equilibrium") || source != "rapier2d lattice", "{check}");
        // What was fitted is no check.
        assert!(source != "paper" && !problem.contains("residual"), "{check}");
    }
    let residuals = array(&summary, "comparisons").iter();
    let residuals = residuals.filter(|entry| entry["problem"].as_str().is_some_and(|text| text.contains("residual")));
    assert_eq!(residuals.count(), 6);
}

/// The lattice's springs and MuJoCo's rods are given the beams' EA and EI: nobody claims another physics.
#[test]
fn nothing_claims_more_independence_than_there_is() {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let readme = std::fs::read_to_string(readme).expect("the README");
    let exported = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/mujoco/README.md");
    let exported = std::fs::read_to_string(exported).expect("the exporter's README");
    let texts = [readme, exported, PAPERS.read("index.html"), PAPERS.said.clone(), PAPERS.read("summary.json")];
    for text in texts {
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
        for claim in ["shares nothing", "second physics", "other parties", "neither theory", "another physics"] {
            assert!(!words.contains(claim), "\"{claim}\" in ... {}", &words[..words.len().min(60)]);
        }
    }
    assert!(PAPERS.read("index.html").contains("not that Euler-Bernoulli beams describe a real finger"));
}

#[test]
fn linear_sensing_of_the_linear_finger_errs_by_noise_alone() {
    let summary = PAPERS.summary();
    let error = |truth: &str, noisy: bool| {
        let maps = array(&summary, "maps").iter();
        let of_kind = maps
            .filter(|map| map["truth"] == truth && map["estimator"] == "least-squares")
            .filter(|map| (map["noise_mm"].as_f64() > Some(0.0)) == noisy);
        of_kind.filter_map(|map| map["mean_error"].as_f64()).fold(0.0, f64::max)
    };
    assert!(error("linear", false) < LINEAR_ROUNDING);
    assert!(error("linear", true) > 1e-3 && error("corotational", false) > 1e-2);
}

/// Every truth by every estimator for the paper's finger, without and with noise; elsewhere what exists. What the nonlinear
/// estimator cannot explain is sensed with noise alone.
#[test]
fn every_truth_is_mapped_by_every_estimator() {
    let kinds = |report: &Report| {
        let summary = report.summary();
        let kind = |map: &Value| {
            let text = |key: &str| map[key].as_str().expect("a name").to_owned();
            (text("truth"), text("estimator"), map["noise_mm"].as_f64() > Some(0.0))
        };
        array(&summary, "maps").iter().map(kind).collect::<std::collections::BTreeSet<_>>()
    };
    let papers = kinds(&PAPERS);
    for truth in ["corotational", "lattice", "linear", "mujoco", "twin"] {
        for estimator in ["least-squares", "network", "nonlinear", "ridge"] {
            let unexplained = estimator == "nonlinear" && ["linear", "twin"].contains(&truth);
            for noisy in if unexplained { &[true][..] } else { &[false, true] } {
                let noisy = *noisy;
                assert!(
                    papers.contains(&(truth.to_owned(), estimator.to_owned(), noisy)),
                    "{truth}, {estimator}, {noisy}"
                );
            }
        }
    }
    assert_eq!(papers.len(), 5 * 4 * 2 - 2);
    // Two truths, three estimators, two levels of noise.
    assert_eq!(kinds(&SPRING_STEELS).len(), 2 * 3 * 2 - 1);
}

#[test]
fn the_overview_holds_the_cells_that_are_drawn() {
    let cells = Csv::of(&PAPERS.read("map_overview.csv"));
    assert!(cells.numbers("force_n").iter().all(|force_n| *force_n == 3.0));
    let truths: std::collections::BTreeSet<_> = cells.texts("truth").into_iter().collect();
    assert_eq!(truths.len(), 5);
    // The same errors as in the map's own file.
    let overview: Vec<String> = cells
        .texts("truth")
        .into_iter()
        .zip(cells.texts("estimator"))
        .zip(cells.texts("noise_mm"))
        .zip(cells.texts("mean_error"))
        .filter(|(((truth, estimator), noise), _)| {
            (*truth, *estimator) == ("twin", "ridge") && noise.parse() == Ok(0.0)
        })
        .map(|(_, error)| error.to_owned())
        .collect();
    let own = Csv::of(&PAPERS.read("map_twin_ridge_without_noise.csv"));
    let of_force = own.numbers("force_n").into_iter().zip(own.texts("mean_error"));
    assert_eq!(
        overview,
        of_force.filter(|(force_n, _)| *force_n == 3.0).map(|(_, e)| e.to_owned()).collect::<Vec<_>>()
    );
}

#[test]
fn maps_come_with_what_explains_them() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let summary = report.summary();
        let explanations = array(&summary, "explanations");
        assert_keys(explanations, &["quantity", "csv"], &["force_n", "noise_mm", "median", "largest", "cells_without"]);
        let cells = Csv::of(&report.read("explanations.csv"));
        for row in explanations {
            let column = cells.texts(row["quantity"].as_str().expect("a column"));
            let values: Vec<f64> = column.iter().filter_map(|value| value.parse().ok()).collect();
            let largest = values.iter().copied().fold(0.0, f64::max);
            assert_close(&[row["largest"].as_f64().expect("a number")], &[largest], LINEAR_ROUNDING);
            assert_eq!(row["cells_without"].as_f64(), Some((column.len() - values.len()) as f64));
        }
    }
}

/// Errors of the table by mesh nodes, at one force: the worst over the loaded nodes.
fn worst_error(report: &Report, mesh_nodes: f64, force_n: f64) -> f64 {
    let rows = Csv::of(&report.read("convergence.csv"));
    let keys = rows.numbers("mesh_nodes").into_iter().zip(rows.numbers("force_n"));
    let wanted = keys.zip(rows.texts("error")).filter(|(key, _)| *key == (mesh_nodes, force_n));
    wanted.filter_map(|(_, error)| error.parse::<f64>().ok()).fold(0.0, f64::max)
}

#[test]
fn meshes_of_the_papers_finger_are_as_fine_as_promised() {
    let summary = PAPERS.summary();
    let promises: Vec<&Value> =
        array(&summary, "checks").iter().filter(|check| check["source"] == "Richardson extrapolation").collect();
    let limits = [(25.0, 1e-2), (61.0, 6e-3), (684.0, 1e-4)];
    assert_eq!(promises.len(), limits.len());
    for (promise, (mesh_nodes, limit)) in promises.iter().zip(limits) {
        let error = worst_error(&PAPERS, mesh_nodes, 3.0);
        let number = |key: &str| promise[key].as_f64().expect("a number");
        assert_close(&[number("ours") / error, number("tolerance")], &[1.0, limit], LINEAR_ROUNDING);
        assert!(error > 0.0 && error <= limit, "{mesh_nodes} nodes: {error}");
    }
    // Nodes 14 to 24 are loaded, and carry 3 N on every mesh.
    let mut nodes = Csv::of(&PAPERS.read("convergence.csv")).numbers("load_node");
    nodes.dedup();
    assert_eq!(nodes, (14..=24).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn finer_meshes_err_less() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        assert!(report.read("index.html").contains("id=\"convergence\""));
        let mut meshes = Csv::of(&report.read("convergence.csv")).numbers("mesh_nodes");
        meshes.sort_by(f64::total_cmp);
        meshes.dedup();
        let errors: Vec<f64> = meshes.iter().map(|nodes| worst_error(report, *nodes, 3.0)).collect();
        // The paper's mesh lies between those that double their elements, and need not be in line with them.
        assert!(errors.len() >= 5 && errors[0] > 0.0, "{errors:?}");
        assert!(errors[errors.len() - 1] < 1e-2 * errors[0], "{errors:?}");
    }
}

#[test]
fn hard_cases_keep_their_promises() {
    let cases = Csv::of(&PAPERS.read("hard_cases.csv"));
    let names = cases.texts("case");
    assert!(names.len() >= 20, "{names:?}");
    for (name, verdict) in names.iter().zip(cases.texts("verdict")) {
        assert_eq!(verdict, "kept", "{name}");
    }
    for column in ["difficulty", "promise", "outcome"] {
        assert!(cases.texts(column).iter().all(|words| words.len() > 10), "{column}");
    }
    // Each case is among the checks, and on the page.
    let summary = PAPERS.summary();
    let page = PAPERS.read("index.html");
    for name in &names {
        assert!(array(&summary, "checks").iter().any(|check| check["problem"] == **name), "{name}");
        assert!(page.contains("id=\"hard-cases\"") && page.replace('\u{2011}', "-").contains(*name), "{name}");
    }
}

/// Eleven single nodes and four pairs, each with its promises among the checks; the summary has what the file has.
#[test]
fn networks_that_ship_keep_their_promises() {
    let rows = Csv::of(&PAPERS.read("networks.csv"));
    let singles = (14..=24).map(|node: usize| node.to_string());
    let pairs = ["19 20", "16 17", "18 20", "16 20"].map(str::to_owned);
    let wanted = singles.chain(pairs.into_iter().flat_map(|pair| [pair.clone(), pair]));
    assert_eq!(rows.texts("nodes"), wanted.collect::<Vec<_>>());
    assert!(rows.numbers("drawn").iter().all(|cases| *cases >= 40.0) && rows.numbers("refused") == [0.0; 19]);
    assert_eq!(rows.numbers("drawn"), rows.numbers("answered"));
    for (error, bound) in rows.numbers("mean_error").into_iter().zip(rows.numbers("mean_error_bound")) {
        // Forty cases scatter by a sixth; the sums of neighbours lose 1.6 to the bound.
        assert!(error > 0.5 * bound && error < 2.5 * bound, "{error}, bound {bound}");
    }
    let summary = PAPERS.summary();
    let promises = array(&summary, "checks").iter().filter(|check| check["source"] == "known forces");
    let ours: Vec<f64> = promises.filter_map(|check| check["ours"].as_f64()).collect();
    assert_close(&ours, &rows.numbers("mean_error"), LINEAR_ROUNDING);
    let networks = array(&summary, "networks");
    assert_keys(
        networks,
        &["nodes", "quantity"],
        &["noise_mm", "drawn", "answered", "refused", "mean_error", "mean_error_bound"],
    );
    assert_eq!(networks.iter().filter_map(|row| row["mean_error"].as_f64()).collect::<Vec<_>>(), ours);
    assert!(PAPERS.read("index.html").contains("id=\"networks\""));
    assert!(!SPRING_STEELS.read("index.html").contains("id=\"networks\""));
    assert!(array(&SPRING_STEELS.summary(), "networks").is_empty());
}

/// Neighbours and nodes apart: the file has what the checks say. All pairs and unknown directions take a full report.
#[test]
fn four_pairs_keep_their_promises() {
    let summary = PAPERS.summary();
    let of_pairs =
        |check: &&Value| check["problem"].as_str().is_some_and(|text| text.starts_with("nonlinear sensing at nodes"));
    let checks: Vec<_> = array(&summary, "checks").iter().filter(of_pairs).collect();
    let rows = Csv::of(&PAPERS.read("noise.csv"));
    // Of a sum over its bound, of a force as it is.
    let errors: Vec<(String, String, f64)> = rows
        .texts("nodes")
        .into_iter()
        .zip(rows.texts("quantity"))
        .zip(rows.numbers("mean_error").into_iter().zip(rows.numbers("mean_error_bound")))
        .map(|((nodes, quantity), (error, bound))| {
            (nodes.to_owned(), quantity.to_owned(), if quantity == "sum" { error / bound } else { error })
        })
        .collect();
    assert_eq!(checks.len(), 8);
    for (nodes, promise) in [("19 20", 0.03), ("16 17", 0.03), ("18 20", 0.012), ("16 20", 0.012)] {
        let of = |sum: bool| {
            let of_pair = errors.iter().filter(|row| row.0 == nodes && (row.1 == "sum") == sum);
            let errors: Vec<f64> = of_pair.map(|row| row.2).collect();
            errors.iter().sum::<f64>() / errors.len() as f64
        };
        let problem = format!("at nodes {}", nodes.replace(' ', " and "));
        let said = checks.iter().filter(|check| check["problem"].as_str().is_some_and(|text| text.contains(&problem)));
        let said: Vec<f64> =
            said.flat_map(|check| [&check["ours"], &check["tolerance"]]).filter_map(Value::as_f64).collect();
        // A quick report has a hundred cases: their chance may add 22 %.
        assert_close(&said, &[of(false), 1.22 * promise, of(true), 0.10 + 0.22], LINEAR_ROUNDING);
    }
    for key in ["pairs", "directions", "directions_without_friction"] {
        assert!(array(&summary, key).is_empty(), "{key}");
    }
    assert!(!PAPERS.read("index.html").contains("id=\"pairs\""));
}

/// Another discretisation: finer lattices are nearer to beams at every force, and what the page says of them is in its files.
#[test]
fn the_lattice_comes_near_to_beams() {
    let rows = Csv::of(&PAPERS.read("lattice.csv"));
    let errors = rows.numbers("error");
    let forces = rows.numbers("segments_a_stretch").iter().filter(|segments| **segments == 2.0).count();
    assert_eq!((forces, errors.len() % forces), (6, 0));
    for (coarse, fine) in errors.iter().zip(&errors[forces..]) {
        assert!(fine * 2.0 < *coarse && *coarse < 0.01, "{errors:?}");
    }
    let summary = PAPERS.summary();
    let keys = ["segments_a_stretch", "bodies", "springs", "force_n", "error", "newton_ms"];
    let entries = array(&summary, "lattice");
    assert_keys(entries, &[], &keys);
    let said: Vec<f64> = entries.iter().filter_map(|row| row["error"].as_f64()).collect();
    assert_close(&said, &errors, LINEAR_ROUNDING);
    // Springs that do not stretch are no beam's; none at all hold nothing.
    let axial = Csv::of(&PAPERS.read("lattice_axial_springs.csv"));
    let of = |stiffness: f64| {
        let rows = axial.numbers("stiffness").into_iter().zip(axial.texts("error"));
        rows.filter(move |row| row.0 == stiffness).map(|row| row.1.parse::<f64>().ok()).collect::<Vec<_>>()
    };
    assert!(of(1000.0).iter().all(|error| *error > Some(0.5)) && of(0.0).iter().all(Option::is_none));
    let page = PAPERS.read("index.html");
    assert!(page.contains("id=\"lattice\"") && page.contains("This quick report compares equilibria alone"));
    assert!(!SPRING_STEELS.read("index.html").contains("id=\"lattice\""));
    assert!(array(&SPRING_STEELS.summary(), "lattice").is_empty());
}

/// The third finger of the maps: least squares errs on it as on the large-rotation finger, and the nonlinear estimator hardly.
#[test]
fn the_lattice_is_sensed_as_the_large_rotation_finger_is() {
    let summary = PAPERS.summary();
    let of_lattice = |map: &&Value| map["truth"] == "lattice" && map["noise_mm"] == 0.0;
    let maps: Vec<_> = array(&summary, "maps").iter().filter(of_lattice).collect();
    let cells = |estimator: &str| {
        let map = maps.iter().find(|map| map["estimator"] == estimator).expect("a map");
        Csv::of(&PAPERS.read(map["csv"].as_str().expect("a name")))
    };
    let biases = |cells: &Csv| {
        let keys = cells.texts("s_mm").into_iter().zip(cells.texts("angle_deg")).zip(cells.texts("force_n"));
        let keys = keys.map(|((s_mm, angle_deg), force_n)| format!("{s_mm} {angle_deg} {force_n}"));
        keys.zip(cells.numbers("bias")).collect::<std::collections::HashMap<_, _>>()
    };
    let (ours, theirs) =
        (biases(&cells("least-squares")), biases(&Csv::of(&PAPERS.read("map_corotational_without_noise.csv"))));
    let apart = ours.iter().map(|(key, ours)| (ours - theirs[key]).abs()).fold(0.0, f64::max);
    let of_maps = |check: &&Value| {
        let problem = check["problem"].as_str().expect("words");
        problem.starts_with("map of least squares on the lattice") || problem.starts_with("lattice sensed by")
    };
    let checks = array(&summary, "checks").iter().filter(of_maps);
    let said: Vec<f64> = checks.filter_map(|check| check["ours"].as_f64()).collect();
    assert_close(&said[..1], &[apart], LINEAR_ROUNDING);
    let worst = cells("nonlinear").numbers("mean_error").into_iter().fold(0.0, f64::max);
    assert_eq!(said, [said[0], 0.0, worst]);
    assert!(apart < 2e-3 && worst < 2e-3 && ours.values().any(|bias| bias.abs() > 0.1));
}

#[test]
fn table_two_has_the_network_on_both_fingers() {
    let rows = Csv::of(&PAPERS.read("table_two.csv"));
    let keys = rows.texts("truth").into_iter().zip(rows.texts("estimator")).zip(rows.numbers("noise_mm"));
    let networks: Vec<_> = keys.filter(|((_, estimator), _)| *estimator == "network").collect();
    for (truth, noise_mm) in [("linear", 0.0), ("linear", 0.067), ("corotational", 0.0), ("corotational", 0.067)] {
        let of_finger = networks.iter().filter(|((of, _), noise)| *of == truth && *noise == noise_mm);
        // Three single nodes, four pairs with their sums, and the five means that the paper lists.
        assert_eq!(of_finger.count(), 3 + 2 * 4 + 5, "{truth}, {noise_mm} mm");
    }
    let summary = PAPERS.summary();
    assert_eq!(array(&summary, "table_two").len(), rows.rows.len());
    assert_keys(
        array(&summary, "table_two"),
        &["truth", "estimator", "group", "nodes", "quantity"],
        &["noise_mm", "drawn", "answered", "refused"],
    );
    // The paper's own method stands beside them, as recorded, and the page says what it misses.
    assert!(rows.texts("estimator").iter().any(|estimator| estimator.starts_with("network of the paper")));
    let page = PAPERS.read("index.html");
    assert!(page.contains("does not reproduce Table II") && !page.contains("reproduces the paper"));
}

#[test]
fn every_file_that_the_page_names_is_there() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let names = report.names();
        assert!(names.contains(&"index.html".to_owned()) && names.contains(&"summary.json".to_owned()));
        let page = report.read("index.html");
        let (anchors, files): (Vec<_>, Vec<_>) = report.links().into_iter().partition(|link| link.starts_with('#'));
        for anchor in &anchors {
            assert!(page.contains(&format!("id=\"{}\"", &anchor[1..])), "{anchor}");
        }
        assert!(files.len() >= 6 && !anchors.is_empty());
        for name in files.iter().filter(|link| !link.starts_with("https://")) {
            assert!(names.contains(name), "{name} is not in {names:?}");
            assert!(!Csv::of(&report.read(name)).rows.is_empty(), "{name}");
        }
        // And no table lies there that the page does not name.
        for name in names.iter().filter(|name| name.ends_with(".csv")) {
            assert!(files.contains(name), "{name} is named nowhere");
        }
        // Results are ordinary files, whole, and nothing else.
        assert!(names.iter().all(|name| !name.starts_with('.')), "{names:?}");
    }
}

#[test]
fn the_page_needs_nothing_but_itself() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        // The name of SVG's namespace is no address that anything is loaded from.
        let page = report.read("index.html").replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for outside in ["http://", "src=", "@import", "url(http", "<script", "<link", "<iframe"] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert!(page.starts_with("<!DOCTYPE html>") || page.starts_with("<!doctype html>"));
        let figures = page.matches("<svg").count();
        assert!(figures >= 8 && figures == page.matches("</svg>").count(), "{figures} figures");
        assert!(!page.contains("NaN"), "a figure holds no number");
    }
}

/// Widths of a desk's and of a phone's window, px.
const WIDTHS: [u32; 2] = [1280, 390];

/// In headless Chromium, light and dark, at the width of a desk and of a phone, and in print. Where there is no Chromium nothing is
/// looked at: the test says so and passes, for a browser is no part of what the project needs.
#[test]
fn the_page_fits_its_window_and_prints() {
    let Some(browser) = browser::browser() else {
        eprintln!("left out: no Chromium here (chromium, chromium-browser, google-chrome, or the path in CHROME)");
        return;
    };
    let html = PAPERS.read("index.html");
    let folder = tempfile::tempdir().expect("a folder");
    let measure = |html: &str, width, dark| browser::measure(&browser, folder.path(), html, width, dark);
    for (width, dark) in WIDTHS.into_iter().flat_map(|width| [(width, false), (width, true)]) {
        let measured = measure(&html, width, dark);
        assert_eq!(measured.window, f64::from(width));
        assert!(measured.page <= measured.window, "{width} px: the page has {} px: {}", measured.page, measured.wide);
        assert_eq!((measured.drawings, measured.flat), (html.matches("<svg").count(), 0), "{width} px");
    }
    // What is too wide is seen.
    let broken = measure(&html.replace("</main>", "<div style=\"width:2000px\">wide</div></main>"), WIDTHS[1], false);
    assert!(broken.page >= 2000.0 && broken.wide.contains("DIV"), "{} px, {}", broken.page, broken.wide);

    let (page, pdf) = (folder.path().join("printed.html"), folder.path().join("printed.pdf"));
    std::fs::write(&page, &html).expect("a copy of the page");
    let print = format!("--print-to-pdf={}", pdf.display());
    browser::assert_silent(&browser::run(&browser, &page, &[&print, "--no-pdf-header-footer"]));
    let printed = std::fs::read(&pdf).expect("a PDF");
    assert!(printed.starts_with(b"%PDF") && printed.len() > html.len() / 20, "{} bytes", printed.len());
}

/// Drawings of a page: the figures that hold an `<svg>`.
fn drawings(page: &str) -> Vec<&str> {
    let figures = page.split("<figure").skip(1).filter_map(|rest| rest.split("</figure>").next());
    figures.filter(|figure| figure.contains("<svg")).collect()
}

/// The words of a drawing, without those that are numbers.
fn words(figure: &str) -> Vec<&str> {
    let texts = figure.split("<text").skip(1).filter_map(|rest| rest.split_once('>')?.1.split("</text>").next());
    texts.map(str::trim).filter(|text| !text.is_empty() && text.parse::<f64>().is_err()).collect()
}

/// Every drawing has a name, a caption and its numbers as a file; what has axes says what they are, and in which unit.
#[test]
fn every_drawing_says_what_it_shows() {
    // Units, and what counts or compares: what has none of them is no axis.
    let units = [
        " mm",
        ", N",
        ", %",
        " deg",
        " us",
        "nodes",
        "node",
        "bodies",
        "segments",
        "cases",
        "modulus",
        "factor",
        "parameters",
    ];
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let page = report.read("index.html");
        let drawings = drawings(&page);
        assert!(drawings.len() >= 8 && drawings.len() == page.matches("<svg").count());
        for figure in drawings {
            let start = &figure[..figure.len().min(400)];
            let between = |open: &str, close: &str| figure.split(open).nth(1)?.split(close).next();
            assert!(between("<title>", "</title>").is_some_and(|name| !name.is_empty()), "{start}");
            assert!(between("<figcaption>", "<").is_some_and(|caption| caption.trim().len() > 20), "{start}");
            assert!(figure.contains("class=\"csv\" href=\""), "{start}");
            let axes = words(figure).into_iter().filter(|text| units.iter().any(|unit| text.contains(unit))).count();
            assert!(axes >= 2, "{:?} in {start}", words(figure));
        }
    }
}

/// Three sentences and a map before everything else, then questions; what sections say stands at their heads.
#[test]
fn the_page_begins_with_its_summary() {
    let page = PAPERS.read("index.html");
    let at = |part: &str| page.find(part).unwrap_or_else(|| panic!("no {part}"));
    let verdict = &page[at("<div class=\"verdict\">")..at("<nav class=\"bar\"")];
    assert_eq!((verdict.matches("<p>").count(), verdict.matches("<svg").count()), (3, 1));
    let questions = ["where", "why", "cost", "physics"].map(|id| at(&format!("<h2 id=\"{id}\"")));
    assert!(questions.is_sorted() && at("<nav class=\"contents\"") < questions[0]);
    for id in [
        "maps",
        "causes",
        "noise",
        "displacement-noise",
        "speed-error",
        "networks",
        "table-one",
        "twin",
        "lattice",
        "contact-scenes",
        "hard-cases",
        "checks",
    ] {
        let section = page[at(&format!("<h3 id=\"{id}\""))..].split("</section>").next().unwrap_or_default();
        let blocks = section.split("class=\"says\"").nth(1).and_then(|says| says.split("</div>").next());
        assert!(blocks.is_some_and(|says| says.matches("<p>").count() >= 1), "{id} says nothing");
    }
    // Every sentence of the summary for machines is on the page once, the verdict's three first.
    let page = page.replace("&#x27;", "'").replace("&quot;", "\"").replace("&#x2f;", "/");
    for (n, sentence) in array(&PAPERS.summary(), "verdict").iter().enumerate() {
        let sentence = sentence.as_str().expect("words");
        assert_eq!(page.matches(sentence).count(), 1, "{sentence}");
        assert_eq!(n < 3, page[..questions[0]].contains(sentence), "{sentence}");
    }
}

/// The share of places and directions in the first sentence is that of the cells in the file.
#[test]
fn the_first_sentence_counts_the_cells_of_its_map() {
    let cells = Csv::of(&PAPERS.read("map_corotational_with_noise.csv"));
    let forces = 4;
    // Least squares answers wherever the finger bends; all of these cells have an equilibrium.
    let errors = cells.numbers("mean_error");
    let worst = errors.chunks(forces).map(|errors| errors.iter().copied().fold(0.0, f64::max));
    let count = errors.len() / forces;
    let kept = worst.filter(|error| *error <= 0.1).count() as f64 / count as f64;
    let summary = PAPERS.summary();
    let first = array(&summary, "verdict")[0].as_str().expect("words");
    let said = format!(
        "by linear least squares at {:.0} % of the places and directions ({count} cells: {count} answered, 0 refused, 0 without \
         equilibrium)",
        100.0 * kept
    );
    assert!(kept > 0.1 && kept < 0.9 && first.contains(&said), "{said}: {first}");
}

/// Time and error of each way of sensing come with the start that they are timed from, their tail, the preparation for a contact, and how far the
/// model itself is off; the recommended one is within its stated standard deviation.
#[test]
fn times_of_sensing_are_of_a_moving_force_cold_and_warm() {
    let summary = PAPERS.summary();
    let points: Vec<&Value> = array(&summary, "speed_error")
        .iter()
        .filter(|point| point["task"] == "sense-one" && point["model"] == "nonlinear")
        .collect();
    let number = |point: &Value, key: &str| point[key].as_f64().unwrap_or_else(|| panic!("{key} of {point}"));
    let of = |start: &str| -> Vec<&Value> { points.iter().copied().filter(|point| point["start"] == start).collect() };
    let (cold, warm) = (of("cold"), of("warm"));
    assert_eq!((cold.len(), warm.len(), points.len()), (4, 4, 8));
    for (cold, warm) in cold.iter().zip(&warm) {
        for point in [cold, warm] {
            assert!(
                number(point, "seconds") <= number(point, "seconds_95") && number(point, "preparation_seconds") > 0.0
            );
            assert_eq!(number(point, "asked"), 11.0 * 25.0, "eleven nodes, a period each");
            assert_eq!(number(point, "failed"), 0.0);
        }
        assert!(cold["setting"].as_str().expect("words").ends_with("cold start"));
        // The start changes the time, not the answer.
        assert!((number(cold, "error") - number(warm, "error")).abs() < 1e-3);
    }
    // 25 nodes are off by more than their stated standard deviation; the setting that is recommended is not.
    assert!(warm[0]["setting"] == "25 nodes, warm start" && number(warm[0], "bias_sigmas") > 2.0);
    let cost = array(&summary, "verdict")
        .iter()
        .filter_map(Value::as_str)
        .find(|said| said.starts_with("Along the normal, sense"));
    let cost = cost.expect("a sentence on cost");
    let mesh = |point: &Value| point["setting"].as_str().expect("words").replace(", warm start", "");
    let named = warm.iter().find(|point| cost.contains(&format!("on {}: ", mesh(point))));
    assert!(named.is_some_and(|point| number(point, "bias_sigmas") <= 0.4), "{cost}");
    let rate = array(&summary, "claims")
        .iter()
        .find(|claim| claim["claim"].as_str().is_some_and(|said| said.contains("cannot exceed 25 Hz")))
        .expect("the claim");
    assert_eq!(rate["verdict"], "not-tested");
    assert_says(rate["how"].as_str().expect("words"), &["Image processing was not run here", "camera noise"]);
}

/// Times of criterion and of other programs are taken as they are, and say whose they are.
#[test]
fn times_say_who_took_them() {
    let rows = Csv::of(&PAPERS.read("speed_error.csv"));
    let [tasks, models, settings, by] = ["task", "model", "setting", "timed_by"].map(|column| rows.texts(column));
    let point = |task: &str, model: &str, setting: &str| {
        let at = (0..by.len()).find(|&row| (tasks[row], models[row], settings[row]) == (task, model, setting));
        let at = at.unwrap_or_else(|| panic!("no point {task}, {model}, {setting}"));
        (rows.texts("seconds")[at].parse::<f64>().expect("a time"), by[at].to_owned())
    };
    assert_eq!(point("solve", "large rotations", "25 nodes"), (1.2345675e-4, "criterion".to_owned()));
    assert_eq!(point("solve", "large rotations", "61 nodes").1, "timed here");
    assert_eq!(point("solve", "corotational frame", "684 nodes"), (0.15, "OpenSees 3.7.1.2".to_owned()));
    assert_eq!(by.iter().filter(|by| **by != "timed here").count(), 3);
    let page = PAPERS.read("index.html");
    let section =
        page[page.find("id=\"speed-error\"").expect("the section")..].split("</section>").next().unwrap_or_default();
    for said in [
        "The times of 1 of ",
        "1 of the files there are not what criterion writes",
        "on this machine: a desk, one core",
        ">criterion<",
        ">OpenSees 3.7.1.2<",
        ">OpenSees: corotational frame<",
        "2 points are of other programs",
        "1 points of other programs are for other nodes or forces than ours and were left aside, the first of them for 3 N on nodes 14 18 22 \
         instead of 3 N on nodes 14-24",
    ] {
        assert!(section.contains(said), "{said}");
    }
    let without = SPRING_STEELS.read("index.html");
    assert!(without.contains("Other programs were not timed") && !section.contains("Other programs were not timed"));
}

/// A table of other programs is checked line by line before anything is computed.
#[test]
fn wrong_tables_of_other_programs_are_refused() {
    let folder = Folder::new();
    let out = folder.path("report");
    for (from, to, said) in [
        (
            "solve,cor",
            "bend,cor",
            &["line 2: task: expected one of solve, sense-one, sense-neighbours, found \"bend\""][..],
        ),
        ("0.15", "-0.15", &["line 2: seconds: expected a number above 0"]),
        ("0.15", "fast", &["line 2: seconds: expected a finite number, found \"fast\""]),
        ("0.0002", "-1", &["line 2: expected an error of at least 0"]),
        (",Torch,", ",,", &["line 3: program: expected words"]),
        ("program,version", "name,version", &["line 1: expected a column program"]),
        ("nodes,forces_n", "places,forces_n", &["line 1: expected a column nodes"]),
        ("14-24,3", ",3", &["line 2: nodes: expected words"]),
    ] {
        let peers = folder.put("peers.csv", PEERS.replacen(from, to, 1));
        let message = finray(&["report", "--quick", "--peers", &peers, "--out", &out]).refused();
        assert_says(&message, &[&["peers.csv: "], said].concat());
    }
    let missing = folder.path("missing");
    let message = finray(&["report", "--quick", "--criterion", &missing, "--out", &out]).refused();
    assert_says(&message, &["missing: cannot be read"]);
    assert_eq!(folder.names(), ["peers.csv"]);
}

#[test]
fn what_exists_for_the_papers_finger_alone_is_left_out_for_others() {
    let summary = SPRING_STEELS.summary();
    assert_eq!(summary["scene"], "spring-steel");
    verdicts_pass(&summary);
    assert!(!sources(&summary).contains(&"OpenSees"));
    let said =
        "Reference values of other programs (OpenSees) and the paper's Table I exist for the paper's finger alone";
    let page = SPRING_STEELS.read("index.html");
    assert!(page.replace("&#x27;", "'").contains(said) && !page.contains("id=\"table-one\""));
    assert!(!SPRING_STEELS.names().contains(&"table_one.csv".to_owned()));
    assert!(!page.contains("id=\"hard-cases\"") && !SPRING_STEELS.names().contains(&"hard_cases.csv".to_owned()));
    let page = PAPERS.read("index.html");
    assert!(!page.replace("&#x27;", "'").contains(said) && page.contains("id=\"table-one\""));
    assert!(PAPERS.names().contains(&"table_one.csv".to_owned()));
}

#[test]
fn what_was_found_is_said_on_page_summary_and_standard_output() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let lines: Vec<_> = report.said.lines().collect();
        let verdict: Vec<_> = report.summary()["verdict"].as_array().expect("sentences").to_vec();
        assert!(verdict.len() >= 3);
        assert_eq!(lines[..lines.len() - 1], verdict.iter().filter_map(Value::as_str).collect::<Vec<_>>());
        assert!(lines[lines.len() - 1].ends_with("made/report/index.html"), "{lines:?}");
        let page = report.read("index.html").replace("&#x27;", "'").replace("&quot;", "\"").replace("&#x2f;", "/");
        for sentence in &lines[..lines.len() - 1] {
            assert!(page.contains(sentence), "{sentence}");
        }
    }
}

#[cfg(target_os = "linux")]
fn opened_by(report: &Report) -> PathBuf {
    report.folder.join("../../programs/opened")
}

/// The page goes to the opener, and nothing is waited for.
#[cfg(target_os = "linux")]
#[test]
fn the_page_is_opened_and_left_to_its_opener() {
    let opened = std::fs::read_to_string(opened_by(&PAPERS)).expect("the opener was started");
    assert_eq!(Path::new(opened.trim()), PAPERS.folder.join("index.html"));
    assert_eq!(PAPERS.noted, "");
}

/// Where nothing can open a page, its path is said and the report is made all the same.
#[cfg(target_os = "linux")]
#[test]
fn a_page_that_nothing_opens_is_still_a_report() {
    let page = SPRING_STEELS.folder.join("index.html");
    assert!(page.is_file());
    assert_says(&SPRING_STEELS.said, &[&format!("The report is in {}", page.display())]);
    let note = &SPRING_STEELS.noted;
    assert!(note.starts_with("note: nothing here opens a page (") && note.lines().count() == 1, "{note}");
    assert_says(note, &[&format!("it is {}", page.display())]);
}

#[test]
fn a_report_that_cannot_be_made_leaves_nothing() {
    let folder = Folder::new();
    let bad = folder.put("bad.toml", paper_with(&[("58.0", "400.0")]));
    let out = folder.path("report");
    assert_says(&finray(&["report", &bad, "--quick", "--out", &out]).refused(), &["bad.toml: line 9"]);
    let missing = folder.path("missing.toml");
    assert_says(&finray(&["report", &missing, "--out", &out]).refused(), &["missing.toml: cannot be read"]);
    // A finger so soft that its stiffness is nothing cannot be solved.
    let soft = folder.put("soft.toml", paper_with(&[("47.976", "1e-307")]));
    finray(&["report", &soft, "--quick", "--out", &out]).failed();
    assert_eq!(folder.names(), ["bad.toml", "soft.toml"]);
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
