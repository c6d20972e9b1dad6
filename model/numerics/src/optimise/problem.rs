//! The problem: residuals, their derivatives, and what is known beforehand.

use super::StepBounds;
use nalgebra::{DMatrix, DVector};

/// Residuals of some unknowns, each in units of its standard deviation.
///
/// # Requirements
/// Residuals are differentiable, and as many at every point. A step of zero leaves a point where it is.
pub trait LeastSquaresProblem {
    /// Values of the unknowns: numbers, or what a step of numbers moves, as a pose.
    type Point;
    /// Why a point has no residuals.
    type Error;

    /// Residuals at a point.
    ///
    /// # Errors
    /// [`Refusal`] for a point that has none.
    fn residual(&mut self, point: &Self::Point) -> Result<DVector<f64>, Refusal<Self::Error>>;

    /// Derivatives of the residuals by a step: a row a residual, a column an unknown. Asked for at the point that
    /// [`residual`](LeastSquaresProblem::residual) was asked for last, whose result it is given: both may share a tangent.
    ///
    /// # Errors
    /// [`Refusal`] for a point that has none.
    fn jacobian(&mut self, point: &Self::Point, residual: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<Self::Error>>;

    /// The point after a step.
    fn moved(&self, point: &Self::Point, step: &DVector<f64>) -> Self::Point;

    /// What is known beforehand: further residuals, below the others. As many at every point.
    fn priors(&self, _point: &Self::Point) -> Vec<Prior> {
        Vec::new()
    }

    /// How far a step may go from a point.
    fn step_bounds(&self, _point: &Self::Point) -> StepBounds {
        StepBounds::default()
    }
}

/// Why a point has no residuals, and what follows from that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal<E> {
    /// The model has no answer at this point. A shorter step is tried.
    Here(E),
    /// The search ends with this error.
    Altogether(E),
}

impl<E> Refusal<E> {
    /// The reason.
    pub fn into_error(self) -> E {
        match self {
            Refusal::Here(error) | Refusal::Altogether(error) => error,
        }
    }
}

/// A residual that states what is known beforehand, linear in the unknowns near a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// Difference to what is expected, over its standard deviation.
    pub residual: f64,
    /// Its derivatives: unknown, and derivative by it. All others are zero.
    pub by: Vec<(usize, f64)>,
}

impl Prior {
    /// A value of one unknown is expected, with a standard deviation.
    pub fn on(unknown: usize, value: f64, expected: f64, sd: f64) -> Prior {
        Prior { residual: (value - expected) / sd, by: vec![(unknown, 1.0 / sd)] }
    }
}

/// A problem of plain numbers, given by one function that computes residuals and derivatives together.
#[derive(Debug, Clone)]
pub struct FromFunction<F> {
    function: F,
    /// Derivatives at the last point.
    jacobian: DMatrix<f64>,
}

impl<F> FromFunction<F> {
    /// `function` returns residuals and derivatives at a point.
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
