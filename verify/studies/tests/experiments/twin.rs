//! The digital twin: the fit to Table I, and sensing on the twin.

use finray_fixtures::TWIN_SCENE;
use finray_model::Kinematics;
use finray_studies::experiments::table_one::{WEIGHTS_G, table_one, weight_n};
use finray_studies::experiments::twin::TWIN;
use finray_studies::experiments::twin::fit::{ANGLE_DEG, fit};
use finray_studies::truths::TruthId;
use finray_studies::truths::{MeshTruth, fine_mesh};
use finray_studies::truths::{TwinError, twin_of};
use finray_tests::{finger_of, paper};

/// Tolerance for the scene's numbers, which are rounded to four digits (0.0641 to three). The fit ends within 1e-7.
const ROUNDED: f64 = 1e-3;
/// Tolerance of a node's mean error against Table I. At nodes 14, 16 and 24, the paper's errors over six weights scatter by about 5 percentage
/// points; see `TARGETS` of the fit.
const NEAR_TABLE_ONE: f64 = 0.03;

#[test]
fn the_twin_is_what_the_fit_finds() {
    let fit = fit(&paper(), &TWIN).expect("a fit");
    let twin = finger_of(TWIN_SCENE);
    let (ours, shipped) = (fit.finger.description(), twin.description());
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < ROUNDED, "{a} against {b}: {ours:?}");
    close(ours.front.youngs_modulus_mpa, shipped.front.youngs_modulus_mpa);
    assert_eq!(ours.zones.len(), shipped.zones.len());
    for (a, b) in ours.zones.iter().zip(&shipped.zones) {
        assert_eq!((a.part, a.from_mm, a.to_mm), (b.part, b.from_mm, b.to_mm));
        close(a.modulus_factor, b.modulus_factor);
    }
    assert!(fit.misfit < 1.0, "{}", fit.misfit);
}

/// The errors have the shading of the paper's table: dark at node 14, grey at nodes 16 and 24, clear at nodes 18 to 22. The errors hardly depend on
/// the load: the six errors of a node span at most 14 percentage points, the paper's span at node 14.
#[test]
fn the_twin_is_shaded_as_table_one() {
    let (paper, twin) = (paper(), finger_of(TWIN_SCENE));
    let mesh = fine_mesh(&twin).expect("a mesh");
    let truth = MeshTruth::new(TruthId::Twin, &mesh, Kinematics::Corotational).expect("a finger");
    let table = table_one(&paper, &truth, ANGLE_DEG, &WEIGHTS_G.map(weight_n)).expect("a table");
    assert!((table.modulus_factor - 1.0).abs() < ROUNDED, "{}", table.modulus_factor);
    let shade = |error: f64| {
        if error > 0.25 {
            "dark"
        } else if error > 0.10 {
            "grey"
        } else {
            "clear"
        }
    };
    let shades: Vec<_> = table.rows.iter().map(|row| shade(row.mean_error)).collect();
    assert_eq!(shades, ["dark", "grey", "clear", "clear", "clear", "grey"]);
    for row in &table.rows {
        assert!((row.mean_error - row.paper_mean_error).abs() < NEAR_TABLE_ONE, "{row:?}");
        let (low, high) = row.errors.iter().fold((f64::MAX, f64::MIN), |(low, high), e| (low.min(*e), high.max(*e)));
        assert!(high - low < 0.141, "{row:?}");
        // At the nodes where the paper sensed too large forces (14, 16 and 24), every sensed force is too large.
        assert!(row.mean_error < 0.10 || low > 0.0, "{row:?}");
    }
}

#[test]
fn other_fingers_have_no_twin() {
    let other = paper().with_modulus_factor(1.1).expect("a finger");
    assert_eq!(twin_of(&other), Err(TwinError::NotThePapersFinger));
}
