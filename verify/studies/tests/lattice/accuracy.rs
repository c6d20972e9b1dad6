//! Difference of the lattice from beams, and its dependence on fineness and axial springs.

use finray_model::NodeId;
use finray_studies::lattice::accuracy::{LoadGrid, study};
use finray_studies::lattice::causes;
use finray_tests::paper;

/// The error decreases with the fourth power of the segment length: halved segments reduce it by a factor of more than ten.
#[test]
fn finer_lattices_are_nearer_to_beams() {
    let finger = paper();
    let grid = LoadGrid { nodes: vec![NodeId(22)], angles_deg: vec![-30.0], forces_n: vec![3.0] };
    let rows = study(&finger, &[2, 4], &grid, |_| None).expect("equilibria");
    assert!(rows[1].bodies > rows[0].bodies && rows[1].springs > rows[0].springs);
    assert!(rows[1].errors[0] * 10.0 < rows[0].errors[0], "{rows:?}");
}

/// The axial springs of a beam segment give the smallest error. Other axial springs give larger errors, and without axial springs there is no
/// equilibrium.
#[test]
fn axial_springs_must_be_those_of_a_beam() {
    let finger = paper();
    let nodes = vec![NodeId(14), NodeId(23)];
    let grid = LoadGrid { nodes, angles_deg: vec![-60.0, 60.0], forces_n: vec![0.1, 3.0] };
    let rows = causes::axial(&finger, 2, &grid).expect("equilibria");
    let [beams, at_ends, rigid, none] = &rows[..] else { panic!("{rows:?}") };
    let error = |row: &causes::AxialRow| row.errors.as_ref().expect("an equilibrium")[1];
    assert!(error(beams) * 3.0 < error(at_ends), "{rows:?}");
    // Axial strain matters also for small rotations: without axial strain, even the smallest displacement has a large error.
    assert!(error(rigid) > 0.2 && rigid.errors.as_ref().expect("an equilibrium")[0] > 0.2, "{rows:?}");
    assert_eq!(none.errors, None);
}
