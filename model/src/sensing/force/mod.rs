//! Sensing with the co-rotational finger: Gauss-Newton on forces, positions and directions.
//!
//! # The problem
//! - [`unknowns`]: the unknowns, with scale, prior and limit of each. To add an unknown, start there.
//! - [`values`]: values of the unknowns, and how a step changes them.
//! - [`marker_motion`]: displacement of a marker as a function of the unknowns, beside its derivatives.
//! - [`priors`], [`touching`]: rows of the least-squares problem below those of the markers: priors, and contact with an object.
//! - [`problem`]: [`ForceProblem`](problem::ForceProblem) and its [`State`](problem::State), an equilibrium with the problem linearised there.
//! - [`linearised`], [`derivatives`]: residuals and derivatives as a least-squares problem, and how they follow from the factored tangent.
//!
//! # The search for a minimum
//! - [`start`], [`object_start`], [`states`]: starting points, and states under given forces or of another problem.
//! - [`correction`]: near the minimum, forces and shape are corrected together.
//! - [`search`], [`step_path`], [`projection`]: far from it, every step ends at an equilibrium.
//! - [`minima`], [`search_history`], [`scan`], [`profile`]: all minima, from several starting points, and the best of them.
//!
//! # The estimate
//! - [`estimator`], [`estimate`]: the course of one estimate, and its result.
//! - [`assessment`], [`components`]: covariance, and refusal of what is not identifiable.
//! - [`alternatives`], [`linear_range`], [`position`], [`position_profile`], [`leaning`]: other explanations of the measurement, which refuse the estimate or widen its
//!   intervals.
//! - [`discretisation`], [`refine`]: the error of the mesh, and estimates on finer meshes.
//! - [`pressed`]: the problem at given values of its unknowns, for calibrations from images.
//! - [`assembled`]: fingers that differ from the scene's.

mod alternatives;
mod assembled;
mod assessment;
mod components;
mod correction;
mod derivatives;
mod discretisation;
mod estimate;
mod estimator;
mod leaning;
mod linear_range;
mod linearised;
mod marker_motion;
mod minima;
mod object_start;
mod position;
mod position_profile;
mod pressed;
mod priors;
mod problem;
mod profile;
mod projection;
mod refine;
mod scan;
mod search;
mod search_history;
mod start;
mod states;
mod step_path;
mod touching;
mod unknowns;
mod values;

pub(crate) use assembled::{LinearisedAssembly, linearise_assembly};
pub use discretisation::Discretisation;
pub use estimate::NonlinearEstimate;
pub use estimator::{NearForces, NonlinearEstimator};
pub(crate) use pressed::{ForceUnknowns, LoadedShape, Press, PressedFinger};
pub use refine::{Refinement, sense_refining};

use super::{UNEXPLAINED_SHARE, UNEXPLAINED_SIGMAS};

/// Another minimum explains the data equally well if its misfit (sum of squared residuals) exceeds the smallest misfit by at most this many noise variances.
const AS_GOOD: f64 = 9.0;
/// Other positions widen a standard deviation only if it grows by more than this factor. Smaller growth hardly changes how often intervals hold.
const CURVED: f64 = 1.5;

/// A direction that follows the deformed plate has settled if a step turns the direction by at most this angle, degrees. The corresponding change of
/// a force is 1e-6 of the force.
const SETTLED_ANGLE_DEG: f64 = 1e-4;

/// Largest residual that noise and errors of the finger explain, mm, root mean square over the coordinates. `marker_noise_mm` is the standard
/// deviation of a coordinate, `moved_rms_mm` the root mean square displacement, both mm.
fn largest_explained_rms_mm(marker_noise_mm: f64, moved_rms_mm: f64) -> f64 {
    f64::max(UNEXPLAINED_SIGMAS * marker_noise_mm, UNEXPLAINED_SHARE * moved_rms_mm)
}
