//! The protocol of Table II of Xu et al. (2021): forces of 0.3 to 3 N on one node, on two neighbours and on two nodes apart.
//!
//! The paper measures on its gripper; here a finger of known kinematics stands for it, seen without and with camera noise,
//! and every estimator senses the same pictures.

use crate::estimators::{BeamEstimator, ELEMENTS, Estimator, EstimatorError, EstimatorKind};
use crate::scatter::{ScatterRequest, ScatterRow, TWO_FORCES_N, scatter};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, LinearEstimator, SensingError};
use finray_model::{Finger, Kinematics, Mesh, NodeId, statics};

/// Contact nodes, and the paper's mean errors for as many nodes as near to each other (sec. V-C). The paper does not say
/// which nodes it touched; these lie in the middle of the front plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSet {
    /// What the paper calls it.
    pub name: &'static str,
    /// The contact nodes.
    pub nodes: &'static [usize],
    /// The paper's mean error of each force.
    pub paper_force: f64,
    /// The paper's mean error of their sum, of several.
    pub paper_sum: Option<f64>,
}

/// The rows of the paper's table.
pub const CONTACT_SETS: [ContactSet; 3] = [
    ContactSet { name: "one node", nodes: &[19], paper_force: 0.065, paper_sum: None },
    ContactSet { name: "neighbours", nodes: &[19, 20], paper_force: 0.475, paper_sum: Some(0.074) },
    ContactSet { name: "apart", nodes: &[18, 20], paper_force: 0.298, paper_sum: Some(0.076) },
];

/// Range of each force, N (sec. V-C).
pub const FORCES_N: [f64; 2] = TWO_FORCES_N;

/// Cases for the nonlinear estimator on the linear finger, whose shapes no large-rotation finger takes: it searches from
/// every start and often refuses, a hundred times slower than where it fits.
pub const CASES_WITHOUT_FIT: usize = 40;
/// And no more than this share of the cases.
const SHARE_WITHOUT_FIT: usize = 4;
/// Most cases for the nonlinear estimator, which takes as long as everything else together: a mean error is known to 4 %.
pub const MOST_FITS: usize = 1000;
/// How often progress is reported.
pub const STEPS: usize = 4 * CONTACT_SETS.len();
/// Seed of forces and noise.
const SEED: u64 = 1;

/// Table II on two fingers.
#[derive(Debug, Clone, PartialEq)]
pub struct TableTwo {
    /// Random cases for each set of contacts; the nonlinear estimator senses the first of them, [`MOST_FITS`] and on the
    /// linear finger a quarter of them, at most [`CASES_WITHOUT_FIT`].
    pub cases: usize,
    /// Largest over smallest singular value of the compliance at the markers, of the linear finger, by [`CONTACT_SETS`]: a
    /// wrong shape shows in the forces by up to so many times its share.
    pub condition_numbers: Vec<f64>,
    /// By the finger that is sensed.
    pub fingers: Vec<TableTwoFinger>,
}

/// Table II on one finger.
#[derive(Debug, Clone, PartialEq)]
pub struct TableTwoFinger {
    /// Name of the truth.
    pub truth: &'static str,
    /// By [`CONTACT_SETS`], level of noise, estimator.
    pub rows: Vec<ScatterRow>,
}

impl TableTwo {
    /// What one estimator makes of one finger at one level of noise, by [`CONTACT_SETS`].
    pub fn of<'t>(&'t self, truth: &str, noise_mm: f64, estimator: &str) -> impl Iterator<Item = &'t ScatterRow> {
        let finger = self.fingers.iter().find(|finger| finger.truth == truth);
        let rows = finger.map_or(&[][..], |finger| &finger.rows);
        rows.iter().filter(move |row| row.noise_mm == noise_mm && row.estimator == estimator)
    }
}

/// Runs the protocol on the linear finger and on `fine`, the mesh of the one with large rotations: least squares, ridge,
/// `further` estimators and the nonlinear one. `progress` is called after each set of contacts, [`STEPS`] times in all.
///
/// # Errors
/// [`EstimatorError`] for a finger without these nodes, or an estimator that is not made for one of the sets.
pub fn table_two(
    fine: &Mesh,
    noise_levels_mm: &[f64],
    cases: usize,
    further: &[&dyn Estimator],
    progress: &(dyn Fn() + Sync),
) -> Result<TableTwo, EstimatorError> {
    let finger = fine.finger();
    let key_nodes = Mesh::key_nodes(finger);
    let model = Mesh::with_elements_per_member(finger, ELEMENTS);
    let [least_squares, ridge, nonlinear] =
        [EstimatorKind::LeastSquares, EstimatorKind::Ridge, EstimatorKind::Nonlinear]
            .map(|kind| BeamEstimator::new(kind, &model));
    let sets = CONTACT_SETS.map(|set| set.nodes.iter().map(|&node| NodeId(node)).collect::<Vec<_>>());
    let run = |mesh, kinematics, cases, estimators: &[&dyn Estimator]| {
        // The bound changes little with the mesh: the coarsest serves.
        let request = ScatterRequest { truth: mesh, kinematics, model: &key_nodes, noise_levels_mm, cases, seed: SEED };
        scatter(&request, estimators, &sets, FORCES_N, progress)
    };
    let others = [&[&least_squares as &dyn Estimator, &ridge], further].concat();
    let mut linear = run(&key_nodes, Kinematics::Linear, cases, &others)?;
    linear.extend(run(
        &key_nodes,
        Kinematics::Linear,
        cases.div_ceil(SHARE_WITHOUT_FIT).min(CASES_WITHOUT_FIT),
        &[&nonlinear],
    )?);
    let mut corotational = run(fine, Kinematics::Corotational, cases, &others)?;
    corotational.extend(run(fine, Kinematics::Corotational, cases.min(MOST_FITS), &[&nonlinear])?);
    let fingers = vec![
        TableTwoFinger { truth: "linear", rows: linear },
        TableTwoFinger { truth: "corotational", rows: corotational },
    ];
    let condition_numbers = sets.iter().map(|set| condition_number(finger, set)).collect::<Result<_, _>>()?;
    Ok(TableTwo { cases, condition_numbers, fingers })
}

/// Largest over smallest singular value of the displacements of all markers under unit forces along the normal.
pub(crate) fn condition_number(finger: &Finger, nodes: &[NodeId]) -> Result<f64, EstimatorError> {
    let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
    let at_rest = statics::solve(&Mesh::key_nodes(finger), &[], Kinematics::Linear).map_err(SensingError::from)?;
    let estimator = LinearEstimator::new(finger, &contacts, &Measurement::of_shape(finger, &at_rest))?;
    let values = estimator.singular_values();
    Ok(values.first().zip(values.last()).map_or(1.0, |(largest, smallest)| largest / smallest))
}
