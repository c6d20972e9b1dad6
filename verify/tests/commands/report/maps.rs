//! The report's maps: key figures, cells, counts and explanations.

use super::shared::*;
use crate::kit::*;
use serde_json::Value;

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
                // For a map of one force, the numbers in the summary follow from the cells of the map.
                let samples = cells.numbers("samples").into_iter().zip(cells.texts("mean_error"));
                let of_force = cells.numbers("force_n").into_iter().zip(samples).filter(|(f, _)| *f == force);
                // A cell without samples has no equilibrium; a cell with samples but without an error is refused.
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

/// A network that refuses most cells of a map must not be judged by the mean over the few other cells.
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
    let page = PAPERS.pages();
    for header in [">cells</th>", ">answered</th>", ">refused</th>", ">no equilibrium</th>"] {
        assert!(page.contains(header), "{header}");
    }
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

/// For the paper's finger, the report maps every truth with every estimator, with and without noise; for other fingers, it maps only the combinations
/// that exist. Truths that the nonlinear estimator cannot explain are mapped only with noise.
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
    // Two truths, three estimators and two noise levels, minus the nonlinear estimator on the linear finger without noise.
    assert_eq!(kinds(&SPRING_STEELS).len(), 2 * 3 * 2 - 1);
}

#[test]
fn the_overview_holds_the_cells_that_are_drawn() {
    let cells = Csv::of(&PAPERS.read("map_overview.csv"));
    let truths: std::collections::BTreeSet<_> = cells.texts("truth").into_iter().collect();
    assert_eq!(truths.len(), 5);
    // In the overview, the error of a cell is the largest error over the forces in the map's own file.
    let kinds = cells.texts("truth").into_iter().zip(cells.texts("estimator")).zip(cells.texts("noise_mm"));
    let of_map = kinds.zip(cells.texts("worst_error")).filter(|(((truth, estimator), noise), _)| {
        (*truth, *estimator) == ("twin", "ridge") && noise.parse() == Ok(0.0)
    });
    let overview: Vec<Option<f64>> = of_map.map(|(_, error)| error.parse().ok()).collect();
    let own = Csv::of(&PAPERS.read("map_twin_ridge_without_noise.csv"));
    let errors: Vec<Option<f64>> = own.texts("mean_error").iter().map(|error| error.parse().ok()).collect();
    let worst = errors
        .chunks(4)
        .map(|forces| forces.iter().copied().collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max));
    assert!(overview.len() > 10 && overview == worst.collect::<Vec<_>>());
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

/// For pairs of neighbouring nodes and pairs of separate nodes, `noise.csv` agrees with the checks. Only a full report includes every pair and the
/// cases with unknown directions.
#[test]
fn four_pairs_are_within_their_tolerances() {
    let summary = PAPERS.summary();
    let of_pairs =
        |check: &&Value| check["problem"].as_str().is_some_and(|text| text.starts_with("nonlinear sensing at nodes"));
    let checks: Vec<_> = array(&summary, "checks").iter().filter(of_pairs).collect();
    let rows = Csv::of(&PAPERS.read("noise.csv"));
    // The error of a sum is divided by its bound; the error of a force is used directly.
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
    for (nodes, tolerance) in [("19 20", 0.03), ("16 17", 0.03), ("18 20", 0.012), ("16 20", 0.012)] {
        let of = |sum: bool| {
            let of_pair = errors.iter().filter(|row| row.0 == nodes && (row.1 == "sum") == sum);
            let errors: Vec<f64> = of_pair.map(|row| row.2).collect();
            errors.iter().sum::<f64>() / errors.len() as f64
        };
        let problem = format!("at nodes {}", nodes.replace(' ', " and "));
        let said = checks.iter().filter(|check| check["problem"].as_str().is_some_and(|text| text.contains(&problem)));
        let said: Vec<f64> =
            said.flat_map(|check| [&check["ours"], &check["tolerance"]]).filter_map(Value::as_f64).collect();
        // A quick report has only a hundred cases, so sampling error may increase the mean error by 22 %.
        assert_close(&said, &[of(false), 1.22 * tolerance, of(true), 0.10 + 0.22], LINEAR_ROUNDING);
    }
    for key in ["pairs", "directions", "directions_without_friction"] {
        assert!(array(&summary, key).is_empty(), "{key}");
    }
    assert!(!PAPERS.pages().contains("id=\"pairs\""));
}
