//! Shares of the mean square error over a part of the finger.

use crate::format::percent;
use crate::prelude::*;
use finray_studies::experiments::causes::{Cause, CauseCell, CauseMap};

/// Share of the plate's length at either end that counts as near it: two segments of the paper's finger.
const NEAR_AN_END: f64 = 1.0 / 6.0;

/// Cells that are looked at together. Those along the normal are what every way of sensing is asked about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Region {
    /// Along the normal, within a sixth of the plate's length of the base.
    Base,
    /// Along the normal, neither near the base nor near the tip.
    Middle,
    /// Along the normal, within a sixth of the plate's length of the tip.
    Tip,
    /// Every position and direction.
    All,
}

impl Region {
    pub(super) const ENDS_AND_MIDDLE: [Region; 3] = [Region::Base, Region::Middle, Region::Tip];
    pub(super) const ALL: [Region; 4] = [Region::Base, Region::Middle, Region::Tip, Region::All];

    /// For tables and files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Region::Base => "near the base",
            Region::Middle => "middle",
            Region::Tip => "near the tip",
            Region::All => "all",
        }
    }

    /// Within a sentence.
    pub(super) fn in_words(self) -> &'static str {
        if self == Region::Middle { "in the middle" } else { self.name() }
    }

    /// Whether a position (mm from the base) and direction (degrees) are within, on a plate of this length.
    pub(super) fn covers(self, length_mm: f64, s_mm: f64, angle_deg: f64) -> bool {
        let along = s_mm / length_mm;
        let normal = angle_deg == 0.0;
        match self {
            Region::Base => normal && along <= NEAR_AN_END,
            Region::Middle => normal && along > NEAR_AN_END && along < 1.0 - NEAR_AN_END,
            Region::Tip => normal && along >= 1.0 - NEAR_AN_END,
            Region::All => true,
        }
    }
}

/// What is wrong over a region, and what goes away with each cause.
pub(super) struct Shares {
    /// Root mean square of sensed / true - 1 over the cells that are answered with every cause.
    pub rms_error: f64,
    /// Their number, and that of all cells.
    pub answered: usize,
    pub cells: usize,
    /// Largest share first.
    pub by_cause: Vec<CauseShare>,
}

/// What one cause is worth over a region.
#[derive(Debug, Clone, Copy)]
pub(super) struct CauseShare {
    pub cause: Cause,
    /// Share of the mean square error over all answered cells known to go away; cells not answered then add nothing.
    pub share: f64,
    /// Root mean square of sensed / true - 1 without it, over the cells that are answered then.
    pub rms_without: f64,
    /// Their number.
    pub cells: usize,
}

impl Shares {
    /// `None` where no cell is answered, or nothing is wrong.
    pub(super) fn of(finger: &Finger, map: &CauseMap, force_n: f64, region: Region) -> Option<Shares> {
        let length_mm = finger.plate_length_mm(Plate::Front);
        let within = |cell: &&CauseCell| cell.force_n == force_n && region.covers(length_mm, cell.s_mm, cell.angle_deg);
        let cells = || map.cells.iter().filter(within);
        let answered: Vec<(f64, &CauseCell)> =
            cells().filter_map(|cell| Some((cell.rms_error?.powi(2), cell))).collect();
        let total: f64 = answered.iter().map(|(square, _)| square).sum();
        if answered.is_empty() || total == 0.0 {
            return None;
        }
        let of_cause = |(i, &cause): (usize, &Cause)| {
            let known = || answered.iter().filter_map(|(square, cell)| Some((square, cell.shares[i]?)));
            let gone: f64 = known().map(|(square, share)| square * share).sum();
            let left: f64 = known().map(|(square, share)| square * (1.0 - share)).sum();
            let cells = known().count();
            CauseShare { cause, share: gone / total, rms_without: (left / cells.max(1) as f64).max(0.0).sqrt(), cells }
        };
        let mut by_cause: Vec<CauseShare> = map.causes.iter().enumerate().map(of_cause).collect();
        by_cause.sort_by(|a, b| b.share.total_cmp(&a.share));
        let rms_error = (total / answered.len() as f64).sqrt();
        Some(Shares { rms_error, answered: answered.len(), cells: cells().count(), by_cause })
    }

    /// The largest share; `None` if every cause hides others.
    pub(super) fn largest(&self) -> Option<CauseShare> {
        self.by_cause.first().copied().filter(|of| of.share > 0.0)
    }

    /// What is left without a cause, and where that is not all of it.
    pub(super) fn without(&self, of: &CauseShare) -> String {
        let left = format!("{} without it", percent(of.rms_without));
        if of.cells < self.answered {
            return format!("{left} at the {} of {} positions that are answered then", of.cells, self.answered);
        }
        left
    }
}
