//! The accuracy map: how wrong a single force is sensed, by its place on the front plate and its direction.
//!
//! Place and direction are known to the estimator; only the size of the force is sought. The error is
//! |sensed / true - 1|, averaged over the forces and the noise pictures of a cell.

use crate::estimators::Estimator;
use crate::sweep::{self, Grid, Sweep};
use crate::truth::Truth;
use finray_model::Finger;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::Read;

/// What a map is made of: the grid of the [`Sweep`] that it sums up. There is a map for each level of noise.
pub type MapRequest = Grid;

/// What came out for one force at one place and direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Place on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Mean of |sensed / true - 1| over the noise pictures that are answered; empty where the finger has no equilibrium or
    /// more than half of the pictures are refused.
    pub mean_error: Option<f64>,
    /// Mean of sensed / true - 1: what is wrong even without noise.
    pub bias: Option<f64>,
    /// Standard deviation of sensed / true over the noise.
    pub spread: Option<f64>,
}

impl From<&sweep::Cell> for Cell {
    fn from(cell: &sweep::Cell) -> Cell {
        let errors = cell.outcome.errors;
        Cell {
            s_mm: cell.s_mm,
            angle_deg: cell.angle_deg,
            force_n: cell.force_n,
            mean_error: errors.map(|errors| errors.mean_error),
            bias: errors.map(|errors| errors.bias),
            spread: cell.spread(),
        }
    }
}

/// An accuracy map: cells by place, then direction, then force.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyMap {
    /// What was asked for.
    pub request: MapRequest,
    /// Name of the truth.
    pub truth: String,
    /// Name of the estimator.
    pub estimator: String,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// The cells.
    pub cells: Vec<Cell>,
}

/// Computes a map for each estimator and noise level in parallel, place by place: by estimator, then noise. The result does
/// not depend on the number of threads. `progress` is called once for every finished place and direction.
pub fn accuracy_maps(
    finger: &Finger,
    truth: &dyn Truth,
    estimators: &[&dyn Estimator],
    request: &MapRequest,
    progress: &(dyn Fn() + Sync),
) -> Vec<AccuracyMap> {
    let sweep = Sweep::new(finger, vec![truth], estimators.to_vec(), request);
    let block = |number| {
        let cells: Vec<Cell> = sweep.block(number).iter().map(Cell::from).collect();
        progress();
        cells
    };
    let blocks: Vec<Vec<Cell>> = (0..sweep.block_count()).into_par_iter().map(block).collect();
    let (forces, levels) = (request.forces_n.len(), request.noise_levels_mm.len());
    let map = |number: usize| AccuracyMap {
        request: request.clone(),
        truth: truth.name().to_owned(),
        estimator: estimators[number / levels].name().to_owned(),
        noise_mm: request.noise_levels_mm[number % levels],
        cells: blocks.iter().flat_map(|block| &block[number * forces..][..forces]).copied().collect(),
    };
    (0..estimators.len() * levels).map(map).collect()
}

impl AccuracyMap {
    /// CSV of the cells: `s_mm,angle_deg,force_n,mean_error,bias,spread`.
    ///
    /// # Errors
    /// None in memory; the signature is the CSV writer's.
    pub fn to_csv(&self) -> Result<String, csv::Error> {
        crate::files::csv_text(&self.cells)
    }

    /// Reads the cells of the table of a sweep with one truth, estimator and level of noise, written as
    /// [`Table::Map`](sweep::Table::Map).
    ///
    /// # Errors
    /// [`csv::Error`] if the table is none.
    pub fn from_csv(request: &sweep::Request, table: impl Read) -> Result<AccuracyMap, csv::Error> {
        let first = |names: &[String]| names.first().cloned().unwrap_or_default();
        Ok(AccuracyMap {
            cells: csv::Reader::from_reader(table).into_deserialize().collect::<Result<_, _>>()?,
            truth: first(&request.truths),
            estimator: first(&request.estimators),
            noise_mm: request.grid.noise_levels_mm.first().copied().unwrap_or(0.0),
            request: request.grid.clone(),
        })
    }

    /// Mean error by direction, then place: of one force, or over all forces. `None` where a force has no equilibrium.
    pub fn errors(&self, force_n: Option<f64>) -> Vec<Vec<Option<f64>>> {
        self.values(force_n, |cell| cell.mean_error)
    }

    /// A quantity by direction, then place: of one force, or its mean over all forces. `None` where a force has none.
    pub fn values(&self, force_n: Option<f64>, of: impl Fn(&Cell) -> Option<f64>) -> Vec<Vec<Option<f64>>> {
        let forces = self.request.forces_n.len();
        let (places, angles) = (self.request.places_mm.len(), self.request.angles_deg.len());
        let cell = |place: usize, angle: usize| {
            let first = (place * angles + angle) * forces;
            let values: Option<Vec<f64>> = self.cells[first..first + forces]
                .iter()
                .filter(|cell| force_n.is_none_or(|f| f == cell.force_n))
                .map(&of)
                .collect();
            values.filter(|v| !v.is_empty()).map(|v| v.iter().sum::<f64>() / v.len() as f64)
        };
        (0..angles).map(|angle| (0..places).map(|place| cell(place, angle)).collect()).collect()
    }

    /// The cells of a coarser grid, whose places and directions are all among this map's; others are left out.
    pub fn thinned(&self, places_mm: &[f64], angles_deg: &[f64]) -> AccuracyMap {
        let kept = |all: &[f64], wanted: &[f64]| all.iter().copied().filter(|x| wanted.contains(x)).collect::<Vec<_>>();
        let request = MapRequest {
            places_mm: kept(&self.request.places_mm, places_mm),
            angles_deg: kept(&self.request.angles_deg, angles_deg),
            ..self.request.clone()
        };
        let on_grid = |cell: &&Cell| places_mm.contains(&cell.s_mm) && angles_deg.contains(&cell.angle_deg);
        AccuracyMap { request, cells: self.cells.iter().filter(on_grid).copied().collect(), ..self.clone() }
    }

    /// What the map says as a whole, of one force or over all.
    pub fn summary(&self, force_n: Option<f64>) -> MapSummary {
        let errors = self.errors(force_n);
        let known: Vec<f64> = errors.iter().flatten().flatten().copied().collect();
        let share = |limit: f64| known.iter().filter(|e| **e > limit).count() as f64 / known.len().max(1) as f64;
        let cells = errors.iter().flatten().count();
        MapSummary {
            truth: self.truth.clone(),
            estimator: self.estimator.clone(),
            noise_mm: self.noise_mm,
            forces_n: force_n.map_or_else(|| self.request.forces_n.clone(), |f| vec![f]),
            mean_error: known.iter().sum::<f64>() / known.len().max(1) as f64,
            largest_error: known.iter().copied().fold(0.0, f64::max),
            share_above_10: share(0.10),
            share_above_25: share(0.25),
            cells,
            cells_without_equilibrium: cells - known.len(),
        }
    }
}

/// A map in a few figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapSummary {
    /// Name of the truth.
    pub truth: String,
    /// Name of the estimator.
    pub estimator: String,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Forces that the errors are averaged over, N.
    pub forces_n: Vec<f64>,
    /// Mean of |sensed / true - 1| over all cells.
    pub mean_error: f64,
    /// Largest error of a cell.
    pub largest_error: f64,
    /// Share of the cells with an error above 10 %.
    pub share_above_10: f64,
    /// Share of the cells with an error above 25 %.
    pub share_above_25: f64,
    /// Number of cells.
    pub cells: usize,
    /// Cells in which a force has no equilibrium; they count in none of the figures above.
    pub cells_without_equilibrium: usize,
}
