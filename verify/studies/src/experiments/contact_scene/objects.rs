//! Contact scenes of the report: objects pressed onto the finger.

use super::study::{SAMPLES, SceneStudy, SceneStudyError, SceneWithOutline, run_all, shipped};
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

/// Contact scenes that a report runs.
pub struct Objects {
    scenes: Vec<SceneWithOutline>,
    samples: usize,
}

impl Objects {
    /// Contact scene with the scene's own object; for the paper's finger without an object, the shipped contact scenes.
    pub(crate) fn of(context: &Context) -> Result<Objects, SceneStudyError> {
        let &Context { given, is_paper, effort, .. } = context;
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
        Ok(Objects { scenes, samples })
    }

    /// Number of times that `press` reports progress.
    pub fn steps(&self) -> usize {
        self.scenes.iter().filter_map(|given| given.scene.object.as_ref()).map(|object| object.steps).sum()
    }

    pub(crate) fn press(&self, progress: &dyn Progress) -> Result<Vec<SceneStudy>, SceneStudyError> {
        run_all(&self.scenes, CAMERA_NOISE_MM, self.samples, &|| progress.step())
    }
}
