//! Supplies the optimiser with residuals and their derivatives, priors, and bounds of the positions.

use super::View;
use super::problem::{Candidate, OWN, Point, Problem, free_part_mm};
use crate::calibration::CalibrationError;
use crate::optimise::{LeastSquaresProblem, Prior, Refusal, StepBounds};
use crate::sensing::{ForceUnknowns, PressedFinger};
use nalgebra::{DMatrix, DVector, Translation2, UnitComplex};

/// Steps of the derivatives by shared quantities, in the unit of each quantity. A change of a length strains beams, which are stiff, so that the
/// response of the finger is of first order only for short steps.
const STEP: f64 = 1e-4;
const LENGTH_STEP: f64 = 1e-7;
/// Step between equilibria of fingers with different frames. Equilibria have ten correct digits.
const FRAME_STEP: f64 = 1e-3;
/// Refusal of a point at which the finger is impossible or has no equilibrium.
const NOWHERE: Refusal<CalibrationError> = Refusal::Here(CalibrationError::NoMinimum);

impl LeastSquaresProblem for Problem<'_> {
    type Point = Point;
    type Error = CalibrationError;

    fn residual(&mut self, point: &Point) -> Result<DVector<f64>, Refusal<CalibrationError>> {
        let candidate = self.candidate(&point.shared).ok_or(NOWHERE)?;
        let pressed = self.all_pressed(&candidate, point)?;
        let rows = self.parts(point).zip(&pressed);
        let rows = rows.flat_map(|((view, own, ..), pressed)| self.with_force_row(pressed.residual(), view, own));
        let residual = DVector::from_vec(rows.collect());
        self.shapes = pressed.into_iter().map(PressedFinger::into_shape).collect();
        Ok(residual)
    }

    fn jacobian(&mut self, point: &Point, residual: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<CalibrationError>> {
        let candidate = self.candidate(&point.shared).ok_or(NOWHERE)?;
        let mut pressed = self.all_pressed(&candidate, point)?;
        let unknowns = self.sought.len() + self.views.iter().map(|view| self.own_count(view)).sum::<usize>();
        let mut jacobian = DMatrix::zeros(residual.len(), unknowns);
        for ((view, _, rows, column), pressed) in self.parts(point).zip(&mut pressed) {
            let by_own = pressed.jacobian().ok_or(NOWHERE)?;
            let own = by_own.columns(0, self.own_count(view));
            jacobian.view_mut((rows.start, column), own.shape()).copy_from(&own);
            if let (Some(force), Some(scatter)) = (view.force, self.scatter) {
                jacobian[(rows.end - 1, column + OWN)] = 1.0 / (force.norm() * scatter);
            }
        }
        let here =
            self.views.iter().zip(&pressed).map(|(view, pressed)| pressed.residual_of(self.press(&candidate, view)));
        let here = here.collect::<Option<Vec<_>>>().ok_or(NOWHERE)?;
        for (k, sought) in self.sought.iter().enumerate() {
            let changed = |step: f64| {
                let mut shared = point.shared.clone();
                shared[k] += step;
                self.candidate(&shared).ok_or(NOWHERE)
            };
            let step = if sought.quantity.is_length() { LENGTH_STEP } else { STEP };
            let other = changed(step)?;
            for (((view, own, rows, _), pressed), here) in self.parts(point).zip(&pressed).zip(&here) {
                let by: Vec<f64> = match pressed.residual_of(self.press(&other, view)) {
                    Some(there) => there.iter().zip(here).map(|(there, here)| (there - here) / step).collect(),
                    None => {
                        let there = changed(FRAME_STEP)?;
                        let there = self.pressed(&there, view, own, None).ok_or(NOWHERE)?.residual();
                        there.iter().zip(pressed.residual()).map(|(there, here)| (there - here) / FRAME_STEP).collect()
                    }
                };
                rows.zip(by).for_each(|(row, by)| jacobian[(row, k)] = by);
            }
        }
        Ok(jacobian)
    }

    fn moved(&self, point: &Point, step: &DVector<f64>) -> Point {
        let mut moved = point.clone();
        moved.shared.iter_mut().zip(step).for_each(|(change, step)| *change += step);
        for ((view, _, _, column), own) in self.parts(point).zip(&mut moved.own) {
            let step = &step.as_slice()[column..column + self.own_count(view)];
            let [least_mm, most_mm] = free_part_mm(self.finger);
            own.s_mm = (own.s_mm + step[0]).clamp(least_mm, most_mm);
            own.base.append_translation_mut(&Translation2::new(step[1], step[2]));
            own.base.append_rotation_wrt_center_mut(&UnitComplex::new(step[3]));
            own.force_n += step.get(OWN).unwrap_or(&0.0);
            own.further_lean_deg += step.get(OWN + 1).unwrap_or(&0.0);
        }
        moved
    }

    fn priors(&self, point: &Point) -> Vec<Prior> {
        let changes = self.sought.iter().zip(&point.shared).enumerate();
        let of_quantities =
            changes.filter_map(|(k, (sought, change))| Some(Prior::on(k, *change, 0.0, sought.prior_sd?)));
        let of_position = |(view, own, _, column): (&View, &ForceUnknowns, _, usize)| {
            let [position_mm, sd_mm] = view.position?;
            Some(Prior::on(column, own.s_mm, position_mm, sd_mm))
        };
        of_quantities.chain(self.parts(point).filter_map(of_position)).collect()
    }

    /// Bounds of a step that keep contacts on the plate, or at their known positions.
    fn step_bounds(&self, point: &Point) -> StepBounds {
        self.parts(point).fold(StepBounds::default(), |bounds, (_, own, _, position)| {
            let within_mm = free_part_mm(self.finger);
            bounds.and(position, own.s_mm, within_mm)
        })
    }
}

impl Problem<'_> {
    /// Equilibria of all views at a point. The search starts from the shapes of the last point.
    fn all_pressed<'c>(
        &self,
        candidate: &'c Candidate,
        point: &Point,
    ) -> Result<Vec<PressedFinger<'c>>, Refusal<CalibrationError>> {
        let own = self.views.iter().zip(&point.own).enumerate();
        let pressed = own.map(|(i, (view, own))| self.pressed(candidate, view, own, self.shapes.get(i)).ok_or(NOWHERE));
        pressed.collect()
    }
}

#[cfg(test)]
#[path = "../../../tests/units/view_derivatives.rs"]
mod tests;
