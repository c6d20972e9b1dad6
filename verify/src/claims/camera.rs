//! Sections IV-B and VI: the camera's error of position.

use super::criteria::simulated;
use super::{Claim, ClaimVerdict, claim};
use crate::experiments::camera::CameraStudy;
use std::f64::consts::SQRT_2;

/// Largest error of the paper's vision, mm.
const LARGEST_MM: f64 = 0.2;

/// The paper measured a real finger, in a camera's images; ours are rendered, of a finger whose light, lens and pose are known.
pub fn position_error(camera: Option<&CameraStudy>) -> Claim {
    let words = "\"the maximum error of the proposed vision-based measuring system is less than 0.2 mm\" (sec. IV-B)";
    let tested = camera.and_then(|camera| {
        let row = camera.as_it_is()?;
        Some((row, camera.nodes.len(), row.displacement_largest_mm?, row.displacement_rms_mm?))
    });
    let Some((row, shapes, largest_mm, rms_mm)) = tested else {
        return claim(words, "0.2 mm", "-", "no image was searched", "", ClaimVerdict::NotTested);
    };
    // Both coordinates at their largest.
    let position_mm = SQRT_2 * largest_mm;
    claim(
        words,
        "0.2 mm",
        format!(
            "largest error of a coordinate {largest_mm:.4} mm, {rms_mm:.4} mm rms; of a position at most {position_mm:.4} mm"
        ),
        format!(
            "{} of {} markers found in rendered images of {shapes} shapes of a simulated finger ({}); lens, pose and height are known. The noise of \
             this report takes 0.2 mm as three standard deviations of a coordinate",
            row.found, row.markers, row.setting
        ),
        "a position off by less than 0.2 mm at most, and every marker found",
        if row.found == row.markers { simulated(position_mm, LARGEST_MM) } else { ClaimVerdict::NotReproduced },
    )
}
