//! Loads along the way from one equilibrium to another.

use super::load_step::CORRECTION_TOLERANCE;
use crate::frame::{FrameLoad, FrameMotion};

/// Tolerance of equilibria on the way: the next step corrects what is left, which must not count beside a short step.
const STATION_TOLERANCE: f64 = 1e-8;
/// Tolerance of all equilibria on a way that is a trial: Newton's corrections shrink by so much at once that these are good to 1e-9.
const TRIED_TOLERANCE: f64 = 1e-6;
/// A way that is a trial ends no earlier than after so many rejected steps where none was taken yet.
const MOST_REJECTED_AT_START: usize = 4;

/// Loads that change along a way, from share 0 to share 1.
pub(super) trait LoadPath {
    /// The loads at a share of the way, and their common multiple.
    fn at(&mut self, share: f64) -> (&[FrameLoad], f64);

    /// Whether an equilibrium on the way, at this share of it, is worth going on from.
    fn goes_on(&mut self, _share: f64, _motion: &FrameMotion) -> bool {
        true
    }

    /// Whether a step that was rejected is tried again, shorter; `rejected` counts those of the whole way.
    fn tries_again(&self, _share: f64, _rejected: usize) -> bool {
        true
    }

    /// Tolerance of the equilibrium at a share of it.
    fn tolerance(&self, share: f64) -> f64 {
        if share < 1.0 { STATION_TOLERANCE } else { CORRECTION_TOLERANCE }
    }

    /// Whether the caller shortens the way where it fails: where exactly does not matter then.
    fn is_trial(&self) -> bool {
        false
    }
}

/// The same loads between two multiples.
#[derive(Clone, Copy)]
pub(super) struct ProportionalLoading<'l> {
    pub loads: &'l [FrameLoad],
    pub from: f64,
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

/// Loads that fade while others grow.
pub(super) struct LoadTransition<'l> {
    pub from: &'l [FrameLoad],
    pub to: &'l [FrameLoad],
    /// Room for both.
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

/// Loads that fade while others grow, for a caller who shortens the way where it fails.
pub(super) struct TrialTransition<'l, W> {
    pub transition: LoadTransition<'l>,
    pub goes_on: W,
    /// The way ends at so many rejected steps.
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
