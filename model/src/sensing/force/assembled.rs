//! Errors of assembly and mounting as part of a force problem.
//!
//! To first order, each error displaces the markers of a bent finger in a fixed pattern, which depends on the forces. The forces and the amplitudes
//! of the patterns are estimated together, and the patterns are linearised again at each estimate (Gauss-Newton on the finger with its errors).

use super::estimator::NearForces;
use super::linearised::Seen;
use super::minima::{find_minima, minimum_near};
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::{carry_over, state_of, state_under};
use super::values::Nuisances;
use crate::Finger;
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::assembly::Pushed;
use crate::sensing::{
    Contact, ContactPosition, ContactQuestion, Direction, PadForce, SensingError, TouchedObject, UnloadedFinger,
};

/// Beam elements per member of the mesh on which errors are linearised.
const ELEMENTS: usize = 4;
/// Standard deviations of a marker coordinate, mm, that the first rounds assume in addition to the stated noise. They keep a search whose patterns
/// belong to other forces from ending at a local minimum far from the priors.
const FIRST_ERRORS_MM: [f64; 5] = [0.3, 0.1, 0.03, 0.01, 0.003];
/// Starting points of the first round if no other search finds a minimum: positions as shares of the plate's length, and the force, N.
const STARTS: [f64; 4] = [0.35, 0.5, 0.65, 0.8];
const FIRST_FORCE_N: f64 = 1.0;
/// Errors have settled if, after they are linearised again, every combination of unknowns differs from its optimum by at most this number of standard
/// deviations. The estimate fails after `ROUNDS` rounds.
const SETTLED_SIGMAS: f64 = 0.02;
/// Displacements by thicknesses are proportional to the forces. They have settled as well if the forces change by less than this share, which is far below
/// the standard deviation of a thickness relative to the thickness.
const SETTLED_SHARE: f64 = 0.02;
const ROUNDS: usize = 20;

/// A measurement on a finger with errors, as the scene's finger would show it: the errors are [shared errors](Measurement::shared_errors), linearised
/// at the forces that explain the measurement best.
#[derive(Debug, Clone)]
pub(crate) struct LinearisedAssembly {
    pub measurement: Measurement,
    /// Contacts and forces, N, that explain the measurement best.
    pub contacts: Vec<Contact>,
    pub forces_n: Vec<f64>,
}

/// Linearises the errors of a finger at the forces that explain a measurement best. `marker_noise_mm` is the standard deviation of one coordinate,
/// mm.
///
/// # Errors
/// [`SensingError`] if no forces explain the measurement, the search does not settle, or a finger with one of the errors is impossible.
pub(crate) fn linearise_assembly(
    finger: &Finger,
    questions: &[ContactQuestion],
    object: Option<&TouchedObject>,
    unloaded: &UnloadedFinger,
    measurement: &Measurement,
    marker_noise_mm: f64,
    near: Option<NearForces>,
) -> Result<LinearisedAssembly, SensingError> {
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let mut problem = ForceProblem::new(&mesh, questions)?.with_object(object);
    let (mut contacts, mut forces_n, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    let mut forces: Vec<PadForce> = Vec::new();
    // An earlier frame of a stream may have shown another number of contacts.
    let near = near.filter(|near| near.contacts.len() == questions.len());
    if let Some(near) = near {
        (contacts, forces_n) = (near.contacts.to_vec(), near.forces_n.to_vec());
        let nuisances = Nuisances::expected(contacts.len(), &[]);
        let near = state_of(&problem, contacts.clone(), forces_n.clone(), nuisances)?;
        forces = near.pad_forces(questions).collect();
    }
    let mut state: Option<State> = None;
    let first = FIRST_ERRORS_MM.into_iter().filter(|error_mm| *error_mm > marker_noise_mm);
    let mut change_n = f64::INFINITY;
    let is_of_thickness = !unloaded.is_assembled(finger);
    for error_mm in first.chain(std::iter::repeat(0.0)).take(ROUNDS) {
        let pushed = Pushed { questions, forces: &forces };
        let seen_as = unloaded.allowed_for(finger, measurement, pushed, &errors)?;
        let seen = Seen { measurement: &seen_as, marker_noise_mm: Some(marker_noise_mm.hypot(error_mm)) };
        problem.expect(seen)?;
        let found = match state.take() {
            None => first_state(&mut problem, near, seen)?,
            Some(state) => {
                let mut start = carry_over(&mut problem, state, seen)?;
                let off = start.solve(seen.measurement, 0.0)?.decrease;
                let largest_n = forces_n.iter().fold(0.0_f64, |most, force_n| most.max(force_n.abs()));
                let is_settled = off <= (SETTLED_SIGMAS * marker_noise_mm).powi(2)
                    || (is_of_thickness && change_n <= SETTLED_SHARE * largest_n);
                if error_mm == 0.0 && is_settled {
                    return Ok(LinearisedAssembly { measurement: seen_as, contacts, forces_n });
                }
                // The history is empty, so the search cannot meet the path of an earlier search.
                let found = minimum_near(&mut problem, start, seen, &mut SearchHistory::default())?;
                found.ok_or(SensingError::NoContact)?.state
            }
        };
        let changes_n = found.forces_n.iter().zip(&forces_n).map(|(to_n, from_n)| (to_n - from_n).abs());
        change_n = changes_n.fold(0.0, f64::max);
        forces = found.pad_forces(questions).collect();
        contacts.clone_from(&found.contacts);
        forces_n.clone_from(&found.forces_n);
        errors.clone_from(&found.nuisances.shared);
        state = Some(found);
    }
    Err(SensingError::NotConverged { iterations: ROUNDS, change_n })
}

/// The best minimum of the first round: near given forces, or else among all minima, or else from contacts at several positions.
fn first_state(problem: &mut ForceProblem, near: Option<NearForces>, seen: Seen) -> Result<State, SensingError> {
    if let Some((_, found)) = near.and_then(|near| minimum_from(problem, near.contacts, near.forces_n, seen)) {
        return Ok(found);
    }
    let refused = match find_minima(problem, None, &mut None, seen) {
        Ok(minima) => return Ok(minima.best.state),
        Err(refused) => refused,
    };
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let questions = problem.questions.clone();
    let contact = |question: &ContactQuestion, share: f64| Contact {
        position: question.position.unwrap_or(ContactPosition::at(share * length_mm)),
        angle_deg: match question.direction {
            Direction::Angle(angle_deg) => angle_deg,
            Direction::Measured(normal) => normal.angle_deg,
            Direction::Leaning(lean) => lean.mean_deg(FIRST_FORCE_N),
            Direction::Auto => 0.0,
        },
    };
    let forces_n = vec![FIRST_FORCE_N; questions.len()];
    let found = STARTS.into_iter().filter_map(|share| {
        let contacts: Vec<Contact> = questions.iter().map(|question| contact(question, share)).collect();
        minimum_from(problem, &contacts, &forces_n, seen)
    });
    found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, state)| state).ok_or(refused)
}

/// Misfit, mm^2, and state of the minimum nearest to forces, N, at contacts. `None` if the search finds no minimum.
fn minimum_from(
    problem: &mut ForceProblem,
    contacts: &[Contact],
    forces_n: &[f64],
    seen: Seen,
) -> Option<(f64, State)> {
    let state = state_under(problem, contacts, forces_n, None)?;
    let start = carry_over(problem, state, seen).ok()?;
    // The history is empty, so the search cannot meet the path of an earlier search.
    let found = minimum_near(problem, start, seen, &mut SearchHistory::default()).ok()??;
    Some((problem.misfit(&found.state, seen.measurement), found.state))
}
