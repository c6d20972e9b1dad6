//! Derivatives of the shape with respect to the unknowns of a force problem.

use super::problem::{ForceProblem, State};
use super::unknowns::{BaseMotion, Unknown};
use crate::Vector;
use crate::element::quarter_turn;
use crate::frame::FrameLoad;
use crate::mesh::LoadError;
use crate::sensing::{Direction, PadForce, SensingError};
use crate::statics::StaticsError;
use nalgebra::UnitComplex;

/// Step of the difference quotients, as a share of each unknown's scale. The differenced quantities are almost linear within such a small step.
const STEP: f64 = 1e-5;
/// Number of times that the loads are updated to the bent shape, which determines their directions and levers.
const FOLLOWED: usize = 3;
/// A tangent that is not positive definite belongs to no stable equilibrium.
const UNSTABLE: SensingError = SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 });

/// Factors the tangent at a state and computes the derivatives of the shape with respect to the unknowns.
///
/// # Errors
/// [`SensingError::Statics`] if the tangent is not positive definite.
pub(super) fn linearise(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    factor(problem, state)?;
    differentiate(problem, state)
}

fn factor(problem: &mut ForceProblem, state: &State) -> Result<(), SensingError> {
    let is_stable = problem.statics.linearise(&state.motion, &state.loads);
    is_stable.then_some(()).ok_or(UNSTABLE)
}

/// Factors the tangent at a state and computes the derivatives of the shape, including the effect of the shape on loads that follow it.
///
/// # Errors
/// [`SensingError::Statics`] if the tangent is not positive definite.
pub(super) fn linearise_with_loads(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    if !problem.loads_follow_plate() {
        return linearise(problem, state);
    }
    factor(problem, state)?;
    prepare(problem, state);
    differentiate_by_differences(problem, state)
}

/// Linearises a shape that is near an equilibrium under its loads. Residuals are those after Newton's correction of the shape, which is left to
/// [`corrected_under`](crate::statics::Statics::corrected_under). `None` if the tangent is not positive definite.
pub(super) fn look_ahead(problem: &mut ForceProblem, state: &mut State) -> Option<()> {
    problem.statics.linearise(&state.motion, &state.loads).then_some(())?;
    differentiate(problem, state).ok()?;
    let State { motion, nuisances, linearised, .. } = state;
    problem.statics.equations().corrected_markers(motion, &mut linearised.ahead);
    let turn = nuisances.base.rotation;
    if turn != UnitComplex::identity() {
        linearised.ahead.iter_mut().for_each(|ahead| *ahead = turn * *ahead);
    }
    Some(())
}

/// Scales the unknowns and linearises the priors.
fn prepare(problem: &ForceProblem, state: &mut State) {
    problem.rescale(state);
    state.linearised.turn_signs.clone_from(&problem.priors.turn_signs);
    state.linearised.prior_rows.clear();
    state.linearised.prior_rows.extend(problem.priors.rows(&state.nuisances, &state.forces_n));
}

/// Computes the derivatives of the shape with respect to the unknowns from the factored tangent.
pub(super) fn differentiate(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    let finger = problem.finger();
    prepare(problem, state);
    if problem.object.is_some() {
        return differentiate_by_differences(problem, state);
    }
    let forces: Vec<PadForce> = state.pad_forces(&problem.questions).collect();
    let State { nuisances, motion, linearised, .. } = state;
    let (base, points, across) = (nuisances.base, &linearised.marker_points, &mut linearised.across);
    let turned = base.rotation != UnitComplex::identity();
    let ladder = problem.statics.equations_mut();
    for (unknown, rates) in problem.unknowns.iter().zip(linearised.rates.chunks_exact_mut(finger.key_node_count())) {
        match *unknown {
            Unknown::Position(i) => {
                let plate = forces[i].contact.position.plate();
                let moved = |load: &FrameLoad, out: &mut [Vector]| ladder.moved_load(motion, load, plate, out);
                add_up(forces[i].loads(problem.mesh), rates, across, moved)?;
            }
            Unknown::Force(i) | Unknown::Across(i) => {
                let unit = match (*unknown, problem.questions[i].direction) {
                    (Unknown::Force(_), Direction::Measured(_)) => {
                        PadForce { force_n: 1.0_f64.hypot(nuisances.tangent(i)), ..forces[i] }
                    }
                    (Unknown::Force(_), _) => PadForce { force_n: 1.0, ..forces[i] },
                    (_, Direction::Measured(_)) => forces[i].turned(90.0 - nuisances.further_leans_deg[i], 1.0),
                    _ => forces[i].turned(90.0, 1.0),
                };
                add_up(unit.loads(problem.mesh), rates, across, |load, out| ladder.added_load(motion, load, out))?;
            }
            // The pose of an object is unknown only if the estimator has an object.
            Unknown::Object(_) => continue,
            Unknown::Shared(k) => {
                rates.copy_from_slice(&problem.shared_errors[k].pattern_mm);
                continue;
            }
            Unknown::Base(way) => {
                for (rate, point) in rates.iter_mut().zip(points) {
                    let arm = base.rotation * (point.rest + motion.displacements[point.node]);
                    *rate = match way {
                        BaseMotion::X => Vector::x(),
                        BaseMotion::Y => Vector::y(),
                        BaseMotion::Turn => quarter_turn(arm),
                    };
                }
                // In the frame of the rotated base, a force of known direction rotates opposite to the base.
                let held = forces.iter().zip(&problem.questions).filter(|(_, q)| q.direction.stated_deg().is_some());
                for (force, _) in held.filter(|_| way == BaseMotion::Turn) {
                    let back_deg = 90.0 * force.contact.position.plate().turn_sign();
                    for load in force.turned(back_deg, force.force_n).loads(problem.mesh) {
                        ladder.added_load(motion, &load?, across);
                        for (rate, across) in rates.iter_mut().zip(&*across) {
                            *rate -= base.rotation * *across;
                        }
                    }
                }
                continue;
            }
        }
        if turned {
            rates.iter_mut().for_each(|rate| *rate = base.rotation * *rate);
        }
    }
    Ok(())
}

/// Sums the effects of the loads on each key node, and writes the sums to `rates`. `room` is a buffer for one load.
fn add_up(
    loads: impl Iterator<Item = Result<FrameLoad, LoadError>>,
    rates: &mut [Vector],
    room: &mut [Vector],
    mut of: impl FnMut(&FrameLoad, &mut [Vector]),
) -> Result<(), LoadError> {
    for (i, load) in loads.enumerate() {
        match i {
            0 => of(&load?, rates),
            _ => {
                of(&load?, room);
                rates.iter_mut().zip(&*room).for_each(|(rate, further)| *rate += further);
            }
        }
    }
    Ok(())
}

/// Computes the same derivatives as [`differentiate`], but by first-order differences of states. The differences include the effect of the shape on
/// loads that follow it.
///
/// # Errors
/// [`SensingError::Statics`] if a state is not finite.
fn differentiate_by_differences(problem: &mut ForceProblem, state: &mut State) -> Result<(), SensingError> {
    let (object, noise_mm) = (problem.object.clone(), problem.priors.noise_mm());
    let mesh = problem.mesh;
    let misses = |state: &State| -> Vec<f64> {
        object.iter().flat_map(|object| object.misses_mm(mesh, state.posed(), noise_mm)).collect()
    };
    let mut applied = state.loads.clone();
    let before = followed(problem, state, None, &mut applied)?;
    let before_misses = misses(&before);
    let at_state = misses(state);
    state.linearised.take_misses(at_state);
    for unknown in 0..problem.unknowns.len() {
        let step = STEP * state.linearised.scales[unknown];
        let after = followed(problem, state, Some((unknown, step)), &mut applied)?;
        let after_misses = misses(&after);
        let states = [(&before, &before_misses), (&after, &after_misses)]
            .map(|(state, misses)| (state.posed(), misses.as_slice()));
        state.linearised.take_differences(unknown, states, step);
    }
    Ok(())
}

/// State after a step of one unknown (index and change), to first order: the tangent factored at `from` determines the new shape, and the new shape
/// determines the loads. If `step` is `None`, no unknown changes. `applied` are the loads under which the equations were linearised or corrected last.
///
/// # Errors
/// [`SensingError::Statics`] if the state is not finite.
pub(super) fn followed(
    problem: &mut ForceProblem,
    from: &State,
    step: Option<(usize, f64)>,
    applied: &mut Vec<FrameLoad>,
) -> Result<State, SensingError> {
    let mut state = from.clone();
    state.linearised.step.clear();
    state.linearised.step.resize(problem.unknowns.len(), 0.0);
    if let Some((unknown, by)) = step {
        state.linearised.step[unknown] = by;
    }
    for _ in 0..FOLLOWED {
        problem.advance(&mut state)?;
        state.motion.clone_from(&from.motion);
        problem.statics.corrected_under(&mut state.motion, applied, &state.loads).ok_or(UNSTABLE)?;
        applied.clone_from(&state.loads);
        state.linearised.step.fill(0.0);
    }
    Ok(state)
}
