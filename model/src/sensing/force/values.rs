//! Values of the unknowns, and how a step changes them.
//!
//! Forces, positions and directions are values of a state. All other values are [`Nuisances`]: poses of the base and of an object, leans of forces,
//! shifts from measured positions, and errors that all markers share.

use super::unknowns::{PosePart, Unknown, leaning_n};
use crate::Vector;
use crate::finger::{Finger, Plate, PlatePosition};
use crate::measurement::{PlateMotion, SharedError};
use crate::sensing::{Contact, ContactPosition, ContactQuestion, Direction};
use nalgebra::{Isometry2, Translation2, UnitComplex};

/// A position changes by at most this share of the plate's length in one step.
const LONGEST_MOVE: f64 = 0.2;
/// A position stays at least this share of the plate's length away from the base. Measurements cannot distinguish a contact closer to the base from a
/// contact at the clamp.
const NEAREST_TO_BASE: f64 = 0.01;

/// Values of all unknowns, to which a step is applied.
pub(super) struct Values<'v> {
    pub forces_n: &'v mut [f64],
    pub contacts: &'v mut [Contact],
    pub nuisances: &'v mut Nuisances,
}

/// Values of the nuisance parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nuisances {
    /// Motion of the base from its expected pose, in the finger frame of the measurement, mm and rad.
    pub base: Isometry2<f64>,
    /// Difference between the lean of each force (its angle from the normal) and the mean lean, degrees. The mean lean from a measured normal is
    /// zero.
    pub further_leans_deg: Vec<f64>,
    /// Difference between the position of each contact and its measured position, mm. Meaningless for an unknown position.
    pub shifts_mm: Vec<f64>,
    /// Deviation of the object from its stated pose: x (mm), y (mm) and rotation (rad).
    pub object: [f64; 3],
    /// Errors that all markers share, in standard deviations. `shared_mm` is the displacement of each key node's marker due to all shared errors
    /// together, mm.
    pub shared: Vec<f64>,
    shared_mm: Vec<Vector>,
    /// Motion of the plate at each contact due to all shared errors together.
    shared_plate: Vec<PlateMotion>,
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
            shared_plate: Vec::new(),
        };
        nuisances.use_patterns(shared_errors);
        nuisances
    }

    /// Applies the amplitudes of the shared errors to other patterns of the same errors.
    pub fn use_patterns(&mut self, shared_errors: &[SharedError]) {
        let key_nodes = shared_errors.first().map_or(0, |error| error.pattern_mm.len());
        self.shared_mm = vec![Vector::zeros(); key_nodes];
        self.shared_plate = vec![PlateMotion::default(); shared_errors.first().map_or(0, |error| error.plate.len())];
        for (k, by) in std::mem::take(&mut self.shared).into_iter().enumerate() {
            self.shared.push(0.0);
            self.share(k, &shared_errors[k], by);
        }
    }

    /// Displacement of a key node's marker due to the errors that all markers share, mm.
    pub fn shared_mm(&self, key_node: usize) -> Vector {
        self.shared_mm.get(key_node).copied().unwrap_or_default()
    }

    /// Motion of the plate at a contact due to the errors that all markers share.
    pub fn shared_plate(&self, contact: usize) -> PlateMotion {
        self.shared_plate.get(contact).copied().unwrap_or_default()
    }

    /// Rotation of the base as a change of an angle on a plate, degrees.
    pub fn base_turn_deg(&self, plate: Plate) -> f64 {
        plate.turn_sign() * self.base.rotation.angle().to_degrees()
    }

    /// Changes a shared error by `by` times its standard deviation.
    fn share(&mut self, index: usize, error: &SharedError, by: f64) {
        self.shared[index] += by;
        self.shared_mm.iter_mut().zip(&error.pattern_mm).for_each(|(all, of_error)| *all += of_error * by);
        self.shared_plate.iter_mut().zip(&error.plate).for_each(|(all, of_error)| *all = all.and(by, *of_error));
    }

    /// Tangent of the angle between the force of a contact and its measured normal, dimensionless.
    pub fn tangent(&self, contact: usize) -> f64 {
        self.further_leans_deg[contact].to_radians().tan()
    }

    /// Changes a nuisance parameter by `by`, in the unit of the unknown. Forces, positions and directions are no nuisance parameters.
    pub fn change(&mut self, unknown: Unknown, by: f64, shared_errors: &[SharedError]) {
        match unknown {
            Unknown::Base(PosePart::X) => self.base.append_translation_mut(&Translation2::new(by, 0.0)),
            Unknown::Base(PosePart::Y) => self.base.append_translation_mut(&Translation2::new(0.0, by)),
            Unknown::Base(PosePart::Turn) => self.base.append_rotation_wrt_center_mut(&UnitComplex::new(by)),
            Unknown::Object(part) => self.object[part as usize] += by,
            Unknown::Shared(k) => self.share(k, &shared_errors[k], by),
            Unknown::Force(_) | Unknown::Position(_) | Unknown::Across(_) => {}
        }
    }

    /// Value to which the prior of an unknown applies, in mm, rad, degrees, tangents or standard deviations. `is_of_tangent` states whether the value
    /// of a direction is the tangent of the lean, and not the lean in degrees.
    pub fn value(&self, unknown: Unknown, is_of_tangent: bool) -> f64 {
        match unknown {
            Unknown::Base(PosePart::X) => self.base.translation.x,
            Unknown::Base(PosePart::Y) => self.base.translation.y,
            Unknown::Base(PosePart::Turn) => self.base.rotation.angle(),
            Unknown::Across(i) if is_of_tangent => self.tangent(i),
            Unknown::Across(i) => self.further_leans_deg[i],
            Unknown::Position(i) => self.shifts_mm[i],
            Unknown::Object(part) => self.object[part as usize],
            Unknown::Shared(i) => self.shared[i],
            Unknown::Force(_) => 0.0,
        }
    }
}

/// Derivative of an unknown's [value](Nuisances::value) with respect to the unknown.
pub(super) fn value_rate(unknown: Unknown, is_of_tangent: bool, forces_n: &[f64]) -> f64 {
    match unknown {
        // The value is the tangent or the angle, but the unknown is the force across the direction.
        Unknown::Across(i) if is_of_tangent => 1.0 / leaning_n(forces_n[i]),
        Unknown::Across(i) => (1.0 / forces_n[i]).to_degrees(),
        Unknown::Force(_) | Unknown::Position(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => 1.0,
    }
}

impl Values<'_> {
    /// Changes the values by `step`, in the units of `unknowns`. Positions stay on their plates.
    pub fn advance(
        &mut self,
        (unknowns, step): (&[Unknown], &[f64]),
        questions: &[ContactQuestion],
        shared_errors: &[SharedError],
        finger: &Finger,
    ) {
        for (&unknown, &x) in unknowns.iter().zip(step) {
            match unknown {
                Unknown::Force(i) => self.forces_n[i] += x,
                // Forces are the first unknowns, so the force along the direction has already been updated.
                Unknown::Across(i) => self.lean(i, x, questions[i].direction, self.forces_n[i] - step[i]),
                Unknown::Position(i) => self.shift(i, x, finger),
                Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => {
                    self.nuisances.change(unknown, x, shared_errors);
                }
            }
        }
    }

    /// Turns the force at `contact` by adding the force `across_n` across its direction. The force before the step was `before_n`, both in N.
    fn lean(&mut self, contact: usize, across_n: f64, direction: Direction, before_n: f64) {
        let force_n = &mut self.forces_n[contact];
        let further_lean_deg = &mut self.nuisances.further_leans_deg[contact];
        match direction {
            // The force across a measured normal is the product of the force along it and of the tangent. Its derivative with respect to the tangent
            // is the force before the step.
            Direction::Measured(_) => {
                let tangent = further_lean_deg.to_radians().tan() + across_n / leaning_n(before_n);
                *further_lean_deg = tangent.atan().to_degrees();
            }
            // A step turns a lean (angle between force and normal) by less than 90 degrees, so a force keeps its sign. Beyond 90 degrees, the opposite
            // force at the opposite lean is the same load, and nearer to the prior.
            Direction::Leaning(_) => {
                *further_lean_deg += (across_n / *force_n).atan().to_degrees();
                *force_n = force_n.signum() * force_n.hypot(across_n);
                if further_lean_deg.abs() > 90.0 {
                    *further_lean_deg -= 180.0_f64.copysign(*further_lean_deg);
                    *force_n = -*force_n;
                }
            }
            Direction::Angle(_) | Direction::Auto => {
                self.contacts[contact].angle_deg += across_n.atan2(*force_n).to_degrees();
                *force_n = force_n.hypot(across_n);
            }
        }
    }

    /// Moves a contact by `by_mm` along its plate, at most up to the limits of a step and of the plate.
    fn shift(&mut self, contact: usize, by_mm: f64, finger: &Finger) {
        if let ContactPosition::At(PlatePosition { plate, s_mm }) = &mut self.contacts[contact].position {
            let length_mm = finger.plate_length_mm(*plate);
            let by_mm = by_mm.clamp(-LONGEST_MOVE * length_mm, LONGEST_MOVE * length_mm);
            let before_mm = *s_mm;
            *s_mm = (before_mm + by_mm).clamp(before_mm.min(NEAREST_TO_BASE * length_mm), length_mm);
            self.nuisances.shifts_mm[contact] += *s_mm - before_mm;
        }
    }
}
