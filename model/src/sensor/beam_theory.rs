//! Errors of beam theory: in marker displacements, and in forces of unknown direction near the base.

use crate::measurement::Measurement;
use crate::scene::Scene;
use crate::sensing::{Contact, ContactUncertainty, Estimate};
use std::borrow::Cow;

/// Error of beam theory in a marker coordinate, relative to the largest displacement, as a multiple of the relative error of the
/// sensed force. Fitted to plane continua of two fingers, `paper` and `thick` in `fixtures/calculix`: the residual is 0.13 % (root
/// mean square) if the force is wrong by 0.38 %.
const MODEL_ERROR_OF_MARKERS: f64 = 0.34;

/// Adds the error of beam theory to the errors of the markers. `model_error` is the relative standard deviation of a sensed force due
/// to this error (`model_error` in `[finger]`), and `marker_noise_mm` the standard deviation of a marker of weight 1. Returns the
/// measurement with new weights, and the new standard deviation of a marker of weight 1. Unknown and zero noise remain.
pub(super) fn with_beam_theory_error(
    model_error: f64,
    measurement: &Measurement,
    marker_noise_mm: Option<f64>,
) -> (Cow<'_, Measurement>, Option<f64>) {
    let largest_mm = || measurement.markers().iter().map(|marker| marker.displacement.norm()).fold(0.0, f64::max);
    let beam_theory_mm = if model_error > 0.0 { MODEL_ERROR_OF_MARKERS * model_error * largest_mm() } else { 0.0 };
    let Some(noise_mm) = marker_noise_mm.filter(|noise_mm| beam_theory_mm > 0.0 && *noise_mm > 0.0) else {
        return (Cow::Borrowed(measurement), marker_noise_mm);
    };
    let both_mm = noise_mm.hypot(beam_theory_mm);
    let weighted = measurement.clone().with_markers(|marker| {
        marker.weight = both_mm / (noise_mm / marker.weight).hypot(beam_theory_mm);
    });
    (Cow::Owned(weighted.with_known_error(noise_mm, both_mm)), Some(both_mm))
}

/// Widens forces and directions of contacts whose direction is estimated by [`ModelError::unknown_direction`](crate::finger::ModelError). A contact is
/// near the base if the first rib is the nearest rib.
pub(super) fn widen_unknown_directions(
    scene: &Scene,
    contacts: &mut [(Contact, ContactUncertainty)],
    estimate: &mut Estimate,
) {
    let Some([near_base, elsewhere]) = scene.model_error.unknown_direction() else { return };
    for (i, (contact, uncertainty)) in contacts.iter_mut().enumerate() {
        let positions_mm = scene.finger.plate_positions_mm(contact.position.plate());
        let until_mm =
            if let [_, first_mm, second_mm, ..] = positions_mm[..] { 0.5 * (first_mm + second_mm) } else { 0.0 };
        let errors = |s_mm: f64| if s_mm < until_mm { near_base } else { elsewhere };
        if let (Some(direction_sd_deg), Some([share, sd_deg])) =
            (&mut uncertainty.direction_sd_deg, contact.position_mm(&scene.finger).map(errors))
        {
            *direction_sd_deg = direction_sd_deg.hypot(sd_deg);
            estimate.add_variance(i, (share * estimate.forces_n[i]).powi(2));
        }
        let of_contact = estimate.alternatives.iter_mut().filter(|alternative| alternative.contact == i);
        of_contact.for_each(|alternative| alternative.widen_by(errors(alternative.position_mm)[0]));
    }
}
