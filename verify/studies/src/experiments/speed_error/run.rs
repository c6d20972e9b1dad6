//! The points of a report.

use super::sensing::{TimedEstimator, sensing};
use super::{ASKED_NODES, ExperimentError, SpeedErrorPoint, Start, solving};
use crate::experiments::{Context, Evidence};
use crate::prelude::*;
use finray_model::estimators::network::NetworkSensing;

impl Evidence for SpeedErrorPoint {}

/// Times models and estimators, one after the other: nothing else may run beside them.
///
/// # Errors
/// [`ExperimentError`] if a model or an estimator fails where it is timed.
pub fn run(context: &Context) -> Result<Vec<SpeedErrorPoint>, ExperimentError> {
    let &Context { finger, noise_mm, progress, .. } = context;
    let forces = context.checked_forces();
    progress.part("speed and error", 2);
    // Nodes are the same for every effort, so that other programs always stand beside ours.
    // Periods of one force and of the pair. Two forces on a finger that folds take tens of milliseconds a frame.
    let periods = match context.effort {
        Effort::Quick => [1, 4],
        Effort::Full => [2, 2 * ASKED_NODES],
    };
    // What a finger does not carry leaves the chart out; the maps say so already.
    let mut points = match solving(finger, ASKED_NODES, forces) {
        Err(ExperimentError::Statics(StaticsError::NoEquilibrium { .. })) => Vec::new(),
        points => points?,
    };
    progress.step();
    if noise_mm > 0.0 {
        let network = NetworkSensing { networks: context.networks, finger, refuses: true };
        let network =
            TimedEstimator { estimator: Box::new(network), setting: "shipped networks".to_owned(), start: Start::None };
        let further = if context.is_paper { vec![network] } else { Vec::new() };
        points.extend(sensing(context.fine, noise_mm, forces, periods, further)?);
    }
    progress.step();
    Ok(points)
}
