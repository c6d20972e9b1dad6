//! Estimated forces with the positions and directions of their contacts.

use super::position_profile::PositionProfile;
use crate::sensing::{Contact, ContactUncertainty, Estimate};

/// Estimated forces with the positions and directions of their contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearEstimate {
    /// Forces with their standard deviations, noise and residual. The covariance includes the uncertainty of estimated positions and directions.
    pub forces: Estimate,
    /// Position and direction of each contact, given or estimated.
    pub contacts: Vec<Contact>,
    /// Number of Gauss-Newton steps.
    pub steps: usize,
    /// Uncertainty of the position and the direction of each contact.
    pub uncertainties: Vec<ContactUncertainty>,
    /// Other forces and positions that explain the measurement.
    pub(super) alternatives: Alternatives,
    /// Estimated leans (angles between force and normal).
    pub(super) leans: Vec<FoundLean>,
}

/// An estimated lean: angle between a contact force and the normal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FoundLean {
    /// Index of the contact whose force leans, from 0.
    pub contact: usize,
    /// Lean (angle between force and normal), degrees. `sd_deg` is its standard deviation, degrees.
    pub lean_deg: f64,
    pub sd_deg: f64,
    /// Derivative of each force with respect to the lean (angle between force and normal), with all other unknowns at their optimum, N per degree.
    pub by_lean_n: Vec<f64>,
    /// Second-order part of the variance of the force that leans, N^2. The variance already includes this part.
    pub second_order_n2: f64,
}

/// Other forces and positions that explain a measurement. They widen the estimate on the mesh on which they were found, and on finer meshes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Alternatives {
    /// Growth of the misfit over the smallest misfit, mm^2, and forces, N, of other minima.
    pub minima: Vec<(f64, Vec<f64>)>,
    /// The same for other positions of several contacts.
    pub others: Vec<(f64, Vec<f64>)>,
    /// Profile over the only unknown position.
    pub profile: Option<PositionProfile>,
}
