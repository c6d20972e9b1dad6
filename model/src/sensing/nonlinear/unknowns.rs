//! What is sought, as a list of numbers: forces, then places, then directions.

use super::{NonlinearEstimator, State};
use crate::finger::Plate;
use crate::sensing::Direction;
use nalgebra::DVector;

/// One unknown: of which contact, and what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unknown {
    Force(usize),
    Place(usize),
    /// The part of a force across its current direction, N: with it the direction turns.
    Across(usize),
}

impl NonlinearEstimator<'_> {
    pub(super) fn unknowns(&self) -> Vec<Unknown> {
        let forces = (0..self.questions.len()).map(Unknown::Force);
        let places = self.questions.iter().enumerate().filter(|(_, q)| q.place.is_none());
        let angles = self.questions.iter().enumerate().filter(|(_, q)| q.direction == Direction::Auto);
        forces.chain(places.map(|(i, _)| Unknown::Place(i))).chain(angles.map(|(i, _)| Unknown::Across(i))).collect()
    }

    /// What counts as one unit of each unknown: 1 N, and for places what moves the finger about as much.
    pub(super) fn scales(&self, state: &State, unknowns: &[Unknown]) -> Vec<f64> {
        let largest = state.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        unknowns
            .iter()
            .map(|unknown| match *unknown {
                Unknown::Force(_) | Unknown::Across(_) => 1.0,
                Unknown::Place(i) => {
                    let force = state.forces_n[i].abs().max(1e-3 * largest).max(f64::MIN_POSITIVE);
                    0.1 * self.finger().plate_length_mm(Plate::Front) / force
                }
            })
            .collect()
    }

    /// Largest change of an unknown: forces against the largest force, places against the plate.
    pub(super) fn relative_change(&self, state: &State, unknowns: &[Unknown], step: &DVector<f64>) -> f64 {
        let largest = state.forces_n.iter().fold(f64::MIN_POSITIVE, |m, f| m.max(f.abs()));
        let length = self.finger().plate_length_mm(Plate::Front);
        let change = |(unknown, x): (&Unknown, &f64)| match unknown {
            Unknown::Force(_) | Unknown::Across(_) => x.abs() / largest,
            Unknown::Place(_) => x.abs() / length,
        };
        unknowns.iter().zip(step.iter()).map(change).fold(0.0, f64::max)
    }
}
