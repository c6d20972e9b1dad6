//! The unknowns of a force problem, and what is stated of each: when it is an unknown, its scale, its prior, and the largest standard deviation at
//! which it counts as identifiable.
//!
//! An unknown is defined in three files: here, in [`values`](super::values) (its value, and how a step changes the value), and in
//! [`marker_motion`](super::marker_motion) (the displacement that it causes at a marker, beside the derivative of this displacement). Its prior becomes a
//! row in `priors`, and its share of each force's standard deviation follows from the covariance in `assessment`, without further code; its own
//! estimate is not reported. `pressed` also names `Unknown::Base`, to order the columns of a calibration. All other files
//! treat a nuisance parameter (an unknown without a contact) alike: the compiler names each `match` that lacks it, and where a `match` ends with `_`,
//! the last arm is right for it. An unknown whose displacement of a marker depends on the shape has no [`fixed_pattern`](super::marker_motion::fixed_pattern). A search for another
//! minimum starts from the expected value of each nuisance parameter, except for the base (`minima`). Any prior makes the search seek rivals on the linear
//! finger less exactly (`priors.count()` in `profile` and `minima`). A constant of the image that a displacement needs belongs into the variant: `expect` then
//! forgets earlier states.

use crate::finger::{Finger, Plate};
use crate::measurement::{BaseUncertainty, Measurement};
use crate::sensing::{ContactQuestion, Direction, TouchedObject};

/// Scale of a rotation of the base, rad. A rotation of the base by this angle moves the tip about as far as a force of 1 N does.
const TURN_UNIT: f64 = 0.01;
/// Smallest force, N, at which a force across changes the direction from a measured normal. It keeps the prior of the direction finite without a
/// force.
const LEAST_LEANING_N: f64 = 1e-9;
/// A direction is not identifiable if its standard deviation exceeds this angle, degrees. A position is not identifiable if its standard deviation
/// exceeds the share `LARGEST_POSITION_SIGMA` of the plate's length.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;
const LARGEST_POSITION_SIGMA: f64 = 0.25;

/// One unknown. A number in a variant is the index of the contact or of the shared error, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unknown {
    /// Force along the contact's direction, N.
    Force(usize),
    /// Position along the contact's plate, mm.
    Position(usize),
    /// Component of a force across the force's current direction or, for a measured direction, across the measured normal, N. This component changes
    /// the direction.
    Across(usize),
    /// Motion of the base from its measured pose.
    Base(PosePart),
    /// Motion of the object from its stated pose. The object rotates about the origin of its outline.
    Object(PosePart),
    /// Error that all markers share, in units of its standard deviation.
    Shared(usize),
}

/// A part of the motion of a base or an object in the finger frame. A base rotates about its own origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PosePart {
    /// Translation along x, mm.
    X,
    /// Translation along y, mm.
    Y,
    /// Rotation, rad.
    Turn,
}

const POSE: [PosePart; 3] = [PosePart::X, PosePart::Y, PosePart::Turn];

/// Gaussian prior of an unknown. It applies to the [value](super::values::Nuisances::value) of the unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UnknownPrior {
    /// Whether the value of a direction is the tangent of the lean, and not the lean in degrees.
    pub is_of_tangent: bool,
    /// Standard deviation without forces, in the unit of the value.
    pub sd: f64,
    /// Expected value per newton of the sum of all forces. `sd_per_n` is the standard deviation of `per_n`.
    pub per_n: f64,
    pub sd_per_n: f64,
}

/// Largest standard deviation of a position or direction that counts as identifiable.
pub(super) struct IdentifiableLimit {
    pub what: &'static str,
    /// Index of the contact, from 0.
    pub contact: usize,
    /// The limit, in `unit`.
    pub sigma: f64,
    pub unit: &'static str,
}

/// Force, N, that divides a force across a measured normal to give the tangent of the lean.
pub(super) fn leaning_n(force_n: f64) -> f64 {
    force_n.abs().max(LEAST_LEANING_N).copysign(force_n)
}

impl Unknown {
    /// All unknowns: those of the contacts in `questions` and of an object, and the uncertain base and the shared errors that `measurement` states.
    /// Forces come first, in the order of the contacts.
    pub(super) fn list(
        questions: &[ContactQuestion],
        object: Option<&TouchedObject>,
        measurement: &Measurement,
    ) -> Vec<Unknown> {
        let is_sought = |question: &ContactQuestion| match question.direction {
            Direction::Auto => true,
            Direction::Leaning(lean) => lean.sd_deg > 0.0,
            Direction::Measured(normal) => normal.tangent_sd(questions.len()) > 0.0,
            Direction::Angle(_) => false,
        };
        let forces = (0..questions.len()).map(Unknown::Force);
        let positions = questions.iter().enumerate().filter(|(_, q)| q.position.is_none() || q.is_position_measured());
        let angles = questions.iter().enumerate().filter(|(_, q)| is_sought(q));
        let base = POSE.into_iter().filter(|_| measurement.base().is_some());
        let object = POSE.into_iter().filter(|part| {
            object.is_some_and(|object| if *part == PosePart::Turn { object.may_turn() } else { object.sd_mm > 0.0 })
        });
        forces
            .chain(positions.map(|(i, _)| Unknown::Position(i)))
            .chain(angles.map(|(i, _)| Unknown::Across(i)))
            .chain(base.map(Unknown::Base))
            .chain(object.map(Unknown::Object))
            .chain((0..measurement.shared_errors().len()).map(Unknown::Shared))
            .collect()
    }

    /// Index of the contact to which the unknown belongs, if any.
    pub(super) fn contact(self) -> Option<usize> {
        match self {
            Unknown::Force(i) | Unknown::Position(i) | Unknown::Across(i) => Some(i),
            Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => None,
        }
    }

    /// Whether the unknown is the position or the direction of a measured contact.
    pub(super) fn is_measured(self, questions: &[ContactQuestion]) -> bool {
        match self {
            Unknown::Position(i) => questions[i].is_position_measured(),
            Unknown::Across(i) => questions[i].is_normal_measured(),
            Unknown::Force(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => false,
        }
    }

    /// Scale of the unknown, in its unit: 1 N for forces, [`TURN_UNIT`] for rotations, 1 mm for translations, and one standard deviation for errors
    /// that all markers share. The scale of a position is a shift of the contact that moves the finger about as far as a force of 1 N does, or the
    /// standard deviation of a measured position. The scale of a force across a measured normal is its standard deviation before the measurement, so
    /// that small forces and accurate normals remain identifiable.
    pub(super) fn scale(self, questions: &[ContactQuestion], forces_n: &[f64], finger: &Finger) -> f64 {
        match self {
            Unknown::Base(PosePart::Turn) | Unknown::Object(PosePart::Turn) => TURN_UNIT,
            Unknown::Across(i) => match questions[i].direction {
                Direction::Measured(normal) => leaning_n(forces_n[i]).abs() * normal.tangent_sd(questions.len()),
                _ => 1.0,
            },
            Unknown::Force(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => 1.0,
            Unknown::Position(i) if questions[i].is_position_measured() => questions[i].position_sd_mm,
            Unknown::Position(i) => {
                let largest_n = forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
                let force_n = forces_n[i].abs().max(1e-3 * largest_n).max(f64::MIN_POSITIVE);
                0.1 * finger.plate_length_mm(Plate::Front) / force_n
            }
        }
    }

    /// Relative size of a change of the unknown by `by`. Changes of forces are relative to the largest force, `largest_n`, and changes of positions
    /// and translations to the plate's length. Changes of rotations are in rad.
    pub(super) fn relative_change(self, by: f64, largest_n: f64, length_mm: f64) -> f64 {
        match self {
            Unknown::Force(_) | Unknown::Across(_) => by.abs() / largest_n,
            Unknown::Base(PosePart::Turn) | Unknown::Object(PosePart::Turn) => by.abs(),
            // One standard deviation of a shared error moves markers by some tenths of a millimetre.
            Unknown::Position(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => by.abs() / length_mm,
        }
    }

    /// Prior of the unknown. `None` if nothing is known of it before the measurement.
    pub(super) fn prior(
        self,
        questions: &[ContactQuestion],
        object: Option<&TouchedObject>,
        measurement: &Measurement,
    ) -> Option<UnknownPrior> {
        let of_sd = |sd: f64| {
            Some(UnknownPrior { is_of_tangent: false, sd: sd.max(f64::MIN_POSITIVE), per_n: 0.0, sd_per_n: 0.0 })
        };
        let base = measurement.base();
        match self {
            Unknown::Force(_) => None,
            Unknown::Position(i) if questions[i].is_position_measured() => of_sd(questions[i].position_sd_mm),
            Unknown::Position(_) => None,
            Unknown::Across(i) => match questions[i].direction {
                Direction::Leaning(lean) => of_sd(lean.sd_deg),
                Direction::Measured(normal) => {
                    of_sd(normal.tangent_sd(questions.len())).map(|prior| UnknownPrior { is_of_tangent: true, ..prior })
                }
                Direction::Auto | Direction::Angle(_) => None,
            },
            Unknown::Base(PosePart::Turn) => {
                let BaseUncertainty { sd_rad, turn_rad_per_n, turn_sd_rad_per_n, .. } = base?;
                of_sd(sd_rad).map(|prior| UnknownPrior { per_n: turn_rad_per_n, sd_per_n: turn_sd_rad_per_n, ..prior })
            }
            Unknown::Base(_) => of_sd(base?.sd_mm),
            Unknown::Object(PosePart::Turn) => of_sd(object?.sd_rad),
            Unknown::Object(_) => of_sd(object?.sd_mm),
            Unknown::Shared(_) => of_sd(1.0),
        }
    }

    /// Largest standard deviation at which the unknown is identifiable. `None` without a limit. A measured contact is at least as certain as
    /// measured.
    pub(super) fn limit(self, questions: &[ContactQuestion], finger: &Finger) -> Option<IdentifiableLimit> {
        match self {
            _ if self.is_measured(questions) => None,
            Unknown::Position(contact) => {
                let sigma = LARGEST_POSITION_SIGMA * finger.plate_length_mm(Plate::Front);
                Some(IdentifiableLimit { what: "the position", contact, sigma, unit: "mm" })
            }
            Unknown::Across(contact) => {
                let sigma = LARGEST_ANGLE_SIGMA_DEG;
                Some(IdentifiableLimit { what: "the direction", contact, sigma, unit: "deg" })
            }
            Unknown::Force(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => None,
        }
    }
}
