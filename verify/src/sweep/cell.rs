//! The cells of a sweep.

use super::{Grid, Table};
use crate::estimators::{Estimator, EstimatorError, PreparedEstimator};
use crate::truth::Truth;
use finray_model::Finger;
use finray_model::measurement::Measurement;
use rayon::prelude::*;
use std::ops::Range;

/// Blocks that a thread computes before rows are written: enough that waiting for the last one costs little, few enough
/// that a run which is stopped loses little and the rows in memory are few.
const BLOCKS_A_THREAD: usize = 16;

/// Truths and estimators on a grid.
pub struct Sweep<'s> {
    finger: &'s Finger,
    truths: Vec<&'s dyn Truth>,
    estimators: Vec<&'s dyn Estimator>,
    grid: &'s Grid,
    /// In units of the noise, by picture, then marker coordinate.
    noise: Vec<Vec<f64>>,
}

/// One force at one place and direction, at one level of noise, on one truth, by one estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Position of the truth in the sweep's list.
    pub truth: usize,
    /// Position of the estimator in the sweep's list.
    pub estimator: usize,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Place on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// What came out.
    pub outcome: Outcome,
}

/// What came out of a cell's noise pictures; a single one without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Noise pictures; none where the finger has no equilibrium.
    pub pictures: usize,
    /// Pictures that were answered.
    pub answered: usize,
    /// `None` where fewer than half of the pictures were answered: the few are no fair sample.
    pub errors: Option<Errors>,
    /// Why the finger or the first picture that was refused gave no answer; `None` if all were answered.
    pub refusal: Option<String>,
}

/// Errors over the answered pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Mean of |sensed / true - 1|.
    pub mean_error: f64,
    /// Mean of sensed / true - 1: what is wrong even without noise.
    pub bias: f64,
    /// Standard deviation of sensed / true over the noise.
    pub spread: f64,
    /// Root mean square of the standard deviations that the estimator states, N; `None` if it states none.
    pub sigma_n: Option<f64>,
}

impl<'s> Sweep<'s> {
    /// Sets up a sweep; all cells see the same noise pictures.
    pub fn new(
        finger: &'s Finger,
        truths: Vec<&'s dyn Truth>,
        estimators: Vec<&'s dyn Estimator>,
        grid: &'s Grid,
    ) -> Sweep<'s> {
        Sweep { finger, truths, estimators, grid, noise: grid.noise(finger) }
    }

    /// Number of blocks: a truth and contact each.
    pub fn block_count(&self) -> usize {
        self.truths.len() * self.grid.contact_count()
    }

    /// Number of cells in every block.
    pub fn cells_in_block(&self) -> usize {
        self.estimators.len() * self.grid.noise_levels_mm.len() * self.grid.forces_n.len()
    }

    /// Names of the truths.
    pub fn truth_names(&self) -> Vec<&str> {
        self.truths.iter().map(|truth| truth.name()).collect()
    }

    /// Names of the estimators.
    pub fn estimator_names(&self) -> Vec<&str> {
        self.estimators.iter().map(|estimator| estimator.name()).collect()
    }

    /// Computes the cells of a block, by estimator, then noise, then force.
    pub fn block(&self, number: usize) -> Vec<Cell> {
        let truth = number / self.grid.contact_count();
        let contact = self.grid.contact(number % self.grid.contact_count());
        let shapes = self.truths[truth].shapes(&contact, &self.grid.forces_n);
        let seen: Vec<Measurement> = shapes.iter().map(|shape| Measurement::of_shape(self.finger, shape)).collect();
        let mut cells = Vec::with_capacity(self.cells_in_block());
        for (i, estimator) in self.estimators.iter().enumerate() {
            let mut prepared = seen.first().map(|markers| estimator.prepare(&[contact], markers));
            for &noise_mm in &self.grid.noise_levels_mm {
                for (n, &force_n) in self.grid.forces_n.iter().enumerate() {
                    let outcome = match (prepared.as_mut(), seen.get(n)) {
                        (Some(Ok(estimator)), Some(seen)) => self.sense(&mut **estimator, seen, noise_mm, force_n),
                        (Some(Err(error)), Some(_)) => Outcome::refused(self.pictures(noise_mm).len(), error),
                        _ => Outcome::not_carried(),
                    };
                    let (s_mm, angle_deg) = (contact.place_mm(self.finger).unwrap_or(f64::NAN), contact.angle_deg);
                    cells.push(Cell { truth, estimator: i, noise_mm, s_mm, angle_deg, force_n, outcome });
                }
            }
        }
        cells
    }

    /// Computes blocks in parallel and hands the rows of each to `write`, in order and soon after they are known; in memory are
    /// only a few blocks a thread.
    ///
    /// # Errors
    /// The first one of `write`, or of the CSV writer (none in memory).
    pub fn stream<E: From<csv::Error>>(
        &self,
        table: Table,
        blocks: Range<usize>,
        mut write: impl FnMut(&str) -> Result<(), E>,
    ) -> Result<(), E> {
        let at_once = BLOCKS_A_THREAD * rayon::current_num_threads();
        for first in blocks.clone().step_by(at_once) {
            let chunk = first..blocks.end.min(first + at_once);
            let rows = |block| table.rows(self, &self.block(block));
            let texts: Vec<Result<String, csv::Error>> = chunk.into_par_iter().with_max_len(1).map(rows).collect();
            for text in texts {
                write(&text?)?;
            }
        }
        Ok(())
    }

    /// Without noise all pictures are the same.
    fn pictures(&self, noise_mm: f64) -> &[Vec<f64>] {
        if noise_mm == 0.0 { &self.noise[..1] } else { &self.noise }
    }

    fn sense(&self, estimator: &mut dyn PreparedEstimator, seen: &Measurement, noise_mm: f64, force_n: f64) -> Outcome {
        let pictures = self.pictures(noise_mm);
        let mut errors = Vec::with_capacity(pictures.len());
        let mut variance_n2 = Some(0.0);
        let mut refusal = None;
        for picture in pictures {
            let mut noisy = seen.clone();
            let mut coordinates = picture.iter();
            if noise_mm > 0.0 {
                noisy.add_noise(noise_mm, || coordinates.next().copied().unwrap_or(0.0));
            }
            match estimator.estimate(&noisy, Some(noise_mm)) {
                Ok(sensed) => {
                    errors.push(sensed.forces_n[0] / force_n - 1.0);
                    variance_n2 = variance_n2.zip(sensed.sigmas_n).map(|(sum, sigmas)| sum + sigmas[0] * sigmas[0]);
                }
                Err(error) => refusal = refusal.or_else(|| Some(error.to_string())),
            }
        }
        let enough = 2 * errors.len() >= pictures.len();
        Outcome {
            pictures: pictures.len(),
            answered: errors.len(),
            errors: if enough { Errors::of(&errors, variance_n2) } else { None },
            refusal,
        }
    }
}

impl Outcome {
    fn refused(pictures: usize, error: &EstimatorError) -> Outcome {
        Outcome { pictures, answered: 0, errors: None, refusal: Some(error.to_string()) }
    }

    fn not_carried() -> Outcome {
        let refusal = "the finger that is sensed has no equilibrium under this force".to_owned();
        Outcome { pictures: 0, answered: 0, errors: None, refusal: Some(refusal) }
    }
}

impl Errors {
    /// `None` without any errors.
    fn of(errors: &[f64], variance_n2: Option<f64>) -> Option<Errors> {
        let count = errors.len() as f64;
        let bias = errors.iter().sum::<f64>() / count;
        let squares: f64 = errors.iter().map(|error| (error - bias).powi(2)).sum();
        (!errors.is_empty()).then(|| Errors {
            mean_error: errors.iter().map(|error| error.abs()).sum::<f64>() / count,
            bias,
            spread: if errors.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 },
            sigma_n: variance_n2.map(|sum| (sum / count).sqrt()),
        })
    }
}
