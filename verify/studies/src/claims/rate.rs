//! Claim on the paper's frame rate, compared with the time of the estimators.

use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::camera::FrameTimes;
use crate::experiments::speed_error::SpeedErrorPoint;
use crate::experiments::speed_error::recommendation::recommended;
use minijinja::context;

/// Frame time at the paper's largest rate of 25 Hz, s (sec. IV-B and VI). In this time the paper only processes images.
const FRAME_S: f64 = 0.04;

/// Claim on the rate of sensing. The paper states the rate of image processing on its own computer. Therefore the test is only whether forces are
/// estimated within a frame time on this computer.
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
        let (ms, percent) = (1e3 * point.seconds, 100.0 * point.seconds / FRAME_S);
        context! { ms, percent, within_ms => point.seconds_95.map(|seconds| 1e3 * seconds) }
    };
    // If sensing the forces alone takes longer than a frame, vision does not limit the rate.
    let slower = way.cold.map_or(way.one.seconds, |cold| cold.seconds.max(way.one.seconds)) >= FRAME_S;
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
