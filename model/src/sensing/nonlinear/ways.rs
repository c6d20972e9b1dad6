//! Ways that searches have taken, so that another search that comes upon one of them ends there: it would go the same way on.
//!
//! Where contacts and directions are known, forces alone say where a search is. Where they are sought as well, two searches may pass each other
//! and end elsewhere: those go on.

use super::State;
use super::unknowns::Unknown;
use crate::sensing::{ContactQuestion, Direction};

/// A way is met where no force is further from it than this share of the largest.
const MET: f64 = 0.01;

/// A way that a search has taken, by the forces of each step, and where it ended: misfit and forces of the minimum, or `None` without one.
#[derive(Debug, Clone)]
struct Way {
    points: Vec<Vec<f64>>,
    end: Option<(f64, Vec<f64>)>,
}

/// All ways so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Ways {
    /// Whether forces alone are sought.
    are_kept: bool,
    ended: Vec<Way>,
    current: Vec<Vec<f64>>,
    /// Which of those that ended the current one has met.
    met: Option<usize>,
}

impl Ways {
    /// None yet, for some unknowns of some questions.
    pub(super) fn of(unknowns: &[Unknown], questions: &[ContactQuestion]) -> Ways {
        let forces_alone = unknowns.iter().all(|unknown| matches!(unknown, Unknown::Force(_)));
        let follows = |question: &ContactQuestion| matches!(question.direction, Direction::Leaning(_));
        Ways { are_kept: forces_alone && !questions.iter().any(follows), ..Ways::default() }
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
        let passes = |way: &Way| way.points.windows(2).any(|ends| is_between(forces_n, [&ends[0], &ends[1]]));
        self.ended.iter().position(|way| way.end.is_some() && passes(way))
    }

    /// Ends the current way; returns the end of the one that it has met instead, if it has.
    pub(super) fn end(&mut self, end: Option<(f64, Vec<f64>)>) -> Option<(f64, Vec<f64>)> {
        let end = self.met.map_or(end, |met| self.ended[met].end.clone());
        self.ended.push(Way { points: std::mem::take(&mut self.current), end: end.clone() });
        end
    }
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
mod tests {
    use super::*;

    /// Forces of 1, 2 and 4 N beside 5, 6 and 7 N.
    fn way(end: Option<(f64, Vec<f64>)>) -> Way {
        Way { points: vec![vec![1.0, 5.0], vec![2.0, 6.0], vec![4.0, 7.0]], end }
    }

    #[test]
    fn a_way_to_a_minimum_is_met_on_it_and_nowhere_else() {
        let ways = Ways { ended: vec![way(None), way(Some((0.1, vec![4.0, 7.0])))], ..Ways::default() };
        for on_it in [[1.0, 5.0], [1.5, 5.5], [3.0, 6.5], [4.05, 7.0]] {
            assert_eq!(ways.passing(&on_it), Some(1), "{on_it:?}");
        }
        for off_it in [[0.9, 5.0], [1.5, 6.0], [4.2, 7.0], [4.0, 7.2], [-1.0, 5.0]] {
            assert_eq!(ways.passing(&off_it), None, "{off_it:?}");
        }
    }

    #[test]
    fn a_way_that_meets_another_ends_where_that_did() {
        let mut ways = Ways { ended: vec![way(Some((0.1, vec![4.0, 7.0])))], ..Ways::default() };
        ways.begin();
        ways.met = Some(0);
        assert_eq!(ways.end(None), Some((0.1, vec![4.0, 7.0])));
        ways.begin();
        assert_eq!(ways.end(Some((0.2, vec![9.0, 9.0]))), Some((0.2, vec![9.0, 9.0])));
    }
}
