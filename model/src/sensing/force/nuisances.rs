//! Nuisance parameters beside forces and positions: poses of the base and of an object, leans of forces, and errors that
//! all markers share.
//!
//! Each nuisance parameter has a Gaussian prior, which is one row of the least-squares problem below the markers. The row of a prior is the deviation
//! from the expected value, in standard deviations, multiplied by the noise of a coordinate. The expected rotation of a compliant base is
//! proportional to the sum of the forces. The uncertainty of the rotation of a compliant base grows with the sum of the forces.

use super::unknowns::{BaseMotion, Unknown};
use crate::Vector;
use crate::finger::Plate;
use crate::measurement::{Measurement, SharedError};
use crate::sensing::{ContactQuestion, Direction, TouchedObject};
use nalgebra::Isometry2;

/// Smallest force, N, at which a force across changes the direction from a measured normal. It keeps the prior of the direction finite without a
/// force.
const LEAST_LEANING_N: f64 = 1e-9;

/// Force, N, that divides a force across a measured normal to give the tangent of the lean.
pub(super) fn leaning_n(force_n: f64) -> f64 {
    force_n.abs().max(LEAST_LEANING_N).copysign(force_n)
}

/// Values of the nuisance parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nuisances {
    /// Motion of the base from its expected pose, in the finger frame of the measurement, mm and rad.
    pub base: Isometry2<f64>,
    /// Difference between the lean of each force (its angle from the normal) and the mean lean, degrees. The mean lean from a measured normal is zero.
    pub further_leans_deg: Vec<f64>,
    /// Difference between the position of each contact and its measured position, mm. Meaningless for an unknown position.
    pub shifts_mm: Vec<f64>,
    /// Deviation of the object from its stated pose: x (mm), y (mm) and rotation (rad).
    pub object: [f64; 3],
    /// Errors that all markers share, in standard deviations. `shared_mm` is the displacement of each key node's marker due to all shared errors
    /// together, mm.
    pub shared: Vec<f64>,
    shared_mm: Vec<Vector>,
}

impl Nuisances {
    /// All parameters at their expected values, but shared errors at the amplitudes where a search starts.
    pub fn expected(contacts: usize, shared_errors: &[SharedError]) -> Nuisances {
        let mut nuisances = Nuisances {
            base: Isometry2::identity(),
            further_leans_deg: vec![0.0; contacts],
            shifts_mm: vec![0.0; contacts],
            object: [0.0; 3],
            shared: shared_errors.iter().map(|error| error.start).collect(),
            shared_mm: Vec::new(),
        };
        nuisances.resume(shared_errors);
        nuisances
    }

    /// Applies the amplitudes of the shared errors to other patterns of the same errors.
    pub fn resume(&mut self, shared_errors: &[SharedError]) {
        let key_nodes = shared_errors.first().map_or(0, |error| error.pattern_mm.len());
        self.shared_mm = vec![Vector::zeros(); key_nodes];
        for (k, by) in std::mem::take(&mut self.shared).into_iter().enumerate() {
            self.shared.push(0.0);
            self.share(k, &shared_errors[k], by);
        }
    }

    /// Displacement of a key node's marker due to the errors that all markers share, mm.
    pub fn shared_mm(&self, key_node: usize) -> Vector {
        self.shared_mm.get(key_node).copied().unwrap_or_default()
    }

    /// Rotation of the base as a change of an angle on a plate, degrees.
    pub fn base_turn_deg(&self, plate: Plate) -> f64 {
        plate.turn_sign() * self.base.rotation.angle().to_degrees()
    }

    /// Changes a shared error by `by` times its standard deviation.
    pub fn share(&mut self, index: usize, error: &SharedError, by: f64) {
        self.shared[index] += by;
        self.shared_mm.iter_mut().zip(&error.pattern_mm).for_each(|(all, of_error)| *all += of_error * by);
    }

    /// Tangent of the angle between the force of a contact and its measured normal, dimensionless.
    pub fn tangent(&self, contact: usize) -> f64 {
        self.further_leans_deg[contact].to_radians().tan()
    }

    /// Value to which the prior of an unknown applies, in mm, rad, degrees, tangents or standard deviations.
    fn value(&self, prior: &Prior) -> f64 {
        match prior.unknown {
            Unknown::Base(BaseMotion::X) => self.base.translation.x,
            Unknown::Base(BaseMotion::Y) => self.base.translation.y,
            Unknown::Base(BaseMotion::Turn) => self.base.rotation.angle(),
            Unknown::Across(i) if prior.is_of_tangent => self.tangent(i),
            Unknown::Across(i) => self.further_leans_deg[i],
            Unknown::Position(i) => self.shifts_mm[i],
            Unknown::Object(way) => self.object[way as usize],
            Unknown::Shared(i) => self.shared[i],
            Unknown::Force(_) => 0.0,
        }
    }
}

/// The prior of one unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Prior {
    /// Index among the unknowns.
    index: usize,
    unknown: Unknown,
    /// Whether the prior of a direction applies to the tangent of the lean, and not to the lean in degrees.
    is_of_tangent: bool,
    /// Standard deviation of [`Nuisances::value`] without forces, in the unit of the value.
    sd: f64,
    /// Expected value per newton of the sum of all forces. `sd_per_n` is the standard deviation of `per_n`.
    per_n: f64,
    sd_per_n: f64,
}

impl Prior {
    /// Standard deviation under forces with the sum `sum_n`, N.
    fn sd_under(&self, sum_n: f64) -> f64 {
        self.sd.hypot(self.sd_per_n * sum_n)
    }

    /// Deviation of a value from its expected value under forces with the sum `sum_n`, N, in standard deviations.
    fn deviation(&self, value: f64, sum_n: f64) -> f64 {
        (value - self.per_n * sum_n) / self.sd_under(sum_n)
    }

    /// Derivative of the deviation with respect to each force, 1/N.
    fn deviation_by_force(&self, value: f64, sum_n: f64) -> f64 {
        if self.per_n == 0.0 && self.sd_per_n == 0.0 {
            return 0.0;
        }
        let sd = self.sd_under(sum_n);
        let widens = self.sd_per_n * (self.sd_per_n * sum_n / sd);
        -(self.per_n + self.deviation(value, sum_n) * widens) / sd
    }
}

/// A prior as a row of the least-squares problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PriorRow {
    /// Index of the unknown with this prior.
    pub index: usize,
    /// Derivative with respect to the unknown, mm per unit of the unknown.
    pub by_unknown: f64,
    /// Derivative with respect to each force on the front plate, mm/N; on the back plate, the sign is opposite. Zero unless the expected value or its standard deviation depends on the forces.
    pub by_force: f64,
    /// Right-hand side of the row, mm.
    pub left_mm: f64,
}

/// All priors, scaled by the measurement's noise, mm.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Priors {
    priors: Vec<Prior>,
    /// Sign of the moment of each force on the base: forces on opposite plates turn it in opposite directions.
    pub turn_signs: Vec<f64>,
    noise_mm: f64,
}

impl Priors {
    /// Priors of all unknowns that have a prior: unknowns of the contacts in `questions`, of the base, of an object, and of shared errors.
    pub fn new(
        unknowns: &[Unknown],
        questions: &[ContactQuestion],
        object: Option<&TouchedObject>,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Priors {
        let base = measurement.base();
        let sd = |unknown: &Unknown| match *unknown {
            Unknown::Base(BaseMotion::Turn) => base.map(|base| base.sd_rad),
            Unknown::Base(_) => base.map(|base| base.sd_mm),
            Unknown::Across(i) => match questions[i].direction {
                Direction::Leaning(lean) => Some(lean.sd_deg),
                Direction::Measured(normal) => Some(normal.tangent_sd(questions.len())),
                Direction::Auto | Direction::Angle(_) => None,
            },
            Unknown::Position(i) => questions[i].is_position_measured().then_some(questions[i].position_sd_mm),
            Unknown::Object(BaseMotion::Turn) => object.map(|object| object.sd_rad),
            Unknown::Object(_) => object.map(|object| object.sd_mm),
            Unknown::Shared(_) => Some(1.0),
            Unknown::Force(_) => None,
        };
        let is_of_tangent = |unknown: &Unknown| match *unknown {
            Unknown::Across(i) => matches!(questions[i].direction, Direction::Measured(_)),
            _ => false,
        };
        let prior = |(index, unknown): (usize, &Unknown)| {
            let turning = base.filter(|_| *unknown == Unknown::Base(BaseMotion::Turn));
            let (per_n, sd_per_n) = turning.map_or((0.0, 0.0), |base| (base.turn_rad_per_n, base.turn_sd_rad_per_n));
            let sd = sd(unknown)?.max(f64::MIN_POSITIVE);
            Some(Prior { index, unknown: *unknown, is_of_tangent: is_of_tangent(unknown), sd, per_n, sd_per_n })
        };
        Priors {
            priors: unknowns.iter().enumerate().filter_map(prior).collect(),
            turn_signs: questions.iter().map(|q| q.position.map_or(1.0, |at| at.plate().turn_sign())).collect(),
            noise_mm: noise_mm.unwrap_or_default(),
        }
    }

    /// Standard deviation of a measured coordinate, mm. This noise scales the priors.
    pub fn noise_mm(&self) -> f64 {
        self.noise_mm
    }

    /// Sum of the forces that turn the base, N: of those on the front plate, less those on the back plate.
    fn sum_n(&self, forces_n: &[f64]) -> f64 {
        self.turn_signs.iter().zip(forces_n).map(|(sign, force_n)| sign * force_n).sum()
    }

    /// Number of priors.
    pub fn count(&self) -> usize {
        self.priors.len()
    }

    /// Sum of the squared deviations from the expected values, in standard deviations, times the squared noise, mm^2.
    pub fn misfit(&self, nuisances: &Nuisances, forces_n: &[f64]) -> f64 {
        let sum_n = self.sum_n(forces_n);
        let off = |prior: &Prior| self.noise_mm * prior.deviation(nuisances.value(prior), sum_n);
        self.priors.iter().map(|prior| off(prior).powi(2)).sum()
    }

    /// Rows of the priors in the least-squares problem, below the rows of the markers.
    pub fn rows<'p>(&'p self, nuisances: &'p Nuisances, forces_n: &'p [f64]) -> impl Iterator<Item = PriorRow> + 'p {
        let sum_n = self.sum_n(forces_n);
        self.priors.iter().map(move |prior| {
            let value = nuisances.value(prior);
            let by_unknown = match prior.unknown {
                // The prior applies to the tangent or the angle, but the unknown is the force across the direction.
                Unknown::Across(i) if prior.is_of_tangent => 1.0 / leaning_n(forces_n[i]),
                Unknown::Across(i) => (1.0 / forces_n[i]).to_degrees(),
                _ => 1.0,
            };
            PriorRow {
                index: prior.index,
                by_unknown: self.noise_mm * by_unknown / prior.sd_under(sum_n),
                by_force: self.noise_mm * prior.deviation_by_force(value, sum_n),
                left_mm: -self.noise_mm * prior.deviation(value, sum_n),
            }
        })
    }
}
