//! What is unknown beside forces and positions, but not quite: where the base is, by how much friction turns a force, and where an object is.
//!
//! Each has a Gaussian prior, which stands below the markers as one more row of the least squares problem: the deviation from
//! what is expected, in its standard deviations, times the noise of a coordinate. A base that gives way is expected to turn with the forces.

use super::unknowns::{BaseMotion, Unknown};
use crate::measurement::{BaseUncertainty, Measurement};
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
}

impl Nuisances {
    /// All as expected.
    pub fn expected(contacts: usize) -> Nuisances {
        Nuisances { base: Isometry2::identity(), further_leans_deg: vec![0.0; contacts], object: [0.0; 3] }
    }

    /// What is expected to be zero, or to grow with the forces: a motion of the base or an object in mm and rad, or a lean in degrees.
    fn value(&self, unknown: Unknown) -> f64 {
        match unknown {
            Unknown::Base(BaseMotion::X) => self.base.translation.x,
            Unknown::Base(BaseMotion::Y) => self.base.translation.y,
            Unknown::Base(BaseMotion::Turn) => self.base.rotation.angle(),
            Unknown::Across(i) => self.further_leans_deg[i],
            Unknown::Object(way) => self.object[way as usize],
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
    /// Standard deviation of [`Nuisances::value`].
    sd: f64,
}

/// A prior as a row of the least squares problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PriorRow {
    /// The unknown that it holds.
    pub index: usize,
    /// By the unknown, mm to its unit.
    pub by_unknown: f64,
    /// By each force, mm/N, where what is expected grows with the forces; otherwise zero.
    pub by_force: f64,
    /// What is left, mm.
    pub left_mm: f64,
}

/// All priors, in mm of the measurement's noise.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Priors {
    priors: Vec<Prior>,
    noise_mm: f64,
    /// By how much all forces together turn the base, rad a newton.
    turn_rad_per_n: f64,
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
        let sd = |unknown: &Unknown| match (*unknown, measurement.base()) {
            (Unknown::Base(BaseMotion::Turn), Some(BaseUncertainty { sd_rad, .. })) => Some(sd_rad),
            (Unknown::Base(_), Some(BaseUncertainty { sd_mm, .. })) => Some(sd_mm),
            (Unknown::Across(i), _) => match questions[i].direction {
                Direction::Leaning(lean) => Some(lean.sd_deg),
                Direction::Auto | Direction::Angle(_) => None,
            },
            (Unknown::Object(BaseMotion::Turn), _) => object.map(|object| object.sd_rad),
            (Unknown::Object(_), _) => object.map(|object| object.sd_mm),
            _ => None,
        };
        let prior = |(index, unknown): (usize, &Unknown)| {
            sd(unknown).map(|sd| Prior { index, unknown: *unknown, sd: sd.max(f64::MIN_POSITIVE) })
        };
        Priors {
            priors: unknowns.iter().enumerate().filter_map(prior).collect(),
            noise_mm: noise_mm.unwrap_or_default(),
            turn_rad_per_n: measurement.base().map_or(0.0, |base| base.turn_rad_per_n),
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

    /// Change of what is expected of an unknown with each force, a newton.
    fn expected_per_n(&self, unknown: Unknown) -> f64 {
        if unknown == Unknown::Base(BaseMotion::Turn) { self.turn_rad_per_n } else { 0.0 }
    }

    /// By how much an unknown is off what is expected of it under some forces.
    fn deviation(&self, unknown: Unknown, nuisances: &Nuisances, forces_n: &[f64]) -> f64 {
        nuisances.value(unknown) - self.expected_per_n(unknown) * forces_n.iter().sum::<f64>()
    }

    /// Sum of the squared deviations, mm^2.
    pub fn misfit(&self, nuisances: &Nuisances, forces_n: &[f64]) -> f64 {
        let off = |prior: &Prior| self.noise_mm * self.deviation(prior.unknown, nuisances, forces_n) / prior.sd;
        self.priors.iter().map(|prior| off(prior).powi(2)).sum()
    }

    /// The rows below those of the markers.
    pub fn rows<'p>(&'p self, nuisances: &'p Nuisances, forces_n: &'p [f64]) -> impl Iterator<Item = PriorRow> + 'p {
        self.priors.iter().map(move |prior| {
            let per_sd_mm = self.noise_mm / prior.sd;
            let by_unknown = match prior.unknown {
                // A lean is an angle, its unknown a force across another.
                Unknown::Across(i) => (1.0 / forces_n[i]).to_degrees(),
                _ => 1.0,
            };
            PriorRow {
                index: prior.index,
                by_unknown: per_sd_mm * by_unknown,
                by_force: -per_sd_mm * self.expected_per_n(prior.unknown),
                left_mm: -per_sd_mm * self.deviation(prior.unknown, nuisances, forces_n),
            }
        })
    }
}
