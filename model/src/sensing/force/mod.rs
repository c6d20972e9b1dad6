//! Sensing with the co-rotational finger: Gauss-Newton on forces, positions and directions.
//!
//! A [`ForceProblem`](problem::ForceProblem) holds the contacts, the unknowns and the finger's equations. An estimate starts from least squares on the
//! linear finger ([`start`]) or from the last estimate. Near the minimum of the difference between measured and computed shape ([`linearised`]),
//! forces and shape are corrected together ([`correction`]). Far from the minimum, every step ends at an equilibrium ([`search`]). Each result is
//! tested before it is returned ([`assessment`], [`alternatives`]). A calibration from images evaluates the same problem at given values of its
//! unknowns ([`pressed`]).

mod alternatives;
mod assembled;
mod assessment;
mod components;
mod correction;
mod derivatives;
mod discretisation;
mod estimate;
mod estimator;
mod follow;
mod leaning;
mod linear_range;
mod linearised;
mod minima;
mod nuisances;
mod object_start;
mod position;
mod pressed;
mod problem;
mod profile;
mod projection;
mod refine;
mod scan;
mod search;
mod search_history;
mod start;
mod states;
mod touching;
mod unknowns;

pub(crate) use assembled::{LinearisedAssembly, linearise_assembly};
pub use discretisation::Discretisation;
pub use estimate::NonlinearEstimate;
pub use estimator::{NearForces, NonlinearEstimator};
pub(crate) use pressed::{ForceUnknowns, LoadedShape, Press, PressedFinger};
pub use refine::{Refinement, sense_refining};

use super::{UNEXPLAINED_SHARE, UNEXPLAINED_SIGMAS};

/// A direction that follows the deformed plate has settled if a step turns the direction by at most this angle, degrees. The corresponding change of
/// a force is 1e-6 of the force.
const SETTLED_ANGLE_DEG: f64 = 1e-4;

/// Largest residual that noise and model error explain, mm, root mean square over the coordinates. `noise_mm` is the standard deviation of a coordinate,
/// `moved_rms_mm` the root mean square displacement, both mm.
fn largest_explained_rms_mm(noise_mm: f64, moved_rms_mm: f64) -> f64 {
    f64::max(UNEXPLAINED_SIGMAS * noise_mm, UNEXPLAINED_SHARE * moved_rms_mm)
}
