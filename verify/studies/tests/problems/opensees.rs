//! Fingers compared with OpenSees: the paper's finger, and fingers with unequal plates, zones, hinges, brackets, clips, undeformable ribs, arms and
//! shear.
//!
//! `fixtures/opensees/README.md` states how the files were made and how accurate they are.

use finray_model::{Finger, Kinematics};
use finray_studies::problems::opensees::{
    COROTATIONAL_TOLERANCE, CaseDeviation, FINGERS, LINEAR_TOLERANCE, deviations, verified_features,
};
use finray_tests::{finger_of, paper};

#[track_caller]
fn assert_agree(name: &str, finger: &Finger, csv: &str, linear_tolerance: f64) {
    let cases = deviations(finger, csv).expect("fixture cases are solved");
    assert!(cases.len() >= 20, "{name}: expected the file's cases, found {}", cases.len());
    for CaseDeviation { case, kinematics, mesh_nodes, displacement, rotation_rad, .. } in cases {
        let tolerance = if kinematics == Kinematics::Linear { linear_tolerance } else { COROTATIONAL_TOLERANCE };
        assert!(
            displacement <= tolerance && rotation_rad <= tolerance,
            "{name}, case {case} ({kinematics:?}, {mesh_nodes} nodes): displacements differ by {displacement:e} of the largest, \
             rotations by {rotation_rad:e} rad"
        );
    }
}

#[test]
fn fingers_with_every_feature_are_as_opensees_has_them() {
    for finger in FINGERS {
        assert_agree(finger.name, &finger_of(finger.scene), finger.csv, finger.linear_tolerance);
    }
}

#[test]
fn the_papers_finger_is_as_opensees_has_it() {
    assert_agree("paper", &paper(), finray_fixtures::OPENSEES_PAPER, LINEAR_TOLERANCE);
}

/// The report of an own finger names what OpenSees verified on other fingers. Tapers are verified by closed forms alone.
#[test]
fn a_finger_is_told_which_of_its_features_are_verified() {
    assert_eq!(verified_features(&paper()), [vec![], vec![]] as [Vec<&str>; 2]);
    let all = finger_of(finray_fixtures::ALL_KEYS_SCENE);
    let [verified, not] = verified_features(&all);
    assert!(
        ["shear_correction", "rib_arm_mm", "zones", "clip_mm"].iter().all(|key| verified.contains(key)),
        "{verified:?}"
    );
    assert!(not.is_empty(), "{not:?}");
    let mut tapered = all.description().clone();
    tapered.back.tip_thickness_mm = Some(1.0);
    let [_, not] = verified_features(&Finger::new(tapered).expect("a finger"));
    assert_eq!(not, ["tip_thickness_mm"]);
}
