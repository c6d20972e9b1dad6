//! Uncertainty of the unloaded finger and its rig after a fit. Only errors that affect sensed forces are included.

use super::forces::force_alone;
use super::problem::{OWN, Point, Problem};
use super::{Quantity, Sought};
use crate::Vector;
use crate::optimise::{Fit, covariance};
use crate::sensing::UnloadedError;
use nalgebra::{DMatrix, Isometry2, RowDVector};

/// An error is negligible, even in combination with others, if it changes a force by at most this share.
const LEAST_SHARE: f64 = 1e-4;

/// Independent errors of the sought quantities, each with the size of one standard deviation, linearised at a fit. An error counts only if it
/// changes the estimated force of at least one view without a measured force. The effect of an error on the force is tested twice: with an
/// unknown and with a known direction of the force. If no force is estimated, because all forces were measured, every error counts.
pub(super) fn unloaded_errors(problem: &Problem, fitted: &Fit<Point>, base: &Isometry2<f64>) -> Vec<UnloadedError> {
    let shared = problem.sought.len();
    if shared == 0 {
        return Vec::new();
    }
    let jacobian = &fitted.jacobian;
    let Some(covariance) = covariance(jacobian) else { return Vec::new() };
    let mut changes: Vec<RowDVector<f64>> = Vec::new();
    for (view, own, rows, column) in problem.parts(&fitted.point).filter(|(view, ..)| view.force.is_none()) {
        // Two cases: all unknowns of the view, and all except the lean (angle between force and normal).
        let all: Vec<usize> = (column..column + problem.own_count(view)).collect();
        let known_direction = &all[..=OWN];
        for unknowns in [&all[..], known_direction] {
            let found = force_alone(problem, jacobian, rows.clone(), unknowns, own.force_n);
            changes.extend(found.map(|(mut by_shared, ..)| {
                // The scene states the uncertainty of a new force's lean (angle from the normal), so an error of the lean in this fit is ignored.
                let leans = problem.sought.iter().zip(by_shared.iter_mut());
                leans.filter(|(sought, _)| sought.quantity == Quantity::Lean).for_each(|(_, by)| *by = 0.0);
                by_shared.transpose()
            }));
        }
    }
    let own = covariance.view((0, 0), (shared, shared)).clone_owned().symmetric_eigen();
    let spread = &own.eigenvectors * DMatrix::from_diagonal(&own.eigenvalues.map(|variance| variance.max(0.0).sqrt()));
    if changes.is_empty() {
        return spread.column_iter().map(|error| unloaded_error(problem, error.as_slice(), base)).collect();
    }
    let found = (DMatrix::from_rows(&changes) * &spread).svd(false, true);
    let Some(combinations) = found.v_t else { return Vec::new() };
    let counts = found.singular_values.iter().zip(combinations.row_iter()).filter(|(share, _)| **share > LEAST_SHARE);
    counts
        .map(|(_, combination)| unloaded_error(problem, (&spread * combination.transpose()).as_slice(), base))
        .collect()
}

/// Expresses changes of all sought quantities as one error of the calibrated finger. `base` is the calibrated pose of the finger's base, mm and
/// rad.
pub(super) fn unloaded_error(problem: &Problem, changes: &[f64], base: &Isometry2<f64>) -> UnloadedError {
    let ribs = problem.finger.rib_count();
    let mut error = UnloadedError::none(ribs);
    for (Sought { quantity, .. }, &change) in problem.sought.iter().zip(changes) {
        match quantity {
            Quantity::Bracket(plate) => {
                error.joints_mm.iter_mut().for_each(|joints_mm| joints_mm[plate.index()][1] += change);
            }
            Quantity::OwnBracket(plate, rib) => error.joints_mm[*rib][plate.index()][1] += change,
            Quantity::RibPosition(plate, rib) => error.joints_mm[*rib][plate.index()][0] += change,
            Quantity::Clip => error.clip_mm.iter_mut().for_each(|clip_mm| *clip_mm += change),
            Quantity::PlateClip(plate) => error.clip_mm[plate.index()] += change,
            Quantity::MarkerHeight => error.height_mm += change,
            Quantity::BaseX => error.base += base.rotation.inverse() * Vector::new(change, 0.0),
            Quantity::BaseY => error.base += base.rotation.inverse() * Vector::new(0.0, change),
            Quantity::BaseTurn => error.base_turn_rad += change.to_radians(),
            Quantity::Preload => error.preload_nmm += change,
            Quantity::Modulus | Quantity::PlateModulus(_) | Quantity::Lean => {}
        }
    }
    error
}
