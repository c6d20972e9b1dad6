//! Priors of the unknowns as rows of the least-squares problem, below the rows of the markers.
//!
//! The row of a prior is the deviation of a value from its expected value, in standard deviations, multiplied by the noise of a coordinate. The
//! expected rotation of a compliant base is proportional to the sum of the forces. Its uncertainty grows with the sum of the forces.

use super::unknowns::{Unknown, UnknownPrior};
use super::values::{Nuisances, value_rate};
use crate::measurement::Measurement;
use crate::sensing::{ContactQuestion, TouchedObject};

/// The prior of one of the unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
struct IndexedPrior {
    /// Index among the unknowns.
    index: usize,
    unknown: Unknown,
    prior: UnknownPrior,
}

impl IndexedPrior {
    fn value(&self, nuisances: &Nuisances) -> f64 {
        nuisances.value(self.unknown, self.prior.is_of_tangent)
    }

    /// Standard deviation under forces with the sum `sum_n`, N.
    fn sd_under(&self, sum_n: f64) -> f64 {
        self.prior.sd.hypot(self.prior.sd_per_n * sum_n)
    }

    /// Deviation of a value from its expected value under forces with the sum `sum_n`, N, in standard deviations.
    fn deviation(&self, value: f64, sum_n: f64) -> f64 {
        (value - self.prior.per_n * sum_n) / self.sd_under(sum_n)
    }

    /// Derivative of the deviation with respect to each force, 1/N.
    fn deviation_by_force(&self, value: f64, sum_n: f64) -> f64 {
        let UnknownPrior { per_n, sd_per_n, .. } = self.prior;
        if per_n == 0.0 && sd_per_n == 0.0 {
            return 0.0;
        }
        let sd = self.sd_under(sum_n);
        let widens = sd_per_n * (sd_per_n * sum_n / sd);
        -(per_n + self.deviation(value, sum_n) * widens) / sd
    }
}

/// A prior as a row of the least-squares problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PriorRow {
    /// Index of the unknown with this prior.
    pub index: usize,
    /// Derivative with respect to the unknown, mm per unit of the unknown.
    pub by_unknown: f64,
    /// Derivative with respect to each force on the front plate, mm/N; on the back plate, the sign is opposite. Zero unless the expected value or its
    /// standard deviation depends on the forces.
    pub by_force: f64,
    /// Right-hand side of the row, mm.
    pub left_mm: f64,
}

/// All priors, scaled by the measurement's noise, mm.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Priors {
    priors: Vec<IndexedPrior>,
    /// Sign of the moment of each force on the base: forces on opposite plates turn it in opposite directions.
    pub turn_signs: Vec<f64>,
    marker_noise_mm: f64,
}

impl Priors {
    /// Priors of all unknowns that have one. `marker_noise_mm` is the standard deviation of a coordinate of weight 1, mm.
    pub fn new(
        unknowns: &[Unknown],
        questions: &[ContactQuestion],
        object: Option<&TouchedObject>,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
    ) -> Priors {
        let prior = |(index, &unknown): (usize, &Unknown)| {
            let prior = unknown.prior(questions, object, measurement)?;
            Some(IndexedPrior { index, unknown, prior })
        };
        Priors {
            priors: unknowns.iter().enumerate().filter_map(prior).collect(),
            turn_signs: questions.iter().map(|q| q.position.map_or(1.0, |at| at.plate().turn_sign())).collect(),
            marker_noise_mm: marker_noise_mm.unwrap_or_default(),
        }
    }

    /// Standard deviation of a measured coordinate, mm. This noise scales the priors.
    pub fn marker_noise_mm(&self) -> f64 {
        self.marker_noise_mm
    }

    /// Sum of the forces that turn the base, N: of those on the front plate, less those on the back plate.
    fn sum_n(&self, forces_n: &[f64]) -> f64 {
        self.turn_signs.iter().zip(forces_n).map(|(sign, force_n)| sign * force_n).sum()
    }

    /// Number of priors that count as measured. Exact markers outweigh every prior, so none counts without noise.
    pub fn count(&self) -> usize {
        if self.marker_noise_mm > 0.0 { self.priors.len() } else { 0 }
    }

    /// Whether no unknown has a prior.
    pub fn is_empty(&self) -> bool {
        self.priors.is_empty()
    }

    /// Sum of the squared deviations from the expected values, in standard deviations, times the squared noise, mm^2.
    pub fn misfit(&self, nuisances: &Nuisances, forces_n: &[f64]) -> f64 {
        let sum_n = self.sum_n(forces_n);
        let off = |prior: &IndexedPrior| self.marker_noise_mm * prior.deviation(prior.value(nuisances), sum_n);
        self.priors.iter().map(|prior| off(prior).powi(2)).sum()
    }

    /// Rows of the priors in the least-squares problem, below the rows of the markers.
    pub fn rows<'p>(&'p self, nuisances: &'p Nuisances, forces_n: &'p [f64]) -> impl Iterator<Item = PriorRow> + 'p {
        let sum_n = self.sum_n(forces_n);
        self.priors.iter().map(move |prior| {
            let value = prior.value(nuisances);
            let by_unknown = value_rate(prior.unknown, prior.prior.is_of_tangent, forces_n);
            PriorRow {
                index: prior.index,
                by_unknown: self.marker_noise_mm * by_unknown / prior.sd_under(sum_n),
                by_force: self.marker_noise_mm * prior.deviation_by_force(value, sum_n),
                left_mm: -self.marker_noise_mm * prior.deviation(value, sum_n),
            }
        })
    }
}
