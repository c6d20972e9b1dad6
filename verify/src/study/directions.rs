//! Where unknown directions can be told.

use crate::estimators::ELEMENTS;
use crate::experiments::direction::{DirectionRequest, DirectionStudy};
use crate::settings::{Effort, Progress};
use crate::truths::Truth;
use finray_model::sensing::SensingError;
use finray_model::{Finger, Mesh};

/// About how many places, degrees between two directions, and noise pictures a cell: seconds of work, most of them
/// for pictures that are refused after a search from every start.
const PLACES: usize = 12;
const STEP_DEG: f64 = 20.0;
const PICTURES: usize = 8;

/// Nothing without noise, which makes it a question, nor in a quick study.
pub(super) fn directions(
    truth: &dyn Truth,
    finger: &Finger,
    noise_mm: f64,
    effort: Effort,
    progress: &dyn Progress,
) -> Result<Option<DirectionStudy>, SensingError> {
    if effort == Effort::Quick || noise_mm == 0.0 {
        return Ok(None);
    }
    let model = Mesh::with_elements_per_member(finger, ELEMENTS);
    let request =
        DirectionRequest { model: &model, noise_mm, places: PLACES, step_deg: STEP_DEG, pictures: PICTURES, seed: 1 };
    progress.part("unknown directions", DirectionStudy::steps(&request));
    DirectionStudy::run(truth, &request, &|| progress.step()).map(Some)
}
