//! A hard case fails if a check fails, an unexpected error occurs, a law has no equilibrium to test, or the time limit is exceeded.

use finray_model::Finger;
use finray_studies::check::{Check, Kind};
use finray_studies::experiments::hard_cases::soundness::Soundness;
use finray_studies::experiments::hard_cases::{Findings, HardCase, Question, TIME_LIMIT_S, Unexpected, answered};
use finray_studies::settings::Effort;
use finray_tests::paper;

fn answered_by(answer: fn(&Finger, Effort, &mut Findings) -> Result<(), Unexpected>) -> HardCase {
    let question = Question { case: "case", difficulty: "difficulty", expectation: "expectation", answer };
    answered(&question, &paper(), Effort::Quick)
}

fn with_error(ours: f64) -> HardCase {
    let case = answered_by(|_, _, _| Ok(()));
    HardCase { checks: vec![Check::new(Kind::Internal, "case", "law", "error", 0.0, ours, 1.0)], ..case }
}

#[test]
fn a_failed_check_fails_its_case() {
    assert!(with_error(0.9).passes());
    assert!(!with_error(1.1).passes() && !with_error(f64::NAN).passes());
}

#[test]
fn an_unexpected_error_fails_its_case() {
    let case = answered_by(|_, _, _| Err("it fell over".into()));
    assert!(!case.passes() && case.notes[0].contains("it fell over"), "{case:?}");
}

#[test]
fn laws_without_a_case_fail() {
    let case = answered_by(|_, _, findings| {
        Soundness::default().report(findings);
        Ok(())
    });
    assert!(!case.passes());
}

#[test]
fn a_slow_case_fails() {
    assert!(!HardCase { seconds: 1.1 * TIME_LIMIT_S, ..with_error(0.0) }.passes());
}
