//! The trusted share of a map: the part of the plate and of the directions that friction allows in which forces are sensed within [`TRUSTED_ERROR`].

use super::map::AccuracyMap;
use super::sweep::{CellState, MapCell, mean_absolute};
use crate::settings::{TRUSTED_ERROR, WEIGHED_MODULUS_SD};
use finray_model::Finger;
use finray_model::finger::StiffnessError;
use std::fmt;

/// A position and direction, with the worst result among the map's forces. The worst result alone decides whether a cell is trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstCell {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Outcome of the cell: without equilibrium if any force has no equilibrium; otherwise refused if any force is refused.
    pub state: CellState,
    /// Largest mean relative error among the forces; `None` unless all are answered.
    pub worst_error: Option<f64>,
    /// Whether the error of every force is within [`TRUSTED_ERROR`]; `false` if a force is refused.
    pub is_trusted: bool,
    /// Share of the noise samples of all forces that are refused.
    pub refused_samples: f64,
    /// Share of the noise samples of all forces that are answered with a warning.
    pub warned_samples: f64,
    /// Part of the plate times part of the directions that friction allows, mm deg. Zero for a direction that friction does not allow.
    pub weight: f64,
}

/// The trusted share of a map, or of a region of a map. Each position counts by the part of the plate that is nearest to it, and each direction by
/// the part of the directions that friction allows that is nearest to it. The share therefore depends on the grid only through its resolution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrustShare {
    /// Number of cells (pairs of position and direction) that count.
    pub cells: usize,
    /// Number of these cells in which a force has no equilibrium, so that nothing can be sensed.
    pub without_equilibrium: usize,
    /// Weight of the cells with equilibrium under every force, mm deg.
    pub carried: f64,
    /// Weight of the trusted cells, mm deg.
    pub trusted: f64,
    /// Weight of the cells with a refused force, mm deg.
    pub refused: f64,
    refused_samples: f64,
    warned_samples: f64,
}

impl AccuracyMap {
    /// Each cell with its worst result among the map's forces, ordered by position, then direction.
    pub fn worst(&self, finger: &Finger) -> Vec<WorstCell> {
        self.worst_of(finger, None)
    }

    /// Each cell with the result for one force (N), or with the worst result among all forces if `force_n` is `None`; ordered by position, then
    /// direction.
    pub fn worst_of(&self, finger: &Finger, force_n: Option<f64>) -> Vec<WorstCell> {
        let (lengths_mm, sectors_deg) = (self.request.lengths_mm(finger), self.request.sectors_deg());
        let weights = lengths_mm.iter().flat_map(|length_mm| sectors_deg.iter().map(move |sector| length_mm * sector));
        let of_group = |(group, weight): (&[MapCell], f64)| {
            let cells: Vec<MapCell> =
                group.iter().filter(|cell| force_n.is_none_or(|f| f == cell.force_n)).copied().collect();
            let state = cells.iter().map(MapCell::state).max().unwrap_or(CellState::WithoutEquilibrium);
            let errors: Option<Vec<f64>> = cells.iter().map(|cell| cell.mean_error).collect();
            let worst_error = errors.and_then(|errors| errors.into_iter().reduce(f64::max));
            let sum = |of: fn(&MapCell) -> usize| cells.iter().map(of).sum::<usize>() as f64;
            let samples = sum(|cell| cell.samples).max(1.0);
            WorstCell {
                s_mm: group[0].s_mm,
                angle_deg: group[0].angle_deg,
                state,
                worst_error,
                is_trusted: worst_error.is_some_and(|error| error <= TRUSTED_ERROR),
                refused_samples: sum(|cell| cell.samples - cell.answered) / samples,
                warned_samples: sum(|cell| cell.warned.unwrap_or(0)) / samples,
                weight,
            }
        };
        self.cells.chunks(self.request.forces_n.len().max(1)).zip(weights).map(of_group).collect()
    }

    /// The trusted share of the whole map.
    pub fn trust(&self, finger: &Finger) -> TrustShare {
        TrustShare::of(&self.worst(finger))
    }
}

/// The trusted share that a finger would have if one hung weight had measured its modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeighedShare {
    /// Relative standard deviation of the modulus as it is, dimensionless.
    pub modulus_sd: f64,
    /// Trusted share with a modulus known to [`WEIGHED_MODULUS_SD`].
    pub share: f64,
}

/// The cause of a small share and its remedy, for instance "the modulus is known to 10 % only; with one hung weight (2 %): 64 %".
impl fmt::Display for WeighedShare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [known, weighed, share] = [self.modulus_sd, WEIGHED_MODULUS_SD, self.share].map(|share| 100.0 * share);
        write!(f, "the modulus is known to {known:.0} % only; with one hung weight ({weighed:.0} %): {share:.0} %")
    }
}

impl AccuracyMap {
    /// The trusted share if one hung weight had measured the modulus. `None` if the modulus is known as well, or if the share would grow by less than
    /// half a per cent.
    ///
    /// Counts the errors of a cell as normally distributed, with the bias and spread of its samples. The mean error with a smaller error that all
    /// forces share is then the mean error of the samples times the ratio of two closed forms.
    pub fn weighed(&self, finger: &Finger, stiffness: StiffnessError) -> Option<WeighedShare> {
        if stiffness.modulus <= WEIGHED_MODULUS_SD || !self.truth.has_stiffness_error() {
            return None;
        }
        let weighed = StiffnessError { modulus: WEIGHED_MODULUS_SD, ..stiffness };
        let mean_error = |cell: &MapCell| {
            let (error, bias, spread) = (cell.mean_error?, cell.bias?, cell.spread?);
            let [after, now] = [weighed, stiffness].map(|of| mean_absolute(bias, of.share().hypot(spread)));
            Some(error * after / now)
        };
        let cells = self.cells.iter().map(|cell| MapCell { mean_error: mean_error(cell).or(cell.mean_error), ..*cell });
        let map = AccuracyMap { cells: cells.collect(), ..self.clone() };
        let (share, now) = (map.trust(finger).share()?, self.trust(finger).share()?);
        (share >= now + 0.005).then_some(WeighedShare { modulus_sd: stiffness.modulus, share })
    }
}

impl TrustShare {
    /// Adds up the cells that count.
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c WorstCell>) -> TrustShare {
        let counted = cells.into_iter().filter(|cell| cell.weight > 0.0);
        counted.fold(TrustShare::default(), |sum, cell| {
            let is_carried = cell.state != CellState::WithoutEquilibrium;
            let of = |holds: bool| if holds { cell.weight } else { 0.0 };
            TrustShare {
                cells: sum.cells + 1,
                without_equilibrium: sum.without_equilibrium + usize::from(!is_carried),
                carried: sum.carried + of(is_carried),
                trusted: sum.trusted + of(cell.is_trusted),
                refused: sum.refused + of(cell.state == CellState::Refused),
                refused_samples: sum.refused_samples + of(is_carried) * cell.refused_samples,
                warned_samples: sum.warned_samples + of(is_carried) * cell.warned_samples,
            }
        })
    }

    /// A part of the weight of the cells with equilibrium under every force; `None` without such cells.
    fn of_carried(&self, part: f64) -> Option<f64> {
        (self.carried > 0.0).then(|| part / self.carried)
    }

    /// Trusted share; `None` if no cell has an equilibrium under every force.
    pub fn share(&self) -> Option<f64> {
        self.of_carried(self.trusted)
    }

    /// Share in which a force is refused.
    pub fn refused_share(&self) -> Option<f64> {
        self.of_carried(self.refused)
    }

    /// Shares of the noise samples that are refused, and that are answered with a warning.
    pub fn samples(&self) -> Option<[f64; 2]> {
        Some([self.of_carried(self.refused_samples)?, self.of_carried(self.warned_samples)?])
    }
}
