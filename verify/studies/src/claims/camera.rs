//! Claims of the paper's sections IV-B and VI: the camera's position error.

use super::criteria::simulated;
use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::camera::CameraStudy;
use minijinja::context;
use std::f64::consts::SQRT_2;

/// Largest position error of the vision system as stated by the paper, mm.
const LARGEST_MM: f64 = 0.2;

/// Claim on the position error. The paper measured a real finger with a camera; here images are rendered with known light, lens and pose.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn position_error(camera: Option<&CameraStudy>, words: &Words) -> Result<Claim, ClaimError> {
    let tested = camera.and_then(|camera| {
        let row = camera.as_it_is()?;
        Some((row, camera.nodes.len(), row.displacement_largest_mm?, row.displacement_rms_mm?))
    });
    let Some((row, shapes, largest_mm, rms_mm)) = tested else {
        return words.claim("position-untested", ClaimVerdict::NotTested, context! {});
    };
    // Upper bound of a distance: both coordinates have their largest error.
    let position_mm = SQRT_2 * largest_mm;
    let verdict =
        if row.found == row.markers { simulated(position_mm, LARGEST_MM) } else { ClaimVerdict::NotReproduced };
    words.claim(
        "position",
        verdict,
        context! { largest_mm, rms_mm, position_mm, shapes, found => row.found, markers => row.markers, setting => row.setting },
    )
}
