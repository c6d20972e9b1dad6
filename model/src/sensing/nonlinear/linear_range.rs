//! Validity of a standard deviation: it is that of the finger linearised at the estimate.

use super::{NonlinearEstimator, State};
use crate::Vector;
use crate::measurement::Measurement;
use crate::sensing::SensingError;
use crate::statics::StaticsError;

/// A force known to within this share of itself is far from where its standard deviation would mislead.
const WELL_KNOWN: f64 = 0.3;
/// One standard deviation more or less of a force must move the markers as the linearised finger has it, but for this
/// share (Bates and Watts, Nonlinear Regression Analysis and Its Applications, ch. 7, on the intrinsic curvature).
const LARGEST_DEPARTURE: f64 = 0.5;

impl NonlinearEstimator<'_> {
    /// Refuses forces that the noise leaves so open that the finger answers differently, or not at all, within their
    /// standard deviations: as where a plate is pushed along itself, which moves nothing until it buckles.
    ///
    /// # Errors
    /// [`SensingError::Undetermined`] for the first such force.
    pub(super) fn require_linear_range(
        &mut self,
        state: &State,
        measurement: &Measurement,
        sigmas_n: &[f64],
    ) -> Result<(), SensingError> {
        for (i, &sigma) in sigmas_n.iter().enumerate() {
            if !sigma.is_finite() || sigma <= WELL_KNOWN * state.forces_n[i].abs() {
                continue;
            }
            for change_n in [-sigma, sigma] {
                if !self.answers_linearly(state, measurement, i, change_n)? {
                    return Err(SensingError::Undetermined { what: "the force", contact: i + 1, sigma, unit: "N" });
                }
            }
        }
        Ok(())
    }

    /// Whether the markers move with a force as the linearised finger has it.
    fn answers_linearly(
        &mut self,
        state: &State,
        measurement: &Measurement,
        contact: usize,
        change_n: f64,
    ) -> Result<bool, SensingError> {
        let mut loads = state.loads.clone();
        let force_n = state.forces_n[contact] + change_n;
        let (found, turn_rad) = (&state.contacts[contact], state.plate_turns_rad[contact]);
        let of_contact = self.pad.loads(self.mesh, found, force_n, turn_rad);
        for (load, found) in loads[contact * self.pad.load_count()..].iter_mut().zip(of_contact) {
            *load = found?;
        }
        let motion = match self.statics.shifted(&state.motion, &state.loads, &loads) {
            Ok(equilibrium) => equilibrium.motion,
            Err(StaticsError::NoEquilibrium { .. }) => return Ok(false),
            Err(other) => return Err(other.into()),
        };
        let (mut departure, mut linear) = (0.0, 0.0);
        for marker in measurement.markers() {
            // Key nodes come first in a frame.
            let node = marker.node.0 - 1;
            let moved: Vector = motion.displacements[node] - state.motion.displacements[node];
            let expected = state.linearised.rate(contact, node) * change_n;
            departure += (moved - expected).norm_squared();
            linear += expected.norm_squared();
        }
        Ok(departure <= LARGEST_DEPARTURE * LARGEST_DEPARTURE * linear)
    }
}
