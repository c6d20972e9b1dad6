//! A small lattice study for tests.

use finray_model::NodeId;
use finray_model::estimators::EstimatorId;
use finray_studies::experiments::lattice::{LatticeSensing, LatticeStudy, MapDifference};
use finray_studies::lattice::accuracy::{FinenessRow, LoadGrid, SettlingCost};
use finray_studies::lattice::causes::{AXIAL_SPRINGS, AxialRow, SETTLINGS, SettlingRow};
use finray_studies::sampling::map::{AccuracyMap, MapRequest};
use finray_studies::sampling::sweep::MapCell;
use finray_studies::truths::TruthId;

/// A map of one cell, in which the estimator has the relative error `error`.
fn map(estimator: EstimatorId, error: f64) -> AccuracyMap {
    let request = MapRequest {
        positions_mm: vec![76.5],
        angles_deg: vec![20.0],
        forces_n: vec![3.0],
        noise_levels_mm: vec![0.0],
        noise_samples: 1,
        seed: 1,
    };
    let cell = MapCell {
        s_mm: 76.5,
        angle_deg: 20.0,
        force_n: 3.0,
        mean_error: Some(error),
        bias: Some(error),
        spread: Some(0.0),
        samples: 1,
        answered: 1,
        warned: None,
        covered: None,
        covered_warned: None,
    };
    AccuracyMap { request, truth: TruthId::Lattice, estimator, noise_mm: 0.0, cells: vec![cell] }
}

/// A study with 2 and 4 segments per plate member. With 4 segments instead of 2, the error is an eighth as large at 1 N, and a sixteenth as large at
/// 5 N.
pub fn sample() -> LatticeStudy {
    let row = |fineness: usize, errors: [f64; 2], settling| FinenessRow {
        fineness,
        bodies: 40 * fineness,
        springs: 200 * fineness,
        forces_n: vec![1.0, 5.0],
        errors: errors.into(),
        newton_ms: 12.3,
        settling,
    };
    let loads =
        LoadGrid { nodes: vec![NodeId(14), NodeId(18)], angles_deg: vec![-60.0, 60.0], forces_n: vec![1.0, 5.0] };
    let axial = AXIAL_SPRINGS.into_iter().zip([Some(0.0016), Some(0.03), Some(0.7), None]);
    let settling = SETTLINGS.into_iter().zip([Some(0.02), Some(5e-4), Some(6e-5), Some(6e-5), Some(7e-4)]);
    let (least_squares, nonlinear) = (map(EstimatorId::LeastSquares, 0.2), map(EstimatorId::Nonlinear, 4e-4));
    LatticeStudy {
        rows: vec![
            row(2, [8e-4, 1.6e-3], Some(SettlingCost { error: 1e-5, steps: 2331, ms: 512.4 })),
            row(4, [1e-4, 1e-4], None),
        ],
        loads: [loads.clone(), loads.clone()],
        axial: axial
            .map(|((name, axial), error)| AxialRow { name, axial, errors: error.map(|error| vec![error; 2]) })
            .collect(),
        axial_forces_n: vec![1.0, 5.0],
        settling: settling
            .map(|((sweeps, positions), error)| SettlingRow { sweeps, positions, error, steps: Some(2000) })
            .collect(),
        settled: loads,
        out_of_balance: 6e-4,
        problem_checks: Vec::new(),
        comparisons: Vec::new(),
        linear: vec![(1.0, 0.1), (5.0, 0.5)],
        sensing: LatticeSensing {
            difference: MapDifference::of(&least_squares, &map(EstimatorId::LeastSquares, 0.2003)),
            least_squares,
            nonlinear,
            others: Vec::new(),
        },
    }
}
