//! Checks of coverage fail for intervals that are too narrow, too wide or refused.

use finray_model::estimators::EstimatorId;
use finray_studies::check::Check;
use finray_studies::experiments::coverage::{CoverageRow, TRUTH};
use finray_studies::sampling::situation::{ContactKnowledge, HiddenMarkers};
use finray_studies::truths::TruthId;

fn row(covered_without_warning: f64, covered_with_warning: f64) -> CoverageRow {
    CoverageRow {
        truth: TRUTH,
        estimator: EstimatorId::LeastSquares,
        contact: ContactKnowledge::Known,
        hidden: HiddenMarkers::None,
        noise_mm: 0.067,
        contacts: 400,
        samples: 30_000,
        refused: 0,
        warned: 10_000,
        without_warning: 20_000,
        covered_without_warning: Some(covered_without_warning),
        covered_with_warning: Some(covered_with_warning),
        error_over_sigma_with_warning: Some(0.9),
    }
}

#[test]
fn intervals_that_are_too_narrow_or_too_wide_fail() {
    let passes = |row: CoverageRow| row.checks(true).iter().map(Check::passes).collect::<Vec<_>>();
    assert_eq!(passes(row(0.95, 1.0)), [true, true, true, true]);
    assert_eq!(passes(row(0.92, 0.92)), [true, false, false, true]);
    assert_eq!(passes(row(0.98, 0.95)), [true, false, true, true]);
    let vague = CoverageRow { error_over_sigma_with_warning: Some(0.1), ..row(0.95, 1.0) };
    assert_eq!(passes(vague), [true, true, true, false]);
    let silent = CoverageRow {
        refused: 30_000,
        warned: 0,
        without_warning: 0,
        covered_without_warning: None,
        covered_with_warning: None,
        error_over_sigma_with_warning: None,
        ..row(0.95, 1.0)
    };
    assert_eq!(passes(silent), [false]);
    let half = CoverageRow { refused: 10_000, ..row(0.95, 1.0) };
    assert_eq!((passes(half.clone())[0], half.checks(false)[0].passes()), (false, true));
    // Unknown contacts may be refused, but their intervals must hold.
    let unknown = CoverageRow { contact: ContactKnowledge::Nothing, ..half };
    assert_eq!(passes(unknown.clone()), [true, true, true]);
    assert_eq!(passes(CoverageRow { covered_without_warning: Some(0.9), ..unknown }), [false, true, true]);
    // A sigma that is twice too large covers almost every error, and is detected among a few hundred answers; few answers decide nothing.
    let fewer = |covered: f64| CoverageRow { warned: 10, without_warning: 600, ..row(covered, 1.0) };
    assert_eq!([0.995, 0.985, 0.91, 0.89].map(|covered| passes(fewer(covered))[1]), [false, true, true, false]);
    assert_eq!(passes(fewer(0.95)), [true, true]);
    assert!(!passes(CoverageRow { samples: 0, refused: 0, ..row(0.95, 1.0) })[0]);
    assert_eq!(passes(CoverageRow { truth: TruthId::Twin, ..row(0.5, 0.5) }), Vec::<bool>::new());
}
