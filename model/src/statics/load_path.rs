//! Load paths between two equilibria.

use super::load_step::CORRECTION_TOLERANCE;
use crate::frame::{FrameLoad, FrameMotion};

/// Convergence tolerance at intermediate equilibria. The next step corrects the error that this tolerance leaves in an intermediate equilibrium. The
/// error of an intermediate equilibrium must be small compared with a short step.
const STATION_TOLERANCE: f64 = 1e-8;
/// Convergence tolerance at all equilibria of a trial path. Because Newton's method converges quadratically, the equilibria are accurate to 1e-9.
const TRIED_TOLERANCE: f64 = 1e-6;
/// A trial path without any accepted step ends only after at least this many rejected steps.
const MOST_REJECTED_AT_START: usize = 4;

/// Loads that vary along a path. A share of 0 is the start of the path, and a share of 1 is its end.
pub(super) trait LoadPath {
    /// The loads at a share of the path, and a factor that multiplies all these loads.
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64);

    /// Whether the path continues after the intermediate equilibrium at the given share.
    fn goes_on(&mut self, _share: f64, _motion: &FrameMotion) -> bool {
        true
    }

    /// Whether to repeat a rejected step with a shorter length. `rejected` is the number of all rejected steps of the path.
    fn tries_again(&self, _share: f64, _rejected: usize) -> bool {
        true
    }

    /// Convergence tolerance of the equilibrium at a share of the path.
    fn tolerance(&self, share: f64) -> f64 {
        if share < 1.0 { STATION_TOLERANCE } else { CORRECTION_TOLERANCE }
    }

    /// Whether the path is a trial, which the caller shortens if the trial fails. The exact share at which a trial fails does not matter.
    fn is_trial(&self) -> bool {
        false
    }
}

/// Loads that keep their ratios while their common factor changes.
#[derive(Clone, Copy)]
pub(super) struct ProportionalLoading<'l> {
    pub loads: &'l [FrameLoad],
    /// Factor on the loads at share 0 of the path.
    pub from: f64,
    /// Factor on the loads at share 1 of the path.
    pub to: f64,
}

impl ProportionalLoading<'_> {
    pub(super) fn multiple(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }
}

impl LoadPath for ProportionalLoading<'_> {
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64) {
        (self.loads, self.multiple(share))
    }
}

/// Two sets of loads. Along the path, the loads `from` decrease linearly to zero, while the loads `to` increase linearly from zero.
pub(super) struct LoadTransition<'l> {
    pub from: &'l [FrameLoad],
    pub to: &'l [FrameLoad],
    /// Buffer for both sets of loads.
    pub loads: Vec<FrameLoad>,
}

impl LoadPath for LoadTransition<'_> {
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64) {
        self.loads.clear();
        if share < 1.0 {
            self.loads.extend(self.from.iter().map(|load| load.scaled(1.0 - share)));
        }
        self.loads.extend(self.to.iter().map(|load| load.scaled(share)));
        (&self.loads, 1.0)
    }
}

/// A [`LoadTransition`] as a trial path, which the caller shortens if the trial fails.
pub(super) struct TrialTransition<'l, W> {
    pub transition: LoadTransition<'l>,
    pub goes_on: W,
    /// Number of rejected steps after which the path ends.
    pub most_rejected: usize,
}

impl<W: FnMut(f64, &FrameMotion) -> bool> LoadPath for TrialTransition<'_, W> {
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64) {
        self.transition.at(share)
    }

    fn goes_on(&mut self, share: f64, motion: &FrameMotion) -> bool {
        (self.goes_on)(share, motion)
    }

    fn tries_again(&self, share: f64, rejected: usize) -> bool {
        rejected < if share > 0.0 { self.most_rejected } else { MOST_REJECTED_AT_START.max(self.most_rejected) }
    }

    fn tolerance(&self, _share: f64) -> f64 {
        TRIED_TOLERANCE
    }

    fn is_trial(&self) -> bool {
        true
    }
}
