//! Tests that a check fails if its figure is outside the tolerance.

use finray_studies::check::{Check, Kind, tallies, worst};

/// Asserts that there are checks and that all of them pass.
#[track_caller]
pub fn assert_all_pass(checks: &[Check]) {
    assert!(!checks.is_empty());
    for check in checks {
        assert!(check.passes(), "{check:?}");
    }
}

fn check(kind: Kind, ours: f64) -> Check {
    Check::new(kind, "problem", "source", "error", 0.0, ours, 1.0)
}

#[test]
fn a_check_with_a_refused_case_fails_however_small_its_figure() {
    let answered = check(Kind::Internal, 0.1).with_refused(0, 100);
    assert!(answered.passes() && answered.quantity == "error");
    let refused = check(Kind::Internal, 0.1).with_refused(1, 100);
    assert!(!refused.passes());
    assert_eq!(refused.quantity, "error; 1 of 100 refused");
}

#[test]
fn only_independent_references_have_a_disagreement() {
    let of = |kind, reference, ours| Check::new(kind, "", "", "", reference, ours, 1.0);
    assert_eq!(of(Kind::External, -4.0, -3.0).disagreement, Some(0.25));
    assert_eq!(of(Kind::Analytical, 0.0, -1e-9).disagreement, Some(1e-9));
    assert_eq!(of(Kind::Internal, 2.0, 1.0).disagreement, None);
    assert_eq!(of(Kind::External, 0.0, 1.7).in_stated_uncertainties().disagreement, None);
}

#[test]
fn the_worst_of_nothing_is_no_number() {
    assert!(worst([]).is_nan() && !check(Kind::Internal, worst([])).passes());
    assert_eq!(worst([1.0, 3.0, 2.0]), 3.0);
    assert!(worst([1.0, f64::NAN, 2.0]).is_nan());
}

/// Checks are counted by kind, and a kind without checks is omitted. The spring lattice is finray's own, although rapier brings it to rest.
#[test]
fn references_are_counted_by_kind() {
    let checks = [check(Kind::Internal, 0.0), check(Kind::External, 2.0), check(Kind::Internal, f64::NAN)];
    let counted: Vec<_> =
        tallies(checks.iter()).into_iter().map(|tally| (tally.kind, tally.passed, tally.all)).collect();
    assert_eq!(counted, [(Kind::External, 0, 1), (Kind::Internal, 1, 2)]);
}
