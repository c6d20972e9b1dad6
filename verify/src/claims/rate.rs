//! The paper's frame rate against the time of our estimates.

use super::{Claim, ClaimVerdict, claim};
use crate::experiments::camera::FrameTimes;
use crate::experiments::speed_error::SpeedErrorPoint;
use crate::experiments::speed_error::recommendation::recommended;

/// Time of a frame at the paper's largest rate of 25 Hz, s (sec. IV-B and VI): that of its vision alone.
const FRAME_S: f64 = 0.04;

/// The paper's rate is that of its image processing, on its computer and in its images. Here images are rendered ones, on this computer: what can
/// be compared is whether estimating the forces would leave the vision that time.
pub fn sensing_rate(points: &[SpeedErrorPoint], images: Option<FrameTimes>) -> Claim {
    let row = |ours: String, how: String, verdict| {
        // What is not tested has no criterion.
        let criterion = if verdict == ClaimVerdict::Refuted { "the forces alone take longer than a frame" } else { "" };
        let words = "\"the maximum force sensing frequency herein cannot exceed 25 Hz\", as the vision takes \"about 40 ms\"; \"verified ... under a force \
                     sensing rate of 15 Hz\" (sec. IV-B, VI)";
        claim(words, "40 ms a frame", ours, how, criterion, verdict)
    };
    let Some(way) = recommended(points) else {
        return row(
            "-".to_owned(),
            "no setting that was timed has a model error within the noise".to_owned(),
            ClaimVerdict::NotTested,
        );
    };
    let of_frame = |point: &SpeedErrorPoint| {
        let tail =
            point.seconds_95.map_or_else(String::new, |seconds| format!(", 95 % within {:.2} ms", 1e3 * seconds));
        format!("{:.2} ms a frame ({:.2} % of 40 ms{tail})", 1e3 * point.seconds, 100.0 * point.seconds / FRAME_S)
    };
    let cold = way.cold.map_or_else(String::new, |cold| format!("; from a cold start {}", of_frame(cold)));
    let slowest = way.cold.map_or(way.one.seconds, |cold| cold.seconds.max(way.one.seconds));
    let images = images.map_or_else(String::new, |FrameTimes { search_s, track_s }| {
        let [search_ms, track_ms] = [search_s, track_s].map(|seconds| 1e3 * seconds);
        format!("; markers in a rendered image: {track_ms:.1} ms following the one before, {search_ms:.1} ms without")
    });
    row(
        format!("forces alone: {}{cold}{images}", of_frame(way.one)),
        format!(
            "{}, {}: median over the frames of one force moving over 0.3 to 3 N on the finest mesh, with camera noise, one core; preparing for a \
             contact takes {:.2} ms more, once. Neither the paper's images nor its computer were at hand, so its rate is not tested",
            way.one.model,
            way.one.setting,
            1e3 * way.one.preparation_seconds.unwrap_or(0.0)
        ),
        // Vision cannot be what bounds the rate if the forces alone take longer than a frame.
        if slowest < FRAME_S { ClaimVerdict::NotTested } else { ClaimVerdict::Refuted },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::speed_error::Task;
    use crate::experiments::speed_error::recommendation::tests::point;

    /// A rate without vision is never better than one with it.
    #[test]
    fn a_rate_without_vision_is_not_better() {
        let fast = sensing_rate(&[point(Task::SenseOne, 133, 1e-4, 0.01, 0.1)], None);
        assert_eq!(fast.verdict, ClaimVerdict::NotTested);
        assert!(
            fast.ours.contains("0.10 ms a frame (0.25 % of 40 ms, 95 % within 0.20 ms)")
                && fast.how.contains("not tested"),
            "{fast:?}"
        );
        let slow = sensing_rate(&[point(Task::SenseOne, 133, 0.05, 0.01, 0.1)], None);
        assert_eq!(slow.verdict, ClaimVerdict::Refuted);
        let biased = sensing_rate(&[point(Task::SenseOne, 25, 1e-4, 0.01, 3.0)], None);
        assert_eq!((biased.verdict, biased.ours.as_str()), (ClaimVerdict::NotTested, "-"));
    }
}
