//! Tests the report's checks: all pass, they are counted by kind, and no text overstates their independence.

use super::shared::*;
use crate::kit::*;
use finray_verify::guide::GUIDES;
use std::path::Path;

#[test]
fn every_check_of_the_papers_finger_passes() {
    let summary = PAPERS.summary();
    assert_eq!(summary["scene"], "paper");
    verdicts_pass(&summary);
    let sources = sources(&summary);
    assert!(sources.contains(&"OpenSees") && sources.len() >= 3, "{sources:?}");
}

#[test]
fn comparisons_have_no_tolerance() {
    let summary = PAPERS.summary();
    let comparisons = array(&summary, "comparisons");
    assert_keys(comparisons, &["problem", "source", "quantity"], &["reference", "ours"]);
    assert!(comparisons.iter().all(|entry| entry.get("verdict").is_none() && entry.get("tolerance").is_none()));
}

/// The report counts external, analytical and internal checks separately. The counts agree in the summary file, at the head of the first page and in
/// the command's output. A kind without checks is not mentioned.
#[test]
fn checks_are_counted_by_whose_figures_they_are_against() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        let summary = report.summary();
        let checks = array(&summary, "checks");
        let of_kind = |kind: &str| checks.iter().filter(|check| check["kind"] == kind).count();
        let kinds = [
            (of_kind("external"), "against other programs", "external checks (OpenSees, MuJoCo)"),
            (
                of_kind("analytical"),
                "against closed forms and literature",
                "analytical checks (closed forms, literature)",
            ),
            (of_kind("internal"), "of our own", "internal checks (our second formulation, a balance or a bound)"),
        ];
        assert_eq!(kinds.iter().map(|(count, ..)| count).sum::<usize>(), checks.len(), "one source has two kinds");
        let head = report.read("index.html");
        let head = head.split("</details>").next().expect("the verdict");
        let there = || kinds.iter().filter(|(count, ..)| *count > 0);
        let [short, long] = [
            there().map(|(n, short, _)| format!("{n} of {n} {short}")).collect::<Vec<_>>().join(", "),
            there().map(|(n, _, long)| format!("{n} of {n} {long}")).collect::<Vec<_>>().join(", "),
        ];
        assert!(head.contains(&format!("pass {short} checks.")), "{short}");
        assert!(report.read("summary.json").contains(&format!("Checks that pass: {long}.")), "{long}");
        assert!(!report.said.contains(" 0 of 0 ") && !head.contains(" 0 of 0 "));
    }
    let summary = PAPERS.summary();
    let checks = array(&summary, "checks");
    for check in checks {
        let source = check["source"].as_str().expect("words");
        // The lattice's springs are finray's own, although rapier2d brings them to rest.
        assert!(check["kind"] != "external" || ["OpenSees", "MuJoCo"].contains(&source), "{check}");
        let problem = check["problem"].as_str().expect("words");
        // A residual of the fit to the paper's Table I must not count as a check.
        assert!(source != "paper" && !problem.contains("residual"), "{check}");
    }
}

/// A figure that a plausible fault moves by 1.5 % fails its check. Figures of chance cannot see such a fault: coverage, multiples of a standard
/// deviation, and mean errors under noise. Nor can the order of a mesh's convergence.
#[test]
fn each_check_sees_a_fault_of_one_and_a_half_per_cent() {
    const FAULT: f64 = 0.015;
    let summary = PAPERS.summary();
    let (mut seen, mut of_chance) = (0, 0);
    for check in array(&summary, "checks") {
        let [problem, quantity] = ["problem", "quantity"].map(|key| check[key].as_str().expect("words"));
        let [reference, ours, tolerance] =
            ["reference", "ours", "tolerance"].map(|key| check[key].as_f64().expect("a number"));
        let is_of_chance =
            quantity.contains("sigma") || [problem, quantity].iter().any(|words| words.contains("mm noise"));
        let is_of_convergence = quantity == "order of convergence" || quantity == "carried load / limit load";
        if is_of_chance || is_of_convergence {
            of_chance += 1;
            // No figure of 0 passes for a standard deviation.
            assert!(!quantity.contains("rms sigma") || quantity.starts_with("ln("), "{check}");
            continue;
        }
        // A count that is off by one, a share of the reference, or a larger difference from zero.
        let off = match reference {
            _ if tolerance == 0.5 => 1.0,
            // A difference in stated uncertainties is a multiple of 1e-5 of the displacement.
            _ if quantity.contains("uncertainties") => FAULT / 1e-5,
            0.0 => FAULT,
            reference => FAULT * reference.abs(),
        };
        assert!((ours + off - reference).abs() > tolerance || (ours - off - reference).abs() > tolerance, "{check}");
        seen += 1;
    }
    assert!(seen > 120 && of_chance < seen / 2, "{seen} seen, {of_chance} of chance");
}

/// Every external and analytical check has a symbol in the drawing of disagreements.
#[test]
fn every_independent_reference_is_drawn() {
    let page = PAPERS.pages();
    let drawing = page.split("<title>Disagreement with").nth(1).and_then(|rest| rest.split("</svg>").next());
    let drawing = drawing.expect("the drawing");
    let summary = PAPERS.summary();
    let known = array(&summary, "checks").iter().filter(|check| check["disagreement"].is_number()).collect::<Vec<_>>();
    let of_kind = |kind: &str| known.iter().filter(|check| check["kind"] == kind).count();
    assert_eq!(of_kind("external") + of_kind("analytical"), known.len());
    // The legend contains one symbol of each kind. Squares are polygons.
    assert_eq!(drawing.matches("<circle").count(), of_kind("external") + 1);
    assert_eq!(drawing.matches("<polygon").count(), of_kind("analytical") + 1);
}

/// The lattice's springs and MuJoCo's rods have the EA and EI of the beams, so no text may claim that they have independent physics.
#[test]
fn nothing_claims_more_independence_than_there_is() {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let readme = std::fs::read_to_string(readme).expect("the README");
    let exported = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/mujoco/README.md");
    let exported = std::fs::read_to_string(exported).expect("the exporter's README");
    let texts = [readme, exported, PAPERS.pages(), PAPERS.said.clone(), PAPERS.read("summary.json")];
    for text in texts.into_iter().chain(GUIDES.iter().map(|guide| guide.text.to_owned())) {
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
        for claim in ["shares nothing", "second physics", "other parties", "neither theory", "another physics"] {
            assert!(!words.contains(claim), "\"{claim}\" in ... {}", &words[..words.len().min(60)]);
        }
    }
    assert!(PAPERS.pages().contains("Material and joints of a real finger are not verified here"));
    // The report compares beam theory with a continuum solution, without a pass or fail verdict. For a finger without a continuum solution, the page
    // states that this finger was not solved as a continuum.
    let summary = PAPERS.summary();
    let median = |beams: &str| {
        let found = array(&summary, "comparisons").iter().find(|entry| {
            let [problem, quantity] = ["problem", "quantity"].map(|key| entry[key].as_str().expect("words"));
            problem.starts_with("continuum paper,") && problem.ends_with(beams) && quantity.starts_with("median")
        });
        found.and_then(|entry| entry["ours"].as_f64()).expect("a comparison")
    };
    let (with_modulus, with_arms) = (median("beams with E"), median("rod arms and shear"));
    assert!(with_modulus > 50.0 * with_arms, "{with_modulus} and {with_arms}");
    let in_words = format!("differ by {:.2} % of the largest displacement", 100.0 * with_arms);
    for [page, absent] in [["checks.html", "this finger was not solved"], ["index.html", "This finger was not solved"]]
    {
        assert!(PAPERS.read(page).contains(&in_words), "{page}");
        assert!(SPRING_STEELS.read(page).contains(&format!("{absent} as a continuum")), "{page}");
    }
}

#[test]
fn hard_cases_pass_their_checks() {
    let cases = Csv::of(&PAPERS.read("hard_cases.csv"));
    let mut names = cases.texts("case");
    names.dedup();
    assert!(names.len() >= 20, "{names:?}");
    for column in ["difficulty", "expectation"] {
        assert!(cases.texts(column).iter().all(|words| words.len() > 10), "{column}");
    }
    // Each hard case occurs among the checks and on the page.
    let summary = PAPERS.summary();
    let page = PAPERS.pages();
    for name in &names {
        assert!(array(&summary, "checks").iter().any(|check| check["problem"] == **name), "{name}");
        assert!(page.contains("id=\"hard-cases\"") && page.contains(*name), "{name}");
    }
}
