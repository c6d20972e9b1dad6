//! Fits of a few parameters to many measurements.

use nalgebra::{DMatrix, DVector};

const MOST_STEPS: usize = 200;
/// The search ends where a step would lower the sum of squares by less than this share of it: the parameters are then within 1e-6 of
/// their standard deviations.
const SETTLED: f64 = 1e-13;
const LEAST_DAMPING: f64 = 1e-14;
const MOST_DAMPING: f64 = 1e10;

/// What a fit found.
pub(crate) struct Fit<P> {
    pub parameters: P,
    /// Sum of squared residuals.
    pub squares: f64,
    /// The residuals, and their derivatives by a step.
    pub residual: DVector<f64>,
    pub derivatives: DMatrix<f64>,
    /// (J^T J)^-1: times the variance of a residual, the covariance of the parameters. `None` where it has no inverse.
    pub inverse: Option<DMatrix<f64>>,
}

/// Minimises |residual|^2 by the method of Levenberg and Marquardt. `residual` gives residuals and their derivatives by a step of the
/// parameters, `None` where there are none; `moved` takes a step.
///
/// `None` if there are no residuals at the start.
///
/// # Reference
/// Nocedal and Wright, Numerical Optimization, sec. 10.3; damping scaled by the diagonal as Marquardt does.
pub(crate) fn fit<P>(
    start: P,
    residual: impl Fn(&P) -> Option<(DVector<f64>, DMatrix<f64>)>,
    moved: impl Fn(&P, &DVector<f64>) -> P,
) -> Option<Fit<P>> {
    let mut parameters = start;
    let (mut at, mut by) = residual(&parameters)?;
    let mut squares = at.norm_squared();
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let normal = by.tr_mul(&by);
        let gradient = by.tr_mul(&at);
        let mut damped = normal.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] += damping * normal[(i, i)].max(f64::MIN_POSITIVE);
        }
        let step =
            damped.cholesky().map(|factor| -factor.solve(&gradient)).filter(|step| step.iter().all(|x| x.is_finite()));
        let Some(step) = step else {
            damping = (damping * 10.0).max(LEAST_DAMPING);
            if damping > MOST_DAMPING {
                break;
            }
            continue;
        };
        let expected = -(gradient.dot(&step) + 0.5 * step.dot(&(&normal * &step)));
        if expected <= SETTLED * squares {
            break;
        }
        let trial = moved(&parameters, &step);
        match residual(&trial).filter(|(found, _)| found.norm_squared() < squares) {
            Some((found, slopes)) => {
                (parameters, at, by) = (trial, found, slopes);
                squares = at.norm_squared();
                damping = (damping * 0.1).max(LEAST_DAMPING);
            }
            None => {
                damping *= 10.0;
                if damping > MOST_DAMPING {
                    break;
                }
            }
        }
    }
    let inverse = by.tr_mul(&by).cholesky().map(|factor| factor.inverse());
    Some(Fit { parameters, squares, residual: at, derivatives: by, inverse })
}
