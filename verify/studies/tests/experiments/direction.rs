//! Forces of unknown direction: errors compared with the Cramer-Rao bound, refusals where the bound is high, and the gain from assuming the
//! deformed normal.

use finray_model::{Kinematics, Mesh};
use finray_studies::experiments::direction::{
    Assumption, DirectionCell, DirectionRequest, DirectionStudy, FORCES_N, IDENTIFIED_DEG, IDENTIFIED_FORCE,
};
use finray_studies::truths::MeshTruth;
use finray_studies::truths::TruthId;
use finray_tests::{CAMERA_NOISE_MM, STANDARD_ERRORS, paper};
use std::sync::LazyLock;

/// Number of noise samples per cell.
const SAMPLES: usize = 24;
/// Allowance for the nonlinearity of a direction's effect, which the linear bound neglects, as a share of the bound. The allowance applies to cells
/// with a small bound.
const CURVED: f64 = 0.1;

static STUDY: LazyLock<DirectionStudy> = LazyLock::new(|| {
    let mesh = Mesh::key_nodes(&paper());
    let truth = MeshTruth::new(TruthId::Corotational, &mesh, Kinematics::Corotational).expect("the finger at rest");
    let request = DirectionRequest {
        model: &mesh,
        noise_mm: CAMERA_NOISE_MM,
        positions: 6,
        step_deg: 40.0,
        samples: SAMPLES,
        forces_n: FORCES_N,
        seed: 5,
    };
    DirectionStudy::run(&truth, &request, &|| {}).expect("contacts on the finger")
});

/// In cells with a low Cramer-Rao bound, every sample is answered, and the errors equal the bound.
#[test]
fn what_is_identifiable_is_sensed_to_the_bound() {
    let allowed = CURVED + STANDARD_ERRORS / (2.0 * SAMPLES as f64).sqrt();
    let mut sure = 0;
    let low = |cell: &&DirectionCell| {
        let bounds = cell.angle_bound_deg.zip(cell.force_bound);
        bounds.is_some_and(|(angle, force)| angle < 0.5 * IDENTIFIED_DEG && force < 0.5 * IDENTIFIED_FORCE)
    };
    for cell in STUDY.cells.iter().filter(low) {
        sure += 1;
        assert_eq!(cell.answers.answered, SAMPLES, "{cell:?}");
        let over = |error: Option<f64>, bound: Option<f64>| error.expect("answers") / bound.expect("a bound");
        let angle = over(cell.answers.angle_error_deg, cell.angle_bound_deg);
        let force = over(cell.answers.force_error, cell.force_bound);
        assert!((angle - 1.0).abs() <= allowed && (force - 1.0).abs() <= allowed, "{angle} {force} {cell:?}");
    }
    assert!(sure >= 12, "{sure} cells say little");
}

/// If the bound of the direction is above 60 degrees, many samples are refused, and no cell counts as identified. Noise makes the answered forces
/// look too large, and the stated standard deviations cover these errors.
#[test]
fn what_is_not_identifiable_is_refused_or_open() {
    let open = STUDY.cells.iter().filter(|cell| cell.angle_bound_deg.is_some_and(|bound| bound > 60.0));
    let mut count = 0;
    for cell in open {
        count += 1;
        let answers = cell.answers;
        assert!(4 * answers.answered <= 3 * SAMPLES && !answers.is_identified(), "{cell:?}");
        assert!(
            answers.force_error.zip(answers.force_sigma).is_none_or(|(error, sigma)| error < 2.0 * sigma),
            "{cell:?}"
        );
    }
    assert!(count > 0);
    assert!(
        STUDY
            .cells
            .iter()
            .filter(|cell| cell.answers.is_identified())
            .all(|cell| cell.angle_bound_deg.is_some_and(|bound| bound < 1.3 * IDENTIFIED_DEG))
    );
}

/// The direction of a larger force is identified better.
#[test]
fn larger_forces_are_identifiable_in_more_directions() {
    let shares = FORCES_N.map(|force_n| {
        let [identified, all] = STUDY.identified(force_n);
        identified as f64 / all as f64
    });
    assert!(shares[0] < shares[1] && shares[1] < shares[2], "{shares:?}");
}

/// For a push along the deformed normal, the estimator that assumes this direction has the smallest error and no bias. Assuming the undeformed normal
/// causes an error equal to the rotation of the plate.
#[test]
fn the_deformed_normal_is_worth_assuming() {
    let mean = |assumed: Assumption| {
        let pushes = STUDY.without_friction.iter().filter(|push| push.assumed == assumed && push.force_n == 3.0);
        let errors: Vec<f64> = pushes.filter_map(|push| push.answers.force_error).collect();
        (errors.iter().sum::<f64>() / errors.len() as f64, errors.len())
    };
    let [(undeformed, _), (normal, nodes), (unknown, _)] = Assumption::ALL.map(mean);
    assert_eq!(nodes, 12);
    assert!(2.0 * normal < undeformed && normal < unknown, "{undeformed} {normal} {unknown}");
    for push in STUDY.without_friction.iter().filter(|push| push.assumed == Assumption::Normal) {
        let turned = push.angle_deg.expect("it is carried");
        assert_eq!(push.answers.answered, SAMPLES, "{push:?}");
        // The deformed normal of the estimated shape agrees with the true normal.
        assert!(push.answers.angle_error_deg.expect("answers") < 1.0 + 0.1 * turned.abs(), "{push:?}");
        let over = push.answers.force_error.expect("answers") / push.answers.force_sigma.expect("answers");
        assert!((over - 1.0).abs() <= CURVED + STANDARD_ERRORS / (2.0 * SAMPLES as f64).sqrt(), "{over} {push:?}");
    }
}
