//! Sensing of random forces under camera noise: one contact and two.

use super::{CAMERA_NOISE_MM, Effort, Progress};
use crate::check::{Check, Kind, worst};
use crate::estimators::{BeamEstimator, ELEMENTS, Estimator, EstimatorError, EstimatorKind};
use crate::scatter::{self, ONE_FORCE_N, ScatterRequest, ScatterRow, TWO_FORCES_N};
use crate::table_two::condition_number;
use finray_model::{Finger, Kinematics, Mesh, NodeId};

/// Mean error of one force that is promised at nodes 14 to 24; the Cramer-Rao bound comes nearest to it at node 24, 1.2 %.
const ONE_FORCE_PROMISE: f64 = 0.013;
/// A mean of so many relative errors is known to 3.5 %: they scatter by 1.1 of their mean, and the bound at node 24 is 8 %
/// below the promise. Fewer cases would pass or fail by chance.
const ENOUGH_CASES: usize = 1000;
/// Cases of a pair from which on its promise is held as it stands. With fewer, two standard errors of a mean are allowed, as
/// neighbours have their bound right below the promise; relative errors of evenly drawn forces scatter by so many times their
/// mean.
const ENOUGH_PAIR_CASES: usize = 2000;
const MEAN_SCATTER: f64 = 1.1;
const MEAN_STANDARD_ERRORS: f64 = 2.0;
const PROMISED_NODES: std::ops::RangeInclusive<usize> = 14..=24;
/// Contact nodes of which the mean error of a force (both forces taken together) is promised, and that error.
const PROMISED_PAIRS: [([usize; 2], f64); 4] =
    [([19, 20], 0.03), ([16, 17], 0.03), ([18, 20], 0.012), ([16, 20], 0.012)];
/// Mean error of the sum of two forces that is promised for them.
const SUM_PROMISE: f64 = 0.008;
/// Promised of every pair: root mean square errors within this share of the Cramer-Rao bound.
const BOUND_PROMISE: f64 = 0.10;
/// Chance is allowed so many of its standard errors: among two hundred figures one beyond them is met once in eighty runs.
const STANDARD_ERRORS: f64 = 4.0;

/// Random forces sensed from noisy pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseStudy {
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// One contact node each, forces of [`ONE_FORCE_N`], by the nonlinear estimator.
    pub single: Vec<ScatterRow>,
    /// Every pair of contact nodes, forces of [`TWO_FORCES_N`], by the nonlinear estimator; none in a quick study.
    pub pairs: Vec<ScatterRow>,
    /// The same pictures by linear least squares.
    pub linear_pairs: Vec<ScatterRow>,
    /// Largest over smallest singular value of the linear finger's compliance, by `pairs`.
    pub condition_numbers: Vec<f64>,
    /// Pairs of the paper's finger for which errors are promised, by the nonlinear estimator, in more cases.
    pub promised: Vec<ScatterRow>,
}

/// Random cases for each set of contacts.
struct Cases {
    single: usize,
    pairs: usize,
    promised: usize,
}

impl Cases {
    fn of(effort: Effort) -> Cases {
        match effort {
            Effort::Quick => Cases { single: 20, pairs: 0, promised: 100 },
            Effort::Full => Cases { single: 1000, pairs: 200, promised: 2000 },
        }
    }
}

impl NoiseStudy {
    pub(super) fn run(
        finger: &Finger,
        truth: &Mesh,
        noise_mm: f64,
        is_paper: bool,
        effort: Effort,
        progress: &dyn Progress,
    ) -> Result<NoiseStudy, EstimatorError> {
        let cases = Cases::of(effort);
        let nodes = scatter::sampled_nodes(finger);
        let singles = scatter::singles(&nodes);
        let pairs = if cases.pairs > 0 { scatter::pairs(&nodes) } else { Vec::new() };
        let promised: Vec<Vec<NodeId>> = match is_paper {
            true => PROMISED_PAIRS.map(|(nodes, _)| nodes.map(NodeId).to_vec()).into(),
            false => Vec::new(),
        };
        progress.part("noise", singles.len() + pairs.len() + promised.len());
        let model = Mesh::with_elements_per_member(finger, ELEMENTS);
        let [nonlinear, linear] =
            [EstimatorKind::Nonlinear, EstimatorKind::LeastSquares].map(|kind| BeamEstimator::new(kind, &model));
        let run = |sets: &[Vec<NodeId>], range_n, cases, estimators: &[&dyn Estimator]| {
            let request = ScatterRequest {
                truth,
                kinematics: Kinematics::Corotational,
                model: &model,
                noise_levels_mm: &[noise_mm],
                cases,
                seed: 1,
            };
            scatter::scatter(&request, estimators, sets, range_n, &|| progress.step())
        };
        let both = run(&pairs, TWO_FORCES_N, cases.pairs, &[&nonlinear, &linear])?;
        let (nonlinear_pairs, linear_pairs) = both.into_iter().partition(|row| row.estimator == nonlinear.name());
        Ok(NoiseStudy {
            noise_mm,
            single: run(&singles, ONE_FORCE_N, cases.single, &[&nonlinear])?,
            pairs: nonlinear_pairs,
            linear_pairs,
            condition_numbers: pairs.iter().map(|pair| condition_number(finger, pair)).collect::<Result<_, _>>()?,
            promised: run(&promised, TWO_FORCES_N, cases.promised, &[&nonlinear])?,
        })
    }

    /// What is promised of the paper's finger under the camera's noise.
    pub fn checks(&self) -> Vec<Check> {
        if self.noise_mm != CAMERA_NOISE_MM {
            return Vec::new();
        }
        let row = |nodes: String, quantity: String, ours: Option<f64>, cases: usize, promise: f64| {
            let problem = format!("nonlinear sensing at {nodes}, {} mm noise", self.noise_mm);
            let quantity = format!("{quantity}, {cases} cases");
            Check::new(Kind::Internal, problem, "true forces", quantity, 0.0, ours.unwrap_or(f64::NAN), promise)
        };
        let mut checks = Vec::new();
        let told = |row: &&ScatterRow| PROMISED_NODES.contains(&row.nodes[0]) && row.cases >= ENOUGH_CASES;
        for single in self.single.iter().filter(told) {
            let node = format!("node {}", single.nodes[0]);
            let quantity = format!("mean error of a force of {} to {} N", ONE_FORCE_N[0], ONE_FORCE_N[1]);
            checks.push(row(node, quantity, single.mean_error(), single.cases, ONE_FORCE_PROMISE));
        }
        for (pair, (_, promise)) in self.promised.iter().zip(PROMISED_PAIRS) {
            let nodes = format!("nodes {} and {}", pair.nodes[0], pair.nodes[1]);
            let each = format!("mean error of each force of {} to {} N", TWO_FORCES_N[0], TWO_FORCES_N[1]);
            let sum = pair.sum.map(|sum| sum.mean_error);
            for (what, ours, promise) in
                [(each, pair.mean_error(), promise), ("mean error of the sum".to_owned(), sum, SUM_PROMISE)]
            {
                let (quantity, chance) = if pair.cases >= ENOUGH_PAIR_CASES {
                    (what, 0.0)
                } else {
                    let chance = MEAN_STANDARD_ERRORS * MEAN_SCATTER / (pair.cases as f64).sqrt();
                    (format!("{what}; {promise} promised, chance may add {:.0} % of it", 100.0 * chance), chance)
                };
                checks.push(row(nodes.clone(), quantity, ours, pair.cases, promise * (1.0 + chance)));
            }
        }
        checks.extend(self.bound_check());
        checks
    }

    /// All pairs reach the bound; none where no pairs were sensed.
    fn bound_check(&self) -> Option<Check> {
        let fewest = self.pairs.iter().map(|row| row.cases).min()?;
        let quantities = self.pairs.iter().flat_map(|row| row.forces.iter().chain(&row.sum));
        let off = worst(quantities.map(|s| s.bound.map_or(f64::NAN, |bound| (bound.over_bound - 1.0).abs())));
        // The standard error of a root mean square of so many normal errors, as a share of it.
        let chance = STANDARD_ERRORS / (2.0 * fewest as f64).sqrt();
        let quantity = format!(
            "error over bound less one, forces and sums, farthest; {BOUND_PROMISE} promised, chance may add {chance:.2} in \
             {fewest} cases a pair"
        );
        let problem = format!("nonlinear sensing at {} pairs of nodes, {} mm noise", self.pairs.len(), self.noise_mm);
        Some(Check::new(Kind::Internal, problem, "Cramer-Rao bound", quantity, 0.0, off, BOUND_PROMISE + chance))
    }
}
