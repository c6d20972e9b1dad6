//! Supplies the optimiser with residuals and their derivatives by differences, priors, and bounds of the positions.

use super::Quantity;
use super::problem::{Point, Pressed, Problem, ViewUnknowns, free_part_mm};
use crate::calibration::CalibrationError;
use crate::optimise::{LeastSquaresProblem, Prior, Refusal, StepBounds};
use nalgebra::{DMatrix, DVector};

/// Steps of the difference quotients. `LENGTH_STEP` is for lengths (mm), and for shared quantities other than factors (in the quantity's unit).
/// `SHARE_STEP` is for relative changes of factors and forces, and for rotations (rad). `ANGLE_STEP_DEG` is for the lean of a view (angle between
/// force and normal), degrees. Equilibria have ten correct digits.
const LENGTH_STEP: f64 = 1e-3;
const SHARE_STEP: f64 = 1e-4;
const ANGLE_STEP_DEG: f64 = 1e-2;
/// Refusal of a point at which the finger is impossible or has no equilibrium.
const NOWHERE: Refusal<CalibrationError> = Refusal::Here(CalibrationError::NoMinimum);

impl LeastSquaresProblem for Problem<'_> {
    type Point = Point;
    type Error = CalibrationError;

    fn residual(&mut self, point: &Point) -> Result<DVector<f64>, Refusal<CalibrationError>> {
        let candidate = self.candidate(&point.shared).ok_or(NOWHERE)?;
        let of_views = self.views.iter().zip(&point.own).map(|(view, own)| self.weighted(None, &candidate, view, own));
        let of_views = of_views.collect::<Option<Vec<_>>>().ok_or(NOWHERE)?;
        Ok(DVector::from_vec(of_views.concat()))
    }

    fn jacobian(&mut self, point: &Point, residual: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<CalibrationError>> {
        let (shared, residual) = (self.sought.len(), residual.as_slice());
        let unknowns = shared + self.views.iter().map(|view| self.own_count(view)).sum::<usize>();
        let mut jacobian = DMatrix::zeros(residual.len(), unknowns);
        let candidate = self.candidate(&point.shared).ok_or(NOWHERE)?;
        let here = self.views.iter().zip(&point.own).map(|(view, own)| self.pressed(&candidate, view, own));
        let here = here.collect::<Option<Vec<Pressed>>>().ok_or(NOWHERE)?;
        for (k, sought) in self.sought.iter().enumerate() {
            let step = match sought.quantity {
                Quantity::Modulus | Quantity::PlateModulus(_) => SHARE_STEP,
                _ => LENGTH_STEP,
            };
            let mut changed = point.shared.clone();
            changed[k] += step;
            let other = self.candidate(&changed).ok_or(NOWHERE)?;
            for ((view, own, rows, _), here) in self.parts(point).zip(&here) {
                let after = self.weighted(Some(here), &other, view, own);
                let by = differences(after, &residual[rows.clone()], step)?;
                jacobian.view_mut((rows.start, k), (rows.len(), 1)).copy_from(&by);
            }
        }
        for ((view, own, rows, column), here) in self.parts(point).zip(&here) {
            for j in 0..self.own_count(view) {
                let step = own.step(j);
                let after = self.weighted(Some(here), &candidate, view, &own.moved(self.finger, j, step));
                let by = differences(after, &residual[rows.clone()], step)?;
                jacobian.view_mut((rows.start, column + j), (rows.len(), 1)).copy_from(&by);
            }
        }
        Ok(jacobian)
    }

    fn moved(&self, point: &Point, step: &DVector<f64>) -> Point {
        let mut moved = point.clone();
        for (change, step) in moved.shared.iter_mut().zip(step) {
            *change += step;
        }
        let mut column = self.sought.len();
        for (view, own) in self.views.iter().zip(&mut moved.own) {
            for j in 0..self.own_count(view) {
                *own = own.moved(self.finger, j, step[column]);
                column += 1;
            }
        }
        moved
    }

    fn priors(&self, point: &Point) -> Vec<Prior> {
        let changes = self.sought.iter().zip(&point.shared).enumerate();
        changes.filter_map(|(k, (sought, change))| Some(Prior::on(k, *change, 0.0, sought.prior_sd?))).collect()
    }

    /// Bounds of a step that keep contacts on the plate, or at their known positions.
    fn step_bounds(&self, point: &Point) -> StepBounds {
        self.parts(point).fold(StepBounds::default(), |bounds, (_, own, _, position)| {
            let within_mm = free_part_mm(self.finger);
            bounds.and(position, own.s_mm, within_mm)
        })
    }
}

/// Difference quotients of the residuals of one view: the change from `before` to `after`, divided by `step`.
fn differences(after: Option<Vec<f64>>, before: &[f64], step: f64) -> Result<DVector<f64>, Refusal<CalibrationError>> {
    let after = after.ok_or(NOWHERE)?;
    Ok(DVector::from_iterator(before.len(), after.iter().zip(before).map(|(after, before)| (after - before) / step)))
}

impl ViewUnknowns {
    /// Step of the difference quotients for an unknown, given by its index, in mm, rad, N or degrees.
    fn step(&self, unknown: usize) -> f64 {
        match unknown {
            0..=2 => LENGTH_STEP,
            3 => SHARE_STEP,
            4 => SHARE_STEP * self.force_n,
            _ => ANGLE_STEP_DEG,
        }
    }
}
