//! Time and error of models and estimators.

use super::{Effort, Progress, StudyError};
use crate::estimators::Estimator;
use crate::networks::accuracy;
use crate::networks::{NetworkSensing, Networks};
use crate::speed_error::{self, SpeedErrorError, SpeedErrorPoint};
use finray_model::statics::StaticsError;
use finray_model::{Finger, Mesh};

/// Times models and estimators, one after the other: nothing else may run beside them.
pub(super) fn time_and_compare(
    finger: &Finger,
    fine: &Mesh,
    noise_mm: f64,
    is_paper: bool,
    effort: Effort,
    progress: &dyn Progress,
) -> Result<Vec<SpeedErrorPoint>, StudyError> {
    let (nodes, pictures) = match effort {
        Effort::Quick => (3, 10),
        Effort::Full => (11, 40),
    };
    // What a finger does not carry leaves the chart out; the maps say so already.
    let mut points = match speed_error::solving(finger, nodes) {
        Err(SpeedErrorError::Statics(StaticsError::NoEquilibrium { .. })) => Vec::new(),
        points => points?,
    };
    progress.step();
    if noise_mm > 0.0 {
        let shipped = Networks::shipped()?;
        let sensing = NetworkSensing { name: accuracy::NAME, networks: &shipped, finger, refuses: true };
        let further: &[(&dyn Estimator, &str)] = if is_paper { &[(&sensing, "ships")] } else { &[] };
        points.extend(speed_error::sensing(fine, noise_mm, nodes, pictures, further)?);
    }
    progress.step();
    Ok(points)
}
