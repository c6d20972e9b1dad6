//! The lattice as the true finger.

use finray_lattice::Lattice;
use finray_model::Kinematics;
use finray_studies::check::difference;
use finray_studies::truths::TruthId;
use finray_studies::truths::{LATTICE_FINENESS, MeshTruth, Truth, fine_mesh};
use finray_tests::{at_position, paper};

/// The lattice has the shapes of co-rotational beams, also under forces between nodes.
#[test]
fn lattice_truth_is_that_of_beams() {
    let finger = paper();
    let truth = Lattice::new(&finger, LATTICE_FINENESS).expect("a lattice");
    assert_eq!(truth.id(), TruthId::Lattice);
    let mesh = fine_mesh(&finger).expect("a mesh");
    let beams = MeshTruth::new(TruthId::Corotational, &mesh, Kinematics::Corotational).expect("prepared");
    for (s_mm, angle_deg) in [(40.0, -60.0), (101.0, 0.0), (130.3, 45.0), (153.0, 10.0)] {
        let contact = at_position(s_mm, angle_deg);
        let (ours, theirs) = (truth.shapes(&contact, &[0.5, 3.0]), beams.shapes(&contact, &[0.5, 3.0]));
        assert_eq!(ours.len(), 2);
        for (a, b) in theirs.iter().zip(&ours) {
            assert!(difference(a, b) < 5e-4, "{s_mm} {angle_deg} {}", difference(a, b));
        }
    }
}
