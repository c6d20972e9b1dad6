//! Contact scenes: an object is pressed onto the lattice finger, a camera watches the nodes, and sensing follows.
//!
//! The camera sees where the object touches and which way it faces there, with noise, and not how hard (`camera`). Sensing is
//! given these contacts, the noisy displacements of the markers and a bound of the friction coefficient (`outline_estimator`), and its
//! forces stand beside those of the contacts. Presses are quasi-static equilibria on lattices fine enough (`refined`); rapier verifies them (`verified`).

mod camera;
pub mod checks;
mod contacts;
pub mod file;
mod object;
pub mod objects;
mod outline_estimator;
pub mod refined;
mod rows;
pub mod samples;
pub mod study;
mod verified;

pub use camera::{baseline_mm, read_contact};
pub use contacts::{HalfSpan, SeenContact, angle_deg, seen_contacts};
pub use object::{HandStep, OutlineError, PreparedObject, TurnedOutline};
pub use outline_estimator::OutlineEstimator;
pub use refined::{Refinement, TotalChange};
pub use rows::{ForceRow, contacts_sensed, force_rows};
pub use verified::{EngineDifference, VerifiedStep};

use crate::prelude::*;
use finray_lattice::pressing::Pressed;
use finray_model::measurement::MarkerErrors;
use finray_model::scene::ContactDescription;
use finray_model::sensing::MeasuredContact;
use finray_model::sensor::Refusal;

/// Segments of plate between two rods on which rapier verifies: the paper's finger under 5 N is then within 0.1 % of converged beams.
pub const FINENESS: usize = 3;

/// A scene's finger as a simulation has it: forces act on the bare plate, displacements count from a known base, and nothing is stated of their errors.
pub fn simulated(scene: &Scene) -> Scene {
    Scene {
        noise_mm: None,
        marker_errors: MarkerErrors::default(),
        base: None,
        contact: ContactDescription { rod_radius_mm: scene.contact.rod_radius_mm, ..ContactDescription::default() },
        touched: None,
        ..scene.clone()
    }
}

/// What a scene needs to be run: finger, object, camera.
#[derive(Debug, Clone)]
pub struct ContactScene {
    /// As it is [`simulated`].
    scene: Scene,
    object: PreparedObject,
    /// Segments in a plate member of mean length, if asked for.
    fineness: Option<usize>,
    /// Bound of the coefficient of friction that sensing assumes.
    assumed_friction: f64,
}

/// One step of a scene, at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneStep {
    /// Length of the way that the object has come, mm.
    pub travel_mm: f64,
    /// How far the clamped end of the finger keeps the object from its prescribed position, mm.
    pub stopped_mm: f64,
    /// Unit vector of the way that the step ends on.
    pub along: Vector,
    /// Finger and object.
    pub pressed: Pressed,
    /// Contacts in front of the camera, without its noise, with their true forces.
    pub contacts: Vec<SeenContact>,
}

impl SceneStep {
    /// Sum of the forces that the finger can feel (not those on the clamp), along the object's way, N.
    pub fn total_n(&self) -> f64 {
        let felt = self.contacts.iter().filter(|seen| !seen.clamped);
        // An empty sum of floats is -0.
        0.0 + felt.map(|seen| seen.force.dot(&self.along)).sum::<f64>()
    }
}

/// Forces sensed in one step.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedStep {
    /// Each contact that is not clamped, from base to tip.
    pub contacts: Vec<SensedContact>,
    /// The sum of their forces along the object's way.
    pub total: SensedForce,
}

/// A contact as the camera read it, and the force along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedContact {
    /// Position and direction that sensing was given.
    pub read: MeasuredContact,
    /// The force.
    pub force: SensedForce,
}

/// A sensed force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedForce {
    /// True, N.
    pub true_n: f64,
    /// Sensed, N.
    pub sensed_n: f64,
    /// Stated standard deviation, N.
    pub sigma_n: f64,
}

impl SensedForce {
    /// Sensed over true, less one.
    pub fn relative_error(&self) -> f64 {
        self.sensed_n / self.true_n - 1.0
    }

    /// The error in stated standard deviations.
    pub fn standardised_error(&self) -> f64 {
        (self.sensed_n - self.true_n) / self.sigma_n
    }
}

impl ContactScene {
    /// Prepares a scene's object in front of its finger; `corners` (mm) are those of a polygon's file, unused otherwise.
    ///
    /// # Errors
    /// [`OutlineError`] for corners that are no outline.
    pub fn new(scene: &Scene, object: &ObjectDescription, corners: &[Vector]) -> Result<ContactScene, OutlineError> {
        Ok(ContactScene {
            scene: simulated(scene),
            object: PreparedObject::new(scene, object, corners)?,
            fineness: None,
            assumed_friction: object.friction,
        })
    }

    /// The same scene on a lattice with so many segments in a plate member of mean length, however coarse that is.
    pub fn with_fineness(self, fineness: usize) -> ContactScene {
        ContactScene { fineness: Some(fineness), ..self }
    }

    /// The same scene with another bound of the coefficient of friction for sensing, which otherwise knows the object's.
    pub fn with_assumed_friction(self, assumed_friction: f64) -> ContactScene {
        ContactScene { assumed_friction, ..self }
    }

    /// The finger.
    pub fn finger(&self) -> &Finger {
        &self.scene.finger
    }

    /// Steps that it has.
    pub fn step_count(&self) -> usize {
        self.object.steps.len()
    }

    /// The object.
    pub fn object(&self) -> &PreparedObject {
        &self.object
    }

    /// Senses the forces of a step from what the camera sees: the key nodes, and the contacts, both with noise of a standard deviation
    /// `noise_mm` a coordinate from `standard_normal`. Forces lie within the cone of the assumed friction. `None` where nothing touches.
    ///
    /// # Errors
    /// [`Refusal`] if they are not identifiable.
    pub fn sense(
        &self,
        step: &SceneStep,
        noise_mm: f64,
        mut standard_normal: impl FnMut() -> f64,
    ) -> Result<Option<SensedStep>, Refusal> {
        let felt: Vec<SeenContact> = step.contacts.iter().filter(|contact| !contact.clamped).copied().collect();
        if felt.is_empty() {
            return Ok(None);
        }
        let mut seen = Measurement::of_shape(self.finger(), &step.pressed.shape);
        seen.add_noise(noise_mm, &mut standard_normal);
        let estimator = OutlineEstimator {
            scene: &self.scene,
            friction: self.assumed_friction,
            marker_noise_mm: Some(noise_mm),
            outline_noise_mm: noise_mm,
            estimator: None,
        };
        let seen = Observation::of_displacements(&seen);
        estimator.sense(&felt, &seen, step.along, standard_normal).map(Some)
    }
}
