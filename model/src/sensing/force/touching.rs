//! Contacts with an object of known shape: the plate, or the pad on it, touches the object's outline tangentially.
//!
//! Each contact adds two rows to the least-squares problem, below the rows of the markers and the priors. The point of the outline that faces the
//! plate must coincide with the contact, both perpendicular to the plate and along the plate. The rows of a contact with an object determine the
//! contact's position and direction as accurately as the object's pose is known.

use super::SETTLED_ANGLE_DEG;
use super::estimator::estimate;
use super::linearised::Posed;
use super::minima::{Near, search_from};
use super::problem::{ForceProblem, Seen, State};
use super::search_history::SearchHistory;
use super::start::StartingPoint;
use crate::Vector;
use crate::finger::Plate;
use crate::mesh::{Load, LoadError, Mesh};
use crate::sensing::{ContactQuestion, Direction, Lean, Normal, SensingError, TouchedObject};
use nalgebra::Point2;

/// Assumed standard deviations of a closed contact, mm: perpendicular to the plate, and along the plate. The assumed standard deviations are far
/// smaller than the error of an object's outline, but not smaller than the error of a mesh.
const CLOSED_SD_MM: [f64; 2] = [0.01, 0.03];
/// The iteration that adapts the loads to the shape ends after this number of updates. Each update of the loads removes most of the change that
/// remains.
const SETTLINGS: usize = 12;
/// A gap of more than this number of standard deviations is no contact.
const LARGEST_GAP_SIGMAS: f64 = 6.0;
/// Uncertainty of the plate's shape between markers, as a multiple of the markers' noise.
const OPEN_BETWEEN_MARKERS: f64 = 2.0;
/// Number of points of the plate whose distance from the outline is evaluated.
const PLACES: usize = 400;

/// An object and the contacts that touch it.
#[derive(Debug, Clone)]
pub(super) struct Touching {
    pub object: TouchedObject,
    /// Thickness of the pad, mm.
    pad_mm: f64,
    /// Indices of the contacts that touch the object, from 0.
    contacts: Vec<usize>,
}

impl Touching {
    /// The object and its contacts. `None` if no contact touches the object.
    pub fn new(questions: &[ContactQuestion], object: &TouchedObject, pad_mm: f64) -> Option<Touching> {
        let contacts: Vec<usize> = (0..questions.len()).filter(|&i| touches_object(&questions[i])).collect();
        (!contacts.is_empty()).then(|| Touching { object: object.clone(), pad_mm, contacts })
    }

    /// Number of rows that the contacts add.
    pub fn row_count(&self) -> usize {
        2 * self.contacts.len()
    }

    /// Violations of the contact conditions by a shape. Each violation is divided by its standard deviation and multiplied by the noise, mm.
    pub fn misses_mm<'t>(&'t self, mesh: &'t Mesh, shape: Posed<'t>, noise_mm: f64) -> impl Iterator<Item = f64> + 't {
        self.contacts.iter().flat_map(move |&i| {
            // The contacts have been checked and are on the plate.
            let s_mm = shape.contacts[i].position_mm(mesh.finger()).unwrap_or(f64::NAN);
            let missed = self.missed_mm(mesh, s_mm, shape).unwrap_or([f64::NAN; 2]);
            [0, 1].map(|way| missed[way] / CLOSED_SD_MM[way] * noise_mm)
        })
    }

    /// Sum of the squared violations, mm^2.
    pub fn misfit(&self, mesh: &Mesh, shape: Posed, noise_mm: f64) -> f64 {
        self.misses_mm(mesh, shape, noise_mm).map(|missed_mm| missed_mm * missed_mm).sum()
    }

    /// Distance between the plate at position `s_mm` and the point of the outline that faces this position. Returns the gap and the distance along
    /// the plate, mm.
    fn missed_mm(&self, mesh: &Mesh, s_mm: f64, shape: Posed) -> Result<[f64; 2], LoadError> {
        let Posed { motion, nuisances, .. } = shape;
        let turn_deg = mesh.normal_turn(motion, &Load::at_position(s_mm, Vector::zeros()), 0.0)?.to_degrees();
        let [inward, tipward] =
            [0.0, 90.0].map(|deg| nuisances.base.rotation * mesh.finger().direction(deg + turn_deg));
        let point = nuisances.base * Point2::from(mesh.front_point(motion, s_mm)?);
        let apart = point.coords - self.object.point_facing(inward, nuisances.object);
        // Distance from the plate's middle line to the surface of plate and pad.
        let reach_mm = 0.5 * mesh.finger().thickness_mm(Plate::Front, s_mm) + self.pad_mm;
        Ok([apart.dot(&inward) - reach_mm, apart.dot(&tipward)])
    }
}

/// Whether a contact touches an object of known shape.
pub(super) fn touches_object(question: &ContactQuestion) -> bool {
    matches!(question.direction, Direction::Leaning(Lean { from: Normal::Object, .. }))
}

/// Iterates a state to the equilibrium under loads that follow its shape.
///
/// # Errors
/// [`SensingError::Statics`] if the finger has no equilibrium under loads that follow its shape.
pub(super) fn settle(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    for _ in 0..SETTLINGS {
        let loads = state.loads.clone();
        state.linearised.step.clear();
        state.linearised.step.resize(problem.unknowns.len(), 0.0);
        let turn_deg = problem.advance(state)?;
        state.motion = problem.statics.shifted(&state.motion, &loads, &state.loads)?.motion;
        if turn_deg <= SETTLED_ANGLE_DEG {
            break;
        }
    }
    Ok(())
}

/// The problem for the same contacts without the object. Directions refer to the normal of the plate.
fn without_object<'m>(problem: &ForceProblem<'m>) -> Result<ForceProblem<'m>, SensingError> {
    let plain = |question: &ContactQuestion| match question.direction {
        Direction::Leaning(lean) if lean.from == Normal::Object => {
            let from = Normal::Deformed { over_mm: 0.0 };
            ContactQuestion { direction: Direction::Leaning(Lean { from, ..lean }), ..*question }
        }
        _ => *question,
    };
    let questions: Vec<ContactQuestion> = problem.questions.iter().map(plain).collect();
    ForceProblem::new(problem.mesh, &questions, problem.pad)
}

/// Refuses an object that is farther from the plate, or deeper in the plate, than the uncertainty of the object's pose allows.
fn require_touch(
    problem: &ForceProblem,
    state: &State,
    Seen { measurement, noise_mm }: Seen,
) -> Result<(), SensingError> {
    let Some(touching) = &problem.object else { return Ok(()) };
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let shape = state.posed();
    let mut nearest_mm = [f64::INFINITY; 2];
    for i in 1..=PLACES {
        let missed_mm = touching.missed_mm(problem.mesh, length_mm * i as f64 / PLACES as f64, shape)?;
        if missed_mm[1].abs() < nearest_mm[1].abs() {
            nearest_mm = missed_mm;
        }
    }
    let [gap_mm, along_mm] = nearest_mm;
    // A distance along the plate counts as zero if it is smaller than the spacing of neighbouring points.
    let beyond_mm = (along_mm.abs() - length_mm / PLACES as f64).max(0.0);
    let gap_mm = gap_mm.hypot(beyond_mm).copysign(gap_mm);
    let object = &touching.object;
    let parts_mm = [
        object.sd_mm,
        object.sd_rad * object.shape.largest_radius_mm(),
        measurement.base().map_or(0.0, |base| base.sd_mm),
        OPEN_BETWEEN_MARKERS * noise_mm.unwrap_or_default(),
        CLOSED_SD_MM[0],
    ];
    let sd_mm = parts_mm.into_iter().fold(0.0, f64::hypot);
    match gap_mm.abs() > LARGEST_GAP_SIGMAS * sd_mm {
        true => Err(SensingError::NotTouching { contact: touching.contacts[0] + 1, gap_mm, sd_mm }),
        false => Ok(()),
    }
}

/// The estimate from markers alone, as a starting point. `None` if the markers do not identify the unknowns.
///
/// # Errors
/// [`SensingError::NotTouching`] if the object cannot touch the plate.
pub(super) fn sense_without_object(problem: &mut ForceProblem, seen: Seen) -> Result<Option<State>, SensingError> {
    let mut plain = without_object(problem)?;
    let found = plain.expect(seen).and_then(|_| estimate(&mut plain, Near::default(), &mut None, seen));
    let Ok((_, state)) = found else { return Ok(None) };
    require_touch(problem, &state, seen)?;
    problem.resumed(state, seen).map(Some)
}

/// The nearest minimum of the problem without the object, as a starting point.
pub(super) fn search_without_object(
    problem: &mut ForceProblem,
    seen: Seen,
    start: StartingPoint,
) -> Result<State, SensingError> {
    let mut plain = without_object(problem)?;
    plain.expect(seen)?;
    let (mut starts, mut history) = (Vec::new(), SearchHistory::default());
    let found = search_from(&mut plain, seen, start, &mut starts, &mut history)?;
    problem.resumed(found.ok_or(SensingError::NoContact)?.state, seen)
}
