//! A press as `finray press` runs it: forces sensed at each step, with notes and warnings in words.

use super::{ContactScene, ForceRow, NotSensed, Refinement, SceneStep, TOTAL_TOLERANCE, TotalChange, force_rows};
use crate::ContactError;
use finray_model::Scene;
use finray_model::statics::StaticsError;
use finray_model::validity::ValidityWarning;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Tolerance of the difference between contact forces and forces on the clamps, relative to the sum of contact forces; it allows for rounding.
pub const BALANCE_TOLERANCE: f64 = 1e-6;

/// A press warns if the object stops farther than this distance from its prescribed position, mm. Rounding alone causes a smaller distance.
const STOPPED_MM: f64 = 1e-6;

/// All steps of a press, with true and sensed forces.
#[derive(Debug, Clone)]
pub struct Press {
    /// Steps up to the end of the press, or up to a failure.
    pub steps: Vec<SceneStep>,
    /// True and sensed forces, one row for each contact and one for the total of each step.
    pub rows: Vec<ForceRow>,
    /// Warning about a coarse mesh, or the reason of a premature end.
    pub ended: Result<Option<String>, ContactError>,
    validity: PressValidity,
}

impl Press {
    /// Presses the object of a scene onto its finger, and senses the forces at each step. Displacements and outline points have noise of `noise_mm`
    /// (standard deviation of a coordinate, mm) from `seed`. Each call of `each` receives the notes of one step, and the number of steps.
    pub fn run(
        scene: &Scene,
        prepared: &ContactScene,
        noise_mm: f64,
        seed: u64,
        mut each: impl FnMut(&[String], usize),
    ) -> Press {
        let mut noise = ChaCha8Rng::seed_from_u64(seed);
        let mut steps = Vec::new();
        let outcome = prepared.run(|step| steps.push(step));
        let (mut rows, mut validity) = (Vec::new(), PressValidity::default());
        for (number, step) in (1..).zip(&steps).take_while(|_| !prepared.is_stopped()) {
            let sensed = prepared.sense(step, noise_mm, || StandardNormal.sample(&mut noise));
            each(&notes(number, step, sensed.as_ref().err()), steps.len());
            rows.extend(force_rows(prepared, number, step, sensed.ok().flatten().as_ref()));
            validity.examine(scene, step);
        }
        Press { steps, rows, ended: outcome.map(|refinement| coarse(&refinement)), validity }
    }

    /// Warnings about steps in which the beam model does not hold.
    pub fn validity_warnings(&self) -> Vec<String> {
        self.validity.warnings()
    }
}

/// Notes and warnings about a step; `refusal` is the reason why its forces were not sensed.
fn notes(number: usize, step: &SceneStep, refusal: Option<&NotSensed>) -> Vec<String> {
    let refused = refusal.map(|refusal| format!("note: step {number}: {refusal}"));
    let imbalance = step.pressed.imbalance().filter(|imbalance| *imbalance > BALANCE_TOLERANCE);
    let imbalance = imbalance.map(|imbalance| {
        format!(
            "note: step {number}: contact forces and the reaction at the base differ by {imbalance:.1e} times the \
                contact forces"
        )
    });
    let stopped = (step.stopped_mm > STOPPED_MM).then(|| {
        format!(
            "warning: step {number}: the clamped end of the finger stops the object {:.3} mm before its prescribed position",
            step.stopped_mm
        )
    });
    refused.into_iter().chain(imbalance).chain(stopped).collect()
}

/// Warning about a coarse mesh.
fn coarse(refinement: &Refinement) -> Option<String> {
    let Refinement { elements, change } = refinement;
    let TotalChange { step, share } = change.filter(|change| change.share > TOTAL_TOLERANCE)?;
    let differ = format!("with half as many elements, the total force differs by {:.1} %", 100.0 * share);
    Some(format!("warning: step {step}: a mesh of {elements} elements per member is coarse: {differ}"))
}

/// The step of a press at which a strain of the finger is largest relative to the limit of its material. Strains are those of beams under the true forces.
#[derive(Debug, Clone, Default)]
struct PressValidity {
    steps: usize,
    worst: Option<(f64, usize, Vec<ValidityWarning>)>,
    unsolved: Option<(usize, StaticsError)>,
}

impl PressValidity {
    /// Computes the strains of the next step. Keeps the step if its largest strain, relative to the limit, is the largest so far.
    fn examine(&mut self, scene: &Scene, step: &SceneStep) {
        self.steps += 1;
        match step.validity(&scene.finger) {
            Ok(None) => {}
            Ok(Some(validity)) => {
                let strain = validity.largest_strain(&scene.strain_limits);
                let share = strain.map_or(0.0, |at| at.strain / scene.strain_limits.of(at.member.part));
                if self.worst.as_ref().is_none_or(|(most, ..)| share >= *most) {
                    self.worst = Some((share, self.steps, validity.warnings(&scene.strain_limits)));
                }
            }
            Err(error) => self.unsolved = self.unsolved.take().or(Some((self.steps, error))),
        }
    }

    /// Warnings about the first step in which the beams have no equilibrium, and about the step with the largest strain.
    fn warnings(&self) -> Vec<String> {
        let unsolved = self.unsolved.iter().map(|(step, error)| {
            format!("warning: step {step}: the beam model has no equilibrium under the contact forces: {error}")
        });
        let worst = self.worst.iter().flat_map(|(_, step, warnings)| {
            warnings.iter().map(move |warning| format!("warning: step {step}: {warning}"))
        });
        unsolved.chain(worst).collect()
    }
}
