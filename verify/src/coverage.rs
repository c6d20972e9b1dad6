//! Whether stated intervals hold the truth: coverage over the cells of the maps, by finger and estimator.

use crate::check::{Check, Kind};
use crate::map::AccuracyMap;
use serde::Serialize;

/// Share of truths within 1.96 standard deviations of a normal distribution.
const NOMINAL: f64 = 0.95;
/// How far from it an estimator without a warning may be: 93 to 97 %, so that a stated sigma is right within a tenth.
const TOLERANCE: f64 = 0.02;
/// Chance that is allowed for beside it, in standard deviations of a share.
const CHANCE: f64 = 3.0;
/// The finger that an estimator must cover; on others (softer ends, a lattice) its model is wrong, and it warns.
const TRUTH: &str = "corotational";

/// Coverage of one map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoverageRow {
    /// Name of the truth.
    pub truth: String,
    /// Name of the estimator.
    pub estimator: String,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Noise samples of all cells with an equilibrium, positions, directions and forces.
    pub samples: usize,
    /// Samples that the estimator refused.
    pub refused: usize,
    /// Answers with a warning.
    pub warned: usize,
    /// Answers without a warning.
    pub without_warning: usize,
    /// Of the answers without a warning, the share whose interval holds the truth; `None` if there are none.
    pub covered_without_warning: Option<f64>,
    /// The same of those with a warning.
    pub covered_with_warning: Option<f64>,
}

impl CoverageRow {
    /// Coverage of a noisy map; `None` without noise, and for an estimator that states no standard deviation.
    pub fn of(map: &AccuracyMap) -> Option<CoverageRow> {
        let sum = |of: &dyn Fn(&crate::map::Cell) -> usize| map.cells.iter().map(of).sum::<usize>();
        let stated = map.cells.iter().any(|cell| cell.covered.is_some());
        if map.noise_mm == 0.0 || !stated {
            return None;
        }
        let samples = sum(&|cell| cell.samples);
        let answered = sum(&|cell| cell.answered);
        let warned = sum(&|cell| cell.warned.unwrap_or(0));
        let share = |part: usize, all: usize| (all > 0).then(|| part as f64 / all as f64);
        Some(CoverageRow {
            truth: map.truth.clone(),
            estimator: map.estimator.clone(),
            noise_mm: map.noise_mm,
            samples,
            refused: samples - answered,
            warned,
            without_warning: answered - warned,
            covered_without_warning: share(sum(&|cell| cell.covered.unwrap_or(0)), answered - warned),
            covered_with_warning: share(sum(&|cell| cell.covered_warned.unwrap_or(0)), warned),
        })
    }

    /// What must hold on the finger that the estimators' models are refined to: 93 to 97 % of the truths lie within 1.96
    /// sigma where there is no warning, at least as many where there is one. None for other fingers.
    fn checks(&self) -> Vec<Check> {
        if self.truth != TRUTH {
            return Vec::new();
        }
        let check = |which: &str, covered: f64, answers: usize, reference: f64, tolerance: f64| {
            let chance = CHANCE * (NOMINAL * (1.0 - NOMINAL) / answers as f64).sqrt();
            Check::new(
                Kind::Internal,
                format!("stated intervals of {} over the map, {} mm noise", self.estimator, self.noise_mm),
                "true forces",
                format!("share within 1.96 sigma, {answers} of {} answers {which}", self.samples - self.refused),
                reference,
                covered,
                tolerance + chance,
            )
        };
        let plain = self
            .covered_without_warning
            .map(|covered| check("without a warning", covered, self.without_warning, NOMINAL, TOLERANCE));
        // At least 93 %: from there up to all of them.
        let least = NOMINAL - TOLERANCE;
        let warned = self
            .covered_with_warning
            .map(|covered| check("with a warning", covered, self.warned, 0.5 * (1.0 + least), 0.5 * (1.0 - least)));
        plain.into_iter().chain(warned).collect()
    }
}

/// Coverage of every noisy map.
pub fn rows<'m>(maps: impl Iterator<Item = &'m AccuracyMap>) -> Vec<CoverageRow> {
    maps.filter_map(CoverageRow::of).collect()
}

/// What must hold of them.
pub fn checks(rows: &[CoverageRow]) -> Vec<Check> {
    rows.iter().flat_map(CoverageRow::checks).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(covered_without_warning: f64, covered_with_warning: f64) -> CoverageRow {
        CoverageRow {
            truth: TRUTH.to_owned(),
            estimator: "least-squares".to_owned(),
            noise_mm: 0.067,
            samples: 30_000,
            refused: 0,
            warned: 10_000,
            without_warning: 20_000,
            covered_without_warning: Some(covered_without_warning),
            covered_with_warning: Some(covered_with_warning),
        }
    }

    #[test]
    fn intervals_that_are_too_narrow_or_too_wide_fail() {
        let passes = |row: CoverageRow| row.checks().iter().map(Check::passes).collect::<Vec<_>>();
        assert_eq!(passes(row(0.95, 1.0)), [true, true]);
        assert_eq!(passes(row(0.92, 0.92)), [false, false]);
        assert_eq!(passes(row(0.98, 0.95)), [false, true]);
        assert_eq!(passes(CoverageRow { truth: "twin".to_owned(), ..row(0.5, 0.5) }), Vec::<bool>::new());
    }
}
