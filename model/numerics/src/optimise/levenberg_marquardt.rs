//! The Levenberg-Marquardt method.

use super::normal_equations::{NormalEquations, Residuals};
use super::{Convergence, LeastSquaresProblem, Refusal, covariance};
use nalgebra::{DMatrix, DVector};

/// Default damping of the first step.
const FIRST_DAMPING: f64 = 1e-3;
/// Factor on the damping after an accepted step.
const LOWERED: f64 = 0.1;
/// Factor on the damping after a rejected step.
const RAISED: f64 = 10.0;
/// Smallest damping; a smaller damping would change a step by no more than rounding errors.
const LEAST_DAMPING: f64 = 1e-14;
/// Largest damping; with a larger damping, no significant step remains, and the search ends.
const MOST_DAMPING: f64 = 1e10;
/// Default limit of the number of steps of a search, including rejected steps.
const MOST_STEPS: usize = 200;

/// Damped least squares: Gauss-Newton steps, shortened if they do not reduce the sum of squares.
///
/// # Requirements
/// The residuals of the problem exist at the starting point. The search finds a local minimum near the start, which need not be the global one.
///
/// # Reference
/// Nocedal and Wright, Numerical Optimization, 2nd ed., sec. 10.3. The damping is scaled by the diagonal of the normal equations (Marquardt 1963).
/// The damping is lowered after an accepted step and raised after a rejected step (Transtrum and Sethna, arXiv:1201.5885, sec. 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevenbergMarquardt {
    /// Convergence criteria.
    pub convergence: Convergence,
    /// Damping of the first step, as a share of the diagonal of the normal equations; 0 for a Gauss-Newton step.
    pub first_damping: f64,
    /// Largest number of steps, including rejected steps.
    pub most_steps: usize,
}

impl Default for LevenbergMarquardt {
    fn default() -> LevenbergMarquardt {
        LevenbergMarquardt { convergence: Convergence::default(), first_damping: FIRST_DAMPING, most_steps: MOST_STEPS }
    }
}

/// The way in which a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The next step would be negligible.
    Converged,
    /// No step, however short, reduces the sum of squares. Causes are rounding or wrong derivatives.
    NoStepHelps,
    /// The largest number of steps was reached.
    StepsUsedUp,
}

/// Result of a search: a point, and the problem linearised there.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit<P> {
    /// The unknowns at the last accepted point.
    pub point: P,
    /// Sum of squared residuals, including priors; dimensionless.
    pub squares: f64,
    /// The residuals in units of their standard deviations; the residuals of the priors come last.
    pub residual: DVector<f64>,
    /// Derivatives of the residuals by the unknowns: one row per residual, one column per unknown.
    pub jacobian: DMatrix<f64>,
    /// Number of points at which the problem was linearised.
    pub iterations: usize,
    /// How the search ended.
    pub outcome: Outcome,
}

impl<P> Fit<P> {
    /// Whether the search has converged.
    pub fn has_converged(&self) -> bool {
        self.outcome == Outcome::Converged
    }

    /// Covariance of the unknowns, as [`covariance`](super::covariance()).
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        covariance(&self.jacobian)
    }
}

impl LevenbergMarquardt {
    /// Searches for a local minimum near a start.
    ///
    /// # Errors
    /// A [`Refusal`] of either kind at the starting point, or [`Refusal::Altogether`] at any later point.
    pub fn minimise<P: LeastSquaresProblem>(
        &self,
        problem: &mut P,
        start: P::Point,
    ) -> Result<Fit<P::Point>, Refusal<P::Error>> {
        let mut point = start;
        let mut now = Residuals::at(problem, &point)?.linearised(problem, &point)?;
        let (mut damping, mut iterations) = (self.first_damping, 1);
        let mut outcome = Outcome::StepsUsedUp;
        for _ in 0..self.most_steps {
            let step = now.step(damping, &problem.step_bounds(&point));
            if step.as_ref().is_some_and(|step| self.is_reached(&now, step)) {
                outcome = Outcome::Converged;
                break;
            }
            let trial = step.map(|step| problem.moved(&point, &step));
            match lower(problem, trial, now.squares)? {
                Some(lower) => {
                    (point, now) = lower;
                    iterations += 1;
                    damping = (damping * LOWERED).max(LEAST_DAMPING);
                }
                None => {
                    damping = (damping * RAISED).max(LEAST_DAMPING);
                    if damping > MOST_DAMPING {
                        outcome = Outcome::NoStepHelps;
                        break;
                    }
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

/// Linearises the problem at a trial point. `None` if there is no trial point, if the trial point has no residuals, or if its sum of squares is not
/// lower.
///
/// # Errors
/// [`Refusal::Altogether`] if the problem ends the search at this point.
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
