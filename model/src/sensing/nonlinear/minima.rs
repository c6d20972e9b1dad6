//! Finds the minima of the misfit (sum of squared weighted residuals) from several starting points, and selects the smallest minimum.
//!
//! Most measurements have one minimum, to which the first starting point leads. Few markers, few ribs and buckling plates cause several minima. If
//! there may be several minima, the search also starts from multiples of the forces that fit the linear finger. For forces at known contacts, the
//! search also starts from every minimum among all equilibria of the finger under forces at these contacts ([`scan`](super::scan)). The scan follows
//! curves of equilibria and may miss minima between these curves. For unknown positions, the search also starts from the rivals of the best minimum in a
//! [`profile`](super::profile) over the positions.

use super::profile::{Rival, Rivals};
use super::scan::{ScannedPoint, least};
use super::search_history::SearchHistory;
use super::start::Start;
use super::{Found, NonlinearEstimator, State, largest_explained_rms_mm};
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::sensing::SensingError;

/// A minimum may be wrong if its residual exceeds both this share of the displacements and `POOR_FIT_SIGMAS` standard deviations of the noise. If a
/// minimum may be wrong, the search also starts from multiples of the forces that fit the linear finger, and the best minimum is used.
const POOR_FIT: f64 = 0.02;
const POOR_FIT_SIGMAS: f64 = 3.0;

/// From this number of measured coordinates, a minimum may count as unique: the first value is for one force, the second for several forces. A
/// minimum counts as unique only if it explains all coordinates and the first starting point leads to this minimum.
pub(super) const MANY_COORDINATES: [usize; 2] = [16, 8];
/// From this multiple of [`MANY_COORDINATES`], a minimum counts as unique if it explains all coordinates or if two searches end in this minimum. The
/// multiple `VERY_MANY` applies only if all unknowns are forces. In the test `random_fingers`, none of the estimates for 8000 random fingers had an
/// undetected error.
const VERY_MANY: usize = 2;

/// Rivals are sought for at most this number of unknown positions, because all combinations of positions are compared.
const MOST_UNPLACED: usize = 3;
/// At most this number of minima, each better than the one before, are compared with their rivals.
const MOST_PROFILES: usize = 4;

/// The minimum with the smallest misfit, and the other results of the searches.
pub(super) struct Minima {
    pub best: Found,
    /// Misfit, mm^2, and forces, N, of all minima, in the order of [`NonlinearEstimator::order`].
    pub all: Vec<(f64, Vec<f64>)>,
    /// Forces, N, and shapes from which the searches started.
    pub starts: Vec<(Vec<f64>, FrameMotion)>,
    /// Misfit, mm^2, and forces, N, for other positions that explain the measurement, in the order of [`NonlinearEstimator::order`].
    pub others: Vec<(f64, Vec<f64>)>,
    /// Points of the scan, one list per curve. Empty without a scan.
    pub scanned: Vec<Vec<ScannedPoint>>,
}

/// State of the search for all minima.
struct Search<'s> {
    measurement: &'s Measurement,
    noise_mm: Option<f64>,
    /// Whether all unknowns are forces, no direction follows the plate, and the measurement has at least [`VERY_MANY`] times [`MANY_COORDINATES`]
    /// coordinates.
    has_very_many: bool,
    history: SearchHistory,
    best: Option<Found>,
    failure: Option<SensingError>,
    all: Vec<(f64, Vec<f64>)>,
    others: Vec<(f64, Vec<f64>)>,
}

impl NonlinearEstimator<'_> {
    /// Finds the minima of the misfit (sum of squared weighted residuals) for a measurement.
    ///
    /// # Errors
    /// [`SensingError`] if there is no minimum, or the unknowns of a minimum that fits well are not identifiable.
    pub(super) fn minima(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Minima, SensingError> {
        let coordinates = measurement.coordinate_count();
        let moved_rms_mm = measurement.displacement_rms_mm();
        // With priors, several minima may have residuals below a small share of the displacements. With priors, the limit of the misfit follows from
        // the noise alone.
        let share = if self.priors.count() == 0 { POOR_FIT } else { 0.0 };
        let poor = (share * moved_rms_mm).max(POOR_FIT_SIGMAS * noise_mm.unwrap_or(0.0));
        let largest_misfit = poor * poor * coordinates as f64;
        let explained_mm2 =
            noise_mm.map(|noise_mm| largest_explained_rms_mm(noise_mm, moved_rms_mm).powi(2) * coordinates as f64);
        let history = SearchHistory::of(&self.unknowns, &self.questions).explaining_up_to(explained_mm2);
        let best = self.minimum_at_hand(measurement, noise_mm)?;
        let is_good = |found: &Option<Found>, estimator: &Self| {
            found.as_ref().is_some_and(|it| it.near && estimator.misfit(&it.state, measurement) <= largest_misfit)
        };
        if std::mem::take(&mut self.is_chosen)
            && let Some(best) = best
        {
            return Ok(Minima { best, all: Vec::new(), starts: Vec::new(), others: Vec::new(), scanned: Vec::new() });
        }
        let is_at_hand = is_good(&best, self);
        let many = MANY_COORDINATES[usize::from(self.questions.len() > 1)];
        let has_many = coordinates >= many;
        // Unknown positions, directions or base poses make a scan coarse and slow. A coarse scan is used only for few markers and without priors.
        let is_coarse = self.unknowns.len() > self.questions.len();
        let has_very_many = !is_coarse && !self.follows_plate() && coordinates >= VERY_MANY * many;
        let (failure, all, others) = (None, Vec::new(), Vec::new());
        let mut search = Search { measurement, noise_mm, has_very_many, history, best, failure, all, others };
        let starts = self.search_from_starts(&mut search, largest_misfit)?;
        let fits = search.best.as_ref().is_some_and(|it| self.misfit(&it.state, measurement) <= largest_misfit);
        // With many markers, a minimum that is far from explaining the measurement also counts as unique if two searches agree on this minimum.
        let is_only_one = has_very_many && (fits || search.history.agree())
            || has_many && (is_good(&search.best, self) || search.history.agree_on_none());
        let is_worth_it = !is_coarse || self.priors.count() == 0 && !has_many;
        let is_scanned = !is_at_hand && !is_only_one && is_worth_it;
        let scanned = if is_scanned { self.search_from_scan(&mut search) } else { Vec::new() };
        if self.seeks_rivals(&search, is_at_hand) {
            self.search_from_rivals(&mut search);
        }
        let Search { best, failure, all, others, .. } = search;
        let best = best.ok_or_else(|| failure.unwrap_or(SensingError::NoContact))?;
        Ok(Minima { best, all, starts, others, scanned })
    }

    /// Searches from multiples of the forces that fit the linear finger until a good minimum is found. Returns the forces, N, and shapes of the starting
    /// points.
    fn search_from_starts(
        &mut self,
        search: &mut Search,
        largest_misfit: f64,
    ) -> Result<Vec<(Vec<f64>, FrameMotion)>, SensingError> {
        let (measurement, noise_mm) = (search.measurement, search.noise_mm);
        let mut starts = Vec::new();
        for start in self.starts(measurement.base().is_some()) {
            if let Some(found) = &mut search.best
                && self.misfit(&found.state, measurement) <= largest_misfit
            {
                let is_only_one = found.near || search.has_very_many;
                if is_only_one || matches!(start, Start::Towards(_) | Start::FromMovedBase | Start::Held) {
                    break;
                }
                // Refuses the measurement if the unknowns of a minimum that fits well are not identifiable.
                self.judged(&mut found.state, measurement, noise_mm, found.steps)?;
            }
            // If searches agree, further multiples of the linear finger's forces lead to no other minimum. Starting points with other directions or
            // another pose of the base may lead to other minima.
            let are_settled = search.history.agree_on_none() || search.has_very_many && search.history.agree();
            if matches!(start, Start::Times(_)) && are_settled {
                continue;
            }
            search.history.begin();
            let found = self.searched(measurement, noise_mm, start, &mut starts, &mut search.history);
            self.take(search, found);
        }
        Ok(starts)
    }

    /// Starts a search from each minimum of the misfit in a scan. Returns the points of the scan.
    fn search_from_scan(&mut self, search: &mut Search) -> Vec<Vec<ScannedPoint>> {
        if self.scan.is_none() {
            self.scan = Some(self.scanned());
        }
        let scan = self.scan.as_ref().and_then(Option::as_ref);
        let scanned = scan.map(|scan| scan.misfits(search.measurement)).unwrap_or_default();
        for point in least(&scanned) {
            let Some(start) = self.state_of(point, search.measurement, search.noise_mm) else { continue };
            search.history.begin();
            let found = self.minimum_near(start, search.measurement, search.noise_mm, &mut search.history);
            self.take(search, found);
        }
        scanned
    }

    /// Whether rivals of the best minimum are sought. A search for a single position keeps a minimum at hand, because the search for the first of similar
    /// measurements has compared the minima. It also keeps a minimum whose residual exceeds [`POOR_FIT_SIGMAS`], because the estimate then carries a warning: the
    /// finger is near a limit load, or differs from the scene. Several positions depend on the order of the contacts without a comparison.
    fn seeks_rivals(&self, search: &Search, is_at_hand: bool) -> bool {
        let coordinates = search.measurement.coordinate_count() as f64;
        let largest_mm2 = search.noise_mm.map(|noise_mm| (POOR_FIT_SIGMAS * noise_mm).powi(2) * coordinates);
        let is_within = |found: &Found| {
            largest_mm2.is_none_or(|largest_mm2| self.misfit(&found.state, search.measurement) <= largest_mm2)
        };
        self.object.is_none()
            && match self.unplaced().len() {
                1 => !is_at_hand && search.best.as_ref().is_some_and(is_within),
                several => (2..=MOST_UNPLACED).contains(&several),
            }
    }

    /// Starts a search from each rival of the best minimum. If a search finds a better minimum, the rivals of that minimum follow.
    fn search_from_rivals(&mut self, search: &mut Search) {
        for _ in 0..MOST_PROFILES {
            let Some(best) = &search.best else { return };
            let (best, misfit_mm2) = (best.state.clone(), self.misfit(&best.state, search.measurement));
            let profiled = self.rivals(&best, search.measurement, search.noise_mm);
            let Ok(Rivals { rivals, others }) = profiled else { return };
            search.others = others;
            self.follow_rivals(search, &best, rivals);
            let is_better = |found: &Found| self.misfit(&found.state, search.measurement) < misfit_mm2;
            if !search.best.as_ref().is_some_and(is_better) {
                return;
            }
        }
    }

    /// Starts a search from each rival of the minimum `best`.
    fn follow_rivals(&mut self, search: &mut Search, best: &State, rivals: Vec<Rival>) {
        let pushes = |state: &State| state.forces_n.iter().all(|force_n| *force_n >= 0.0);
        for Rival { contacts, forces_n } in rivals {
            let near = self.state_under(&contacts, &forces_n, Some(best));
            let Some(mut start) = near.or_else(|| self.state_under(&contacts, &forces_n, None)) else { continue };
            start.nuisances.base = best.nuisances.base;
            let Ok(start) = self.resumed(start, search.measurement, search.noise_mm) else { continue };
            search.history.begin();
            let found = self.minimum_near(start, search.measurement, search.noise_mm, &mut search.history);
            // Contacts push. A search from pushing forces that ends at a pulling force has left the rival.
            let is_rival = |found: &Option<Found>| found.as_ref().is_none_or(|it| pushes(&it.state) || !pushes(best));
            match found {
                Ok(found) if is_rival(&found) => self.take(search, Ok(found)),
                _ => _ = search.history.end(None),
            }
        }
    }

    /// Records the result of a search.
    fn take(&self, search: &mut Search, found: Result<Option<Found>, SensingError>) {
        let misfit = |found: &Found| self.misfit(&found.state, search.measurement);
        match found {
            Ok(Some(found)) => {
                let order = self.order(&found.state.contacts);
                let forces_n = order.iter().map(|&i| found.state.forces_n[i]).collect();
                search.all.extend(search.history.end(Some((misfit(&found), forces_n))));
                if search.best.as_ref().is_none_or(|best| misfit(&found) < misfit(best)) {
                    search.best = Some(found);
                }
            }
            Ok(None) => search.all.extend(search.history.end(None)),
            Err(error) => {
                search.history.end(None);
                search.failure.get_or_insert(error);
            }
        }
    }

    /// State at a point of the scan, linearised for a measurement. `None` if no equilibrium is found.
    fn state_of(&mut self, point: &ScannedPoint, measurement: &Measurement, noise_mm: Option<f64>) -> Option<State> {
        let before = self.scan.as_ref()?.as_ref()?.state_before(point).clone();
        let state = self.state_under(&before.contacts, &point.forces_n, Some(&before))?;
        self.resumed(state, measurement, noise_mm).ok()
    }

    /// Minimum nearest to a starting point, found by the trust-region search unless the starting point is near the minimum. `None` if the search
    /// meets a path of `history`. Adds forces and shape of the starting point to `starts`.
    pub(super) fn searched(
        &mut self,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        start: Start,
        starts: &mut Vec<(Vec<f64>, FrameMotion)>,
        history: &mut SearchHistory,
    ) -> Result<Option<Found>, SensingError> {
        let start = match self.object {
            None => self.start(measurement, noise_mm, start)?,
            Some(_) => self.searched_without_object(measurement, noise_mm, start)?,
        };
        starts.push((start.forces_n.clone(), start.motion.clone()));
        self.minimum_near(start, measurement, noise_mm, history)
    }

    /// Minimum nearest to a state, found by the trust-region search unless the state is near the minimum. `None` if the search meets a path of
    /// `history`.
    pub(super) fn minimum_near(
        &mut self,
        start: State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        history: &mut SearchHistory,
    ) -> Result<Option<Found>, SensingError> {
        if history.meets(&start) {
            return Ok(None);
        }
        let mut state = start.clone();
        if let Some(steps) = self.correct(&mut state, measurement, noise_mm) {
            history.reach(&state);
            return Ok(Some(Found { state, steps, near: true }));
        }
        self.search(start, measurement, noise_mm, history)
    }
}
