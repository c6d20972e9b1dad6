//! The method of Levenberg and Marquardt.

use super::damping::Damping;
use super::normal_equations::{NormalEquations, Residuals};
use super::{Convergence, LeastSquaresProblem, Refusal, covariance};
use nalgebra::{DMatrix, DVector};

/// Damping of the first step unless told otherwise.
const FIRST_DAMPING: f64 = 1e-3;
/// Steps of a search, those that were not taken included, unless told otherwise.
const MOST_STEPS: usize = 200;

/// Damped least squares: Gauss-Newton steps, shortened where they do not lower the sum of squares.
///
/// # Requirements
/// A start at which the problem has residuals. The nearest minimum is found, which need not be the lowest.
///
/// # Reference
/// Nocedal and Wright, Numerical Optimization, 2nd ed., sec. 10.3; damping scaled by the diagonal of the normal equations
/// (Marquardt 1963), lowered after a taken step and raised after another (Transtrum and Sethna, arXiv:1201.5885, sec. 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardt {
    /// Where the search ends.
    pub convergence: Convergence,
    /// Damping of the first step, as a share of the diagonal of the normal equations; 0 for a Gauss-Newton step.
    pub first_damping: f64,
    /// Steps that are tried.
    pub most_steps: usize,
}

impl Default for LevenbergMarquardt {
    fn default() -> LevenbergMarquardt {
        LevenbergMarquardt { convergence: Convergence::default(), first_damping: FIRST_DAMPING, most_steps: MOST_STEPS }
    }
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The next step would be too small to count.
    Converged,
    /// No step lowers the sum of squares, however short: rounding, or derivatives that are wrong.
    NoStepHelps,
    /// The steps were used up.
    StepsUsedUp,
}

/// A point of a problem and the problem linearised there.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit<P> {
    /// The unknowns.
    pub point: P,
    /// Sum of squared residuals, priors included.
    pub squares: f64,
    /// The residuals, priors last.
    pub residual: DVector<f64>,
    /// Their derivatives by a step.
    pub jacobian: DMatrix<f64>,
    /// Times that the problem was linearised and solved for a step.
    pub iterations: usize,
    /// How the search ended.
    pub outcome: Outcome,
}

impl<P> Fit<P> {
    /// Whether the search has converged.
    pub fn has_converged(&self) -> bool {
        self.outcome == Outcome::Converged
    }

    /// See [`covariance`](super::covariance()).
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        covariance(&self.jacobian)
    }
}

impl LevenbergMarquardt {
    /// Searches for the minimum that is nearest to a start.
    ///
    /// # Errors
    /// [`Refusal`] of the start, of either kind, and [`Refusal::Altogether`] of any point that is tried.
    pub fn minimise<P: LeastSquaresProblem>(
        &self,
        problem: &mut P,
        start: P::Point,
    ) -> Result<Fit<P::Point>, Refusal<P::Error>> {
        let mut point = start;
        let mut now = Residuals::at(problem, &point)?.linearised(problem, &point)?;
        let (mut damping, mut iterations) = (Damping(self.first_damping), 1);
        let mut outcome = Outcome::StepsUsedUp;
        for _ in 0..self.most_steps {
            let step = now.step(damping.0, &problem.step_bounds(&point));
            if step.as_ref().is_some_and(|step| self.is_reached(&now, step)) {
                outcome = Outcome::Converged;
                break;
            }
            let trial = step.map(|step| problem.moved(&point, &step));
            match lower(problem, trial, now.squares)? {
                Some(lower) => {
                    (point, now) = lower;
                    iterations += 1;
                    damping.lower();
                }
                None if damping.raise() => {}
                None => {
                    outcome = Outcome::NoStepHelps;
                    break;
                }
            }
        }
        let NormalEquations { squares, residual, jacobian, .. } = now;
        Ok(Fit { point, squares, residual, jacobian, iterations, outcome })
    }

    fn is_reached(&self, now: &NormalEquations, step: &DVector<f64>) -> bool {
        self.convergence.is_small_decrease(now.decrease(step), now.squares)
            || self.convergence.is_small_step(step.amax())
    }
}

/// A point and the problem linearised there.
type Linearised<P> = (<P as LeastSquaresProblem>::Point, NormalEquations);

/// A trial point, linearised; `None` if its sum of squares is not lower, or there is no answer or no step.
///
/// # Errors
/// [`Refusal::Altogether`] of the point.
fn lower<P: LeastSquaresProblem>(
    problem: &mut P,
    trial: Option<P::Point>,
    squares: f64,
) -> Result<Option<Linearised<P>>, Refusal<P::Error>> {
    let Some(point) = trial else { return Ok(None) };
    let next = Residuals::at(problem, &point).and_then(|residuals| {
        let is_lower = residuals.squares() < squares;
        is_lower.then(|| residuals.linearised(problem, &point)).transpose()
    });
    match next {
        Ok(next) => Ok(next.map(|next| (point, next))),
        Err(Refusal::Here(_)) => Ok(None),
        Err(end) => Err(end),
    }
}
