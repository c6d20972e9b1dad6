//! The accuracy map: error of a single sensed force by position on the front plate and direction.
//!
//! What the estimator knows of position and direction, and which markers it sees, is the map's [`Situation`]. The error is |sensed / true - 1|, averaged over the forces and noise
//! samples of a cell.

use crate::prelude::*;
use crate::sampling::sampled::SampledSensor;
use crate::sampling::situation::Situation;
use crate::sampling::sweep::{self, CellState, Grid, MapCell, Sweep};
use crate::settings::{GROSS_ERROR, TRUSTED_ERROR};
use crate::truths::{Truth, TruthId};
use std::io::Read;

/// Request for maps: the grid of the [`Sweep`] whose cells the maps summarise. Each pair of estimator and noise level gives one map.
pub type MapRequest = Grid;

/// An accuracy map: errors of an estimator on a true finger, with cells by position, direction and force.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyMap {
    /// Grid of positions, directions, forces and noise.
    pub request: MapRequest,
    /// The true finger.
    pub truth: TruthId,
    /// The estimator.
    pub estimator: EstimatorId,
    /// What the sensor knows and sees.
    pub situation: Situation,
    /// Standard deviation of the noise of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Cells, ordered by position, then direction, then force.
    pub cells: Vec<MapCell>,
}

/// Computes a map for each sensor and noise level, in this order. Pairs of position and direction are computed in parallel; the result does not
/// depend on the number of threads. `progress` is called after each pair.
pub fn accuracy_maps(
    scene: impl Into<PreparedScene>,
    truth: &dyn Truth,
    sensors: &[SampledSensor],
    request: &MapRequest,
    progress: &(dyn Fn() + Sync),
) -> Vec<AccuracyMap> {
    let sweep = Sweep::new(scene, vec![truth], sensors.to_vec(), request);
    let block = |number| {
        let cells: Vec<MapCell> = sweep.block(number).iter().map(MapCell::from).collect();
        progress();
        cells
    };
    let blocks: Vec<Vec<MapCell>> = (0..sweep.block_count()).into_par_iter().map(block).collect();
    let (forces, levels) = (request.forces_n.len(), request.noise_levels_mm.len());
    let map = |number: usize| AccuracyMap {
        request: request.clone(),
        truth: truth.id(),
        estimator: sensors[number / levels].options.estimator,
        situation: sensors[number / levels].situation,
        noise_mm: request.noise_levels_mm[number % levels],
        cells: blocks.iter().flat_map(|block| &block[number * forces..][..forces]).copied().collect(),
    };
    (0..sensors.len() * levels).map(map).collect()
}

impl AccuracyMap {
    /// Reads the cells of a sweep with one true finger, one estimator and one noise level, from a table written as [`Table::Map`](sweep::Table::Map).
    ///
    /// # Errors
    /// [`csv::Error`] if the table is invalid.
    pub fn from_csv(request: &sweep::Request, table: impl Read) -> Result<AccuracyMap, csv::Error> {
        Ok(AccuracyMap {
            cells: csv::Reader::from_reader(table).into_deserialize().collect::<Result<_, _>>()?,
            truth: request.truths.first().copied().unwrap_or(TruthId::Corotational),
            estimator: request.estimators.first().copied().unwrap_or(EstimatorId::LeastSquares),
            situation: request.situation,
            noise_mm: request.grid.noise_levels_mm.first().copied().unwrap_or(0.0),
            request: request.grid.clone(),
        })
    }

    /// Mean relative errors for one force (N), or over all forces, indexed by direction, then position. An entry is `None` if a force of its cell is
    /// refused or has no equilibrium.
    pub fn errors(&self, force_n: Option<f64>) -> Vec<Vec<Option<f64>>> {
        self.values(force_n, |cell| cell.mean_error)
    }

    /// A quantity of the cells for one force (N), or its mean over all forces, indexed by direction, then position. An entry is `None` if a force of
    /// its cell lacks the quantity.
    pub fn values(&self, force_n: Option<f64>, of: impl Fn(&MapCell) -> Option<f64>) -> Vec<Vec<Option<f64>>> {
        let means: Vec<Option<f64>> =
            self.groups(force_n).map(|group| group.map(&of).collect::<Option<Vec<f64>>>().and_then(mean)).collect();
        let angles = self.request.angles_deg.len();
        (0..angles).map(|angle| means.iter().skip(angle).step_by(angles).copied().collect()).collect()
    }

    /// The part of this map at the given positions (mm) and directions (degrees). Positions and directions that the map lacks are omitted.
    pub fn thinned(&self, positions_mm: &[f64], angles_deg: &[f64]) -> AccuracyMap {
        let kept = |all: &[f64], wanted: &[f64]| all.iter().copied().filter(|x| wanted.contains(x)).collect::<Vec<_>>();
        let request = MapRequest {
            positions_mm: kept(&self.request.positions_mm, positions_mm),
            angles_deg: kept(&self.request.angles_deg, angles_deg),
            ..self.request.clone()
        };
        let on_grid = |cell: &&MapCell| positions_mm.contains(&cell.s_mm) && angles_deg.contains(&cell.angle_deg);
        AccuracyMap { request, cells: self.cells.iter().filter(on_grid).copied().collect(), ..self.clone() }
    }

    /// The part of this map for some of its forces; `keeps` takes a force, N.
    pub fn with_forces(&self, keeps: impl Fn(f64) -> bool) -> AccuracyMap {
        let forces_n = self.request.forces_n.iter().copied().filter(|force_n| keeps(*force_n)).collect();
        let cells = self.cells.iter().copied().filter(|cell| keeps(cell.force_n)).collect();
        AccuracyMap { request: MapRequest { forces_n, ..self.request.clone() }, cells, ..self.clone() }
    }

    /// Cells of one force (N), or of all forces, grouped by position and direction.
    fn groups(&self, force_n: Option<f64>) -> impl Iterator<Item = impl Iterator<Item = &MapCell> + Clone> {
        let wanted = move |cell: &&MapCell| force_n.is_none_or(|f| f == cell.force_n);
        self.cells.chunks(self.request.forces_n.len().max(1)).map(move |group| group.iter().filter(wanted))
    }

    /// Summary for one force (N), or for the mean over all forces. A cell with several forces has the worst outcome of its forces. From worst to
    /// best, the outcomes are: without equilibrium, refused, answered.
    pub fn summary(&self, force_n: Option<f64>) -> MapSummary {
        let errors = self.errors(force_n);
        let known: Vec<f64> = errors.iter().flatten().flatten().copied().collect();
        let states: Vec<CellState> = self.groups(force_n).filter_map(|group| group.map(MapCell::state).max()).collect();
        let count = |state| states.iter().filter(|found| **found == state).count();
        let (refused, without_equilibrium) = (count(CellState::Refused), count(CellState::WithoutEquilibrium));
        let share = |limit: f64| {
            let above = refused + known.iter().filter(|error| **error > limit).count();
            ratio(above, states.len() - without_equilibrium)
        };
        let bent = || self.groups(force_n).flatten();
        let samples: usize = bent().map(|cell| cell.samples).sum();
        let answered_samples: usize = bent().map(|cell| cell.answered).sum();
        MapSummary {
            truth: self.truth,
            estimator: self.estimator,
            noise_mm: self.noise_mm,
            forces_n: force_n.map_or_else(|| self.request.forces_n.clone(), |f| vec![f]),
            cells: states.len(),
            answered: count(CellState::Answered),
            refused,
            without_equilibrium,
            mean_error: mean(known.iter().copied()),
            largest_error: known.iter().copied().reduce(f64::max),
            share_above_10: share(TRUSTED_ERROR),
            share_above_25: share(GROSS_ERROR),
            share_of_samples_refused: ratio(samples - answered_samples, samples),
        }
    }
}

/// A ratio of counts; `None` if `all` is zero.
fn ratio(part: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

/// Summary of a map. Show [`counts`](MapSummary::counts) beside a mean, because the mean covers answered cells only.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapSummary {
    /// The true finger.
    pub truth: TruthId,
    /// The estimator.
    pub estimator: EstimatorId,
    /// Standard deviation of the noise of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Forces over which the errors are averaged, N.
    pub forces_n: Vec<f64>,
    /// Number of cells: positions times directions.
    pub cells: usize,
    /// Number of answered cells: see [`CellState`].
    pub answered: usize,
    /// Number of cells that the estimator refused.
    pub refused: usize,
    /// Number of cells in which a force has no equilibrium. `mean_error`, `largest_error` and the shares of cells exclude the cells without
    /// equilibrium.
    pub without_equilibrium: usize,
    /// Mean of |sensed / true - 1| over the answered cells; `None` without answered cells.
    pub mean_error: Option<f64>,
    /// Largest error of an answered cell, relative; `None` without answered cells.
    pub largest_error: Option<f64>,
    /// Share of cells with an error above 10 % or refused, among cells with equilibrium; `None` without such cells.
    pub share_above_10: Option<f64>,
    /// Share of cells with an error above 25 % or refused, among cells with equilibrium; `None` without such cells.
    pub share_above_25: Option<f64>,
    /// Share of all noise samples that the estimator refused, including samples of answered cells.
    pub share_of_samples_refused: Option<f64>,
}

impl MapSummary {
    /// Phrase that states the counts; shown beside every mean and share.
    pub fn counts(&self) -> String {
        format!(
            "{} cells: {} answered, {} refused, {} without equilibrium",
            self.cells, self.answered, self.refused, self.without_equilibrium
        )
    }
}
