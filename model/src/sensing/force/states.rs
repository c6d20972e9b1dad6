//! States of a force problem: equilibria with the derivatives of their shapes.

use super::SETTLED_ANGLE_DEG;
use super::derivatives::differentiate;
use super::linearised::{Linearised, Seen};
use super::problem::{ForceProblem, State};
use super::unknowns::Unknown;
use super::values::Nuisances;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::LoadError;
use crate::sensing::{Contact, Direction, SensingError};
use crate::statics::{Equilibrium, EquilibriumEquations, Ladder, Statics, StaticsError};
use std::sync::Arc;

/// The iteration that adapts the loads to the shape ends after this number of updates. Each update of the loads removes most of the change that
/// remains.
const SETTLINGS: usize = 60;

/// A minimum and the number of steps to this minimum. If `near` is `true`, the search started near the minimum, or every step was complete and as
/// good as predicted. A minimum with `near` counts as locally unique. If `near` is `false`, there may be further minima.
pub(super) struct Found {
    pub state: State,
    pub steps: usize,
    pub near: bool,
}

/// State under forces, N, at contacts, followed from the state `from`, or from rest if `from` is `None`. `None` if no equilibrium is found.
pub(super) fn state_under(
    problem: &mut ForceProblem,
    contacts: &[Contact],
    forces_n: &[f64],
    from: Option<&State>,
) -> Option<State> {
    state_found(problem, contacts, forces_n, |statics, loads| match from {
        Some(from) => statics.tried(&from.motion, [&from.loads, loads], 1, |_, _| true),
        None => statics.equilibrium(loads),
    })
}

/// State under forces, N, at contacts, found from a shape near the equilibrium. `None` if no equilibrium is found.
pub(super) fn state_near(
    problem: &mut ForceProblem,
    contacts: &[Contact],
    forces_n: &[f64],
    shape: &FrameMotion,
) -> Option<State> {
    state_found(problem, contacts, forces_n, |statics, loads| statics.tried(shape, [loads, loads], 1, |_, _| true))
}

fn state_found<'m>(
    problem: &mut ForceProblem<'m>,
    contacts: &[Contact],
    forces_n: &[f64],
    find: impl FnOnce(&mut Statics<Ladder<'m>>, &[FrameLoad]) -> Result<Equilibrium, StaticsError>,
) -> Option<State> {
    let nuisances = Nuisances::expected(contacts.len(), &problem.shared_errors);
    let mut state = state_of(problem, contacts.to_vec(), forces_n.to_vec(), nuisances).ok()?;
    state.motion = find(&mut problem.statics, &state.loads).ok()?.motion;
    problem.statics.linearise(&state.motion, &state.loads).then_some(())?;
    differentiate(problem, &mut state).ok()?;
    Some(state)
}

/// A state with its loads, at rest and without derivatives. The leans from measured normals and the shifts from measured positions follow from the
/// contacts.
///
/// # Errors
/// [`LoadError`] for a contact off its plate.
pub(super) fn state_of(
    problem: &ForceProblem,
    contacts: Vec<Contact>,
    forces_n: Vec<f64>,
    mut nuisances: Nuisances,
) -> Result<State, LoadError> {
    let mut plate_turns_rad = vec![0.0; contacts.len()];
    let position_mm = |contact: &Contact| contact.position_mm(problem.finger()).unwrap_or(f64::NAN);
    for (i, (contact, question)) in contacts.iter().zip(&problem.questions).enumerate() {
        if let Direction::Measured(normal) = question.direction {
            let normal_deg = normal.angle_deg - nuisances.base_turn_deg(contact.position.plate());
            nuisances.further_leans_deg[i] = contact.angle_deg - normal_deg;
            plate_turns_rad[i] = normal_deg.to_radians();
        }
        if let Some(position) = question.position {
            nuisances.shifts_mm[i] = position_mm(contact) - position_mm(&Contact { position, ..*contact });
        }
    }
    let linearised = Linearised::new(problem.mesh, &problem.unknowns);
    let motion = problem.statics.equations().at_rest();
    let (loads, unit_motions) = (Vec::new(), None);
    let mut state = State { forces_n, contacts, nuisances, plate_turns_rad, loads, motion, linearised, unit_motions };
    state.loads = state.loads_under(problem.mesh, &problem.questions, &state.forces_n)?;
    Ok(state)
}

/// First-order motions of the mesh per N of each force at a state. `None` unless all unknowns are forces whose loads do not follow the shape.
pub(super) fn unit_motions(problem: &mut ForceProblem, state: &State) -> Option<Arc<[FrameMotion]>> {
    let are_forces = problem.unknowns.iter().all(|unknown| matches!(unknown, Unknown::Force(_)));
    let has_pad = problem.questions.iter().any(|question| question.pad.is_some());
    let are_all = state.linearised.scales.len() == state.contacts.len();
    if !(are_forces && are_all) || problem.object.is_some() || problem.follows_plate() || has_pad {
        return None;
    }
    problem.statics.linearise(&state.motion, &state.loads).then_some(())?;
    let mut applied = state.loads.clone();
    let unit_motion = |(i, contact): (usize, &Contact)| {
        let (mut loads, mut motion) = (state.loads.clone(), state.motion.clone());
        loads[i] = problem.mesh.frame_load(&contact.load(problem.finger(), state.forces_n[i] + 1.0)).ok()?;
        problem.statics.corrected_under(&mut motion, &applied, &loads)?;
        applied = loads;
        motion.add(&state.motion, -1.0);
        Some(motion)
    };
    state.contacts.iter().enumerate().map(unit_motion).collect()
}

/// Linearises the state of a problem with other unknowns for the unknowns of this problem.
///
/// # Errors
/// [`SensingError`] if loads that follow an object have no equilibrium.
pub(super) fn carry_over(problem: &mut ForceProblem, state: State, seen: Seen) -> Result<State, SensingError> {
    let linearised = Linearised::new(problem.mesh, &problem.unknowns);
    let mut state = State { linearised, unit_motions: None, ..state };
    state.nuisances.use_patterns(&problem.shared_errors);
    if problem.object.is_some() {
        settle(problem, &mut state, SETTLED_ANGLE_DEG)?;
    }
    problem.statics.linearise(&state.motion, &state.loads);
    differentiate(problem, &mut state)?;
    state.weigh(seen);
    Ok(state)
}

/// Iterates a state to the equilibrium under loads that follow its shape, until the directions of the loads change by at most `settled_deg`, degrees.
/// Returns whether they have settled. The state's shape is the equilibrium under the state's loads, or near it.
///
/// # Errors
/// [`SensingError::Statics`] if the finger has no equilibrium under loads that follow its shape.
pub(super) fn settle(problem: &mut ForceProblem, state: &mut State, settled_deg: f64) -> Result<bool, SensingError> {
    let follows = problem.loads_follow_plate();
    for update in 0..SETTLINGS {
        let loads = state.loads.clone();
        state.linearised.step.clear();
        state.linearised.step.resize(problem.unknowns.len(), 0.0);
        let turn_deg = problem.advance(state)?;
        state.motion = problem.statics.shifted(&state.motion, &loads, &state.loads)?.motion;
        // The first update knows only the shape before the loads.
        if turn_deg <= settled_deg && (update > 0 || !follows) {
            return Ok(true);
        }
    }
    Ok(false)
}
