//! Objects pressed onto the finger.

use crate::experiments::contact_scene;
use crate::experiments::contact_scene::study::{SceneStudy, SceneStudyError, SceneWithOutline};
use crate::settings::{CAMERA_NOISE_MM, Effort, Progress};

/// Segments in a stretch of plate, and steps of the object, in the contact scene of a quick study.
const QUICK_FINENESS: usize = 2;
const QUICK_STEPS: usize = 3;

/// Contact scenes that are to be run.
pub(super) struct Objects {
    /// Each with the fineness of its lattice.
    scenes: Vec<(SceneWithOutline, usize)>,
    samples: usize,
}

impl Objects {
    /// The scene's own object, or for the paper's finger without one the scenes that ship.
    pub(super) fn of(given: &SceneWithOutline, is_paper: bool, effort: Effort) -> Result<Objects, SceneStudyError> {
        let mut scenes = match &given.scene.object {
            Some(_) => vec![(given.clone(), contact_scene::FINENESS)],
            None if is_paper => contact_scene::study::shipped()?,
            None => Vec::new(),
        };
        let mut samples = contact_scene::study::SAMPLES;
        if effort == Effort::Quick {
            // Samples of every step take longer than the rest of a quick study.
            samples = 0;
            scenes.truncate(1);
            for (given, fineness) in &mut scenes {
                *fineness = QUICK_FINENESS;
                if let Some(object) = &mut given.scene.object {
                    object.steps = object.steps.min(QUICK_STEPS);
                }
            }
        }
        Ok(Objects { scenes, samples })
    }

    /// How often progress is reported.
    pub(super) fn steps(&self) -> usize {
        self.scenes.iter().filter_map(|(given, _)| given.scene.object.as_ref()).map(|object| object.steps).sum()
    }

    /// Presses them onto the finger.
    pub(super) fn press(&self, progress: &dyn Progress) -> Result<Vec<SceneStudy>, SceneStudyError> {
        contact_scene::study::run_all(&self.scenes, CAMERA_NOISE_MM, self.samples, &|| progress.step())
    }
}
