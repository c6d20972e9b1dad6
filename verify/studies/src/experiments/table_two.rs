//! The protocol of Table II of Xu et al. (2021): forces of 0.3 to 3 N on one node, on two neighbours and on two distant nodes.
//!
//! The paper measures on its gripper, at the nodes of sec. V-C, and lists the mean over the tests of each group.

use crate::prelude::*;
use crate::settings::TWO_FORCES_N;

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

/// Condition number: largest over smallest singular value of the displacements of all markers under unit forces along the normal.
pub(crate) fn condition_number(finger: &Finger, nodes: &[NodeId]) -> Result<f64, SensingError> {
    let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
    let estimator = LinearEstimator::new(finger, &contacts, &Measurement::at_rest(finger))?;
    let values = estimator.singular_values();
    Ok(values.first().zip(values.last()).map_or(1.0, |(largest, smallest)| largest / smallest))
}
