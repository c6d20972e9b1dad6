//! Claims of the paper's sections IV-B and VI: the camera's position error, and its frame rate compared with the time of the estimators.

use super::criteria::simulated;
use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::camera::{CameraStudy, FrameTimes};
use crate::experiments::speed_error::SpeedErrorPoint;
use crate::experiments::speed_error::recommendation::recommended;
use crate::settings::CAMERA_FRAME_S;
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
    // Upper bound of the distance error, reached if both coordinates have their largest error.
    let position_mm = SQRT_2 * largest_mm;
    let verdict =
        if row.found == row.markers { simulated(position_mm, LARGEST_MM) } else { ClaimVerdict::NotReproduced };
    words.claim(
        "position",
        verdict,
        context! { largest_mm, rms_mm, position_mm, shapes, found => row.found, markers => row.markers, setting => row.setting },
    )
}

/// Claim on the rate of sensing. The paper states the rate of image processing on the authors' computer. The check of this claim only tests whether
/// this computer estimates forces within one frame time.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn sensing_rate(
    points: &[SpeedErrorPoint],
    images: Option<FrameTimes>,
    words: &Words,
) -> Result<Claim, ClaimError> {
    let Some(way) = recommended(points) else {
        return words.claim("rate-untested", ClaimVerdict::NotTested, context! {});
    };
    let of_frame = |point: &SpeedErrorPoint| {
        let (ms, percent) = (1e3 * point.seconds, 100.0 * point.seconds / CAMERA_FRAME_S);
        context! { ms, percent, within_ms => point.seconds_95.map(|seconds| 1e3 * seconds) }
    };
    // If sensing the forces alone takes longer than a frame, vision does not limit the rate.
    let slower = way.cold.map_or(way.one.seconds, |cold| cold.seconds.max(way.one.seconds)) >= CAMERA_FRAME_S;
    let numbers = context! {
        one => of_frame(way.one),
        cold => way.cold.map(of_frame),
        images => images.map(|of| context! { search_ms => 1e3 * of.search_s, track_ms => 1e3 * of.track_s }),
        model => way.one.model.as_str(),
        setting => way.one.setting.as_str(),
        preparation_ms => 1e3 * way.one.preparation_seconds.unwrap_or(0.0),
        slower,
    };
    words.claim("rate", if slower { ClaimVerdict::Refuted } else { ClaimVerdict::NotTested }, numbers)
}
