//! Widens forces at a contact whose position is uncertain because of errors of the assembly.
//!
//! A force near the base bends the finger like a smaller force farther from the base. If the position's uncertainty is a large share of its distance
//! from an end of the plate, the force is a strongly nonlinear function of the position. If the position is very uncertain, a linearised standard
//! deviation of the force is too small.

use super::assessment::assess;
use super::estimate::NonlinearEstimate;
use super::linearised::Seen;
use super::minima::minimum_near;
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::{carry_over, state_under};
use super::unknowns::LARGEST_POSITION_SIGMA;
use crate::finger::Plate;
use crate::sensing::{Contact, ContactPosition, SensingError};

/// The dependence of forces on a position counts as nonlinear if the position's standard deviation exceeds this share of the distance to the nearer
/// end of the plate.
const UNCERTAIN_POSITION: f64 = 0.1;
/// Step between the positions of a scan, in standard deviations of the position.
const STEP_SDS: f64 = 0.75;
/// Largest step of a scan, as a share of the plate's length, and largest number of steps on either side of the best position.
const LARGEST_STEP: f64 = 0.1;
const MOST_STEPS: usize = 12;
/// Contacts are not sought on this share of the plate at either end.
const MARGIN: f64 = 0.02;
/// A scan ends at a position at which the misfit exceeds the smallest misfit by this number of noise variances. For a linear finger, a scan therefore
/// ends three standard deviations from the best position.
const BEYOND: f64 = 9.0;
/// The markers do not bound the position if the misfit grows by less than this number of noise variances up to an end of the plate. For a linear
/// finger, the misfit grows by this value over one standard deviation of the position.
const BOUNDED: f64 = 1.0;

/// Forces that explain the measurement best with the contact at one position.
struct ForcesAt {
    s_mm: f64,
    forces_n: Vec<f64>,
    sigmas_n: Vec<f64>,
    /// Growth of the misfit from the best position, in noise variances.
    growth: f64,
}

/// Widens the standard deviations if the only unknown position is so uncertain that forces depend nonlinearly on it. Scans the positions on both
/// sides of the best position.
///
/// # Errors
/// [`SensingError::Undetermined`] if the markers do not confine the position to a part of the plate.
///
/// # Reference
/// The forces have a mixture of normal distributions, weighted by the profile likelihood (Bates and Watts, Nonlinear Regression Analysis and Its
/// Applications, ch. 6).
pub(super) fn widen_by_position(
    problem: &ForceProblem,
    state: &State,
    seen: Seen,
    estimate: &mut NonlinearEstimate,
) -> Result<(), SensingError> {
    let [i] = problem.unplaced()[..] else { return Ok(()) };
    // Without errors of the assembly, markers confine positions so well that the rivals of the minimum suffice.
    if problem.shared_errors.is_empty() {
        return Ok(());
    }
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let found_mm = state.contacts[i].position_mm(problem.finger()).unwrap_or(f64::NAN);
    let sd_mm = estimate.position_sds_mm[i];
    if problem.object.is_some() || sd_mm <= UNCERTAIN_POSITION * found_mm.min(length_mm - found_mm) {
        return Ok(());
    }
    let step_mm = (STEP_SDS * sd_mm).min(LARGEST_STEP * length_mm);
    let least_mm2 = problem.misfit(state, seen.measurement);
    let variance_mm2 = estimate.forces.trusted_noise_mm.powi(2);
    let (mut points, mut is_bounded): (Vec<ForcesAt>, bool) = (Vec::new(), true);
    for step_mm in [-step_mm, step_mm] {
        let (mut near, mut growth) = (state.clone(), 0.0);
        for number in 1..=MOST_STEPS {
            let s_mm = found_mm + number as f64 * step_mm;
            if !(MARGIN * length_mm..=(1.0 - MARGIN) * length_mm).contains(&s_mm) {
                is_bounded &= growth > BOUNDED;
                break;
            }
            let Ok((next, sigmas_n, misfit_mm2)) = best_at(problem, &near, i, s_mm, seen) else { break };
            growth = (misfit_mm2 - least_mm2) / variance_mm2;
            points.push(ForcesAt { s_mm, forces_n: next.forces_n.clone(), sigmas_n, growth });
            if growth > BEYOND {
                break;
            }
            near = next;
        }
    }
    // The standard deviations for a known position hardly differ between the best position and a neighbouring position.
    let own_n = points.first().map_or_else(|| estimate.forces.sigmas_n.clone(), |point| point.sigmas_n.clone());
    points.push(ForcesAt { s_mm: found_mm, forces_n: state.forces_n.clone(), sigmas_n: own_n, growth: 0.0 });
    let weight = |point: &ForcesAt| (-0.5 * point.growth).exp();
    let weights: f64 = points.iter().map(weight).sum();
    let mean =
        |of: &dyn Fn(&ForcesAt) -> f64| points.iter().map(|point| weight(point) * of(point)).sum::<f64>() / weights;
    let spread_mm = mean(&|point| (point.s_mm - found_mm).powi(2)).sqrt();
    if !is_bounded || spread_mm > LARGEST_POSITION_SIGMA * length_mm {
        return Err(SensingError::Undetermined { what: "the position", contact: i + 1, sigma: spread_mm, unit: "mm" });
    }
    for j in 0..state.forces_n.len() {
        let square_n2 = mean(&|point| (point.forces_n[j] - state.forces_n[j]).powi(2) + point.sigmas_n[j].powi(2));
        let more_n2 = square_n2 - estimate.forces.sigmas_n[j].powi(2);
        if more_n2 > 0.0 {
            estimate.forces.add_variance(j, more_n2);
        }
    }
    Ok(())
}

/// State, standard deviations of the forces, N, and misfit, mm^2, of the minimum with a contact at a known position. The search starts from `near`.
fn best_at(
    problem: &ForceProblem,
    near: &State,
    contact: usize,
    s_mm: f64,
    seen: Seen,
) -> Result<(State, Vec<f64>, f64), SensingError> {
    let position = ContactPosition::at(s_mm);
    let mut questions = problem.questions.clone();
    questions[contact].position = Some(position);
    let mut placed = problem.with_questions(&questions)?;
    placed.expect(seen)?;
    let mut contacts = near.contacts.clone();
    contacts[contact] = Contact { position, ..contacts[contact] };
    let state = state_under(&mut placed, &contacts, &near.forces_n, Some(near)).ok_or(SensingError::NoContact)?;
    let start = carry_over(&mut placed, State { nuisances: near.nuisances.clone(), ..state }, seen)?;
    // The history is empty, so the search cannot end because it meets the path of an earlier search.
    let found = minimum_near(&mut placed, start, seen, &mut SearchHistory::default())?;
    let mut state = found.ok_or(SensingError::NoContact)?.state;
    let sigmas_n = assess(&placed, &mut state, seen, 0)?.forces.sigmas_n;
    let misfit_mm2 = placed.misfit(&state, seen.measurement);
    Ok((state, sigmas_n, misfit_mm2))
}
