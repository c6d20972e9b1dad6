//! What is said of training cases and sizes follows from the recorded errors.

use finray_verify::experiments::networks::records::CurveRow;
use finray_verify::report::curves::{PAPERS, blocks, curves, samples_in_words, sizes_in_words};

/// Two seeds whose mean error is the bound's 2 % and a share of it.
fn rows(curve: &str, networks: &[(usize, &str, usize, f64)]) -> Vec<CurveRow> {
    let row = |seed: u64, nodes: &str, &(samples, layers, weights, above): &(usize, &str, usize, f64)| CurveRow {
        curve: curve.to_owned(),
        nodes: nodes.to_owned(),
        samples,
        hidden_layers: layers.to_owned(),
        weights,
        seed,
        cases: 100,
        mean_error: Some(0.02 * (1.0 + above + if seed == 1 { 0.01 } else { -0.01 })),
        mean_error_bound: Some(0.02),
    };
    let seeds = [1, 2];
    let of_nodes = |nodes: &'static str| {
        seeds.iter().flat_map(move |&seed| networks.iter().map(move |network| row(seed, nodes, network)))
    };
    of_nodes("24").chain(of_nodes("19 20")).collect()
}

fn sizes(rows: &[CurveRow]) -> String {
    sizes_in_words(&curves(rows, "size", |row| row.weights)).expect("words").expect("a sentence")
}

#[test]
fn the_smallest_network_that_keeps_the_error_is_named() {
    let [none, small, large] = [(1, "none", 94, 1.0), (1, "16-16", 1400, 0.05), (1, PAPERS, 70_000, 0.03)];
    let said = sizes(&rows("size", &[large, none, small]));
    assert!(
        said.contains("not needed: 16-16 keeps its error within 10 % at node 24 (1400 weights instead of 70000)"),
        "{said}"
    );
    let worse = (1, "16-16", 1400, 0.2);
    assert!(sizes(&rows("size", &[large, none, worse])).contains("is needed"));
    // It must keep the error for every set of contacts.
    let mut uneven = rows("size", &[large, none, small]);
    let of_pair = uneven.iter_mut().filter(|row| row.hidden_layers == "16-16" && row.nodes == "19 20");
    of_pair.for_each(|row| row.mean_error = row.mean_error.map(|error| 1.2 * error));
    assert!(sizes(&uneven).contains("is needed"));
}

#[test]
fn the_number_of_cases_that_is_enough_is_named() {
    let said = |networks: &[(usize, &str, usize, f64)]| {
        let all = rows("samples", networks);
        samples_in_words(&curves(&all, "samples", |row| row.samples)).expect("words").expect("a sentence")
    };
    let [few, some, many] = [(1000, "32-32", 1, 0.8), (5000, "32-32", 1, 0.12), (20_000, "32-32", 1, 0.1)];
    assert!(said(&[many, few, some]).contains("From 5000 training cases on"), "{}", said(&[many, few, some]));
    let still = (5000, "32-32", 1, 0.3);
    assert!(said(&[few, still, many]).contains("still falls"));
}

#[test]
fn seeds_are_gathered_and_nothing_recorded_is_nothing_shown() {
    let all = rows("samples", &[(1000, "32-32", 1, 0.5)]);
    let [one, pair] = &curves(&all, "samples", |row| row.samples)[..] else { panic!("two curves") };
    assert_eq!((one.nodes.as_str(), pair.nodes.as_str(), one.points.len()), ("24", "19 20", 1));
    let point = &one.points[0];
    assert!(
        (point.over_bound.mean - 1.5).abs() < 1e-12 && (point.over_bound.least - 1.49).abs() < 1e-12,
        "{:?}",
        point.over_bound
    );
    assert!(blocks(&[]).expect("nothing to draw").is_empty());
    assert_eq!(blocks(&all).expect("a figure").len(), 2);
}
