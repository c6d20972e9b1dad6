//! The protocol of Table II of Xu et al. (2021): forces of 0.3 to 3 N on one node, on two neighbours and on two distant nodes.
//!
//! The paper measures on its gripper, at the nodes of sec. V-C, and lists the mean over the tests of each group. Here a simulated finger with known
//! kinematics replaces the gripper, with and without camera noise. All estimators get the same samples.

use super::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::scatter::{ScatterRequest, ScatterRow, scatter};
use crate::settings::TWO_FORCES_N;
use crate::truths::TruthId;
use finray_model::estimators::network::NetworkSensing;

/// A row of the paper's table: the contacts of its tests (sec. V-C), and mean errors over these tests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactGroup {
    /// Short name of the group.
    pub name: &'static str,
    /// Contact nodes of each test.
    pub sets: &'static [&'static [usize]],
    /// The paper's mean relative error of each force.
    pub paper_force: f64,
    /// The paper's mean relative error of the sum of two forces; `None` for one force.
    pub paper_sum: Option<f64>,
}

/// The rows of the paper's table.
pub const CONTACT_GROUPS: [ContactGroup; 3] = [
    ContactGroup { name: "one node", sets: &[&[21], &[19], &[17]], paper_force: 0.065, paper_sum: None },
    ContactGroup { name: "neighbours", sets: &[&[19, 20], &[16, 17]], paper_force: 0.475, paper_sum: Some(0.074) },
    ContactGroup { name: "apart", sets: &[&[18, 20], &[16, 20]], paper_force: 0.298, paper_sum: Some(0.076) },
];
/// The paper's mean absolute error of a single force, N (sec. V-C, for forces of 0 to 3 N).
pub const PAPER_ERROR_N: f64 = 0.07;

/// Contact nodes of every test, in the order of the groups.
pub fn contact_sets() -> Vec<&'static [usize]> {
    CONTACT_GROUPS.iter().flat_map(|group| group.sets).copied().collect()
}

/// A set of contacts at which recipes for training networks are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedSet {
    /// Short name of the set.
    pub name: &'static str,
    /// Contact nodes.
    pub nodes: &'static [usize],
}

/// One set of contacts from each group.
pub const COMPARED_SETS: [ComparedSet; 3] = [
    ComparedSet { name: "node 19", nodes: &[19] },
    ComparedSet { name: "19 and 20", nodes: &[19, 20] },
    ComparedSet { name: "18 and 20", nodes: &[18, 20] },
];

/// Range of each force, N (sec. V-C).
pub const FORCES_N: [f64; 2] = TWO_FORCES_N;

/// Largest number of cases per set for the nonlinear estimator on the linear finger, whose shapes no co-rotational finger fits. For shapes that it
/// cannot fit, the search tries every starting point and takes a hundred times as long; the estimator often refuses.
pub const CASES_WITHOUT_FIT: usize = 20;
/// Divisor of the number of cases, for the cases that the nonlinear estimator senses on the linear finger.
const SHARE_WITHOUT_FIT: usize = 4;
/// Largest number of cases per set for the nonlinear estimator; this estimator takes as long as all other computations together. A mean error over
/// the sets of a group is known to 4 % with this number of cases. Relative errors have a standard deviation of 1.1 times their mean.
pub const MOST_FITS: usize = 500;
/// Number of times that [`table_two`] calls `progress`: four runs with one call for each set of contacts.
pub const STEPS: usize = 4 * {
    let [one, neighbours, apart] = CONTACT_GROUPS;
    one.sets.len() + neighbours.sets.len() + apart.sets.len()
};
const SEED: u64 = 1;

/// Results for Table II on two fingers.
#[derive(Debug, Clone, PartialEq)]
pub struct TableTwo {
    /// Number of random cases for each set of contacts. The nonlinear estimator senses at most the first [`MOST_FITS`] of these cases; on the linear
    /// finger it senses a quarter of them, at most [`CASES_WITHOUT_FIT`].
    pub cases: usize,
    /// Condition number of the linear compliance (largest over smallest singular value), for each of [`contact_sets`]. It states how strongly errors
    /// of the shape are amplified.
    pub condition_numbers: Vec<f64>,
    /// Results on each true finger.
    pub fingers: Vec<TableTwoFinger>,
}

/// Results for Table II on one finger.
#[derive(Debug, Clone, PartialEq)]
pub struct TableTwoFinger {
    /// Type of the true finger.
    pub truth: TruthId,
    /// Rows by contact set (in the order of [`contact_sets`]), noise level, and estimator.
    pub rows: Vec<ScatterRow>,
}

impl TableTwo {
    /// Errors of one estimator on one finger at one noise level (mm), one row for each of [`contact_sets`].
    pub fn of(&self, truth: TruthId, noise_mm: f64, estimator: EstimatorId) -> impl Iterator<Item = &ScatterRow> {
        let finger = self.fingers.iter().find(|finger| finger.truth == truth);
        let rows = finger.map_or(&[][..], |finger| &finger.rows);
        rows.iter().filter(move |row| row.noise_mm == noise_mm && row.estimator == estimator)
    }
}

/// Errors of an estimator in the tests of one group: means over the group's sets, as in the paper's table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupErrors {
    /// Mean relative error of each force.
    pub force: f64,
    /// Mean absolute error of each force, N.
    pub force_n: f64,
    /// Mean relative error of the sum of several forces; `None` for one force.
    pub sum: Option<f64>,
    /// Mean relative error of each force for an estimator that reaches the Cramer-Rao bound; `None` without noise.
    pub force_bound: Option<f64>,
    /// Mean relative error of the sum for an estimator that reaches the Cramer-Rao bound; `None` without noise or for one force.
    pub sum_bound: Option<f64>,
    /// Number of answered cases, over which the means are taken.
    pub answered: usize,
    /// Number of refused cases.
    pub refused: usize,
}

impl GroupErrors {
    /// Means over the rows of one estimator, one row for each set of the group. `None` if a set is missing or has no answered case.
    pub fn of<'r>(group: &ContactGroup, rows: impl IntoIterator<Item = &'r ScatterRow>) -> Option<GroupErrors> {
        let rows: Vec<&ScatterRow> = rows.into_iter().collect();
        let of_set = |nodes: &&[usize]| rows.iter().find(|row| row.nodes == *nodes).copied();
        let rows: Vec<&ScatterRow> = group.sets.iter().map(of_set).collect::<Option<_>>()?;
        let mean = |figure: &dyn Fn(&ScatterRow) -> Option<f64>| {
            mean(rows.iter().map(|row| figure(row)).collect::<Option<Vec<f64>>>()?)
        };
        // The sum of a single force is the force itself, so its error is not stated again.
        let several = |figure: Option<f64>| figure.filter(|_| group.paper_sum.is_some());
        Some(GroupErrors {
            force: mean(&ScatterRow::mean_error)?,
            force_n: mean(&ScatterRow::mean_error_n)?,
            sum: several(mean(&|row| Some(row.sum?.mean_error))),
            force_bound: mean(&ScatterRow::mean_error_bound),
            sum_bound: several(mean(&|row| Some(row.sum?.bound?.mean_error_bound))),
            answered: rows.iter().map(|row| row.cases).sum(),
            refused: rows.iter().map(|row| row.refused).sum(),
        })
    }
}

impl TableTwo {
    /// Errors of one estimator in a group of tests on one finger at one noise level (mm).
    pub fn group(
        &self,
        group: &ContactGroup,
        truth: TruthId,
        noise_mm: f64,
        estimator: EstimatorId,
    ) -> Option<GroupErrors> {
        GroupErrors::of(group, self.of(truth, noise_mm, estimator))
    }

    /// Smallest and largest condition number of a group's sets.
    pub fn condition_range(&self, group: &ContactGroup) -> Option<[f64; 2]> {
        let of_sets = contact_sets().into_iter().zip(&self.condition_numbers);
        let numbers = of_sets.filter(|(set, _)| group.sets.contains(set)).map(|(_, number)| *number);
        Span::of(numbers).map(Span::ends)
    }
}

impl Evidence for TableTwo {}

/// Table II by every estimator; `None` unless the finger is the paper's.
pub(crate) fn run(context: &Context) -> Result<Option<TableTwo>, EstimatorError> {
    if !context.is_paper {
        return Ok(None);
    }
    let sensing = NetworkSensing { networks: context.networks, finger: context.finger, refuses: true };
    let [cases, _] = context.effort.sensed_cases();
    context.progress.part("Table II", STEPS);
    let step = || context.progress.step();
    table_two(context.fine, &context.noise_levels_mm(), cases, &[&sensing], &step).map(Some)
}

/// Runs the protocol on the linear finger and on `fine`, the mesh of the co-rotational finger, at the given noise levels (mm). Estimators are least
/// squares, ridge, the `further` estimators and the nonlinear estimator. `progress` is called after each set of contacts, [`STEPS`] times in all.
///
/// # Errors
/// [`EstimatorError`] for a finger without the nodes of Table II, or an estimator that does not support one of the sets.
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
        [BeamEstimator::least_squares, BeamEstimator::ridge, BeamEstimator::nonlinear]
            .map(|estimator| estimator(&model).of_noise_alone());
    let sets: Vec<Vec<NodeId>> =
        contact_sets().iter().map(|set| set.iter().map(|&node| NodeId(node)).collect()).collect();
    let run = |mesh, kinematics, cases, estimators: &[&dyn Estimator]| {
        // The Cramer-Rao bound depends little on the mesh, so the coarsest mesh suffices.
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
        TableTwoFinger { truth: TruthId::Linear, rows: linear },
        TableTwoFinger { truth: TruthId::Corotational, rows: corotational },
    ];
    let condition_numbers = sets.iter().map(|set| condition_number(finger, set)).collect::<Result<_, _>>()?;
    Ok(TableTwo { cases, condition_numbers, fingers })
}

/// Condition number: largest over smallest singular value of the displacements of all markers under unit forces along the normal.
pub(crate) fn condition_number(finger: &Finger, nodes: &[NodeId]) -> Result<f64, EstimatorError> {
    let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
    let estimator = LinearEstimator::new(finger, &contacts, &Measurement::at_rest(finger))?;
    let values = estimator.singular_values();
    Ok(values.first().zip(values.last()).map_or(1.0, |(largest, smallest)| largest / smallest))
}
