//! Follows the valleys of the misfit over an unknown position.
//!
//! The profile of the misfit (sum of squared residuals) over a position is the smallest misfit with the contact at this position. If few markers are
//! seen, the profile has a valley: the force changes with the position, and the misfit hardly does. A standard deviation linearised at the minimum is
//! then too small, and vanishes where the force along the valley is stationary. The valley is therefore followed on the finger itself, from the
//! minimum in both directions.

use super::AS_GOOD;
use super::estimate::NonlinearEstimate;
use super::linearised::Seen;
use super::minima::minimum_near;
use super::position_profile::{ForcesAt, PositionProfile};
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::{carry_over, state_under};
use super::unknowns::Unknown;
use crate::finger::Plate;
use crate::sensing::{Contact, ContactPosition, SensingError};

/// The dependence of forces on a position counts as linear if the position's standard deviation is at most this share of the distance to the nearer
/// end of the plate, and at most the share `SHARP` of the plate's length. Forces depend on the position roughly with its inverse square.
const UNCERTAIN_POSITION: f64 = 0.1;
const SHARP: f64 = 0.02;
/// First step between positions, in standard deviations of the position.
const FIRST_STEP_SDS: f64 = 0.5;
/// Smallest and largest step, as a share of the plate's length, and largest number of steps on either side of a minimum.
const STEPS: [f64; 2] = [0.002, 0.07];
const MOST_STEPS: usize = 24;
/// Contacts are not sought on this share of the plate at its base, where a force moves hardly any marker.
const MARGIN: f64 = 0.02;
/// A valley ends where the misfit exceeds the smallest misfit by this number of noise variances. On a linear finger, it therefore ends three standard
/// deviations from the minimum.
const BEYOND: f64 = AS_GOOD;
/// The profile goes on up to this growth, because another valley may begin behind a ridge.
const FAR: f64 = 50.0;
/// A step within a valley that raises the misfit by more noise variances is halved. A step that raises it by less than `SHORT` is followed by a longer one.
const LONG: f64 = 3.0;
const SHORT: f64 = 1.0;

/// Follows the valleys of the misfit over an unknown position.
struct Valley<'s, 'm> {
    /// The problem with the contact at a known position.
    placed: ForceProblem<'m>,
    contact: usize,
    seen: Seen<'s>,
    least_mm2: f64,
    noise_mm: f64,
}

/// The profile over the only unknown position. `rivals` are other minima. `None` if the position is so certain that forces depend linearly on it, or
/// the finger does not explain the measurement.
///
/// # Errors
/// [`SensingError`] if the markers do not confine position and force, or two ranges of positions with different forces explain the measurement.
pub(super) fn profile_over_position(
    problem: &ForceProblem,
    state: &State,
    rivals: &[State],
    seen: Seen,
    estimate: &NonlinearEstimate,
) -> Result<Option<PositionProfile>, SensingError> {
    let [contact] = problem.unplaced()[..] else { return Ok(None) };
    let noise_mm = estimate.forces.trusted_noise_mm;
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let position_mm = |state: &State| state.contacts[contact].position_mm(problem.finger()).unwrap_or(f64::NAN);
    let least_mm2 = problem.misfit(state, seen.measurement);
    let sd_mm = estimate.uncertainties[contact].position_sd_mm.unwrap_or_default();
    let is_rival = |rival: &&State| {
        let growth = (problem.misfit(rival, seen.measurement) - least_mm2) / noise_mm.powi(2);
        let is_elsewhere = (position_mm(rival) - position_mm(state)).abs() > BEYOND.sqrt() * sd_mm;
        growth <= BEYOND && is_elsewhere && position_mm(rival) >= MARGIN * length_mm
    };
    let rivals: Vec<&State> = rivals.iter().filter(is_rival).collect();
    let is_linear = rivals.is_empty() && is_sharp(problem, state, estimate);
    // A finger that differs from the scene makes the noise, and every valley, wide; the estimate then carries a warning.
    let is_warned = estimate.forces.warning.is_some();
    if is_linear || is_warned || problem.object.is_some() || !(noise_mm > 0.0 && noise_mm.is_finite()) {
        return Ok(None);
    }
    let mut questions = problem.questions.clone();
    questions[contact].position = Some(ContactPosition::at(length_mm));
    let mut placed = problem.with_questions(&questions)?;
    placed.expect(seen)?;
    let mut valley = Valley { placed, contact, seen, least_mm2, noise_mm };
    let mut profile = PositionProfile { contact, ranges: Vec::new() };
    for start in [state].into_iter().chain(rivals) {
        if !profile.contains(position_mm(start), &start.forces_n) {
            profile.ranges.extend(valley.ranges(start, sd_mm)?);
        }
    }
    if profile.ranges.is_empty() {
        return Ok(None);
    }
    profile.require_determined(&estimate.forces.sigmas_n, &state.forces_n)?;
    Ok(Some(profile))
}

/// Whether forces depend linearly on all unknown positions, according to the linearised standard deviations of these positions.
fn is_sharp(problem: &ForceProblem, state: &State, estimate: &NonlinearEstimate) -> bool {
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let sharp = |&i: &usize| {
        let s_mm = state.contacts[i].position_mm(problem.finger()).unwrap_or(f64::NAN);
        let sd_mm = estimate.uncertainties[i].position_sd_mm.unwrap_or_default();
        sd_mm <= (UNCERTAIN_POSITION * s_mm.min(length_mm - s_mm)).min(SHARP * length_mm)
    };
    problem.unplaced().iter().all(sharp)
}

impl Valley<'_, '_> {
    /// Connected ranges of positions that explain the measurement, about a minimum and behind ridges on either side. `sd_mm` is the linearised standard
    /// deviation of the position. Empty if the search fails at the minimum itself.
    ///
    /// # Errors
    /// [`SensingError::Undetermined`] if the search fails at a position that may explain the measurement.
    fn ranges(&mut self, start: &State, sd_mm: f64) -> Result<Vec<Vec<ForcesAt>>, SensingError> {
        let s_mm = start.contacts[self.contact].position_mm(self.placed.finger()).unwrap_or(f64::NAN);
        let Ok((state, point)) = self.at(start, start.forces_n.clone(), s_mm) else { return Ok(Vec::new()) };
        let mut range = self.followed(&state, &point, -1.0, sd_mm)?;
        range.reverse();
        let further = self.followed(&state, &point, 1.0, sd_mm)?;
        range.push(point);
        range.extend(further);
        // Each range includes one point beyond it on either side.
        let explains = |point: &ForcesAt| point.growth <= BEYOND;
        let mut ranges: Vec<Vec<ForcesAt>> = Vec::new();
        for ends in range.windows(2).filter(|ends| ends.iter().any(explains)) {
            match ranges.last_mut().filter(|range| range.last() == Some(&ends[0]) && explains(&ends[0])) {
                Some(range) => range.push(ends[1].clone()),
                None => ranges.push(ends.to_vec()),
            }
        }
        // The range of the minimum comes first.
        let distance_mm =
            |range: &Vec<ForcesAt>| (range[0].s_mm - s_mm).max(s_mm - range[range.len() - 1].s_mm).max(0.0);
        ranges.sort_by(|a, b| distance_mm(a).total_cmp(&distance_mm(b)));
        Ok(ranges)
    }

    /// The profile from a point in one direction, until the misfit has grown by `BEYOND` or the plate ends.
    ///
    /// # Errors
    /// [`SensingError::Undetermined`] as for [`ranges`](Self::ranges).
    fn followed(
        &mut self,
        state: &State,
        point: &ForcesAt,
        sign: f64,
        sd_mm: f64,
    ) -> Result<Vec<ForcesAt>, SensingError> {
        let length_mm = self.placed.finger().plate_length_mm(Plate::Front);
        let end_mm = if sign > 0.0 { length_mm } else { MARGIN * length_mm };
        let [least_mm, most_mm] = STEPS.map(|share| share * length_mm);
        let mut step_mm = (FIRST_STEP_SDS * sd_mm).clamp(least_mm, most_mm);
        let (mut points, mut near): (Vec<ForcesAt>, State) = (Vec::new(), state.clone());
        for _ in 0..MOST_STEPS {
            let last = points.last().unwrap_or(point);
            let last_growth = last.growth;
            let left_mm = sign * (end_mm - last.s_mm);
            if left_mm <= 1e-6 * length_mm || last.growth > FAR {
                break;
            }
            let s_mm = if left_mm <= 1.2 * step_mm { end_mm } else { last.s_mm + sign * step_mm };
            // The forces go on as from the point before.
            let before = points.len().checked_sub(2).map_or(point, |k| &points[k]);
            let share = if before.s_mm == last.s_mm { 0.0 } else { (s_mm - last.s_mm) / (last.s_mm - before.s_mm) };
            let forces_n =
                last.forces_n.iter().zip(&before.forces_n).map(|(last, before)| last + share * (last - before));
            let next = self.at(&near, forces_n.collect(), s_mm);
            let rise = next.as_ref().map_or(f64::INFINITY, |(_, next)| next.growth - last.growth);
            match next {
                Ok((state, next)) if rise <= LONG || step_mm <= least_mm || last.growth > BEYOND - LONG => {
                    points.push(next);
                    near = state;
                    if rise < SHORT || last_growth > BEYOND {
                        step_mm = (1.6 * step_mm).min(most_mm);
                    }
                }
                Err(_) if step_mm <= least_mm && last.growth < BEYOND => {
                    let (contact, sigma) = (self.contact + 1, (last.s_mm - point.s_mm).abs().max(sd_mm));
                    return Err(SensingError::Undetermined { what: "the position", contact, sigma, unit: "mm" });
                }
                Err(_) if step_mm <= least_mm => break,
                _ => step_mm = (0.5 * step_mm).max(least_mm),
            }
        }
        Ok(points)
    }

    /// State and forces of the minimum with the contact at a position. The search starts from `forces_n` near the state `near`.
    fn at(&mut self, near: &State, forces_n: Vec<f64>, s_mm: f64) -> Result<(State, ForcesAt), SensingError> {
        let (i, placed) = (self.contact, &mut self.placed);
        let position = ContactPosition::at(s_mm);
        placed.questions[i].position = Some(position);
        let mut contacts = near.contacts.clone();
        contacts[i] = Contact { position, ..contacts[i] };
        let state = state_under(placed, &contacts, &forces_n, Some(near)).ok_or(SensingError::NoContact)?;
        let start = carry_over(placed, State { nuisances: near.nuisances.clone(), ..state }, self.seen)?;
        // The history is empty, so the search cannot end because it meets the path of an earlier search.
        let found = minimum_near(placed, start, self.seen, &mut SearchHistory::default())?;
        let mut state = found.ok_or(SensingError::NoContact)?.state;
        placed.rescale(&mut state);
        let parts = state.linearised.singular_parts(self.seen.measurement)?;
        let sd = |j: usize| state.linearised.scales[j] * parts.covariance(j, j).sqrt() * self.noise_mm;
        let across = placed.unknowns.iter().position(|unknown| *unknown == Unknown::Across(i));
        let growth = (placed.misfit(&state, self.seen.measurement) - self.least_mm2) / self.noise_mm.powi(2);
        let point = ForcesAt {
            s_mm,
            sigmas_n: (0..state.forces_n.len()).map(sd).collect(),
            angle_deg: state.contacts[i].angle_deg,
            angle_sd_deg: across.map_or(0.0, |j| (sd(j) / state.forces_n[i].abs()).to_degrees()),
            forces_n: state.forces_n.clone(),
            growth,
        };
        Ok((state, point))
    }
}
