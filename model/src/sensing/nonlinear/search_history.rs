//! Ways that searches have taken, so that another search that comes upon one of them ends there: it would go the same way on.
//!
//! Where contacts and directions are known, forces alone say where a search is. Where they are sought as well, two searches may pass each other
//! and end elsewhere: those go on.
//!
//! A minimum that is far from explaining the measurement need not be found to the last digit, and where two searches agree on it the others
//! that start from multiples of the linear forces are left out.

use super::State;
use super::unknowns::Unknown;
use crate::sensing::{ContactQuestion, Direction};

/// A way is met where no force is further from it than this share of the largest.
const MET: f64 = 0.01;

/// A minimum is far from explaining a measurement where its residual is so many times as large as what is still explained ...
const FAR: f64 = 1.25;
/// ... and is as good as found where no step is predicted to decrease its misfit by more than this share.
const NEARLY: f64 = 0.01;
/// Two searches agree where their misfits differ by no more than this share, and their forces by no more than this share of the largest.
const AGREE: f64 = 0.05;

/// A way that a search has taken, by the forces of each step, and where it ended: misfit and forces of the minimum, or `None` without one.
#[derive(Debug, Clone)]
struct SearchPath {
    points: Vec<Vec<f64>>,
    end: Option<(f64, Vec<f64>)>,
}

/// All ways so far.
#[derive(Debug, Clone, Default)]
pub(super) struct SearchHistory {
    /// Whether forces alone are sought.
    are_kept: bool,
    ended: Vec<SearchPath>,
    current: Vec<Vec<f64>>,
    /// Which of those that ended the current one has met.
    met: Option<usize>,
    /// Misfit above which a minimum is far from explaining the measurement, mm^2; `None` if any may explain it.
    far_mm2: Option<f64>,
}

impl SearchHistory {
    /// None yet, for some unknowns of some questions.
    pub(super) fn of(unknowns: &[Unknown], questions: &[ContactQuestion]) -> SearchHistory {
        let forces_alone = unknowns.iter().all(|unknown| matches!(unknown, Unknown::Force(_)));
        let follows = |question: &ContactQuestion| matches!(question.direction, Direction::Leaning(_));
        SearchHistory { are_kept: forces_alone && !questions.iter().any(follows), ..SearchHistory::default() }
    }

    /// The same, towards minima that explain a measurement up to a misfit, mm^2.
    pub(super) fn explaining_up_to(self, misfit_mm2: Option<f64>) -> SearchHistory {
        SearchHistory { far_mm2: misfit_mm2.map(|misfit_mm2| FAR * FAR * misfit_mm2), ..self }
    }

    /// Whether a misfit that can be decreased by so much is as good as a minimum far from explaining the measurement.
    pub(super) fn ends_far(&self, misfit_mm2: f64, decrease_mm2: f64) -> bool {
        self.is_far(misfit_mm2) && decrease_mm2 <= NEARLY * misfit_mm2
    }

    fn is_far(&self, misfit_mm2: f64) -> bool {
        self.far_mm2.is_some_and(|far_mm2| misfit_mm2 > far_mm2)
    }

    /// Whether two searches agree on the best minimum so far, and it is far from explaining the measurement.
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

    /// Begins another way.
    pub(super) fn begin(&mut self) {
        self.current.clear();
        self.met = None;
    }

    /// Goes on to a state; whether one of the ways before leads past it to a minimum.
    pub(super) fn meets(&mut self, state: &State) -> bool {
        self.met = self.passing(&state.forces_n);
        self.reach(state);
        self.met.is_some()
    }

    /// Goes on to the state where the way ends.
    pub(super) fn reach(&mut self, state: &State) {
        if self.are_kept {
            self.current.push(state.forces_n.clone());
        }
    }

    /// A way that leads past forces to a minimum.
    fn passing(&self, forces_n: &[f64]) -> Option<usize> {
        let passes = |way: &SearchPath| way.points.windows(2).any(|ends| is_between(forces_n, [&ends[0], &ends[1]]));
        self.ended.iter().position(|way| way.end.is_some() && passes(way))
    }

    /// Ends the current way; returns the end of the one that it has met instead, if it has.
    pub(super) fn end(&mut self, end: Option<(f64, Vec<f64>)>) -> Option<(f64, Vec<f64>)> {
        let end = self.met.map_or(end, |met| self.ended[met].end.clone());
        self.ended.push(SearchPath { points: std::mem::take(&mut self.current), end: end.clone() });
        end
    }
}

/// Whether a minimum, by misfit and forces, is another one.
fn agree(one: &(f64, Vec<f64>), other: &(f64, Vec<f64>)) -> bool {
    let largest = other.1.iter().fold(0.0_f64, |m, n| m.max(n.abs()));
    let mut forces = one.1.iter().zip(&other.1);
    (one.0 - other.0).abs() <= AGREE * other.0 && forces.all(|(a, b)| (a - b).abs() <= AGREE * largest)
}

/// Whether forces are on the straight line between two others.
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
