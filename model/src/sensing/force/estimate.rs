//! Estimated forces with the positions and directions of their contacts.

use crate::sensing::{Contact, Estimate, ModelError, Warning};
use nalgebra::{DMatrix, DVector};

/// Estimated forces with the positions and directions of their contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearEstimate {
    /// Forces with their standard deviations, noise and residual.
    pub forces: Estimate,
    /// Covariance of the forces, N^2, in the order of the contacts. The covariance includes the uncertainty of estimated positions and directions.
    pub covariance_n2: DMatrix<f64>,
    /// Position and direction of each contact, given or estimated.
    pub contacts: Vec<Contact>,
    /// Number of Gauss-Newton steps.
    pub steps: usize,
    /// Standard deviation of each contact's position, mm, linearised at the estimate. Zero for a known position.
    pub position_sds_mm: Vec<f64>,
    /// Estimated leans (angles between force and normal).
    pub(super) leans: Vec<FoundLean>,
}

impl NonlinearEstimate {
    /// Adds an error of the model, N, to the standard deviations and the covariance.
    pub(super) fn add_model_error(&mut self, error_n: Vec<f64>, warning: fn(ModelError) -> Warning) {
        let error = DVector::from_column_slice(&error_n);
        self.add_covariance(&(&error * error.transpose()));
        self.forces.add_model_error(error_n, warning);
    }

    /// Adds a covariance of the forces along their directions, N^2.
    pub(super) fn add_covariance(&mut self, covariance_n2: &DMatrix<f64>) {
        self.covariance_n2 += covariance_n2;
        if let Some(measured) = &mut self.forces.measured {
            let mut along = measured.covariance_n2.view_mut((0, 0), covariance_n2.shape());
            along += covariance_n2;
        }
    }

    /// Adds a variance to that of one force along its direction, N^2.
    pub(super) fn add_variance(&mut self, contact: usize, variance_n2: f64) {
        let count = self.covariance_n2.nrows();
        let mut covariance_n2 = DMatrix::zeros(count, count);
        covariance_n2[(contact, contact)] = variance_n2;
        self.add_covariance(&covariance_n2);
        self.forces.sigmas_n[contact] = self.forces.sigmas_n[contact].hypot(variance_n2.sqrt());
    }
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
