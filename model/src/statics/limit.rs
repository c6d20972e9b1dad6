//! Prediction of the end of a branch of stable equilibria, from the determinant of the tangent stiffness.
//!
//! At the end of the branch, one pivot of the tangent and the tangent's determinant D reach zero. Let s be the share of the load path, and s* the
//! share at the end of the branch. Near the end of the branch, the determinant D at a share s of the path falls as (1 - s / s*)^p. The exponent p is
//! 1/2 at a fold (limit load, snap-through) and 1 at a bifurcation (a straight rib that buckles). On a path that only passes close to a fold, p is
//! 2/3 over part of the path. Three equilibria determine s* and p.

/// Exponent p of the determinant of a branch that ends in a fold (limit load, snap-through).
const FOLD: f64 = 0.5;
/// Exponent p of the determinant of a branch that ends in a bifurcation (buckling of a straight member).
const BIFURCATION: f64 = 1.0;
/// Number of bisections of the interval of exponents p. The bisections determine p to 1e-3, which is finer than the accuracy of the predictions.
const HALVINGS: usize = 9;
/// A step covers this share of the remaining distance to a fold. Near a fold, displacements vary with the square root of the remaining distance. If a
/// step covers 8/9 of the distance to a fold, the tangent's prediction is wrong by half, which is the limit for a load step.
const REACH_AT_FOLD: f64 = 0.8;
/// A step covers this share of the remaining distance to a bifurcation. Near a bifurcation, displacements are smooth functions of the load.
const REACH_AT_BIFURCATION: f64 = 0.95;
/// A step has at least this share of the length of the last step. This lower limit applies if the determinant falls by powers of ten between two
/// equilibria, because predictions are then useless.
const LEAST_REACH: f64 = 0.01;
/// Largest exponent p of the determinant that counts as a fold. The exponents 2/3 and 1 exceed 0.58 by more than the errors due to rounding and to
/// the finite distance between equilibria.
const LARGEST_POWER_OF_FOLD: f64 = 0.58;
/// A fold counts as reached when the remaining distance is below this share of the predicted end of the branch.
const GAP_TO_FOLD: f64 = 1e-4;
/// The end of a branch that is not a fold counts as reached when the remaining distance is below this share of the predicted end. A branch whose
/// predicted end is not a fold may still turn there and continue.
const GAP_TO_OTHERS: f64 = 1e-6;
/// The last two predictions agree if they differ by at most this share of the remaining distance.
const AGREEMENT: f64 = 0.5;

/// The last three equilibria on the path, and the predicted end of the branch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Approach {
    /// Share of the path and natural logarithm of the determinant at each equilibrium, oldest first.
    points: [Option<[f64; 2]>; 3],
    predicted: Option<End>,
    /// The prediction before the last equilibrium was added.
    predicted_before: Option<End>,
}

/// The predicted end of the branch: share of the path, and exponent p.
#[derive(Debug, Clone, Copy)]
struct End {
    share: f64,
    power: f64,
}

impl Approach {
    /// Whether the equilibrium at a share of the path has not been added yet.
    pub(super) fn asks_for(&self, share: f64) -> bool {
        self.points[2].is_none_or(|[known, _]| known != share)
    }

    /// Adds the next equilibrium and predicts the end. Ignores an equilibrium with unknown determinant.
    pub(super) fn add(&mut self, share: f64, log_determinant: Option<f64>) {
        let Some(log) = log_determinant else { return };
        self.points = [self.points[1], self.points[2], Some([share, log])];
        self.predicted_before = self.predicted;
        self.predicted = self.end();
    }

    /// Target of the next step, a share of the path. The target lies before the predicted end, unless the remaining distance is shorter than a
    /// hundredth of the last step. `None` without a prediction.
    pub(super) fn near(&self) -> Option<f64> {
        let End { share: end, power } = self.predicted?;
        let [_, Some([before, _]), Some([at, _])] = self.points else { return None };
        let reach = REACH_AT_FOLD + (REACH_AT_BIFURCATION - REACH_AT_FOLD) * (2.0 * power - 1.0);
        Some(at + f64::max(reach * (end - at), LEAST_REACH * (at - before)))
    }

    /// Whether an equilibrium lies beyond the predicted end and therefore disproves the prediction.
    pub(super) fn is_disproved_by(&self, share: f64) -> bool {
        self.predicted.is_some_and(|end| share > end.share)
    }

    /// Whether the last two predictions agree and the branch ends before a share of the path. The distance from the predicted end to this share must
    /// exceed the distance from the last equilibrium to the predicted end.
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

    /// A share of the path that the branch should not reach. This share lies as far beyond the predicted end as the last equilibrium lies before the
    /// predicted end. `None` unless the end is close.
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
        // Actual fall of the determinant's logarithm between the first two equilibria, minus the fall that the exponent `power` implies.
        let excess = |power: f64| {
            let ([first, log_first], [second, log_second]) = (first?, second);
            let end = end(power)?;
            Some(log_first - log_second - power * ((end - first) / (end - second)).ln())
        };
        let [mut low, mut high] = [FOLD, BIFURCATION];
        let power = match (excess(low), excess(high)) {
            // One interval between equilibria does not determine the exponent.
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

/// Share s* of the path at which the determinant becomes zero, if it falls as (1 - s / s*)^p with the share s between two equilibria. `None` if the
/// determinant does not fall.
fn end_of_interval([from, log_from]: [f64; 2], [to, log_to]: [f64; 2], power: f64) -> Option<f64> {
    let ratio = ((log_from - log_to) / power).exp();
    let left = (to - from) / (ratio - 1.0);
    (left > 0.0 && left.is_finite()).then_some(to + left)
}

#[cfg(test)]
#[path = "../../tests/units/limit.rs"]
mod tests;
