//! Paths of searches. A search ends when it meets the path of an earlier search, because it would continue along that path.
//!
//! With known contacts and directions, forces alone describe the state of a search. With unknown contacts or directions, two searches may pass the
//! same forces and end at different minima, so their paths are not recorded.
//!
//! A minimum far from explaining the measurement does not need full accuracy. If two searches agree on a minimum far from explaining the measurement,
//! no search starts from further multiples of the forces of the linear finger.

use super::problem::State;
use super::unknowns::Unknown;
use crate::sensing::{ContactQuestion, Direction};

/// A search meets a path if the distance of each force from the path is at most this share of the largest force.
const MET: f64 = 0.01;

/// A minimum is far from explaining a measurement if its residual exceeds the largest explained residual by more than this factor.
const FAR: f64 = 1.25;
/// A search far from explaining the measurement ends if the next step is predicted to decrease the misfit (sum of squared residuals) by at most this share.
const NEARLY: f64 = 0.01;
/// Two searches agree if neither their misfits (relative difference) nor their forces (share of the largest force) differ by more than this value.
const AGREE: f64 = 0.05;

/// Path of a search: the forces at each step, N, and the minimum at the end of the path. `end` contains the misfit of this minimum, mm^2, and its
/// forces, N; `end` is `None` if the search ended without a minimum.
#[derive(Debug, Clone)]
struct SearchPath {
    points: Vec<Vec<f64>>,
    end: Option<(f64, Vec<f64>)>,
}

/// Paths of all searches.
#[derive(Debug, Clone, Default)]
pub(super) struct SearchHistory {
    /// Whether paths are recorded: only if forces are the only unknowns and no direction follows the plate.
    are_kept: bool,
    ended: Vec<SearchPath>,
    current: Vec<Vec<f64>>,
    /// Index of the ended path that the current path has met.
    met: Option<usize>,
    /// Misfit above which a minimum is far from explaining the measurement, mm^2. `None` if any misfit may explain the measurement.
    far_mm2: Option<f64>,
}

impl SearchHistory {
    /// An empty history for a search of the unknowns at the contacts in `questions`.
    pub(super) fn of(unknowns: &[Unknown], questions: &[ContactQuestion]) -> SearchHistory {
        let forces_alone = unknowns.iter().all(|unknown| matches!(unknown, Unknown::Force(_)));
        let follows = |question: &ContactQuestion| matches!(question.direction, Direction::Leaning(_));
        SearchHistory { are_kept: forces_alone && !questions.iter().any(follows), ..SearchHistory::default() }
    }

    /// This history with a limit: the largest misfit, mm^2, that explains the measurement. `None` if any misfit may explain the measurement.
    pub(super) fn explaining_up_to(self, misfit_mm2: Option<f64>) -> SearchHistory {
        SearchHistory { far_mm2: misfit_mm2.map(|misfit_mm2| FAR * FAR * misfit_mm2), ..self }
    }

    /// Whether a search may end at the misfit `misfit_mm2`: if this misfit is far from explaining the measurement, and the predicted decrease
    /// `decrease_mm2` in the next step is small.
    pub(super) fn ends_far(&self, misfit_mm2: f64, decrease_mm2: f64) -> bool {
        self.is_far(misfit_mm2) && decrease_mm2 <= NEARLY * misfit_mm2
    }

    fn is_far(&self, misfit_mm2: f64) -> bool {
        self.far_mm2.is_some_and(|far_mm2| misfit_mm2 > far_mm2)
    }

    /// Whether two searches agree on the best minimum so far, and this minimum is far from explaining the measurement.
    pub(super) fn agree_on_none(&self) -> bool {
        self.best().is_some_and(|(misfit_mm2, _)| self.is_far(*misfit_mm2)) && self.agree()
    }

    /// Whether two searches agree on the best minimum so far.
    pub(super) fn agree(&self) -> bool {
        self.best().is_some_and(|best| self.ends().filter(|end| agree(end, best)).count() > 1)
    }

    fn best(&self) -> Option<&(f64, Vec<f64>)> {
        self.ends().min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn ends(&self) -> impl Iterator<Item = &(f64, Vec<f64>)> {
        self.ended.iter().filter_map(|way| way.end.as_ref())
    }

    /// Starts the path of another search.
    pub(super) fn begin(&mut self) {
        self.current.clear();
        self.met = None;
    }

    /// Adds a state to the current path. Returns whether an earlier path passes this state and ends at a minimum.
    pub(super) fn meets(&mut self, state: &State) -> bool {
        self.met = self.passing(&state.forces_n);
        self.reach(state);
        self.met.is_some()
    }

    /// Adds a state to the current path, if paths are recorded.
    pub(super) fn reach(&mut self, state: &State) {
        if self.are_kept {
            self.current.push(state.forces_n.clone());
        }
    }

    /// Index of an ended path that passes the forces `forces_n`, N, and ends at a minimum.
    fn passing(&self, forces_n: &[f64]) -> Option<usize> {
        let passes = |way: &SearchPath| way.points.windows(2).any(|ends| is_between(forces_n, [&ends[0], &ends[1]]));
        self.ended.iter().position(|way| way.end.is_some() && passes(way))
    }

    /// Ends the current path with the minimum `end`. Returns this minimum, or the minimum of the earlier path that the current path has met.
    pub(super) fn end(&mut self, end: Option<(f64, Vec<f64>)>) -> Option<(f64, Vec<f64>)> {
        let end = self.met.map_or(end, |met| self.ended[met].end.clone());
        self.ended.push(SearchPath { points: std::mem::take(&mut self.current), end: end.clone() });
        end
    }
}

/// Whether two minima agree. Each minimum consists of a misfit, mm^2, and forces, N.
fn agree(one: &(f64, Vec<f64>), other: &(f64, Vec<f64>)) -> bool {
    let largest = other.1.iter().fold(0.0_f64, |m, n| m.max(n.abs()));
    let mut forces = one.1.iter().zip(&other.1);
    (one.0 - other.0).abs() <= AGREE * other.0 && forces.all(|(a, b)| (a - b).abs() <= AGREE * largest)
}

/// Whether the forces `forces_n`, N, lie on the straight line from `from` to `to`, within [`MET`].
fn is_between(forces_n: &[f64], [from, to]: [&[f64]; 2]) -> bool {
    let along = |n: &[f64]| n.iter().zip(from).zip(to).map(|((x, a), b)| (x - a) * (b - a)).sum::<f64>();
    let whole = along(to);
    let share = if whole > 0.0 { (along(forces_n) / whole).clamp(0.0, 1.0) } else { 1.0 };
    let largest = forces_n.iter().fold(0.0_f64, |m, n| m.max(n.abs()));
    let mut coordinates = forces_n.iter().zip(from).zip(to);
    coordinates.all(|((x, a), b)| (x - (a + share * (b - a))).abs() <= MET * largest)
}

#[cfg(test)]
#[path = "../../../tests/units/search_history.rs"]
mod tests;
