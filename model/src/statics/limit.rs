//! Where a branch of stable equilibria ends, predicted from the determinant of the tangent stiffness.
//!
//! At the end the tangent loses its last positive pivot, so its determinant D goes to zero there: like (1 - s / s*)^p in the share s of the way, with
//! p = 1/2 at a fold (limit load, snap-through) and p = 1 at a bifurcation (a straight rib that buckles). Where the path only comes close to a fold
//! and goes on, p is 2/3 for a while. Three equilibria give s* and p.

/// Powers with which the determinant goes to zero.
const FOLD: f64 = 0.5;
const BIFURCATION: f64 = 1.0;
/// Halvings of the range between them: to 1e-3, which is finer than predictions are.
const HALVINGS: usize = 9;
/// A step towards the end goes this share of the way left at a fold. There displacements go with the root of what is left, and
/// a tangent that is asked to predict 84 % of it is off by half, which is as much as a load step may be.
const REACH_AT_FOLD: f64 = 0.8;
/// The same at a bifurcation, where the path is smooth.
const REACH_AT_BIFURCATION: f64 = 0.95;
/// A step is no shorter than this share of the last: a determinant that falls by powers of ten predicts nothing.
const LEAST_REACH: f64 = 0.01;
/// A power up to this is a fold's: the others that there are, 2/3 and 1, are as far from it as rounding and secants allow.
const LARGEST_POWER_OF_FOLD: f64 = 0.58;
/// The end is reached when this share of the load is left to a fold.
const GAP_TO_FOLD: f64 = 1e-4;
/// The same with other powers, where a branch may still turn and go on.
const GAP_TO_OTHERS: f64 = 1e-6;
/// The last two predictions may differ by this share of the way left.
const AGREEMENT: f64 = 0.5;

/// Equilibria on the way to the end of the branch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Approach {
    /// Share of the way and logarithm of the determinant, oldest first.
    points: [Option<[f64; 2]>; 3],
    predicted: Option<End>,
    /// From the equilibria before the last.
    predicted_before: Option<End>,
}

/// The predicted end of the branch.
#[derive(Debug, Clone, Copy)]
struct End {
    share: f64,
    power: f64,
}

impl Approach {
    /// Whether an equilibrium is not known yet.
    pub(super) fn asks_for(&self, share: f64) -> bool {
        self.points[2].is_none_or(|[known, _]| known != share)
    }

    /// Takes the next equilibrium; without its determinant nothing is predicted.
    pub(super) fn add(&mut self, share: f64, log_determinant: Option<f64>) {
        let Some(log) = log_determinant else { return };
        self.points = [self.points[1], self.points[2], Some([share, log])];
        self.predicted_before = self.predicted;
        self.predicted = self.end();
    }

    /// The farthest share that is worth a step: short of the end, unless that is much nearer than the last equilibrium.
    pub(super) fn near(&self) -> Option<f64> {
        let End { share: end, power } = self.predicted?;
        let [_, Some([before, _]), Some([at, _])] = self.points else { return None };
        let reach = REACH_AT_FOLD + (REACH_AT_BIFURCATION - REACH_AT_FOLD) * (2.0 * power - 1.0);
        Some(at + f64::max(reach * (end - at), LEAST_REACH * (at - before)))
    }

    /// Whether an equilibrium disproves the prediction.
    pub(super) fn is_disproved_by(&self, share: f64) -> bool {
        self.predicted.is_some_and(|end| share > end.share)
    }

    /// Whether two predictions agree that the branch ends before a share, by as much as is left to the end.
    pub(super) fn ends_before(&self, share: f64) -> bool {
        let (Some(End { share: end, .. }), Some(at)) = (self.predicted, self.at()) else { return false };
        self.predictions_agree() && end + (end - at) < share
    }

    fn predictions_agree(&self) -> bool {
        let (Some(before), Some(end), Some(at)) = (self.predicted_before, self.predicted, self.at()) else {
            return false;
        };
        (before.share - end.share).abs() <= AGREEMENT * (end.share - at)
    }

    /// A share as far behind the end as the last equilibrium is before it, if near enough: no branch gets there.
    pub(super) fn beyond(&self) -> Option<f64> {
        let (End { share: end, power }, at) = (self.predicted?, self.at()?);
        let left = end - at;
        let gap = if power <= LARGEST_POWER_OF_FOLD { GAP_TO_FOLD } else { GAP_TO_OTHERS };
        (self.predictions_agree() && left < gap * end).then_some(end + left)
    }

    fn at(&self) -> Option<f64> {
        self.points[2].map(|[share, _]| share)
    }

    fn end(&self) -> Option<End> {
        let [first, Some(second), Some(third)] = self.points else { return None };
        let end = |power: f64| end_of_interval(second, third, power);
        // How much faster than with this power the determinant falls between the first two equilibria.
        let excess = |power: f64| {
            let ([first, log_first], [second, log_second]) = (first?, second);
            let end = end(power)?;
            Some(log_first - log_second - power * ((end - first) / (end - second)).ln())
        };
        let [mut low, mut high] = [FOLD, BIFURCATION];
        let power = match (excess(low), excess(high)) {
            // A single interval tells nothing of the power.
            (None, _) | (_, None) => BIFURCATION,
            (Some(at_low), Some(at_high)) if at_low * at_high > 0.0 => {
                if at_low.abs() < at_high.abs() {
                    low
                } else {
                    high
                }
            }
            (Some(at_low), _) => {
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    let same_side = excess(middle).is_some_and(|at_middle| at_middle * at_low > 0.0);
                    *(if same_side { &mut low } else { &mut high }) = middle;
                }
                0.5 * (low + high)
            }
        };
        end(power).map(|share| End { share, power })
    }
}

/// Where a determinant that falls like (1 - s / s*)^p between two equilibria is zero; `None` if it does not fall.
fn end_of_interval([from, log_from]: [f64; 2], [to, log_to]: [f64; 2], power: f64) -> Option<f64> {
    let ratio = ((log_from - log_to) / power).exp();
    let left = (to - from) / (ratio - 1.0);
    (left > 0.0 && left.is_finite()).then_some(to + left)
}

#[cfg(test)]
#[path = "../../tests/units/limit.rs"]
mod tests;
