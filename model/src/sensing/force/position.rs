//! Follows the valleys of the misfit over an unknown position.
//!
//! The profile of the misfit (sum of squared residuals) over a position is the smallest misfit with the contact at this position. If few markers are
//! seen, the profile has a valley: the force changes with the position, and the misfit hardly does. A standard deviation linearised at the minimum is
//! then too small, and vanishes where the force along the valley is stationary. The valley is therefore followed on the finger itself, from the
//! minimum in both directions.

use super::AS_GOOD;
use super::estimate::NonlinearEstimate;
use super::linearised::Seen;
use super::minima::minimum_at;
use super::position_profile::{ForcesAt, PositionProfile};
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::unknowns::Unknown;
use crate::finger::Plate;
use crate::sensing::{ContactPosition, SensingError};

/// The dependence of forces on a position counts as linear if the position's standard deviation is at most this share of the distance to the nearer
/// end of the plate, and at most the share `SHARP` of the plate's length. Forces depend on the position roughly with its inverse square.
const UNCERTAIN_POSITION: f64 = 0.1;
const SHARP: f64 = 0.02;
/// While markers are hidden, the finger is also solved at three standard deviations of the position on either side. The misfit must grow as on a linear
/// finger within the share `STRAIGHT`, and forces may bend away from a straight line by at most `BENT` of their standard deviations.
const STRAIGHT: f64 = 0.3;
const BENT: f64 = 0.5;
/// A force is refused if its interval is wider than this multiple of the force because of its position. While markers are hidden, the interval is compared
/// with that at a known position, and may be wider: it then excludes neither zero nor twice the force. Otherwise, it is compared with the linearised
/// interval: an error that all markers share may hide the position of a force far smaller than the estimate.
const WIDEST: f64 = 1.0;
const WIDEST_HIDDEN: f64 = 2.0;
/// The profile has found a better minimum if the misfit falls by more than this number of noise variances. Less is an error of the search.
const BETTER: f64 = 0.1;
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
    /// Growth of the misfit and state of the best point that is better than the minimum.
    better: Option<(f64, State)>,
}

/// What a profile over the only unknown position shows.
pub(super) enum Profiled {
    /// Forces depend linearly on the position, or the finger does not explain the measurement.
    Nothing,
    /// Positions and forces that explain the measurement.
    Profile(PositionProfile),
    /// A state near a better minimum.
    Better(Box<State>),
}

/// The profile over the only unknown position. `rivals` are other minima.
///
/// # Errors
/// [`SensingError`] if the markers do not confine position and force, or two ranges of positions with different forces explain the measurement.
pub(super) fn profile_over_position(
    problem: &ForceProblem,
    state: &State,
    rivals: &[State],
    seen: Seen,
    estimate: &NonlinearEstimate,
) -> Result<Profiled, SensingError> {
    let [contact] = problem.unplaced()[..] else { return Ok(Profiled::Nothing) };
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
    let is_sharp = rivals.is_empty() && is_sharp(problem, state, estimate);
    let is_linear = is_sharp && !problem.is_weak(seen.measurement);
    // A finger that differs from the scene makes the noise, and every valley, wide; the estimate then carries a warning.
    let is_warned = estimate.forces.warning.is_some();
    if is_linear || is_warned || problem.object.is_some() || !(noise_mm > 0.0 && noise_mm.is_finite()) {
        return Ok(Profiled::Nothing);
    }
    let mut questions = problem.questions.clone();
    questions[contact].position = Some(ContactPosition::at(length_mm));
    let mut placed = problem.with_questions(&questions)?;
    placed.expect(seen)?;
    let mut valley = Valley { placed, contact, seen, least_mm2, noise_mm, better: None };
    if is_sharp && valley.is_straight(state, sd_mm, &estimate.forces.sigmas_n) {
        return Ok(Profiled::Nothing);
    }
    let is_weak = problem.is_weak(seen.measurement);
    let mut profile = PositionProfile { contact, is_weak, ranges: Vec::new() };
    for start in [state].into_iter().chain(rivals) {
        if !profile.contains(position_mm(start), &start.forces_n) {
            match valley.ranges(start, sd_mm) {
                // The finger has no equilibrium beside a position that is certain.
                Err(_) if is_sharp => return Ok(Profiled::Nothing),
                ranges => profile.ranges.extend(ranges?),
            }
        }
    }
    if let Some((_, state)) = valley.better.filter(|_| is_weak) {
        return Ok(Profiled::Better(Box::new(state)));
    }
    if profile.ranges.is_empty() {
        return Ok(Profiled::Nothing);
    }
    let at_position_n = profile.best().map(|best| best.sigmas_n[contact]).filter(|_| is_weak);
    let (certain_n, widest) =
        at_position_n.map_or((estimate.forces.sigmas_n[contact], WIDEST), |sd_n| (sd_n, WIDEST_HIDDEN));
    profile.require_determined(certain_n, widest)?;
    Ok(Profiled::Profile(profile))
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
    /// Whether misfit and forces about a minimum depend on the position as on a linear finger.
    fn is_straight(&mut self, state: &State, sd_mm: f64, sigmas_n: &[f64]) -> bool {
        let s_mm = state.contacts[self.contact].position_mm(self.placed.finger()).unwrap_or(f64::NAN);
        let sds = BEYOND.sqrt();
        let ends = [-sds, sds].map(|sds| self.at(state, state.forces_n.clone(), s_mm + sds * sd_mm));
        let [Ok((_, below)), Ok((_, above))] = ends else { return false };
        let grows = |point: &ForcesAt| (point.growth / BEYOND - 1.0).abs() <= STRAIGHT;
        let bend_n = |j: usize| (0.5 * (below.forces_n[j] + above.forces_n[j]) - state.forces_n[j]).abs();
        grows(&below) && grows(&above) && (0..sigmas_n.len()).all(|j| bend_n(j) <= BENT * sigmas_n[j])
    }

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
        let history = SearchHistory::default();
        let mut state = minimum_at(placed, (i, s_mm), near, &forces_n, self.seen, history)?;
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
        if point.growth < self.better.as_ref().map_or(-BETTER, |(growth, _)| *growth) {
            self.better = Some((point.growth, state.clone()));
        }
        Ok((state, point))
    }
}
