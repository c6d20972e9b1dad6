//! Bounds on the step of a search.

use nalgebra::DVector;

/// Bounds on the change of each unknown in a step from one point. The bounds are computed from the current values and keep the unknowns within their
/// ranges. The bounds also keep the step within the range in which the linearised problem is a good approximation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepBounds {
    /// Index of an unknown, with its most negative and its most positive change.
    bounds: Vec<(usize, [f64; 2])>,
}

impl StepBounds {
    /// Limits the change of every unknown to `largest` in magnitude; `unknowns` is the number of unknowns.
    pub fn within(unknowns: usize, largest: f64) -> StepBounds {
        StepBounds { bounds: (0..unknowns).map(|unknown| (unknown, [-largest, largest])).collect() }
    }

    /// Adds a bound: the unknown, whose current value is `value`, stays between `least` and `most`.
    pub fn and(mut self, unknown: usize, value: f64, [least, most]: [f64; 2]) -> StepBounds {
        self.bounds.push((unknown, [least - value, most - value]));
        self
    }

    /// The first bound that the straight line from step `from` to step `to` meets, among unknowns that are not yet held at a bound.
    pub(super) fn first_met(&self, from: &DVector<f64>, to: &DVector<f64>, is_held: &[bool]) -> Option<MetBound> {
        let met = |&(unknown, [least, most]): &(usize, [f64; 2])| {
            let bound = if to[unknown] < least { least } else { most };
            let is_beyond = !is_held[unknown] && !(least..=most).contains(&to[unknown]);
            let share = ((bound - from[unknown]) / (to[unknown] - from[unknown])).clamp(0.0, 1.0);
            is_beyond.then_some(MetBound { unknown, bound, share })
        };
        self.bounds.iter().filter_map(met).min_by(|a, b| a.share.total_cmp(&b.share))
    }
}

/// A bound that the line of a step meets, and the share of the line's length up to the bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MetBound {
    pub unknown: usize,
    pub bound: f64,
    pub share: f64,
}
