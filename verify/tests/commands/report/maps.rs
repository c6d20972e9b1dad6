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
