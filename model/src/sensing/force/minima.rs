//! Finds the minima of the misfit (sum of squared weighted residuals) from several starting points, and selects the smallest minimum.
//!
//! Most measurements have one minimum, to which the first starting point leads. Few markers, few ribs and buckling plates cause several minima. If
//! there may be several minima, the search also starts from multiples of the forces that fit the linear finger. For forces at known contacts, the
//! search also starts from every minimum among all equilibria of the finger under forces at these contacts ([`scan`](super::scan)). The scan follows
//! curves of equilibria and may miss minima between these curves. For unknown positions, the search also starts from the rivals of the best minimum in a
//! [`profile`](super::profile) over the positions. While markers are hidden, it also starts from the best contacts at known positions along the plate: another
//! minimum may have a shape so unlike the best that the finger linearised at the best does not show it.

use super::assessment::assess;
use super::correction::correct;
use super::largest_explained_rms_mm;
use super::linearised::Seen;
use super::object_start::without_object;
use super::problem::{ForceProblem, State};
use super::profile::{Rival, Rivals, find_rivals};
use super::scan::{Scan, ScannedPoint, least, scan};
use super::search::search;
use super::search_history::SearchHistory;
use super::start::{StartingPoint, start_at, starting_points};
use super::states::{Found, carry_over, state_under};
use crate::finger::Plate;
use crate::frame::FrameMotion;
use crate::sensing::{ContactPosition, ContactQuestion, Direction, SensingError};

/// A minimum may be wrong if its residual exceeds both this share of the displacements and `POOR_FIT_SIGMAS` standard deviations of the noise. If a
/// minimum may be wrong, the search also starts from multiples of the forces that fit the linear finger, and the best minimum is used.
const POOR_FIT: f64 = 0.02;
const POOR_FIT_SIGMAS: f64 = 3.0;

/// From this number of measured coordinates, a minimum may count as unique: the first value is for one force, the second for several forces. A
/// minimum counts as unique only if it explains all coordinates and the first starting point leads to this minimum.
pub(super) const MANY_COORDINATES: [usize; 2] = [16, 8];
/// From this multiple of [`MANY_COORDINATES`], a minimum counts as unique if it explains all coordinates or if two searches end in this minimum. The
/// multiple `VERY_MANY` applies only if all unknowns are forces or are measured. In the test `random_fingers`, none of the estimates for 8000 random fingers had an
/// undetected error.
const VERY_MANY: usize = 2;

/// Rivals are sought for at most this number of unknown positions, because all combinations of positions are compared.
const MOST_UNPLACED: usize = 3;
/// At most this number of minima, each better than the one before, are compared with their rivals.
const MOST_PROFILES: usize = 4;

/// Positions, as shares of the front plate's length, at which a search along the plate starts. Near the base, where forces grow with the inverse square of
/// the position, they are denser.
const PLATE_POSITIONS: [f64; 11] = [0.04, 0.055, 0.076, 0.105, 0.145, 0.2, 0.276, 0.38, 0.525, 0.725, 1.0];
/// At most this number of minima along the plate are followed.
const MOST_PLATE_MINIMA: usize = 3;

/// The minimum with the smallest misfit, and the other results of the searches.
pub(super) struct Minima {
    pub best: Found,
    /// Misfit, mm^2, and forces, N, of all minima, in the order of [`ForceProblem::order`].
    pub all: Vec<(f64, Vec<f64>)>,
    /// Forces, N, and shapes from which the searches started.
    pub starts: Vec<(Vec<f64>, FrameMotion)>,
    /// States of the other minima, if one position is unknown.
    pub rivals: Vec<State>,
    /// Misfit, mm^2, and forces, N, for other positions that explain the measurement, in the order of [`ForceProblem::order`].
    pub others: Vec<(f64, Vec<f64>)>,
    /// Points of the scan, one list per curve. Empty without a scan.
    pub scanned: Vec<Vec<ScannedPoint>>,
}

impl Minima {
    /// A minimum that needs no comparison.
    pub fn only(best: Found) -> Minima {
        let (all, rivals) = (Vec::new(), Vec::new());
        Minima { best, all, rivals, starts: Vec::new(), others: Vec::new(), scanned: Vec::new() }
    }
}

/// Scanned equilibria of a problem. The outer option is `None` before the scan. The inner option is `None` if a scan is impossible for the contacts.
pub(super) type KeptScan = Option<Option<Scan>>;

/// Searches for all minima of the misfit (sum of squared weighted residuals) for a measurement.
struct GlobalSearch<'s, 'm> {
    problem: &'s mut ForceProblem<'m>,
    seen: Seen<'s>,
    /// A minimum may be wrong if its misfit exceeds this value, mm^2.
    largest_misfit: f64,
    /// Whether all unknowns are forces or are measured, no direction follows the plate, and the measurement has at least [`VERY_MANY`] times [`MANY_COORDINATES`]
    /// coordinates.
    has_very_many: bool,
    history: SearchHistory,
    best: Option<Found>,
    failure: Option<SensingError>,
    all: Vec<(f64, Vec<f64>)>,
    rivals: Vec<State>,
    starts: Vec<(Vec<f64>, FrameMotion)>,
    others: Vec<(f64, Vec<f64>)>,
}

/// Finds the minima of the misfit (sum of squared weighted residuals) for a measurement. `at_hand` is a minimum that is known already.
///
/// # Errors
/// [`SensingError`] if there is no minimum, or the unknowns of a minimum that fits well are not identifiable.
pub(super) fn find_minima(
    problem: &mut ForceProblem,
    at_hand: Option<Found>,
    scan: &mut KeptScan,
    seen: Seen,
) -> Result<Minima, SensingError> {
    let Seen { measurement, marker_noise_mm } = seen;
    let coordinates = measurement.coordinate_count();
    let moved_rms_mm = measurement.displacement_rms_mm();
    // With priors, several minima may have residuals below a small share of the displacements. With priors, the limit of the misfit follows from
    // the noise alone.
    let share = if problem.priors.count() == 0 { POOR_FIT } else { 0.0 };
    let poor = (share * moved_rms_mm).max(POOR_FIT_SIGMAS * marker_noise_mm.unwrap_or(0.0));
    let explained_mm2 = marker_noise_mm
        .map(|marker_noise_mm| largest_explained_rms_mm(marker_noise_mm, moved_rms_mm).powi(2) * coordinates as f64);
    let many = MANY_COORDINATES[usize::from(problem.questions.len() > 1)];
    let has_many = coordinates >= many;
    // Positions and directions that are not measured, and unknown base poses, make a scan coarse and slow. A coarse scan is used only for few markers and without priors.
    let is_coarse = !problem.is_of_forces();
    let mut search = GlobalSearch {
        seen,
        largest_misfit: poor * poor * coordinates as f64,
        has_very_many: !is_coarse && !problem.follows_plate() && coordinates >= VERY_MANY * many,
        history: SearchHistory::of(&problem.unknowns, &problem.questions).explaining_up_to(explained_mm2),
        best: at_hand,
        failure: None,
        all: Vec::new(),
        rivals: Vec::new(),
        starts: Vec::new(),
        others: Vec::new(),
        problem,
    };
    let is_at_hand = search.is_good();
    search.search_from_starts()?;
    let fits = search.best.as_ref().is_some_and(|found| search.misfit(found) <= search.largest_misfit);
    // With many markers, a minimum that is far from explaining the measurement also counts as unique if two searches agree on this minimum.
    let is_only_one = search.has_very_many && (fits || search.history.agree())
        || has_many && (search.is_good() || search.history.agree_on_none());
    let is_worth_it = !is_coarse || search.problem.priors.count() == 0 && !has_many;
    let is_scanned = !is_at_hand && !is_only_one && is_worth_it;
    let scanned = if is_scanned { search.search_from_scan(scan) } else { Vec::new() };
    if search.seeks_rivals(is_at_hand) {
        search.search_from_rivals();
    }
    if search.problem.is_weak(measurement) {
        search.search_along_plate(explained_mm2);
    }
    let GlobalSearch { best, failure, all, rivals, starts, others, .. } = search;
    let best = best.ok_or_else(|| failure.unwrap_or(SensingError::NoContact))?;
    Ok(Minima { best, all, rivals, starts, others, scanned })
}

impl GlobalSearch<'_, '_> {
    fn misfit(&self, found: &Found) -> f64 {
        self.problem.misfit(&found.state, self.seen.measurement)
    }

    /// Whether the best minimum explains the measurement and counts as locally unique.
    fn is_good(&self) -> bool {
        self.best.as_ref().is_some_and(|found| found.near && self.misfit(found) <= self.largest_misfit)
    }

    /// Searches from multiples of the forces that fit the linear finger until a good minimum is found.
    fn search_from_starts(&mut self) -> Result<(), SensingError> {
        for start in starting_points(self.problem, self.seen.measurement.base().is_some()) {
            if let Some(found) = &mut self.best
                && self.problem.misfit(&found.state, self.seen.measurement) <= self.largest_misfit
            {
                let is_only_one = found.near || self.has_very_many;
                let is_further =
                    matches!(start, StartingPoint::Towards(_) | StartingPoint::FromMovedBase | StartingPoint::Held);
                if is_only_one || is_further {
                    break;
                }
                // Refuses the measurement if the unknowns of a minimum that fits well are not identifiable.
                assess(self.problem, &mut found.state, self.seen, found.steps)?;
            }
            // If searches agree, further multiples of the linear finger's forces lead to no other minimum. Starting points with other directions or
            // another pose of the base may lead to other minima.
            let are_settled = self.history.agree_on_none() || self.has_very_many && self.history.agree();
            if matches!(start, StartingPoint::Times(_)) && are_settled {
                continue;
            }
            self.history.begin();
            let found = search_from(self.problem, self.seen, start, &mut self.starts, &mut self.history);
            self.take(found);
        }
        Ok(())
    }

    /// Starts a search from each minimum of the misfit in a scan. Returns the points of the scan.
    fn search_from_scan(&mut self, kept: &mut KeptScan) -> Vec<Vec<ScannedPoint>> {
        let Some(scan) = kept.get_or_insert_with(|| scan(self.problem)) else { return Vec::new() };
        let scanned = scan.misfits(self.seen.measurement);
        for point in least(&scanned) {
            let before = scan.state_before(point);
            let state = state_under(self.problem, &before.contacts, &point.forces_n, Some(before));
            let Some(start) = state.and_then(|state| carry_over(self.problem, state, self.seen).ok()) else { continue };
            self.history.begin();
            let found = minimum_near(self.problem, start, self.seen, &mut self.history);
            self.take(found);
        }
        scanned
    }

    /// Whether rivals of the best minimum are sought. A search for a single position with very many coordinates keeps a minimum at hand, because the
    /// search for the first of similar measurements has compared the minima. It also keeps a minimum whose residual exceeds [`POOR_FIT_SIGMAS`], because
    /// the estimate then carries a warning: the finger is near a limit load, or differs from the scene. Several positions depend on the order of the
    /// contacts without a comparison.
    fn seeks_rivals(&self, is_at_hand: bool) -> bool {
        let coordinates = self.seen.measurement.coordinate_count() as f64;
        let largest_mm2 =
            self.seen.marker_noise_mm.map(|marker_noise_mm| (POOR_FIT_SIGMAS * marker_noise_mm).powi(2) * coordinates);
        let is_within = |found: &Found| largest_mm2.is_none_or(|largest_mm2| self.misfit(found) <= largest_mm2);
        self.problem.object.is_none()
            && match self.problem.unplaced().len() {
                1 => {
                    !(is_at_hand && coordinates >= (VERY_MANY * MANY_COORDINATES[0]) as f64)
                        && self.best.as_ref().is_some_and(is_within)
                }
                several => (2..=MOST_UNPLACED).contains(&several),
            }
    }

    /// Starts a search from each rival of the best minimum. If a search finds a better minimum, the rivals of that minimum follow.
    fn search_from_rivals(&mut self) {
        for _ in 0..MOST_PROFILES {
            let Some(best) = &self.best else { return };
            let (misfit_mm2, best) = (self.misfit(best), best.state.clone());
            let Ok(Rivals { rivals, others }) = find_rivals(self.problem, &best, self.seen) else { return };
            self.others = others;
            self.follow_rivals(&best, rivals);
            if !self.best.as_ref().is_some_and(|found| self.misfit(found) < misfit_mm2) {
                return;
            }
        }
    }

    /// Places the contact at several positions along the plate, outwards from the best minimum, and starts a search from each position whose misfit is
    /// smaller than that of its neighbours. A misfit far above `explained_mm2` needs no accuracy.
    fn search_along_plate(&mut self, explained_mm2: Option<f64>) {
        let [contact] = self.problem.unplaced()[..] else { return };
        let length_mm = self.problem.finger().plate_length_mm(Plate::Front);
        let mut questions = self.problem.questions.clone();
        questions[contact].position = Some(ContactPosition::at(length_mm));
        let Ok(mut placed) = self.problem.with_questions(&questions) else { return };
        if placed.expect(self.seen).is_err() {
            return;
        }
        let best = self.best.as_ref().map(|best| best.state.clone());
        let share = |state: &State| state.contacts[contact].position_mm(self.problem.finger()).map(|s| s / length_mm);
        let nearest = best.as_ref().and_then(share).map_or(PLATE_POSITIONS.len() - 1, |share| {
            PLATE_POSITIONS.partition_point(|at| *at < share).min(PLATE_POSITIONS.len() - 1)
        });
        let mut along: [Option<(f64, State)>; PLATE_POSITIONS.len()] = Default::default();
        for (i, before) in (0..=nearest).rev().map(|i| (i, i + 1)).chain((nearest + 1..along.len()).map(|i| (i, i - 1)))
        {
            let before = along.get(before).and_then(|it| it.as_ref().map(|(_, state)| state)).or(best.as_ref());
            let s_mm = PLATE_POSITIONS[i] * length_mm;
            let history = SearchHistory::default().explaining_up_to(explained_mm2);
            let warm = before.and_then(|near| {
                let moved = share(near).map_or(1.0, |share| share / PLATE_POSITIONS[i]);
                let mut forces_n = near.forces_n.clone();
                forces_n[contact] *= moved;
                minimum_at(&mut placed, (contact, s_mm), near, &forces_n, self.seen, history.clone()).ok()
            });
            let found = warm.or_else(|| {
                placed.questions[contact].position = Some(ContactPosition::at(s_mm));
                let start = StartingPoint::Times(1.0);
                let found = search_from(&mut placed, self.seen, start, &mut Vec::new(), &mut history.clone());
                found.ok().flatten().map(|found| found.state)
            });
            // Contacts push.
            let found = found.filter(|state| state.forces_n.iter().all(|force_n| *force_n >= 0.0));
            along[i] = found.map(|state| (placed.misfit(&state, self.seen.measurement), state));
        }
        let misfit_mm2 = |i: Option<usize>| i.and_then(|i| along.get(i)?.as_ref()).map_or(f64::INFINITY, |it| it.0);
        let is_least = |&i: &usize| misfit_mm2(Some(i)) <= misfit_mm2(i.checked_sub(1)).min(misfit_mm2(Some(i + 1)));
        let mut least: Vec<usize> = (0..along.len()).filter(|&i| along[i].is_some()).filter(is_least).collect();
        least.sort_by(|a, b| misfit_mm2(Some(*a)).total_cmp(&misfit_mm2(Some(*b))));
        least.truncate(MOST_PLATE_MINIMA);
        for (_, state) in least.into_iter().filter_map(|i| along[i].clone()) {
            let Ok(start) = carry_over(self.problem, state, self.seen) else { continue };
            self.history.begin();
            let found = minimum_near(self.problem, start, self.seen, &mut self.history);
            self.take(found);
        }
    }

    /// Starts a search from each rival of the minimum `best`.
    fn follow_rivals(&mut self, best: &State, rivals: Vec<Rival>) {
        let pushes = |state: &State| state.forces_n.iter().all(|force_n| *force_n >= 0.0);
        for Rival { contacts, forces_n } in rivals {
            let near = state_under(self.problem, &contacts, &forces_n, Some(best));
            let near = near.or_else(|| state_under(self.problem, &contacts, &forces_n, None));
            let Some(mut start) = near else { continue };
            start.nuisances.base = best.nuisances.base;
            let Ok(start) = carry_over(self.problem, start, self.seen) else { continue };
            self.history.begin();
            let found = minimum_near(self.problem, start, self.seen, &mut self.history);
            // Contacts push. A search from pushing forces that ends at a pulling force has left the rival.
            let is_rival = |found: &Option<Found>| found.as_ref().is_none_or(|it| pushes(&it.state) || !pushes(best));
            match found {
                Ok(found) if is_rival(&found) => self.take(Ok(found)),
                _ => _ = self.history.end(None),
            }
        }
    }

    /// Records the result of a search.
    fn take(&mut self, found: Result<Option<Found>, SensingError>) {
        match found {
            Ok(Some(found)) => {
                let order = self.problem.order(&found.state.contacts);
                let forces_n = order.iter().map(|&i| found.state.forces_n[i]).collect();
                let misfit_mm2 = self.misfit(&found);
                self.all.extend(self.history.end(Some((misfit_mm2, forces_n))));
                let is_best = self.best.as_ref().is_none_or(|best| misfit_mm2 < self.misfit(best));
                let other = if is_best { self.best.replace(found) } else { Some(found) };
                if self.problem.unplaced().len() == 1 {
                    self.rivals.extend(other.map(|other| other.state));
                }
            }
            Ok(None) => self.all.extend(self.history.end(None)),
            Err(error) => {
                self.history.end(None);
                self.failure.get_or_insert(error);
            }
        }
    }
}

/// Minimum nearest to a starting point, found by the trust-region search unless the starting point is near the minimum. `None` if the search
/// meets a path of `history`. Adds forces and shape of the starting point to `starts`.
pub(super) fn search_from(
    problem: &mut ForceProblem,
    seen: Seen,
    start: StartingPoint,
    starts: &mut Vec<(Vec<f64>, FrameMotion)>,
    history: &mut SearchHistory,
) -> Result<Option<Found>, SensingError> {
    let start = match (&problem.object, start) {
        (Some(_), _) => search_without_object(problem, seen, start)?,
        (None, StartingPoint::Held) => held_start(problem, seen)?,
        (None, _) => start_at(problem, seen, start)?,
    };
    starts.push((start.forces_n.clone(), start.motion.clone()));
    minimum_near(problem, start, seen, history)
}

/// Minimum nearest to a state, found by the trust-region search unless the state is near the minimum. `None` if the search meets a path of
/// `history`.
pub(super) fn minimum_near(
    problem: &mut ForceProblem,
    start: State,
    seen: Seen,
    history: &mut SearchHistory,
) -> Result<Option<Found>, SensingError> {
    if history.meets(&start) {
        return Ok(None);
    }
    let mut state = start.clone();
    if let Some(steps) = correct(problem, &mut state, seen) {
        history.reach(&state);
        return Ok(Some(Found { state, steps, near: true }));
    }
    search(problem, start, seen, history)
}

/// Starting point with directions that do not follow the plate. If directions follow a strongly turning plate, the search fails more often.
fn held_start(problem: &mut ForceProblem, seen: Seen) -> Result<State, SensingError> {
    let held = |question: &ContactQuestion| match question.direction {
        Direction::Leaning(lean) => ContactQuestion { direction: Direction::Angle(lean.angle_deg), ..*question },
        Direction::Angle(_) | Direction::Measured(_) | Direction::Auto => *question,
    };
    let questions: Vec<ContactQuestion> = problem.questions.iter().map(held).collect();
    let mut held = problem.with_questions(&questions)?;
    held.expect(seen)?;
    let (mut starts, mut history) = (Vec::new(), SearchHistory::default());
    let found = search_from(&mut held, seen, StartingPoint::Times(1.0), &mut starts, &mut history)?;
    // The history is empty, so the search cannot end at an earlier path.
    carry_over(problem, found.ok_or(SensingError::NoContact)?.state, seen)
}

/// The nearest minimum of the problem without the object, as a starting point.
fn search_without_object(problem: &mut ForceProblem, seen: Seen, start: StartingPoint) -> Result<State, SensingError> {
    let mut plain = without_object(problem)?;
    plain.expect(seen)?;
    let (mut starts, mut history) = (Vec::new(), SearchHistory::default());
    let found = search_from(&mut plain, seen, start, &mut starts, &mut history)?;
    carry_over(problem, found.ok_or(SensingError::NoContact)?.state, seen)
}

/// State of the minimum with one contact (by index) at a position, mm, for a problem in which this position is known. The search starts from `forces_n`
/// near the state `near`. With an empty history, it cannot end because it meets the path of an earlier search.
///
/// # Errors
/// [`SensingError`] if the search fails.
pub(super) fn minimum_at(
    placed: &mut ForceProblem,
    (contact, s_mm): (usize, f64),
    near: &State,
    forces_n: &[f64],
    seen: Seen,
    mut history: SearchHistory,
) -> Result<State, SensingError> {
    let position = ContactPosition::at(s_mm);
    placed.questions[contact].position = Some(position);
    let mut contacts = near.contacts.clone();
    contacts[contact].position = position;
    let state = state_under(placed, &contacts, forces_n, Some(near)).ok_or(SensingError::NoContact)?;
    let start = carry_over(placed, State { nuisances: near.nuisances.clone(), ..state }, seen)?;
    Ok(minimum_near(placed, start, seen, &mut history)?.ok_or(SensingError::NoContact)?.state)
}
