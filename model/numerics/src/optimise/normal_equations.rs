//! The linear problem of a step: normal equations, formed once per point and solved for any damping.

use super::{LeastSquaresProblem, Prior, Refusal, StepBounds};
use nalgebra::{DMatrix, DVector};

/// Residuals at a point, including the residuals of the priors.
#[derive(Debug, Clone)]
pub(super) struct Residuals {
    measured: DVector<f64>,
    priors: Vec<Prior>,
    /// The residuals of the problem, followed by the residuals of the priors.
    all: DVector<f64>,
}

impl Residuals {
    /// Evaluates the residuals at a point.
    ///
    /// # Errors
    /// [`Refusal`] if the problem has no residuals at this point.
    pub(super) fn at<P: LeastSquaresProblem>(
        problem: &mut P,
        point: &P::Point,
    ) -> Result<Residuals, Refusal<P::Error>> {
        let measured = problem.residual(point)?;
        let priors = problem.priors(point);
        let all = measured.iter().copied().chain(priors.iter().map(|prior| prior.residual));
        let all = DVector::from_iterator(measured.len() + priors.len(), all);
        Ok(Residuals { measured, priors, all })
    }

    pub(super) fn squares(&self) -> f64 {
        self.all.norm_squared()
    }

    /// Linearises the problem at the same point.
    ///
    /// # Errors
    /// [`Refusal`] if the problem has no derivatives at this point.
    pub(super) fn linearised<P: LeastSquaresProblem>(
        self,
        problem: &mut P,
        point: &P::Point,
    ) -> Result<NormalEquations, Refusal<P::Error>> {
        let rows = self.measured.len();
        let mut jacobian = problem.jacobian(point, &self.measured)?.resize_vertically(self.all.len(), 0.0);
        for (i, prior) in self.priors.iter().enumerate() {
            for &(unknown, derivative) in &prior.by {
                jacobian[(rows + i, unknown)] = derivative;
            }
        }
        let (matrix, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&self.all));
        Ok(NormalEquations { squares: self.squares(), residual: self.all, jacobian, matrix, gradient })
    }
}

/// A problem linearised at a point: J^T J d = -J^T r for the step d.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    /// Sum of squared residuals, dimensionless.
    pub squares: f64,
    /// Residuals r; the residuals of the priors come last.
    pub residual: DVector<f64>,
    /// Derivatives J of the residuals with respect to the unknowns.
    pub jacobian: DMatrix<f64>,
    /// Normal matrix J^T J.
    matrix: DMatrix<f64>,
    /// Gradient J^T r.
    gradient: DVector<f64>,
}

impl NormalEquations {
    /// The best damped step within bounds. If a step takes an unknown to its bound, this unknown stays at the bound, and the step is solved again for
    /// the other unknowns. `None` if the damped matrix is not positive definite.
    pub(super) fn step(&self, damping: f64, bounds: &StepBounds) -> Option<DVector<f64>> {
        let mut damped = self.matrix.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] += damping * self.matrix[(i, i)].max(f64::MIN_POSITIVE);
        }
        let mut step = DVector::zeros(damped.nrows());
        let mut is_held = vec![false; damped.nrows()];
        loop {
            let best = self.best_of_free(damped.clone(), &step, &is_held)?;
            let Some(met) = bounds.first_met(&step, &best, &is_held) else { return Some(best) };
            step += (best - &step) * met.share;
            step[met.unknown] = met.bound;
            is_held[met.unknown] = true;
        }
    }

    /// The best damped step in which every unknown held at a bound changes as in `step`.
    fn best_of_free(&self, mut damped: DMatrix<f64>, step: &DVector<f64>, is_held: &[bool]) -> Option<DVector<f64>> {
        let mut right = -&self.gradient;
        for held in (0..is_held.len()).filter(|&k| is_held[k]) {
            right -= damped.column(held) * step[held];
            damped.row_mut(held).fill(0.0);
            damped.column_mut(held).fill(0.0);
            damped[(held, held)] = 1.0;
        }
        for held in (0..is_held.len()).filter(|&k| is_held[k]) {
            right[held] = step[held];
        }
        let best = damped.cholesky()?.solve(&right);
        best.iter().all(|x| x.is_finite()).then_some(best)
    }

    /// Decrease of the sum of squares that the linearised problem predicts for a step.
    pub(super) fn decrease(&self, step: &DVector<f64>) -> f64 {
        -2.0 * (self.gradient.dot(step) + 0.5 * step.dot(&(&self.matrix * step)))
    }
}
