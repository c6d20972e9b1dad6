//! Accuracy of the shipped networks on the co-rotational finger under camera noise, with its tolerances.

use crate::experiments::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::scatter::{ScatterRequest, ScatterRow, scatter};
use crate::settings::{CAMERA_NOISE_MM, ENOUGH_CASES, TWO_FORCES_N};
use finray_model::estimators::network::Networks;

/// Range of each force, N.
pub const FORCES_N: [f64; 2] = TWO_FORCES_N;
/// Relative allowance for chance in a mean error over n cases, multiplied by sqrt(n): three standard errors. Relative errors have a standard
/// deviation of 1.1 times their mean.
const CHANCE: f64 = 3.3;
/// Tolerance of the mean relative error of the sum of two forces.
const SUM_ERROR: f64 = 0.01;
/// Tolerance of a mean error, as a multiple of the error at the Cramer-Rao bound. The error of a force was at most 7 % above its bound; this excess
/// is known within 2 %. The error of a sum was up to 59 % above its bound: the noise of neighbours cancels in a sum, but the networks' own errors
/// need not cancel.
const OVER_BOUND: f64 = 1.10;
const SUM_OVER_BOUND: f64 = 1.70;
const SEED: u64 = 2;

/// A set of contact nodes, with the tolerance of the mean error of each force at the camera's noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckedSet {
    /// Nodes at which the forces act.
    pub nodes: &'static [usize],
    /// Tolerance of the mean relative error of each force.
    pub force: f64,
}

/// Single contact nodes, two pairs of neighbours and two distant pairs. The mean error at the Cramer-Rao bound is 1.5 % at node 24, and 2.1 % for the
/// pair of nodes 19 and 20.
pub const CHECKED_SETS: [CheckedSet; 15] = {
    const fn set(nodes: &'static [usize], force: f64) -> CheckedSet {
        CheckedSet { nodes, force }
    }
    const ONE: f64 = 0.016;
    const NEIGHBOURS: f64 = 0.04;
    const APART: f64 = 0.02;
    [
        set(&[14], ONE),
        set(&[15], ONE),
        set(&[16], ONE),
        set(&[17], ONE),
        set(&[18], ONE),
        set(&[19], ONE),
        set(&[20], ONE),
        set(&[21], ONE),
        set(&[22], ONE),
        set(&[23], ONE),
        set(&[24], ONE),
        set(&[19, 20], NEIGHBOURS),
        set(&[16, 17], NEIGHBOURS),
        set(&[18, 20], APART),
        set(&[16, 20], APART),
    ]
};

/// Results of the shipped networks on the co-rotational finger with the fine mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkStudy {
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// One row for each of [`CHECKED_SETS`], with forces in the range [`FORCES_N`].
    pub rows: Vec<ScatterRow>,
}

impl Evidence for NetworkStudy {
    fn checks(&self, _: &Context) -> Vec<Check> {
        self.checks()
    }
}

/// Study of the shipped networks under noise; `None` without noise, or for a finger that is not the paper's.
pub(crate) fn run(context: &Context) -> Result<Option<NetworkStudy>, Refusal> {
    if !context.is_paper || context.noise_mm == 0.0 {
        return Ok(None);
    }
    context.progress.part("networks", CHECKED_SETS.len());
    let step = || context.progress.step();
    NetworkStudy::run(context.fine, context.networks, context.noise_mm, context.effort.sensed_cases(), &step).map(Some)
}

impl NetworkStudy {
    /// Senses `cases` random cases of each set of contacts on `fine`, the mesh of the true finger, with noise `noise_mm` (mm). `progress`
    /// is called after each set.
    ///
    /// # Errors
    /// [`Refusal`] for a finger or contacts without a shipped network.
    pub fn run(
        fine: &Mesh,
        networks: &Networks,
        noise_mm: f64,
        cases: usize,
        progress: &(dyn Fn() + Sync),
    ) -> Result<NetworkStudy, Refusal> {
        let finger = fine.finger();
        let network = SensorOptions { networks: networks.clone(), ..SensorOptions::of(EstimatorId::Network) };
        let sets: Vec<Vec<NodeId>> =
            CHECKED_SETS.iter().map(|set| set.nodes.iter().map(|&node| NodeId(node)).collect()).collect();
        // The Cramer-Rao bound depends little on the mesh, so the coarsest mesh suffices.
        let request = ScatterRequest {
            truth: fine,
            kinematics: Kinematics::Corotational,
            model: &Mesh::key_nodes(finger),
            scene: &Scene::of_finger(finger.clone()).into(),
            noise_levels_mm: &[noise_mm],
            cases,
            seed: SEED,
        };
        Ok(NetworkStudy { noise_mm, rows: scatter(&request, &[network], &sets, FORCES_N, progress)? })
    }

    /// Checks of all sets of contacts.
    pub fn checks(&self) -> Vec<Check> {
        self.rows.iter().flat_map(|row| self.checks_of(row)).collect()
    }

    /// Checks of one set of contacts: the error of each force and, for several forces, the error of their sum. The checks apply only to the camera's
    /// noise, for which the networks are trained. At another noise level, the list of checks is empty.
    pub fn checks_of(&self, row: &ScatterRow) -> Vec<Check> {
        let set = CHECKED_SETS.iter().find(|set| set.nodes == row.nodes);
        let Some(set) = set.filter(|_| self.noise_mm == CAMERA_NOISE_MM) else { return Vec::new() };
        let cases = row.drawn();
        let nodes = row.nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ");
        let problem = format!("network that ships, node{} {nodes}", if row.nodes.len() > 1 { "s" } else { "" });
        let subject = Kind::Internal.on(problem, "known forces");
        let check = |quantity: &str, error: Option<f64>, largest: f64| {
            let quantity = format!("mean error of {quantity}, {} mm noise, {cases} cases", self.noise_mm);
            let tolerance = largest * (1.0 + chance(cases));
            subject.vanishes(quantity, error.unwrap_or(f64::NAN), tolerance).with_refused(row.refused, cases)
        };
        // Without a bound the tolerance is NaN, and the check fails.
        let least = |aim: f64, bound: Option<f64>| bound.map_or(f64::NAN, |bound| aim.min(bound));
        let of_force = row.mean_error_bound().map(|bound| OVER_BOUND * bound);
        let of_sum = row.sum.and_then(|sum| Some(SUM_OVER_BOUND * sum.bound?.mean_error_bound));
        let each = check("each force", row.mean_error(), least(set.force, of_force));
        let sum = (row.nodes.len() > 1)
            .then(|| check("the sum", row.sum.map(|sum| sum.mean_error), least(SUM_ERROR, of_sum)));
        std::iter::once(each).chain(sum).collect()
    }
}

/// Relative allowance for chance in a mean error over few cases; 0 for enough cases.
fn chance(cases: usize) -> f64 {
    if cases < ENOUGH_CASES { CHANCE / (cases as f64).sqrt() } else { 0.0 }
}
