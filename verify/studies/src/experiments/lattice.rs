//! Study of the lattice: its error and the causes, its computation time, and the sensing of forces from its shapes.

use super::contact_scene::objects::Objects;
use super::contact_scene::study::SceneStudy;
use super::{Context, Evidence, ExperimentError};
use crate::lattice::accuracy::{FinenessRow, LoadGrid, study};
use crate::lattice::causes::{self, AxialRow, SettlingRow};
use crate::prelude::*;
use crate::problems::lattice::{FINENESS, NEWTON};
use crate::problems::{self, ProblemError};
use crate::sampling::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::sampling::sampled::SampledSensor;
use crate::sampling::sweep::MapCell;
use crate::truths::{LATTICE_FINENESS, TruthId};
use finray_lattice::settling::Precision;
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// Forces under which settings of axial springs are compared, N; rotations are negligible under the smallest force.
const AXIAL_FORCES_N: [f64; 3] = [0.1, 2.0, 5.0];
/// Largest fineness at which lattices are settled (simulated until rest); finer lattices need many seconds.
const SETTLED_FINENESS: usize = 4;
/// Tolerance of the difference in sensed / true between lattice and beams. Under 3 N, displacements of the maps' lattice (four segments per member)
/// have a relative error of 1.2e-4. Linear sensing of one force at most doubles the relative error of the displacements.
const MAP_TOLERANCE: f64 = 2.6e-4;
/// Tolerance of the nonlinear estimator's error on the lattice. The estimator's mesh (four elements per member) has an error of 4e-4 under 3 N; the
/// lattice adds its own error.
const NONLINEAR_TOLERANCE: f64 = 5.3e-4;

/// All results of the lattice study for a report.
#[derive(Debug, Clone, PartialEq)]
pub struct LatticeStudy {
    /// Error and time by fineness. Only a full study settles lattices (simulates them until rest), and only the coarser lattices.
    pub rows: Vec<FinenessRow>,
    /// Loads under which `rows` were computed: first the loads for Newton's method, then the load for settling.
    pub loads: [LoadGrid; 2],
    /// Errors of lattices with the axial springs of a beam and with other axial springs, at [`FINENESS`] segments per member.
    pub axial: Vec<AxialRow>,
    /// Forces at which axial springs are compared, N.
    pub axial_forces_n: Vec<f64>,
    /// Errors of settling (simulation until rest), one row per setting, at [`FINENESS`] segments per member; empty in a quick study.
    pub settling: Vec<SettlingRow>,
    /// Loads under which the settings of `settling` are compared.
    pub settled: LoadGrid,
    /// Largest unbalanced force after rounding the equilibrium to single precision, relative to the load, dimensionless.
    pub out_of_balance: f64,
    /// Checks of [`problems::lattice`]; empty in a quick study.
    pub problem_checks: Vec<Check>,
    /// Figures that are expected to differ from their references; empty in a quick study.
    pub comparisons: Vec<Comparison>,
    /// Forces (N), each with the largest difference of linear beams from the lattice, relative to the largest displacement.
    pub linear: Vec<(f64, f64)>,
    /// Maps of sensing on the lattice.
    pub sensing: LatticeSensing,
}

/// Accuracy maps of sensing from the lattice's displacements. Only maps in `others` include noise.
#[derive(Debug, Clone, PartialEq)]
pub struct LatticeSensing {
    /// Map by linear least squares.
    pub least_squares: AccuracyMap,
    /// Map by the nonlinear estimator, at fewer positions and directions.
    pub nonlinear: AccuracyMap,
    /// Maps of both estimators with noise, and of ridge regression with and without noise.
    pub others: Vec<AccuracyMap>,
    /// Difference of the least-squares maps on the lattice and on the co-rotational finger.
    pub difference: MapDifference,
}

/// Difference of two maps without noise, over the cells that both maps contain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapDifference {
    /// Number of compared cells.
    pub cells: usize,
    /// Largest difference of sensed / true, dimensionless.
    pub largest: f64,
    /// Cell with the largest difference, from the first map.
    pub at: Option<MapCell>,
    /// Number of cells with an equilibrium in only one of the two maps.
    pub in_one_alone: usize,
}

impl MapDifference {
    /// Compares two maps without noise.
    pub fn of(ours: &AccuracyMap, theirs: &AccuracyMap) -> MapDifference {
        let mut difference = MapDifference { cells: 0, largest: 0.0, at: None, in_one_alone: 0 };
        let key = |cell: &MapCell| [cell.s_mm, cell.angle_deg, cell.force_n].map(f64::to_bits);
        let known: HashMap<_, _> = theirs.cells.iter().map(|cell| (key(cell), cell.bias)).collect();
        for cell in &ours.cells {
            match (cell.bias, known.get(&key(cell))) {
                (Some(ours), Some(Some(theirs))) => {
                    difference.cells += 1;
                    let apart = (ours - theirs).abs();
                    if difference.at.is_none() || apart > difference.largest || apart.is_nan() {
                        (difference.largest, difference.at) = (apart, Some(*cell));
                    }
                }
                (None, Some(Some(_))) | (Some(_), Some(None)) => difference.in_one_alone += 1,
                _ => {}
            }
        }
        difference
    }
}

/// Size of the study by effort.
struct Extent {
    finenesses: RangeInclusive<usize>,
    /// Loads for comparing finenesses and axial springs: every `nodes`-th node, in the directions `angles_deg` (degrees).
    nodes: usize,
    angles_deg: &'static [f64],
    /// Number of positions and step of the directions (degrees): first for the map of least squares, then for the map of the nonlinear estimator.
    /// Both grids are parts of the co-rotational map's grid.
    maps: [(usize, f64); 2],
}

impl Extent {
    fn of(effort: Effort) -> Extent {
        match effort {
            Effort::Quick => {
                Extent { finenesses: 2..=4, nodes: 2, angles_deg: &[-60.0, 60.0], maps: [(12, 40.0), (12, 80.0)] }
            }
            Effort::Full => {
                Extent { finenesses: 2..=6, nodes: 1, angles_deg: &[-60.0, 0.0, 60.0], maps: [(24, 20.0), (12, 20.0)] }
            }
        }
    }
}

impl Evidence for LatticeStudy {
    fn checks(&self, context: &Context) -> Vec<Check> {
        self.checks(context.forces)
    }

    fn comparisons(&self) -> Vec<Comparison> {
        self.comparisons.clone()
    }
}

/// Studies the lattice of the paper's finger in parallel with pressed objects, because each object settles for a long time on a single thread. `maps`
/// includes the map of least squares on the co-rotational finger without noise.
pub(crate) fn run_beside_objects(
    context: &Context,
    maps: &[AccuracyMap],
) -> Result<(Option<LatticeStudy>, Vec<SceneStudy>), ExperimentError> {
    let of_beams = |map: &&AccuracyMap| {
        map.truth == TruthId::Corotational && map.estimator == EstimatorId::LeastSquares && map.noise_mm == 0.0
    };
    let theirs = maps.iter().find(of_beams).filter(|_| context.is_paper);
    let objects = Objects::of(context)?;
    let steps = if theirs.is_some() { LatticeStudy::STEPS } else { 0 };
    context.progress.part("lattice, objects", steps + objects.steps());
    let noise_levels_mm = context.noise_levels_mm();
    let settled = |theirs: &AccuracyMap| {
        let noise = (&noise_levels_mm[..], context.effort.coarse_resolution().2);
        LatticeStudy::run(context.finger, context.effort, theirs, noise, &|| context.progress.step())
    };
    let (lattice, scenes) = rayon::join(|| theirs.map(settled).transpose(), || objects.press(context.progress));
    Ok((lattice?, scenes?))
}

impl LatticeStudy {
    /// Number of times that a study reports progress.
    pub const STEPS: usize = 7;

    /// Computes the study. `theirs` is the map of least squares on the co-rotational finger without noise. `noise` holds the standard deviations of a
    /// coordinate's noise (mm; the first is 0) and the number of noise samples of the maps.
    pub(crate) fn run(
        finger: &Finger,
        effort: Effort,
        theirs: &AccuracyMap,
        noise: (&[f64], usize),
        step: &(dyn Fn() + Sync),
    ) -> Result<LatticeStudy, ProblemError> {
        let full = effort == Effort::Full;
        let extent = Extent::of(effort);
        let full_grid = LoadGrid::full(finger);
        let nodes = full_grid.nodes.iter().copied().step_by(extent.nodes).collect();
        let all = LoadGrid { nodes, angles_deg: extent.angles_deg.to_vec(), ..full_grid };
        let few = LoadGrid::few(finger);
        // A medium load in the middle of the finger.
        let middle = few.nodes[few.nodes.len() / 2];
        let one = LoadGrid { nodes: vec![middle], angles_deg: vec![few.angles_deg[1]], forces_n: vec![2.0] };
        let largest = few.forces_n.iter().copied().fold(0.0, f64::max);
        // The solver's sweeps over the springs converge most slowly for a load near the tip.
        let settled = LoadGrid { nodes: few.nodes[..1].to_vec(), forces_n: vec![largest], ..few };
        let finenesses: Vec<usize> = extent.finenesses.clone().collect();

        // The times in `rows` are measured on one core, in parallel with the other computations of the study.
        let settles = |fineness| (full && fineness <= SETTLED_FINENESS).then(|| one.clone());
        let rows = || study(finger, &finenesses, &all, settles).inspect(|_| step());
        let problem = || if full { problems::lattice::checks(finger).inspect(|_| step()) } else { Ok(Vec::new()) };
        let settling = || -> Result<_, ProblemError> {
            let lattice = Lattice::new(finger, FINENESS)?;
            let rows = if full { causes::settling(&lattice, &settled)? } else { Vec::new() };
            Ok((rows, causes::out_of_balance(&lattice, &settled, Precision::Single)?))
        };
        let (rows, (problem_checks, settling)) = rayon::join(rows, || rayon::join(problem, settling));
        let (settling, out_of_balance) = settling?;
        step();

        let axial_grid = LoadGrid { forces_n: AXIAL_FORCES_N.to_vec(), ..all.clone() };
        let axial = causes::axial(finger, FINENESS, &axial_grid)?;
        step();
        let comparisons = if full { problems::lattice::comparisons(finger)? } else { Vec::new() };
        let linear = all.forces_n.iter().copied().zip(comparisons.iter().map(|comparison| comparison.ours)).collect();
        step();
        Ok(LatticeStudy {
            rows: rows?,
            loads: [all, one],
            axial,
            axial_forces_n: axial_grid.forces_n,
            settling,
            settled,
            out_of_balance,
            problem_checks: problem_checks?,
            comparisons,
            linear,
            sensing: LatticeSensing::run(finger, &extent, theirs, noise, step)?,
        })
    }

    /// All checks. Checks of sensing apply only to the paper's forces.
    pub fn checks(&self, forces: ReportForces) -> Vec<Check> {
        let mut checks = self.problem_checks.clone();
        if forces == ReportForces::PAPER {
            checks.extend(self.sensing.checks());
        }
        checks
    }
}

impl LatticeSensing {
    fn run(
        finger: &Finger,
        extent: &Extent,
        theirs: &AccuracyMap,
        noise: (&[f64], usize),
        step: &(dyn Fn() + Sync),
    ) -> Result<LatticeSensing, LatticeError> {
        let truth = Lattice::new(finger, LATTICE_FINENESS)?;
        let (noise_levels_mm, noise_samples) = noise;
        let [linear, nonlinear] = extent.maps.map(|(positions, step_deg)| {
            let (positions_mm, angles_deg) = MapRequest::grid(finger, positions, step_deg);
            let (forces_n, noise_levels_mm) = (theirs.request.forces_n.clone(), noise_levels_mm.to_vec());
            MapRequest { positions_mm, angles_deg, forces_n, noise_levels_mm, noise_samples, seed: 1 }
        });
        let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
        let map = |estimators: &[EstimatorId], request: &MapRequest| {
            let sensors: Vec<_> = estimators.iter().map(|id| SampledSensor::new(*id, Networks::none())).collect();
            let maps = accuracy_maps(scene.clone(), &truth, &sensors, request, &|| ());
            step();
            maps
        };
        // The first map of each estimator is without noise.
        let mut linear = map(&[EstimatorId::LeastSquares, EstimatorId::Ridge], &linear);
        let mut nonlinear = map(&[EstimatorId::Nonlinear], &nonlinear);
        let (least_squares, exact) = (linear.remove(0), nonlinear.remove(0));
        let difference = MapDifference::of(&least_squares, theirs);
        linear.append(&mut nonlinear);
        Ok(LatticeSensing { least_squares, nonlinear: exact, others: linear, difference })
    }

    /// The two maps without noise: by linear least squares, and by the nonlinear estimator.
    pub fn maps(&self) -> [&AccuracyMap; 2] {
        [&self.least_squares, &self.nonlinear]
    }

    /// Largest force of the maps, N.
    pub fn largest_n(&self) -> f64 {
        self.least_squares.request.forces_n.iter().copied().fold(0.0, f64::max)
    }

    /// All maps of sensing on the lattice, without and with noise.
    pub fn all_maps(&self) -> impl Iterator<Item = &AccuracyMap> {
        self.maps().into_iter().chain(&self.others)
    }

    /// Largest relative error of the nonlinear estimator; NaN if a cell has no answer.
    pub fn nonlinear_error(&self) -> f64 {
        worst(self.nonlinear.cells.iter().map(|cell| cell.mean_error.unwrap_or(f64::NAN)))
    }

    /// Checks that least squares has equal errors on the lattice and on the co-rotational finger, and that the nonlinear estimator has a small
    /// error.
    pub fn checks(&self) -> [Check; 3] {
        let forces: Vec<String> = self.least_squares.request.forces_n.iter().map(f64::to_string).collect();
        let forces = forces.join(", ");
        let name = |what: &str, cells: usize| format!("{what}, {forces} N, {cells} cells, no noise");
        let MapDifference { cells, largest, in_one_alone, .. } = self.difference;
        // Without common cells the check must fail.
        let largest = if cells > 0 { largest } else { f64::NAN };
        let map = name("map of least squares on the lattice against the map on the co-rotational finger", cells);
        let map = Kind::Internal.on(map, NEWTON);
        let nonlinear = name("lattice sensed by the nonlinear estimator", self.nonlinear.cells.len());
        let nonlinear = Kind::Internal.on(nonlinear, NEWTON);
        [
            map.vanishes("largest difference of sensed / true", largest, MAP_TOLERANCE),
            map.counts("cells with an equilibrium in one alone", 0, in_one_alone),
            nonlinear.vanishes("largest |sensed / true - 1|", self.nonlinear_error(), NONLINEAR_TOLERANCE),
        ]
    }
}
