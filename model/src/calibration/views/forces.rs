//! Compares measured forces with the forces estimated from the images of a fit.

use super::View;
use super::problem::{BASE_ROWS, OWN, Point, Problem};
use super::scatter::{NewImage, Scatter};
use crate::optimise::{Fit, LeastSquaresProblem, covariance};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Derivatives and variance of the force of a view, estimated from markers and base alone. The force is relative to its measured value `force_n`,
/// N. `by` is the Jacobian of a fit. The rows of the view start at `row`, and the unknowns of the view start at `column`. `None` if the force is
/// not identifiable.
pub(super) fn new_image(
    problem: &Problem,
    by: &DMatrix<f64>,
    [row, column]: [usize; 2],
    view: &View,
    force_n: f64,
) -> Option<NewImage> {
    // The last row of a view is the residual of the measured force. The last unknown of a view is the force, here as a relative value.
    let rows = problem.row_count(view) - 1;
    let own: Vec<usize> = (column..column + problem.own_count(view)).collect();
    let (by_shared, covariance, alone) = force_alone(problem, by, row..row + rows, &own, force_n)?;
    let by_base = alone.rows(rows - BASE_ROWS, BASE_ROWS) * covariance.column(OWN);
    let variance = covariance[(OWN, OWN)];
    Some(NewImage { by_shared, variance, of_markers: variance - by_base.norm_squared() })
}

/// Estimates the force of one view, relative to `force_n`, N, from the residual rows `rows` of the view. `own` lists the columns of the view's
/// own unknowns. The force is the fifth of the view's own unknowns. Returns the derivative of the relative force with respect to each shared
/// unknown, and covariance and Jacobian of the view's own unknowns. `None` if the force is not identifiable.
pub(super) fn force_alone(
    problem: &Problem,
    by: &DMatrix<f64>,
    rows: Range<usize>,
    own: &[usize],
    force_n: f64,
) -> Option<(DVector<f64>, DMatrix<f64>, DMatrix<f64>)> {
    let of_view = by.rows(rows.start, rows.len());
    let mut alone = of_view.select_columns(own);
    alone.column_mut(OWN).scale_mut(force_n);
    let covariance = covariance(&alone)?;
    // Change of the estimated force per unit change of each shared unknown.
    let by_shared = -alone.tr_mul(&of_view.columns(0, problem.sought.len())).tr_mul(&covariance.column(OWN));
    Some((by_shared, covariance, alone))
}

/// Scatter of measured forces about the forces estimated from the images, linearised at a fit. `None` if the images do not determine all unknowns.
pub(super) fn scatter_of(problem: &Problem, fitted: &Fit<Point>) -> Option<Scatter> {
    let (mut by, mut residual) = (fitted.jacobian.clone(), fitted.residual.clone());
    let shared = problem.sought.len();
    let (mut forces, mut off, mut new) = (Vec::new(), Vec::new(), Vec::new());
    // A guess of the modulus that proves wrong is no scatter of the forces, so its prior says nothing about their common factor.
    let priors = problem.priors(&fitted.point);
    let first_prior = by.nrows() - priors.len();
    for (i, prior) in priors.iter().enumerate() {
        let is_modulus =
            |(unknown, _): &(usize, f64)| problem.sought.get(*unknown).is_some_and(|it| it.quantity.is_modulus());
        if prior.by.iter().any(is_modulus) {
            by.row_mut(first_prior + i).fill(0.0);
            residual[first_prior + i] = 0.0;
        }
    }
    for (view, own, rows, column) in problem.parts(&fitted.point) {
        if let Some(force_n) = view.force.map(|force| force.norm()) {
            new.push(new_image(problem, &by, [rows.start, column], view, force_n)?);
            by.row_mut(rows.end - 1).fill(0.0);
            residual[rows.end - 1] = 0.0;
            by.column_mut(column + OWN).scale_mut(force_n);
            forces.push(column + OWN);
            off.push(own.force_n / force_n - 1.0);
        }
    }
    let others = (0..by.ncols()).filter(|column| !forces.contains(column));
    let by = by.select_columns(&others.chain(forces.iter().copied()).collect::<Vec<_>>());
    Scatter::new(&by.tr_mul(&by), &by.tr_mul(&residual), shared, &DVector::from_vec(off), &new)
}
