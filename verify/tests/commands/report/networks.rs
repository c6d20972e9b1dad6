//! The report's sections on shipped networks and Table II.

use super::shared::*;
use crate::kit::*;

/// `networks.csv` contains eleven single nodes and four pairs of nodes, and each of its rows has a check. The summary agrees with the file.
#[test]
fn networks_that_ship_are_within_their_tolerances() {
    let rows = Csv::of(&PAPERS.read("networks.csv"));
    let singles = (14..=24).map(|node: usize| node.to_string());
    let pairs = ["19 20", "16 17", "18 20", "16 20"].map(str::to_owned);
    let wanted = singles.chain(pairs.into_iter().flat_map(|pair| [pair.clone(), pair]));
    assert_eq!(rows.texts("nodes"), wanted.collect::<Vec<_>>());
    assert!(rows.numbers("drawn").iter().all(|cases| *cases >= 40.0) && rows.numbers("refused") == [0.0; 19]);
    assert_eq!(rows.numbers("drawn"), rows.numbers("answered"));
    for (error, bound) in rows.numbers("mean_error").into_iter().zip(rows.numbers("mean_error_bound")) {
        // A mean error over forty cases has a relative scatter of one sixth. For the sum of two forces on neighbouring nodes, the error is 1.6 times
        // the bound.
        assert!(error > 0.5 * bound && error < 2.5 * bound, "{error}, bound {bound}");
    }
    let summary = PAPERS.summary();
    let checks = array(&summary, "checks").iter().filter(|check| check["source"] == "known forces");
    let ours: Vec<f64> = checks.filter_map(|check| check["ours"].as_f64()).collect();
    assert_close(&ours, &rows.numbers("mean_error"), LINEAR_ROUNDING);
    let networks = array(&summary, "networks");
    assert_keys(
        networks,
        &["nodes", "quantity"],
        &["noise_mm", "drawn", "answered", "refused", "mean_error", "mean_error_bound"],
    );
    assert_eq!(networks.iter().filter_map(|row| row["mean_error"].as_f64()).collect::<Vec<_>>(), ours);
    assert!(PAPERS.pages().contains("id=\"networks\""));
    assert!(!SPRING_STEELS.pages().contains("id=\"networks\""));
    assert!(array(&SPRING_STEELS.summary(), "networks").is_empty());
}

#[test]
fn table_two_has_the_network_on_both_fingers() {
    let rows = Csv::of(&PAPERS.read("table_two.csv"));
    let keys = rows.texts("truth").into_iter().zip(rows.texts("estimator")).zip(rows.numbers("noise_mm"));
    let networks: Vec<_> = keys.filter(|((_, estimator), _)| *estimator == "network").collect();
    for (truth, noise_mm) in [("linear", 0.0), ("linear", 0.067), ("corotational", 0.0), ("corotational", 0.067)] {
        let of_finger = networks.iter().filter(|((of, _), noise)| *of == truth && *noise == noise_mm);
        // The rows are three single nodes, two rows for each of four pairs, and the five means that the paper lists.
        assert_eq!(of_finger.count(), 3 + 2 * 4 + 5, "{truth}, {noise_mm} mm");
    }
    let summary = PAPERS.summary();
    assert_eq!(array(&summary, "table_two").len(), rows.rows.len());
    assert_keys(
        array(&summary, "table_two"),
        &["truth", "estimator", "group", "nodes", "quantity"],
        &["noise_mm", "drawn", "answered", "refused"],
    );
    // The table also contains the recorded errors of the paper's method, and the page states that Table II is not reproduced.
    assert!(rows.texts("estimator").iter().any(|estimator| estimator.starts_with("network of the paper")));
    let page = PAPERS.pages();
    assert!(page.contains("does not reproduce Table II") && !page.contains("reproduces the paper"));
}
