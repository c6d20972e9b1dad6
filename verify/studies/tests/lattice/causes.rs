//! Dependence of the lattice's rest state on the number of solver sweeps and on floating-point precision.

use finray_lattice::settling::Precision;
use finray_lattice::{Lattice, settling};
use finray_model::NodeId;
use finray_studies::lattice::accuracy::LoadGrid;
use finray_studies::lattice::causes;
use finray_tests::paper;

/// Tolerance between the settled lattice and its equilibrium, as a share of the largest displacement.
const SETTLING_TOLERANCE: f64 = 5e-4;

/// With more solver sweeps per step, the lattice settles nearer to its equilibrium; only the error of the criterion for rest remains. In single
/// precision, the error is larger.
#[test]
fn few_sweeps_and_single_precision_rest_elsewhere() {
    let finger = paper();
    let lattice = Lattice::new(&finger, 2).expect("a lattice");
    let grid = LoadGrid { nodes: vec![NodeId(14)], angles_deg: vec![-50.0], forces_n: vec![5.0] };
    let rows = causes::settling(&lattice, &grid).expect("an equilibrium");
    let error = |sweeps: usize, positions: Precision| {
        let row = rows.iter().find(|row| row.sweeps == sweeps && row.positions == positions).expect("a row");
        row.error.expect("it settles")
    };
    let [few, more, usual] = [8, 16, settling::SWEEPS].map(|sweeps| error(sweeps, Precision::Double));
    assert!(few > 5.0 * more && more > 2.0 * usual && usual < SETTLING_TOLERANCE, "{rows:?}");
    assert!(error(settling::SWEEPS, Precision::Single) > 3.0 * usual, "{rows:?}");
    let [double, single] = [Precision::Double, Precision::Single]
        .map(|positions| causes::out_of_balance(&lattice, &grid, positions).expect("an equilibrium"));
    assert!(double < 1e-9 && single > 1e-5, "{double} {single}");
}
