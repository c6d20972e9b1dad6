//! The paper's frame rate against the time of our estimates.

use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::camera::FrameTimes;
use crate::experiments::speed_error::SpeedErrorPoint;
use crate::experiments::speed_error::recommendation::recommended;
use minijinja::context;

/// Time of a frame at the paper's largest rate of 25 Hz, s (sec. IV-B and VI): that of its vision alone.
const FRAME_S: f64 = 0.04;

/// The paper's rate is that of its image processing, on its computer and in its images. Here images are rendered ones, on this computer: what can
/// be compared is whether estimating the forces would leave the vision that time.
///
/// # Errors
/// [`ClaimError`] if its words lack a number.
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
    // Vision cannot be what bounds the rate if the forces alone take longer than a frame.
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
