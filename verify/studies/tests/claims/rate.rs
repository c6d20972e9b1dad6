//! Verdict on the paper's frame rate.

use crate::experiments::speed_error::point;
use finray_studies::claims::{ClaimVerdict, Words, rate};
use finray_studies::experiments::speed_error::{SpeedErrorPoint, Task};

/// A rate without vision is never better than one with it.
#[test]
fn a_rate_without_vision_is_not_better() {
    let words = Words::shipped().expect("words of the claims");
    let sensing_rate = |points: &[SpeedErrorPoint]| rate::sensing_rate(points, None, &words).expect("all numbers");
    let fast = sensing_rate(&[point(Task::SenseOne, 133, 1e-4, 0.01, 0.1)]);
    assert_eq!(fast.verdict, ClaimVerdict::NotTested);
    assert!(
        fast.ours.contains("0.10 ms a frame (0.25 % of 40 ms, 95 % within 0.20 ms)") && fast.how.contains("not tested"),
        "{fast:?}"
    );
    let slow = sensing_rate(&[point(Task::SenseOne, 133, 0.05, 0.01, 0.1)]);
    assert_eq!(slow.verdict, ClaimVerdict::Refuted);
    let biased = sensing_rate(&[point(Task::SenseOne, 25, 1e-4, 0.01, 3.0)]);
    assert_eq!((biased.verdict, biased.ours.as_str()), (ClaimVerdict::NotTested, "-"));
}
