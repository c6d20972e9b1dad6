//! Blocks (groups of cells) of a sweep, computed in parallel and written in order.

use super::samples::NoiseSamples;
use super::tally::Tally;
use super::{Cell, Grid, Table};
use crate::prelude::*;
use crate::sampling::noise::with_sample;
use crate::sampling::sampled::{SampledForces, SampledSensor};
use crate::truths::Truth;
use std::ops::Range;
use std::time::Duration;

/// Number of pieces of work per thread between two writes. With many pieces, waiting for the slowest piece costs little.
const PIECES_A_THREAD: usize = 16;
/// If a round of pieces takes less time than this, waiting for threads and files dominates. The next pieces then have up to twice as many blocks. A
/// stopped run loses at most the current round.
const LEAST_TIME: Duration = Duration::from_millis(10);
/// Largest number of rows in memory, exceeded only if pieces of a single block already have more rows.
const MOST_ROWS: usize = 1 << 16;

/// A sweep of true fingers and sensors over a grid.
pub struct Sweep<'s> {
    scene: PreparedScene,
    truths: Vec<&'s dyn Truth>,
    sensors: Vec<SampledSensor>,
    grid: &'s Grid,
    noise: NoiseSamples,
}

impl<'s> Sweep<'s> {
    /// Sets up a sweep.
    pub fn new(
        scene: impl Into<PreparedScene>,
        truths: Vec<&'s dyn Truth>,
        sensors: Vec<SampledSensor>,
        grid: &'s Grid,
    ) -> Sweep<'s> {
        let scene = scene.into();
        Sweep { noise: NoiseSamples::new(grid, &scene.finger), scene, truths, sensors, grid }
    }

    /// Number of blocks, one for each true finger and contact.
    pub fn block_count(&self) -> usize {
        self.truths.len() * self.grid.contact_count()
    }

    /// Number of cells in every block.
    pub fn cells_in_block(&self) -> usize {
        self.sensors.len() * self.grid.noise_levels_mm.len() * self.grid.forces_n.len()
    }

    /// Computes the cells of a block, ordered by estimator, then noise level, then force.
    pub fn block(&self, number: usize) -> Vec<Cell> {
        let truth = self.truths[number / self.grid.contact_count()];
        let contact = self.grid.contact(number % self.grid.contact_count());
        let finger = &self.scene.finger;
        let s_mm = contact.position_mm(finger).unwrap_or(f64::NAN);
        let bent = self.grid.bent(truth, finger, contact);
        let prepare = |sensor: &SampledSensor| {
            let seen = bent.iter().map(|(_, shape)| sensor.sees(finger, shape, s_mm));
            (sensor.at(&self.scene, contact), seen.collect::<Vec<Measurement>>())
        };
        let prepared: Vec<_> = self.sensors.iter().map(prepare).collect();
        let common_sd = if truth.id().has_stiffness_error() { self.scene.stiffness_error.share() } else { 0.0 };
        let mut tallies = vec![Tally::new(common_sd); self.cells_in_block()];
        self.noise.each(number, |first, samples| {
            let mut tallies = tallies.iter_mut();
            for (sensors, seen) in &prepared {
                for (noise_mm, force_n, n) in self.levels() {
                    let (Some(tally), Some(seen)) = (tallies.next(), seen.get(n)) else { continue };
                    match sensors {
                        Ok(sensors) => {
                            let count = self.noise.samples(noise_mm).saturating_sub(first);
                            let samples = self.noise.of_force(n, samples).take(count);
                            sense(sensors, seen, (noise_mm, force_n), self.grid.is_leaning, samples, tally);
                        }
                        Err(refusal) => tally.refuse(refusal),
                    }
                }
            }
        });
        let cells_of_estimator = tallies.chunks(self.cells_in_block() / self.sensors.len().max(1));
        cells_of_estimator
            .zip(&self.sensors)
            .flat_map(|(tallies, sensor)| {
                let (carried, estimator) = (bent.len(), sensor.options.estimator);
                tallies.iter().zip(self.levels()).map(move |(tally, (noise_mm, force_n, n))| {
                    let cell = Cell {
                        truth: truth.id(),
                        estimator,
                        noise_mm,
                        s_mm,
                        angle_deg: contact.angle_deg,
                        force_n,
                        samples: 0,
                        answered: 0,
                        mean_error: None,
                        bias: None,
                        spread: None,
                        sigma_n: None,
                        refusal: Some(truth.no_shape().to_owned()),
                        warned: None,
                        covered: None,
                        covered_warned: None,
                    };
                    if n < carried { tally.fill(cell, self.noise.samples(noise_mm)) } else { cell }
                })
            })
            .collect()
    }

    /// Every pair of noise level (mm) and force (N), with the index of the force.
    fn levels(&self) -> impl Iterator<Item = (f64, f64, usize)> {
        let of_level =
            |&noise_mm| self.grid.forces_n.iter().enumerate().map(move |(n, &force_n)| (noise_mm, force_n, n));
        self.grid.noise_levels_mm.iter().flat_map(of_level)
    }

    /// Computes blocks in parallel. `write` gets the blocks in order, several at a time: the number of blocks and their rows. Memory contains only a
    /// few blocks per thread.
    ///
    /// # Errors
    /// The first error of `write` or of the CSV writer.
    pub fn stream<E: From<csv::Error>>(
        &self,
        table: Table,
        blocks: Range<usize>,
        mut write: impl FnMut(usize, &str) -> Result<(), E>,
    ) -> Result<(), E> {
        let pieces = PIECES_A_THREAD * rayon::current_num_threads();
        let longest = (MOST_ROWS / (pieces * self.cells_in_block().max(1))).max(1);
        let (mut next, mut length) = (blocks.start, 1);
        while next < blocks.end {
            let piece = |number: usize| {
                let first = blocks.end.min(next + number * length);
                first..blocks.end.min(first + length)
            };
            let rows = |number| {
                let cells: Vec<Cell> = piece(number).flat_map(|block| self.block(block)).collect();
                Ok((piece(number).len(), table.rows(&cells)?))
            };
            let count = pieces.min((blocks.end - next).div_ceil(length));
            let begun = Instant::now();
            let texts: Vec<Result<(usize, String), csv::Error>> =
                (0..count).into_par_iter().with_max_len(1).map(rows).collect();
            let quick = begun.elapsed() < LEAST_TIME;
            for text in texts {
                let (blocks, rows) = text?;
                write(blocks, &rows)?;
            }
            next = piece(count).start;
            if quick {
                length = longest.min(2 * length);
            }
        }
        Ok(())
    }
}

/// Senses the force (N) in each noise sample (mm) of a measurement by the sensors in turn, and adds the answers and refusals to `tally`. Unknown contacts
/// are sensed without a shared start, because a start near the truth would hide other contacts that explain the markers.
fn sense<'p>(
    sensors: &[Sensor],
    seen: &Measurement,
    (noise_mm, force_n): (f64, f64),
    is_unknown: bool,
    samples: impl ExactSizeIterator<Item = &'p [f64]>,
    tally: &mut Tally,
) {
    let count = if is_unknown { 1 } else { samples.len().div_ceil(sensors.len().max(1)) };
    let sampled: Vec<_> = sensors.iter().map(|sensor| SampledForces::new(sensor, seen, noise_mm, count)).collect();
    for (sample, sensor) in samples.zip(sampled.iter().cycle()) {
        let noisy = if noise_mm > 0.0 { with_sample(seen, sample, noise_mm) } else { seen.clone() };
        match sensor.sense(&noisy) {
            Ok(sensed) => tally.answer(&sensed, force_n),
            Err(refusal) => tally.refuse(&refusal),
        }
    }
}
