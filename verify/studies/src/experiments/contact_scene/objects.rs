//! Contact scenes of the report: objects pressed onto the finger.

use super::study::{SAMPLES, SceneStudy, SceneStudyError, run_all, shipped};
use crate::experiments::{Context, Evidence};
use crate::prelude::*;

impl Evidence for SceneStudy {
    fn checks(&self, context: &Context) -> Vec<Check> {
        let ships = context.is_paper && context.given.scene.object.is_none();
        if ships { self.shipped_checks() } else { self.checks() }
    }
}

/// Largest number of steps of the object in a quick study.
const QUICK_STEPS: usize = 3;

/// Results of the scene's own object; for the paper's finger without an object, of the shipped contact scenes.
///
/// # Errors
/// [`SceneStudyError`] if a scene cannot be pressed.
pub(crate) fn run(context: &Context) -> Result<Vec<SceneStudy>, SceneStudyError> {
    let &Context { given, is_paper, effort, progress, .. } = context;
    let mut scenes = match &given.scene.object {
        Some(_) => vec![given.clone()],
        None if is_paper => shipped()?,
        None => Vec::new(),
    };
    let mut samples = SAMPLES;
    if effort == Effort::Quick {
        // Noise samples of every step would take longer than the rest of a quick study.
        samples = 0;
        scenes.truncate(1);
        for given in &mut scenes {
            if let Some(object) = &mut given.scene.object {
                object.steps = object.steps.min(QUICK_STEPS);
            }
        }
    }
    let steps = scenes.iter().filter_map(|given| given.scene.object.as_ref()).map(|object| object.steps).sum();
    progress.part("objects", steps);
    run_all(&scenes, CAMERA_NOISE_MM, samples, &|| progress.step())
}
