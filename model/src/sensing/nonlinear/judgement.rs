//! What an estimate is worth: standard deviations, and refusals of what the data do not tell.

use super::unknowns::Unknown;
use super::{NonlinearEstimate, NonlinearEstimator, State};
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::sensing::{Contact, Estimate, LARGEST_SPAN, SensingError};
use nalgebra::DMatrix;

/// A direction known to less than this, degrees, or a place to less than this share of the plate, is not known.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;
const LARGEST_PLACE_SIGMA: f64 = 0.25;

impl NonlinearEstimator<'_> {
    /// Standard deviations and refusals.
    ///
    /// # Errors
    /// [`SensingError`] for unknowns that the data do not tell.
    pub(super) fn judged(
        &self,
        state: &mut State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        steps: usize,
    ) -> Result<NonlinearEstimate, SensingError> {
        let (coordinates, count) = (measurement.coordinate_count(), self.unknowns.len());
        let misfit = state.linearised.misfit(&state.motion, measurement);
        let noise_mm = noise_mm.unwrap_or_else(|| match coordinates - count {
            0 => f64::INFINITY,
            freedoms => (misfit / freedoms as f64).sqrt(),
        });
        self.rescale(state);
        // The triangle has the singular values of the derivatives.
        let svd = state.linearised.triangle(measurement)?.svd(false, true);
        let mut singular_values: Vec<f64> = svd.singular_values.iter().copied().collect();
        singular_values.sort_by(|a, b| b.total_cmp(a));
        let span = singular_values[0] / singular_values[count - 1];
        let Some(v_t) = svd.v_t.as_ref().filter(|_| span <= LARGEST_SPAN) else {
            let column = svd.v_t.map_or(0, |v_t| v_t.row(svd.singular_values.imin()).iamax_full().1);
            let weakest = self.unknowns[column].contact() + 1;
            return Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest });
        };
        let scales = &state.linearised.scales;
        // (A^T A)^-1 = V S^-2 V^T, from the scaled unknowns back to theirs.
        let covariance = |i: usize, j: usize| {
            let scaled = |k: usize| v_t[(k, i)] * v_t[(k, j)] / svd.singular_values[k].powi(2);
            scales[i] * scales[j] * (0..count).map(scaled).sum::<f64>() * noise_mm * noise_mm
        };
        let sigma = |j: usize| covariance(j, j).sqrt();
        for (j, unknown) in self.unknowns.iter().enumerate() {
            let (what, contact, sigma, limit, unit) = match *unknown {
                Unknown::Force(_) => continue,
                Unknown::Place(i) => {
                    let limit = LARGEST_PLACE_SIGMA * self.finger().plate_length_mm(Plate::Front);
                    ("the place", i + 1, sigma(j), limit, "mm")
                }
                Unknown::Across(i) => {
                    let sigma_deg = (sigma(j) / state.forces_n[i].abs()).to_degrees();
                    ("the direction", i + 1, sigma_deg, LARGEST_ANGLE_SIGMA_DEG, "deg")
                }
            };
            if sigma > limit {
                return Err(SensingError::Undetermined { what, contact, sigma, unit });
            }
        }
        Ok(NonlinearEstimate {
            forces: Estimate {
                forces_n: state.forces_n.clone(),
                sigmas_n: (0..self.questions.len()).map(sigma).collect(),
                noise_mm,
                residual_rms_mm: (misfit / coordinates as f64).sqrt(),
                singular_values,
            },
            covariance_n2: DMatrix::from_fn(self.questions.len(), self.questions.len(), covariance),
            contacts: state
                .contacts
                .iter()
                .map(|c| Contact { angle_deg: c.angle_deg - 360.0 * ((c.angle_deg + 180.0) / 360.0).floor(), ..*c })
                .collect(),
            steps,
        })
    }
}
