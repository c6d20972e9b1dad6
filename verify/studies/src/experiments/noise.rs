//! Sensing of random forces under camera noise, with one contact and with two.

use super::{Context, Evidence};
use crate::experiments::table_two::condition_number;
use crate::prelude::*;
use crate::sampling::scatter::{self, Controlled, Counts, ScatterRequest, ScatterRow};
use crate::settings::{ONE_FORCE_N, TWO_FORCES_N};

/// Tolerance of the mean relative error of one force at nodes 14 to 24. The mean error at the Cramer-Rao bound is largest at node 24: 1.2 %.
const ONE_FORCE_TOLERANCE: f64 = 0.013;
/// Checks of single nodes require at least this number of drawn cases. With 1000 cases, the ratio of a mean relative error to its bound is known to 3
/// %, a third of the ratio's tolerance. Refused cases count as drawn, so that they cannot remove a check.
const ENOUGH_CASES: usize = 1000;
/// With at least this number of drawn cases, a pair's tolerance has no allowance for chance. With fewer cases, two standard errors are added to the
/// tolerance, because the bound for neighbouring nodes is just below the tolerance. Relative errors of uniformly drawn forces have a standard
/// deviation of `MEAN_SCATTER` times their mean.
const ENOUGH_PAIR_CASES: usize = 2000;
const MEAN_SCATTER: f64 = 1.1;
const MEAN_STANDARD_ERRORS: f64 = 2.0;
/// Contact nodes with checked errors.
pub const CHECKED_NODES: std::ops::RangeInclusive<usize> = 14..=24;
/// Pairs of contact nodes, each with the tolerance of its mean relative error, averaged over both forces.
pub const CHECKED_PAIRS: [([usize; 2], f64); 4] =
    [([19, 20], 0.03), ([16, 17], 0.03), ([18, 20], 0.012), ([16, 20], 0.012)];
/// Tolerance of the relative difference from the Cramer-Rao bound. It applies to mean errors of single nodes and of sums, and to root mean square
/// errors of every pair.
pub const BOUND_TOLERANCE: f64 = 0.10;
/// Tolerance of the standard error of a figure that is checked with [`BOUND_TOLERANCE`]. Chance then cannot hide a difference of twice
/// [`BOUND_TOLERANCE`], which exceeds the tolerance by four standard errors. The standard error is 2 % for neighbouring nodes, and a few tenths of a
/// per cent for distant nodes.
pub const BOUND_STANDARD_ERROR: f64 = BOUND_TOLERANCE / 4.0;

/// Results of sensing random forces under camera noise.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseStudy {
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Results of single contact nodes under forces of [`ONE_FORCE_N`] (scaled for fingers other than the paper's), by the nonlinear estimator.
    pub single: Vec<ScatterRow>,
    /// Results of every pair of contact nodes under forces of [`TWO_FORCES_N`] (scaled for fingers other than the paper's), by the nonlinear
    /// estimator. Empty in a quick study.
    pub pairs: Vec<ScatterRow>,
    /// Results of every pair by linear least squares, with the samples of `pairs`.
    pub linear_pairs: Vec<ScatterRow>,
    /// Condition number of the linear finger's compliance (largest over smallest singular value), one for each of `pairs`.
    pub condition_numbers: Vec<f64>,
    /// Results of the checked pairs of the paper's finger, by the nonlinear estimator, with more cases.
    pub checked: Vec<ScatterRow>,
}

/// Names of the two references in checks: the applied forces, and the Cramer-Rao bound of the same model.
const TRUE_FORCES: &str = "true forces";
const BOUND: &str = "Cramer-Rao bound";

/// Numbers of random cases for each set of contacts.
struct Cases {
    single: usize,
    pairs: usize,
    checked: usize,
}

impl Cases {
    /// Pairs of the paper's finger have more cases, because their figures are checked against [`BOUND_STANDARD_ERROR`]. The figures of other fingers
    /// are shown, but not checked. For other fingers, control variates allow half as many cases: with 100 cases, the standard error of a mean error
    /// is 9 %. Without control variates it is 14 %.
    fn of(effort: Effort, is_paper: bool) -> Cases {
        match effort {
            Effort::Quick => Cases { single: 20, pairs: 0, checked: 100 },
            Effort::Full => Cases { single: 1000, pairs: if is_paper { 200 } else { 100 }, checked: 2000 },
        }
    }
}

impl Evidence for NoiseStudy {
    fn checks(&self, context: &Context) -> Vec<Check> {
        if context.is_paper { self.checks() } else { Vec::new() }
    }
}

/// Runs the study for a report; `None` without noise.
pub(crate) fn run(context: &Context) -> Result<Option<NoiseStudy>, Refusal> {
    (context.noise_mm > 0.0).then(|| NoiseStudy::run(context)).transpose()
}

impl NoiseStudy {
    fn run(context: &Context) -> Result<NoiseStudy, Refusal> {
        let &Context { finger, fine: truth, noise_mm, is_paper, progress, .. } = context;
        let [one_n, two_n] = [ONE_FORCE_N, TWO_FORCES_N].map(|range_n| context.checked_forces().scaled(range_n));
        let cases = Cases::of(context.effort, is_paper);
        let nodes = scatter::sampled_nodes(finger);
        let singles = scatter::singles(&nodes);
        let pairs = if cases.pairs > 0 { scatter::pairs(&nodes) } else { Vec::new() };
        let checked: Vec<Vec<NodeId>> = match is_paper {
            true => CHECKED_PAIRS.map(|(nodes, _)| nodes.map(NodeId).to_vec()).into(),
            false => Vec::new(),
        };
        progress.part("noise", singles.len() + pairs.len() + checked.len());
        let model = Mesh::with_elements_per_member(finger, ELEMENTS);
        let [nonlinear, least_squares] = [EstimatorId::Nonlinear, EstimatorId::LeastSquares].map(SensorOptions::of);
        let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
        let noise_levels_mm = [noise_mm];
        let request = |cases| ScatterRequest {
            truth,
            kinematics: Kinematics::Corotational,
            model: &model,
            scene: &scene,
            noise_levels_mm: &noise_levels_mm,
            cases,
            seed: 1,
        };
        let step = || progress.step();
        let alone = std::slice::from_ref(&nonlinear);
        let run = |sets: &[Vec<NodeId>], range_n, cases| scatter::scatter(&request(cases), alone, sets, range_n, &step);
        let both = scatter::scatter(&request(cases.pairs), &[nonlinear.clone(), least_squares], &pairs, two_n, &step)?;
        let (mut nonlinear_pairs, linear_pairs): (Vec<ScatterRow>, Vec<ScatterRow>) =
            both.into_iter().partition(|row| row.estimator == EstimatorId::Nonlinear);
        // On the paper's finger, pairs that exceed the tolerance, or are too close to it for a verdict, are computed again with more, newly drawn
        // cases.
        let is_open = |&i: &usize| is_paper && nonlinear_pairs[i].is_near_tolerance(BOUND_TOLERANCE);
        let open: Vec<usize> = (0..pairs.len()).filter(is_open).collect();
        let sets: Vec<Vec<NodeId>> = open.iter().map(|&i| pairs[i].clone()).collect();
        let again = scatter::scatter(&request(ENOUGH_PAIR_CASES), alone, &sets, two_n, &|| ())?;
        for (i, row) in open.into_iter().zip(again) {
            nonlinear_pairs[i] = row;
        }
        Ok(NoiseStudy {
            noise_mm,
            single: run(&singles, one_n, cases.single)?,
            pairs: nonlinear_pairs,
            linear_pairs,
            condition_numbers: pairs.iter().map(|pair| condition_number(finger, pair)).collect::<Result<_, _>>()?,
            checked: run(&checked, two_n, cases.checked)?,
        })
    }

    /// Checks of the paper's finger under the camera's noise. The number of drawn cases decides which checks apply; a refused case fails its check.
    pub fn checks(&self) -> Vec<Check> {
        if self.noise_mm != CAMERA_NOISE_MM {
            return Vec::new();
        }
        let mut checks = self.node_checks();
        for (pair, (_, limit)) in self.checked.iter().zip(CHECKED_PAIRS) {
            checks.extend(self.pair_checks(pair, limit));
        }
        checks.extend(self.bound_checks());
        checks
    }

    fn check(&self, at: &str, source: &str, quantity: String, figures: [f64; 3], rows: &[&ScatterRow]) -> Check {
        let counts = Counts::of(rows.iter().copied());
        let problem = format!("nonlinear sensing at {at}, {} mm noise", self.noise_mm);
        let quantity = format!("{quantity}, {} cases drawn", counts.drawn);
        let [reference, ours, tolerance] = figures;
        Check::new(Kind::Internal, problem, source, quantity, reference, ours, tolerance)
            .with_refused(counts.refused, counts.drawn)
    }

    /// Checks of each node against its bound, and of the worst node against the tolerance; empty if too few cases were drawn.
    fn node_checks(&self) -> Vec<Check> {
        if self.single.iter().map(ScatterRow::drawn).max().is_none_or(|most| most < ENOUGH_CASES) {
            return Vec::new();
        }
        // A node without a row, or without equilibrium, gives NaN, and its check fails.
        let row = |node: usize| self.single.iter().find(move |row| row.nodes == [node]);
        let over_bound = |node: usize| Some(row(node)?.mean_error()? / row(node)?.mean_error_bound()?);
        let of_node = |node: usize| {
            let figures = [1.0, over_bound(node).unwrap_or(f64::NAN), BOUND_TOLERANCE];
            let rows: Vec<&ScatterRow> = row(node).into_iter().collect();
            self.check(
                &format!("node {node}"),
                BOUND,
                "mean error of a force / mean error at the Cramer-Rao bound".to_owned(),
                figures,
                &rows,
            )
        };
        let worst = worst(CHECKED_NODES.map(|node| row(node).and_then(ScatterRow::mean_error).unwrap_or(f64::NAN)));
        let rows: Vec<&ScatterRow> = CHECKED_NODES.filter_map(row).collect();
        let quantity = format!("largest mean error of a force of {} to {} N", ONE_FORCE_N[0], ONE_FORCE_N[1]);
        let figures = [0.0, worst, ONE_FORCE_TOLERANCE];
        let all = self.check("nodes 14 to 24", TRUE_FORCES, quantity, figures, &rows);
        CHECKED_NODES.map(of_node).chain([all]).collect()
    }

    /// Checks of a pair: its forces against their limit, and the sum against its bound.
    fn pair_checks(&self, pair: &ScatterRow, limit: f64) -> [Check; 2] {
        let drawn = pair.drawn();
        let chance = match drawn {
            enough if enough >= ENOUGH_PAIR_CASES => 0.0,
            few => MEAN_STANDARD_ERRORS * MEAN_SCATTER / (few as f64).sqrt(),
        };
        let said = |what: String| match chance {
            0.0 => what,
            chance => format!("{what}; chance may add {:.0} %", 100.0 * chance),
        };
        let at = format!("nodes {} and {}", pair.nodes[0], pair.nodes[1]);
        let each = format!("mean error of each force of {} to {} N", TWO_FORCES_N[0], TWO_FORCES_N[1]);
        let each_figures = [0.0, pair.mean_error().unwrap_or(f64::NAN), limit * (1.0 + chance)];
        let sum = pair.sum.and_then(|sum| Some(sum.mean_error / sum.bound?.mean_error_bound));
        let sum_figures = [1.0, sum.unwrap_or(f64::NAN), BOUND_TOLERANCE + chance];
        [
            self.check(&at, TRUE_FORCES, said(each), each_figures, &[pair]),
            self.check(
                &at,
                BOUND,
                said("mean error of the sum / mean error at the Cramer-Rao bound".to_owned()),
                sum_figures,
                &[pair],
            ),
        ]
    }

    /// Checks that all pairs reach the bound within 10 %, and that standard errors are small enough; empty without pairs.
    fn bound_checks(&self) -> Vec<Check> {
        if self.pairs.is_empty() {
            return Vec::new();
        }
        let figures: Vec<Option<Controlled>> = self
            .pairs
            .iter()
            .flat_map(|row| row.forces.iter().chain(&row.sum).map(|scatter| scatter.bound?.controlled))
            .collect();
        // A pair lacks a figure if the finger has no equilibrium or the bound does not exist.
        let complete = figures.len() == 3 * self.pairs.len();
        let over_all = |figure: fn(Controlled) -> f64| {
            if complete { worst(figures.iter().map(|found| found.map_or(f64::NAN, figure))) } else { f64::NAN }
        };
        let off = over_all(|found| (found.over_bound_controlled - 1.0).abs());
        let chance = over_all(|found| found.standard_error);
        let rows: Vec<&ScatterRow> = self.pairs.iter().collect();
        let at = format!("{} pairs of nodes", self.pairs.len());
        let farthest = "largest difference of (root mean square error / bound) from 1, forces and sums".to_owned();
        let standard_error = "largest standard error of these ratios".to_owned();
        vec![
            self.check(&at, BOUND, farthest, [0.0, off, BOUND_TOLERANCE], &rows),
            self.check(&at, BOUND, standard_error, [0.0, chance, BOUND_STANDARD_ERROR], &rows),
        ]
    }
}
