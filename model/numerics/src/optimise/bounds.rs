//! How far a step may go.

use nalgebra::DVector;

/// Bounds of the change of each unknown in a step from one point. They hold an unknown within its range, if they are taken
/// from where it is, and a step within the range where the linearised problem is worth something.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepBounds {
    /// Unknown, most negative and most positive change.
    bounds: Vec<(usize, [f64; 2])>,
}

impl StepBounds {
    /// All of so many unknowns change by no more than `largest` in a step.
    pub fn within(unknowns: usize, largest: f64) -> StepBounds {
        StepBounds { bounds: (0..unknowns).map(|unknown| (unknown, [-largest, largest])).collect() }
    }

    /// The same with a further bound: an unknown of this value stays between two others.
    pub fn and(mut self, unknown: usize, value: f64, [least, most]: [f64; 2]) -> StepBounds {
        self.bounds.push((unknown, [least - value, most - value]));
        self
    }

    /// The first bound that is met on the straight line from a step to another one, by unknowns that are not held yet.
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

/// A bound that a line meets, and at which share of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MetBound {
    pub unknown: usize,
    pub bound: f64,
    pub share: f64,
}
