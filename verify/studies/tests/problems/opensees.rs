//! Fingers compared with OpenSees: the paper's finger, and fingers with unequal plates, zones, hinges, brackets, clips, undeformable ribs or rigid
//! arms.
//!
//! `fixtures/opensees/README.md` states how the files were made and how accurate they are.

use finray_model::Kinematics;
use finray_studies::problems::opensees::{COROTATIONAL_TOLERANCE, CaseDeviation, LINEAR_TOLERANCE, deviations};
use finray_tests::finger_of;

/// Tolerance for linear solutions of the spring-steel finger. On fine meshes, rounding errors grow with the fourth power of the node count. Rounding
/// errors are larger for spring steel, whose plates are thousands of times stiffer in tension than in bending.
const STEEL_LINEAR_TOLERANCE: f64 = 1e-7;

fn worst_deviation(scene: &str, csv: &str, linear_tolerance: f64) {
    let finger = finger_of(scene);
    let cases = deviations(&finger, csv).expect("fixture cases are solved");
    assert!(cases.len() >= 20, "expected the file's cases, found {}", cases.len());
    for CaseDeviation { case, kinematics, mesh_nodes, displacement, rotation_rad, .. } in cases {
        let tolerance = if kinematics == Kinematics::Linear { linear_tolerance } else { COROTATIONAL_TOLERANCE };
        assert!(
            displacement <= tolerance && rotation_rad <= tolerance,
            "case {case} ({kinematics:?}, {mesh_nodes} nodes): displacements differ by {displacement:e} of the largest, \
             rotations by {rotation_rad:e} rad"
        );
    }
}

macro_rules! finger {
    ($name:ident, $scene:ident, $csv:ident, $tolerance:expr) => {
        #[test]
        fn $name() {
            worst_deviation(finray_fixtures::$scene, finray_fixtures::$csv, $tolerance);
        }
    };
}

finger!(unequal_plates_with_zones, ASYMMETRIC_SCENE, OPENSEES_ASYMMETRIC, LINEAR_TOLERANCE);
finger!(hinged_ribs, HINGED_SCENE, OPENSEES_HINGED, LINEAR_TOLERANCE);
finger!(undeformable_ribs, RIGID_RIBS_SCENE, OPENSEES_RIGID_RIBS, LINEAR_TOLERANCE);
finger!(undeformable_hinged_ribs, HINGED_RIGID_SCENE, OPENSEES_HINGED_RIGID, STEEL_LINEAR_TOLERANCE);
finger!(hinged_ribs_on_brackets, BRACKETS_SCENE, OPENSEES_BRACKETS, LINEAR_TOLERANCE);
finger!(joined_ribs_on_brackets, BRACKETS_JOINED_SCENE, OPENSEES_BRACKETS_JOINED, LINEAR_TOLERANCE);
finger!(undeformable_ribs_on_brackets, BRACKETS_RIGID_SCENE, OPENSEES_BRACKETS_RIGID, STEEL_LINEAR_TOLERANCE);
finger!(clips_and_rigid_ends, CLIPS_SCENE, OPENSEES_CLIPS, STEEL_LINEAR_TOLERANCE);
finger!(rigid_arms, ARMS_SCENE, OPENSEES_ARMS, LINEAR_TOLERANCE);
finger!(paper_finger, PAPER_SCENE, OPENSEES_PAPER, LINEAR_TOLERANCE);
