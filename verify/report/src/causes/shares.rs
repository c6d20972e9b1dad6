//! Shares of the causes in the mean square error of a region.

use crate::format::percent;
use crate::prelude::*;
use finray_studies::experiments::causes::{Cause, CauseCell, CauseMap};

/// Length of each of the regions near base and tip, as a share of the plate length. On the paper's finger this is the length of two members.
const NEAR_AN_END: f64 = 1.0 / 6.0;

/// A region of cells (positions and directions). Every estimator has cells along the normal; only some estimators have cells in other directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Region {
    /// Forces along the normal, within a sixth of the plate's length from the base.
    Base,
    /// Forces along the normal, between the regions near base and tip.
    Middle,
    /// Forces along the normal, within a sixth of the plate's length from the tip.
    Tip,
    /// Forces at every position and in every direction.
    All,
}

impl Region {
    /// The regions whose cells all have a force along the normal.
    pub(super) const ENDS_AND_MIDDLE: [Region; 3] = [Region::Base, Region::Middle, Region::Tip];
    pub(super) const ALL: [Region; 4] = [Region::Base, Region::Middle, Region::Tip, Region::All];

    pub(super) fn name(self) -> &'static str {
        match self {
            Region::Base => "near the base",
            Region::Middle => "middle",
            Region::Tip => "near the tip",
            Region::All => "all",
        }
    }

    /// The region as part of a sentence.
    pub(super) fn in_words(self) -> &'static str {
        if self == Region::Middle { "in the middle" } else { self.name() }
    }

    /// Whether a position (mm from the base) and direction (degrees) belong to the region, on a plate of this length.
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

/// Error in a region, and how much of it disappears without each cause.
pub(super) struct Shares {
    /// Root mean square of sensed / true - 1 with all causes, over the answered cells.
    pub rms_error: f64,
    pub answered: usize,
    pub cells: usize,
    /// Causes, the one with the largest share first.
    pub by_cause: Vec<CauseShare>,
}

/// Effect of one cause on the error in a region.
#[derive(Debug, Clone, Copy)]
pub(super) struct CauseShare {
    pub cause: Cause,
    /// Share of the mean square error that disappears without the cause. A cell that the estimator does not answer without the cause counts as no
    /// reduction.
    pub share: f64,
    /// Root mean square of sensed / true - 1 without the cause, over the cells answered without the cause.
    pub rms_without: f64,
    /// Number of cells answered without the cause.
    pub cells: usize,
}

impl Shares {
    /// Shares of the causes in the region's error; `None` if no cell is answered, or if there is no error.
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

    /// The cause with the largest share; `None` if no share is positive because causes cancel each other.
    pub(super) fn largest(&self) -> Option<CauseShare> {
        self.by_cause.first().copied().filter(|of| of.share > 0.0)
    }

    /// Text with the error without a cause. If fewer positions are answered without the cause than with all causes, the text adds both numbers of
    /// positions.
    pub(super) fn without(&self, of: &CauseShare) -> String {
        let left = format!("{} without it", percent(of.rms_without));
        if of.cells < self.answered {
            return format!(
                "{left} at the {} of {} positions that are answered without this cause",
                of.cells, self.answered
            );
        }
        left
    }
}
