//! The history of searches: a search that meets the path of an earlier search ends in the same minimum.

use super::*;

/// Path of two forces: 1, 2 and 4 N for the first force; 5, 6 and 7 N for the second force.
fn way(end: Option<(f64, Vec<f64>)>) -> SearchPath {
    SearchPath { points: vec![vec![1.0, 5.0], vec![2.0, 6.0], vec![4.0, 7.0]], end }
}

#[test]
fn a_way_to_a_minimum_is_met_on_it_and_nowhere_else() {
    let ways = SearchHistory { ended: vec![way(None), way(Some((0.1, vec![4.0, 7.0])))], ..SearchHistory::default() };
    for on_it in [[1.0, 5.0], [1.5, 5.5], [3.0, 6.5], [4.05, 7.0]] {
        assert_eq!(ways.passing(&on_it), Some(1), "{on_it:?}");
    }
    for off_it in [[0.9, 5.0], [1.5, 6.0], [4.2, 7.0], [4.0, 7.2], [-1.0, 5.0]] {
        assert_eq!(ways.passing(&off_it), None, "{off_it:?}");
    }
}

#[test]
fn a_way_that_meets_another_ends_where_that_did() {
    let mut ways = SearchHistory { ended: vec![way(Some((0.1, vec![4.0, 7.0])))], ..SearchHistory::default() };
    ways.begin();
    ways.met = Some(0);
    assert_eq!(ways.end(None), Some((0.1, vec![4.0, 7.0])));
    ways.begin();
    assert_eq!(ways.end(Some((0.2, vec![9.0, 9.0]))), Some((0.2, vec![9.0, 9.0])));
}
