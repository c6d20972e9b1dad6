//! The problem of a search: residuals, their derivatives, and priors.

use super::StepBounds;
use nalgebra::{DMatrix, DVector};

/// Residuals as functions of unknowns. Each residual is in units of its standard deviation.
///
/// # Requirements
/// Residuals are differentiable, and their number is the same at every point. A step of zero leaves a point unchanged.
pub trait LeastSquaresProblem {
    /// Values of the unknowns: numbers, or an object, for example a pose, that is moved by a step (a vector of numbers).
    type Point;
    /// Reason why a point has no residuals.
    type Error;

    /// Residuals at a point, in units of their standard deviations.
    ///
    /// # Errors
    /// [`Refusal`] for a point that has no residuals.
    fn residual(&mut self, point: &Self::Point) -> Result<DVector<f64>, Refusal<Self::Error>>;

    /// Derivatives of the residuals with respect to a step: one row per residual, one column per unknown. Called only at the point of the last call
    /// of [`residual`](LeastSquaresProblem::residual), with the result of that call. Both functions may therefore share a tangent matrix.
    ///
    /// # Errors
    /// [`Refusal`] for a point that has no derivatives.
    fn jacobian(&mut self, point: &Self::Point, residual: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<Self::Error>>;

    /// The point that a step leads to.
    fn moved(&self, point: &Self::Point, step: &DVector<f64>) -> Self::Point;

    /// Prior knowledge as further residuals, placed after the residuals of [`residual`](LeastSquaresProblem::residual). The number of priors is the
    /// same at every point.
    fn priors(&self, _point: &Self::Point) -> Vec<Prior> {
        Vec::new()
    }

    /// Bounds on a step from a point.
    fn step_bounds(&self, _point: &Self::Point) -> StepBounds {
        StepBounds::default()
    }
}

/// Reason why a point has no residuals, and the consequence for the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal<E> {
    /// The model has no solution at this point. The search tries a shorter step.
    Here(E),
    /// The search ends with this error.
    Altogether(E),
}

impl<E> Refusal<E> {
    /// The reason why the point has no residuals.
    pub fn into_error(self) -> E {
        match self {
            Refusal::Here(error) | Refusal::Altogether(error) => error,
        }
    }
}

/// A residual that states prior knowledge. It is linear in the unknowns near a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// Deviation from the expected value, divided by its standard deviation.
    pub residual: f64,
    /// Derivatives of the residual: pairs of an unknown's index and the derivative with respect to this unknown. All other derivatives are zero.
    pub by: Vec<(usize, f64)>,
}

impl Prior {
    /// A prior for one unknown: its current value is `value`, and its expected value is `expected` with the standard deviation `sd`. All are in the
    /// unknown's unit.
    pub fn on(unknown: usize, value: f64, expected: f64, sd: f64) -> Prior {
        Prior { residual: (value - expected) / sd, by: vec![(unknown, 1.0 / sd)] }
    }
}

/// A problem whose unknowns are plain numbers; one function computes residuals and derivatives together.
#[derive(Debug, Clone)]
pub struct FromFunction<F> {
    function: F,
    /// Derivatives at the last point, one row per residual.
    jacobian: DMatrix<f64>,
}

impl<F> FromFunction<F> {
    /// A problem from `function`, which returns residuals and derivatives at a point.
    pub fn new(function: F) -> FromFunction<F> {
        FromFunction { function, jacobian: DMatrix::zeros(0, 0) }
    }
}

impl<E, F> LeastSquaresProblem for FromFunction<F>
where
    F: FnMut(&DVector<f64>) -> Result<(DVector<f64>, DMatrix<f64>), Refusal<E>>,
{
    type Point = DVector<f64>;
    type Error = E;

    fn residual(&mut self, point: &DVector<f64>) -> Result<DVector<f64>, Refusal<E>> {
        let (residual, jacobian) = (self.function)(point)?;
        self.jacobian = jacobian;
        Ok(residual)
    }

    fn jacobian(&mut self, _: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<E>> {
        Ok(std::mem::take(&mut self.jacobian))
    }

    fn moved(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        point + step
    }
}
