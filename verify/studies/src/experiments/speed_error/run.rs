//! Computes time and error of models and estimators for the report.

use super::sensing::{TimedEstimator, sensing};
use super::{ASKED_NODES, ExperimentError, SpeedErrorPoint, Start, solving};
use crate::experiments::{Context, Evidence};
use crate::prelude::*;

impl Evidence for SpeedErrorPoint {}

/// Times models and estimators one by one; no other computation may run at the same time.
///
/// # Errors
/// [`ExperimentError`] if a model or an estimator fails while it is timed.
pub fn run(context: &Context) -> Result<Vec<SpeedErrorPoint>, ExperimentError> {
    let &Context { finger, noise_mm, progress, .. } = context;
    let forces = context.checked_forces();
    progress.part("speed and error", 2);
    // Numbers of oscillation periods, for one force and for two forces. Sensing two forces on a finger that folds takes tens of milliseconds per
    // frame. The effort changes only these numbers and not the nodes, so that points of other programs are always comparable.
    let periods = match context.effort {
        Effort::Quick => [1, 4],
        Effort::Full => [2, 2 * ASKED_NODES],
    };
    // If the finger has no equilibrium under the loads, the points of the task `solve` are omitted; the maps show the missing equilibria.
    let mut points = match solving(finger, ASKED_NODES, forces) {
        Err(ExperimentError::Statics(StaticsError::NoEquilibrium { .. })) => Vec::new(),
        points => points?,
    };
    progress.step();
    if noise_mm > 0.0 {
        let options = SensorOptions { networks: context.networks.clone(), ..SensorOptions::of(EstimatorId::Network) };
        let network = TimedEstimator { options, setting: "shipped networks".to_owned(), start: Start::None };
        let further = if context.is_paper { vec![network] } else { Vec::new() };
        points.extend(sensing(context.fine, noise_mm, forces, periods, further)?);
    }
    progress.step();
    Ok(points)
}
