//! Distribution of forces over an unknown position.
//!
//! The profile of the misfit (sum of squared residuals) over a position is the smallest misfit with the contact at this position. If few markers are
//! seen, the profile has a valley: the force changes with the position, and the misfit hardly does. A standard deviation linearised at the minimum is
//! then too small, and vanishes where the force along the valley is stationary. The valley is therefore followed on the finger itself, from the
//! minimum in both directions.

use super::alternatives::{AS_GOOD, CURVED};
use super::estimate::NonlinearEstimate;
use super::linearised::Seen;
use super::minima::minimum_near;
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::{carry_over, state_under};
use super::unknowns::Unknown;
use crate::finger::{Finger, Plate};
use crate::sensing::{Contact, ContactPosition, SensingError, TWO_SIDED_95};
use statrs::distribution::{ContinuousCDF, Normal};

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
/// Number of points between neighbouring positions of the profile, by interpolation.
const BETWEEN: usize = 8;
/// Ranges of positions are alternatives if the central intervals of this probability of their forces do not overlap.
const APART: f64 = 0.998;

/// Forces that explain a measurement best with the contact at one position.
#[derive(Debug, Clone, PartialEq)]
struct ForcesAt {
    s_mm: f64,
    /// Forces and their standard deviations at this position, N.
    forces_n: Vec<f64>,
    sigmas_n: Vec<f64>,
    /// Direction of the force at the contact, and its standard deviation at this position, degrees.
    angle_deg: f64,
    angle_sd_deg: f64,
    /// Growth of the misfit from the smallest misfit, in noise variances.
    growth: f64,
}

impl ForcesAt {
    /// Forces at the share `t` of the way to another position. Along a valley, the square root of the growth is nearly linear.
    fn towards(&self, other: &ForcesAt, t: f64) -> ForcesAt {
        let between = |a: f64, b: f64| a + t * (b - a);
        let all = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| between(*a, *b)).collect();
        ForcesAt {
            s_mm: between(self.s_mm, other.s_mm),
            forces_n: all(&self.forces_n, &other.forces_n),
            sigmas_n: all(&self.sigmas_n, &other.sigmas_n),
            angle_deg: between(self.angle_deg, other.angle_deg),
            angle_sd_deg: between(self.angle_sd_deg, other.angle_sd_deg),
            growth: between(self.growth.max(0.0).sqrt(), other.growth.max(0.0).sqrt()).powi(2),
        }
    }
}

/// Weight, mean and standard deviation of one normal distribution of a mixture.
type Component = (f64, f64, f64);

/// Value below which the mixture lies with a probability.
fn quantile(mixture: &[Component], probability: f64) -> f64 {
    const HALVINGS: usize = 50;
    let normal = Normal::standard();
    let whole: f64 = mixture.iter().map(|(weight, ..)| weight).sum();
    let reach = |sign: f64| mixture.iter().map(move |(_, mean, sd)| mean + sign * 10.0 * sd);
    let mut from = reach(-1.0).fold(f64::INFINITY, f64::min);
    let mut to = reach(1.0).fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        let below = |&(weight, mean, sd): &Component| match sd > 0.0 {
            true => weight * normal.cdf((middle - mean) / sd),
            false => weight * f64::from(mean <= middle),
        };
        match mixture.iter().map(below).sum::<f64>() < probability * whole {
            true => from = middle,
            false => to = middle,
        }
    }
    0.5 * (from + to)
}

/// Central interval of a probability.
fn interval(mixture: &[Component], probability: f64) -> [f64; 2] {
    [0.5 - 0.5 * probability, 0.5 + 0.5 * probability].map(|below| quantile(mixture, below))
}

/// Forces over all positions that explain a measurement: one list for each connected range, in ascending order of the positions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PositionProfile {
    contact: usize,
    ranges: Vec<Vec<ForcesAt>>,
}

/// Follows the valleys of the misfit over an unknown position.
struct Valley<'s, 'm> {
    /// The problem with the contact at a known position.
    placed: ForceProblem<'m>,
    contact: usize,
    seen: Seen<'s>,
    least_mm2: f64,
    noise_mm: f64,
}

impl PositionProfile {
    /// The profile over the only unknown position. `rivals` are other minima. `None` if the position is so certain that forces depend linearly on it, or
    /// the finger does not explain the measurement.
    ///
    /// # Errors
    /// [`SensingError`] if the markers do not confine position and force, or two ranges of positions with different forces explain the measurement.
    pub fn of(
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
            if !profile.contains(problem, start) {
                profile.ranges.extend(valley.ranges(start, sd_mm)?);
            }
        }
        if profile.ranges.is_empty() {
            return Ok(None);
        }
        profile.require_determined(&estimate.forces.sigmas_n, state)?;
        Ok(Some(profile))
    }

    /// Whether a range contains the position and the forces of a minimum.
    fn contains(&self, problem: &ForceProblem, state: &State) -> bool {
        let s_mm = state.contacts[self.contact].position_mm(problem.finger()).unwrap_or(f64::NAN);
        self.ranges.iter().any(|range| at(range, s_mm).is_some_and(|found| is_same(&found, &state.forces_n)))
    }

    /// Mixture of the distributions of a quantity over one or all ranges, each weighted by the likelihood and the length of plate for which it stands.
    /// `of` returns mean and standard deviation at a point that stands for a length of plate, mm.
    fn mixture(ranges: &[Vec<ForcesAt>], of: impl Fn(&ForcesAt, f64) -> (f64, f64)) -> Vec<Component> {
        let pieces = ranges.iter().flat_map(|range| range.windows(2));
        let parts = pieces.flat_map(|ends| {
            (0..BETWEEN).map(move |i| {
                let length_mm = (ends[1].s_mm - ends[0].s_mm) / BETWEEN as f64;
                (length_mm, ends[0].towards(&ends[1], (i as f64 + 0.5) / BETWEEN as f64))
            })
        });
        let component = |(length_mm, point): (f64, ForcesAt)| {
            let (mean, sd) = of(&point, length_mm);
            (length_mm * (-0.5 * point.growth).exp(), mean, sd)
        };
        parts.map(component).collect()
    }

    fn force(ranges: &[Vec<ForcesAt>], j: usize) -> Vec<Component> {
        PositionProfile::mixture(ranges, |point, _| (point.forces_n[j], point.sigmas_n[j]))
    }

    fn position(ranges: &[Vec<ForcesAt>]) -> Vec<Component> {
        // A uniform distribution over the length of plate has this standard deviation.
        PositionProfile::mixture(ranges, |point, length_mm| (point.s_mm, length_mm / 12.0_f64.sqrt()))
    }

    /// Refuses two ranges with different forces, a position that may be anywhere, and a force whose interval, because of the position, is wider than the force.
    fn require_determined(&self, linear_n: &[f64], state: &State) -> Result<(), SensingError> {
        let (i, contact) = (self.contact, self.contact + 1);
        let intervals_n: Vec<[f64; 2]> =
            (0..self.ranges.len()).map(|k| interval(&PositionProfile::force(&self.ranges[k..=k], i), APART)).collect();
        let is_apart = |k: &usize| intervals_n[*k][0] > intervals_n[0][1] || intervals_n[*k][1] < intervals_n[0][0];
        if let Some(k) = (1..self.ranges.len()).find(is_apart) {
            let ends_mm = |range: &[ForcesAt]| [range[0].s_mm, range[range.len() - 1].s_mm];
            return Err(SensingError::TwoRanges {
                contact,
                forces_n: [intervals_n[0], intervals_n[k]],
                positions_mm: [ends_mm(&self.ranges[0]), ends_mm(&self.ranges[k])],
            });
        }
        let force_n = interval(&PositionProfile::force(&self.ranges, i), 0.95);
        let position_mm = interval(&PositionProfile::position(&self.ranges), 0.95);
        let is_by_position = force_n[1] - force_n[0] > 2.0 * CURVED * TWO_SIDED_95 * linear_n[i];
        if is_by_position && force_n[1] - force_n[0] > state.forces_n[i].abs() {
            return Err(SensingError::WideRange { contact, force_n, position_mm });
        }
        Ok(())
    }

    /// Widens the standard deviations of forces, position and direction, and sets their intervals. The profile may be that of a coarser mesh.
    pub fn widen(&self, estimate: &mut NonlinearEstimate, finger: &Finger) {
        let found_mm = estimate.contacts[self.contact].position_mm(finger).unwrap_or(f64::NAN);
        let at_found = self.ranges.iter().find_map(|range| at(range, found_mm));
        for j in 0..estimate.forces.forces_n.len() {
            let force_n = estimate.forces.forces_n[j];
            // Error of the mesh of the profile.
            let shift_n = at_found.as_ref().map_or(0.0, |at_found| force_n - at_found.forces_n[j]);
            let mut mixture = PositionProfile::force(&self.ranges, j);
            mixture.iter_mut().for_each(|(_, mean_n, _)| *mean_n += shift_n);
            let limits_n = interval(&mixture, 0.95);
            estimate.forces.widen_to(j, spread(&mixture, force_n), limits_n);
        }
        let i = self.contact;
        let position = PositionProfile::position(&self.ranges);
        let [from_mm, to_mm] = interval(&position, 0.95);
        let uncertainty = &mut estimate.uncertainties[i];
        uncertainty.position_sd_mm = Some(spread(&position, found_mm));
        uncertainty.position_interval_mm = Some([from_mm.min(found_mm), to_mm.max(found_mm)]);
        if let Some(sd_deg) = &mut uncertainty.direction_sd_deg {
            let angle = PositionProfile::mixture(&self.ranges, |point, _| (point.angle_deg, point.angle_sd_deg));
            *sd_deg = spread(&angle, estimate.contacts[i].angle_deg);
        }
    }
}

/// Root mean square distance of a mixture from a value.
fn spread(mixture: &[Component], from: f64) -> f64 {
    let whole: f64 = mixture.iter().map(|(weight, ..)| weight).sum();
    let square = |(weight, mean, sd): &Component| weight * ((mean - from).powi(2) + sd * sd);
    (mixture.iter().map(square).sum::<f64>() / whole).sqrt()
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

/// The forces of a range at a position, by interpolation.
fn at(range: &[ForcesAt], s_mm: f64) -> Option<ForcesAt> {
    let ends = range.windows(2).find(|ends| (ends[0].s_mm..=ends[1].s_mm).contains(&s_mm))?;
    Some(ends[0].towards(&ends[1], (s_mm - ends[0].s_mm) / (ends[1].s_mm - ends[0].s_mm)))
}

/// Whether forces are those of a point of the profile, up to the error of interpolation and some standard deviations.
fn is_same(found: &ForcesAt, forces_n: &[f64]) -> bool {
    let same = |((a, b), sigma_n): ((&f64, &f64), &f64)| (a - b).abs() <= 5.0 * sigma_n + 0.02 * a.abs();
    found.forces_n.iter().zip(forces_n).zip(&found.sigmas_n).all(same)
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
