//! What is unknown beside forces and positions, but not quite: where the base is, by how much friction turns a force, where an object is, and
//! errors that markers share.
//!
//! Each has a Gaussian prior, which stands below the markers as one more row of the least squares problem: the deviation from what is expected, in
//! its standard deviations, times the noise of a coordinate. A base that gives way is expected to turn with the forces, and as much less surely.

use super::unknowns::{BaseMotion, Unknown};
use crate::Vector;
use crate::measurement::{Measurement, SharedError};
use crate::sensing::{ContactQuestion, Direction, TouchedObject};
use nalgebra::Isometry2;

/// Values of the nuisances.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nuisances {
    /// Where the base is, in the finger frame of the measurement.
    pub base: Isometry2<f64>,
    /// How much further than its mean each force leans, degrees.
    pub further_leans_deg: Vec<f64>,
    /// By how much the object is off where it is thought to be: mm, mm and rad.
    pub object: [f64; 3],
    /// Errors that markers share, in their standard deviations, and by how much they displace each key node's marker together, mm.
    pub shared: Vec<f64>,
    shared_mm: Vec<Vector>,
}

impl Nuisances {
    /// All as expected.
    pub fn expected(contacts: usize, shared_errors: &[SharedError]) -> Nuisances {
        Nuisances {
            base: Isometry2::identity(),
            further_leans_deg: vec![0.0; contacts],
            object: [0.0; 3],
            shared: vec![0.0; shared_errors.len()],
            shared_mm: shared_errors.first().map_or_else(Vec::new, |error| vec![Vector::zeros(); error.len()]),
        }
    }

    /// By how much the errors that markers share displace a key node's, mm.
    pub fn shared_mm(&self, key_node: usize) -> Vector {
        self.shared_mm.get(key_node).copied().unwrap_or_default()
    }

    /// Lets a shared error grow by so many of its standard deviations.
    pub fn share(&mut self, index: usize, error: &SharedError, by: f64) {
        self.shared[index] += by;
        self.shared_mm.iter_mut().zip(error).for_each(|(all, of_error)| *all += of_error * by);
    }

    /// What is expected to be zero, or to grow with the forces: a motion of the base or an object in mm and rad, or a lean in degrees.
    fn value(&self, unknown: Unknown) -> f64 {
        match unknown {
            Unknown::Base(BaseMotion::X) => self.base.translation.x,
            Unknown::Base(BaseMotion::Y) => self.base.translation.y,
            Unknown::Base(BaseMotion::Turn) => self.base.rotation.angle(),
            Unknown::Across(i) => self.further_leans_deg[i],
            Unknown::Object(way) => self.object[way as usize],
            Unknown::Shared(i) => self.shared[i],
            Unknown::Force(_) | Unknown::Position(_) => 0.0,
        }
    }
}

/// The prior of one unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Prior {
    /// Place among the unknowns.
    index: usize,
    unknown: Unknown,
    /// Standard deviation of [`Nuisances::value`], without forces.
    sd: f64,
    /// What is expected of it, and a standard deviation of its own, for each newton of all forces together.
    per_n: f64,
    sd_per_n: f64,
}

impl Prior {
    /// Its standard deviation under forces of a sum.
    fn sd_under(&self, sum_n: f64) -> f64 {
        self.sd.hypot(self.sd_per_n * sum_n)
    }

    /// By how much a value is off what is expected under them, in standard deviations.
    fn deviation(&self, value: f64, sum_n: f64) -> f64 {
        (value - self.per_n * sum_n) / self.sd_under(sum_n)
    }

    /// Change of that deviation with each force, 1/N.
    fn deviation_by_force(&self, value: f64, sum_n: f64) -> f64 {
        if self.per_n == 0.0 && self.sd_per_n == 0.0 {
            return 0.0;
        }
        let sd = self.sd_under(sum_n);
        let widens = self.sd_per_n * (self.sd_per_n * sum_n / sd);
        -(self.per_n + self.deviation(value, sum_n) * widens) / sd
    }
}

/// A prior as a row of the least squares problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PriorRow {
    /// The unknown that it holds.
    pub index: usize,
    /// By the unknown, mm to its unit.
    pub by_unknown: f64,
    /// By each force, mm/N, where what is expected, or its standard deviation, grows with the forces; otherwise zero.
    pub by_force: f64,
    /// What is left, mm.
    pub left_mm: f64,
}

/// All priors, in mm of the measurement's noise.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Priors {
    priors: Vec<Prior>,
    noise_mm: f64,
}

impl Priors {
    /// Those of some questions, of a measurement's base and of an object.
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
                Direction::Auto | Direction::Angle(_) => None,
            },
            Unknown::Object(BaseMotion::Turn) => object.map(|object| object.sd_rad),
            Unknown::Object(_) => object.map(|object| object.sd_mm),
            Unknown::Shared(_) => Some(1.0),
            Unknown::Force(_) | Unknown::Position(_) => None,
        };
        let prior = |(index, unknown): (usize, &Unknown)| {
            let turning = base.filter(|_| *unknown == Unknown::Base(BaseMotion::Turn));
            let (per_n, sd_per_n) = turning.map_or((0.0, 0.0), |base| (base.turn_rad_per_n, base.turn_sd_rad_per_n));
            let sd = sd(unknown)?.max(f64::MIN_POSITIVE);
            Some(Prior { index, unknown: *unknown, sd, per_n, sd_per_n })
        };
        Priors {
            priors: unknowns.iter().enumerate().filter_map(prior).collect(),
            noise_mm: noise_mm.unwrap_or_default(),
        }
    }

    /// Standard deviation of a measured coordinate against which they are weighed, mm.
    pub fn noise_mm(&self) -> f64 {
        self.noise_mm
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.priors.len()
    }

    /// Sum of the squared deviations, mm^2.
    pub fn misfit(&self, nuisances: &Nuisances, forces_n: &[f64]) -> f64 {
        let sum_n = forces_n.iter().sum();
        let off = |prior: &Prior| self.noise_mm * prior.deviation(nuisances.value(prior.unknown), sum_n);
        self.priors.iter().map(|prior| off(prior).powi(2)).sum()
    }

    /// The rows below those of the markers.
    pub fn rows<'p>(&'p self, nuisances: &'p Nuisances, forces_n: &'p [f64]) -> impl Iterator<Item = PriorRow> + 'p {
        let sum_n = forces_n.iter().sum();
        self.priors.iter().map(move |prior| {
            let value = nuisances.value(prior.unknown);
            let by_unknown = match prior.unknown {
                // A lean is an angle, its unknown a force across another.
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
