//! Nonlinear least squares: the Levenberg-Marquardt method, and the parts from which other searches are built.
//!
//! A [`LeastSquaresProblem`] states its residuals in units of their standard deviations, its [`Prior`]s, and the [`StepBounds`] of its unknowns.
//! [`LevenbergMarquardt`] minimises half the sum of squares and returns a [`Fit`] with the covariance of the unknowns. Each part of the method has a file:
//! convergence, bounds, and the linear solve.
//!
//! A search that follows a path of equilibria cannot evaluate residuals at an arbitrary point, so it has its own loop. The loop uses the same parts:
//! the trust region ([`TrustRegion`]), [`Convergence`], the covariance, and a linear solve without heap allocation ([`GramSchmidt`]).
//!
//! ```
//! use finray_numerics::optimise::{FromFunction, LevenbergMarquardt, Refusal};
//! use nalgebra::{DMatrix, DVector};
//!
//! // Fits the decay exp(-rate t) to two measurements.
//! let readings = [(1.0_f64, 0.50), (2.0, 0.24)];
//! let residual = |rate: &DVector<f64>| {
//!     let decay = |t: f64| (-rate[0] * t).exp();
//!     let residual = DVector::from_iterator(2, readings.iter().map(|(t, seen)| decay(*t) - seen));
//!     let jacobian = DMatrix::from_iterator(2, 1, readings.iter().map(|(t, _)| -t * decay(*t)));
//!     Ok::<_, Refusal<()>>((residual, jacobian))
//! };
//! let start = DVector::from_element(1, 1.0);
//! let fit = LevenbergMarquardt::default().minimise(&mut FromFunction::new(residual), start).expect("defined everywhere");
//! assert!(fit.has_converged() && (fit.point[0] - 0.703).abs() < 1e-3);
//! ```

mod bounds;
mod convergence;
mod covariance;
mod gram_schmidt;
mod levenberg_marquardt;
mod normal_equations;
mod problem;
mod trust_region;

pub use bounds::StepBounds;
pub use convergence::Convergence;
pub use covariance::{SingularParts, covariance};
pub use gram_schmidt::GramSchmidt;
pub use levenberg_marquardt::{Fit, LevenbergMarquardt, Outcome};
pub use problem::{FromFunction, LeastSquaresProblem, Prior, Refusal};
pub use trust_region::{Prediction, TrustRegion};
