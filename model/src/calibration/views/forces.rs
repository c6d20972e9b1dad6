//! Measured forces against those that the images of a fit show.

use super::problem::{OWN, Point, Problem};
use super::scatter::Scatter;
use crate::least_squares::Fit;
use nalgebra::DVector;

impl Problem<'_> {
    /// How measured forces scatter about those that the images show, linearised at a fit; `None` where the images do not show all unknowns.
    pub(super) fn scatter_of(&self, fitted: &Fit<Point>) -> Option<Scatter> {
        let (mut by, mut residual) = (fitted.derivatives.clone(), fitted.residual.clone());
        let shared = self.sought.len();
        // The last row of a view, and the last of its unknowns: what was measured of its force, and the force, here as a share.
        let (mut row, mut column) = (0, shared);
        let (mut forces, mut off, mut new) = (Vec::new(), Vec::new(), Vec::new());
        for (view, own) in self.views.iter().zip(&fitted.parameters.own) {
            let (unknowns, rows) = (self.own_count(view), self.row_count(view));
            if let Some(force_n) = view.force.map(|force| force.norm()) {
                by.row_mut(row + rows - 1).fill(0.0);
                residual[row + rows - 1] = 0.0;
                by.column_mut(column + OWN).scale_mut(force_n);
                forces.push(column + OWN);
                off.push(own.force_n / force_n - 1.0);
                let alone = by.view((row, column), (rows, unknowns));
                let covariance = alone.tr_mul(&alone).cholesky()?.inverse();
                // Without what was measured of it, the force follows the finger.
                let by_shared = -alone.tr_mul(&by.view((row, 0), (rows, shared))).tr_mul(&covariance.column(OWN));
                new.push(by_shared);
            }
            row += rows;
            column += unknowns;
        }
        let others = (0..by.ncols()).filter(|column| !forces.contains(column));
        let by = by.select_columns(&others.chain(forces.iter().copied()).collect::<Vec<_>>());
        Scatter::new(&by.tr_mul(&by), &by.tr_mul(&residual), shared, &DVector::from_vec(off), &new)
    }
}
