//! Which way of sensing to run, and what it costs.

use super::super::format::{percent, time};
use super::in_words;
use crate::estimators::EstimatorId;
use crate::experiments::speed_error::recommendation::{LARGEST_BIAS_SIGMAS, Recommendation, recommended, ways};
use crate::experiments::speed_error::sensing::SENSED_N;
use crate::study::Study;

/// Time of one frame of the paper's camera at 25 Hz, s.
const CAMERA_FRAME_S: f64 = 0.04;

/// Which estimator to run, at which cost.
pub(super) fn cost(study: &Study) -> Option<String> {
    let all = ways(&study.speed_error);
    let [low, high] = SENSED_N;
    let Some(way) = recommended(&study.speed_error) else {
        return (!all.is_empty()).then(|| {
            format!(
                "No setting that was timed senses forces of {low} to {high} N along the normal with a model error within {LARGEST_BIAS_SIGMAS} standard \
                 deviations of the noise: finer meshes than these are needed."
            )
        });
    };
    let bias = way.bias_sigmas().map_or_else(String::new, |bias| {
        format!("; its model is off by {bias:.2} standard deviations of the noise at most")
    });
    let fastest = |estimator: EstimatorId, holds: bool| {
        let others = all.iter().filter(|other| other.one.estimator == Some(estimator) && other.holds() == holds);
        let faster = others.filter(|other| other.one.seconds < way.one.seconds);
        faster.min_by(|a, b| a.one.seconds.total_cmp(&b.one.seconds))
    };
    let network = fastest(EstimatorId::Network, true).map_or_else(String::new, |network| {
        format!(
            "; a network takes {} for contacts that it is trained for (mean error {})",
            time(network.one.seconds),
            percent(network.one.error)
        )
    });
    let models = [EstimatorId::LeastSquares, EstimatorId::Nonlinear, EstimatorId::Network];
    let faults = models.into_iter().filter_map(|model| fastest(model, false));
    let faults: Vec<String> =
        faults.map(|other| format!("{} ({}; {})", named(other), time(other.one.seconds), fault(other))).collect();
    let faster = if faults.is_empty() {
        String::new()
    } else {
        format!("; faster, but not to be trusted: {}", faults.join(", "))
    };
    let slowest =
        [Some(way.one), way.cold].into_iter().flatten().map(|point| point.seconds_95.unwrap_or(point.seconds));
    let camera = format!(
        "; of the 40 ms of a camera frame at 25 Hz that is {}, cold or warm, in 95 % of frames at most",
        percent(slowest.fold(0.0, f64::max) / CAMERA_FRAME_S)
    );
    Some(format!(
        "Along the normal, sense forces of {low} to {high} N by {}: {}{bias}{network}{faster}{camera}.",
        named(&way),
        times(&way),
    ))
}

fn named(way: &Recommendation) -> String {
    // Linear estimators are exact on any mesh, and a network has none.
    let mesh = if way.one.estimator == Some(EstimatorId::Nonlinear) {
        format!(" on {}", way.one.mesh())
    } else {
        String::new()
    };
    format!("{}{mesh}", way.one.estimator.map_or_else(|| way.one.model.clone(), in_words))
}

/// Times and errors of the recommended way.
fn times(way: &Recommendation) -> String {
    let tail =
        |seconds_95: Option<f64>| seconds_95.map_or_else(String::new, |s| format!(", 95 % within {}", time(s)));
    let mut said = format!("{} a frame{}", time(way.one.seconds), tail(way.one.seconds_95));
    if let Some(cold) = way.cold {
        said +=
            &format!(" from the frame before, {}{} from a cold start", time(cold.seconds), tail(cold.seconds_95));
    }
    if let Some(preparation) = way.one.preparation_seconds {
        said += &format!(", {} to prepare for a new contact", time(preparation));
    }
    said += &format!("; mean error {}", percent(way.one.error));
    if let Some(two) = way.neighbours {
        said += &format!(", of two neighbours {}", percent(two.error));
    }
    said
}

/// Why a way is not recommended.
fn fault(way: &Recommendation) -> String {
    let points = || [Some(way.one), way.neighbours].into_iter().flatten();
    let (failed, asked) =
        (points().map(|point| point.failed).sum::<usize>(), points().map(|point| point.asked).sum::<usize>());
    match way.bias_sigmas() {
        Some(bias) if bias > LARGEST_BIAS_SIGMAS => {
            format!("its model is off by up to {bias:.1} standard deviations of the noise")
        }
        Some(_) => format!("refused {failed} of {asked} frames"),
        None => "states no standard deviation".to_owned(),
    }
}
