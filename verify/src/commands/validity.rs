//! Warnings where the assumptions of the beam model do not hold: large strains, shear, bending out of the plane.

use super::print_message;
use finray_model::Scene;
use finray_model::sensor::{SensedForces, Sensor};
use finray_model::statics::StaticsError;
use finray_model::validity::Doubt;
use finray_studies::experiments::contact_scene::SceneStep;

/// Warns if the co-rotational finger violates the assumptions of the beam model under the sensed forces.
pub fn warn_of_forces(sensor: &Sensor, sensed: &SensedForces) {
    match sensor.doubts(sensed) {
        Ok(doubts) => warn("", &doubts),
        Err(error) => {
            print_message(format_args!("warning: the finger has no equilibrium under the sensed forces: {error}"))
        }
    }
}

/// The step of a press at which a strain of the finger is largest relative to the limit of its material. Strains are those of beams under the true forces.
#[derive(Default)]
pub struct Pressing {
    steps: usize,
    worst: Option<(f64, usize, Vec<Doubt>)>,
    unsolved: Option<(usize, StaticsError)>,
}

impl Pressing {
    /// Computes the strains of the next step. Keeps the step if its largest strain, relative to the limit, is the largest so far.
    pub fn examine(&mut self, scene: &Scene, step: &SceneStep) {
        self.steps += 1;
        match step.validity(&scene.finger) {
            Ok(validity) => {
                let strain = validity.largest_strain(&scene.strain_limits);
                let share = strain.map_or(0.0, |at| at.strain / scene.strain_limits.of(at.member.part));
                if self.worst.as_ref().is_none_or(|(most, ..)| share >= *most) {
                    self.worst = Some((share, self.steps, validity.doubts(&scene.strain_limits)));
                }
            }
            Err(error) => self.unsolved = self.unsolved.take().or(Some((self.steps, error))),
        }
    }

    /// Prints the warnings about the step with the largest strain.
    pub fn warn(&self) {
        if let Some((step, error)) = &self.unsolved {
            print_message(format_args!(
                "warning: step {step}: the beam model has no equilibrium under the contact forces: {error}"
            ));
        }
        if let Some((_, step, doubts)) = &self.worst {
            warn(&format!("step {step}: "), doubts);
        }
    }
}

/// Prints a warning for each violated assumption of the beam model, with `of` before it. The result is still written, so the exit code is 0.
pub fn warn(of: &str, doubts: &[Doubt]) {
    for doubt in doubts {
        print_message(format_args!("warning: {of}{doubt}"));
    }
}
