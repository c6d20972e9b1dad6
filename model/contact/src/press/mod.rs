//! Contact scenes: the object of a scene is pressed onto its finger, a camera observes the nodes, and the forces are sensed.
//!
//! The camera observes the position and direction of each contact with noise, but not the contact force (module `camera`). Sensing gets the observed
//! contacts, the noisy displacements of the markers, and a bound of the friction coefficient (module `outline_estimator`). The sensed forces are
//! compared with the true forces. Presses are quasi-static equilibria on sufficiently fine meshes (module `refined`).

mod camera;
mod contacts;
mod outline_estimator;
mod refined;
mod rows;
mod run;

pub use camera::{baseline_mm, read_contact};
pub use contacts::{HalfSpan, SeenContact, seen_contacts};
pub use outline_estimator::{NotSensed, OutlineEstimator};
pub use refined::{Refinement, TOTAL_TOLERANCE, TotalChange};
pub use rows::{ForceRow, contacts_sensed, force_rows};
pub use run::{BALANCE_TOLERANCE, Press};

use crate::path::{PreparedObject, PressError};
use crate::pressing::Pressed;
use finray_model::finger::PlatePosition;
use finray_model::measurement::Measurement;
use finray_model::observation::Observation;
use finray_model::scene::ObjectDescription;
use finray_model::sensing::{ContactPosition, MeasuredContact};
use finray_model::statics::StaticsError;
use finray_model::validity::Validity;
use finray_model::{Finger, Load, Scene, Vector};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Standard deviation that estimators assume for a noise-free measurement, mm. If estimators assumed a smaller standard deviation, mesh errors of
/// micrometres would look like outliers.
pub const LEAST_STATED_MM: f64 = 0.01;

/// Message for a scene without an object.
pub const NO_OBJECT: &str =
    "line 1: object is missing: expected a table [object] with shape, at_mm and travel_mm or force_n";

/// A scene prepared for pressing: finger, object and assumed friction.
#[derive(Debug, Clone)]
pub struct ContactScene {
    /// The scene, [as simulated](Scene::as_simulated).
    scene: Scene,
    object: PreparedObject,
    /// Number of elements of each plate member; `None` for automatic refinement.
    elements: Option<usize>,
    /// Upper bound of the friction coefficient that sensing assumes, dimensionless.
    assumed_friction: f64,
    /// Flag that ends the press before its next step.
    stop: Arc<AtomicBool>,
}

/// Equilibrium of finger and object after one step of a contact scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneStep {
    /// Distance that the object has travelled so far, mm.
    pub travel_mm: f64,
    /// Distance between the object and its prescribed position, mm. The distance is positive if the finger's clamped end stops the object.
    pub stopped_mm: f64,
    /// Unit vector of the object's motion at the end of the step, in the finger frame.
    pub along: Vector,
    /// Equilibrium of finger and object.
    pub pressed: Pressed,
    /// Contacts as seen without noise, with their true forces.
    pub contacts: Vec<SeenContact>,
}

impl SceneStep {
    /// Sum of the forces that deform the finger (without those on the clamp), along the object's motion, N.
    pub fn total_n(&self) -> f64 {
        let felt = self.contacts.iter().filter(|seen| !seen.clamped);
        // Adding 0.0 turns -0.0, the sum of no floats, into 0.0.
        0.0 + felt.map(|seen| seen.force.dot(&self.along)).sum::<f64>()
    }

    /// Validity of the beam model under the true contact forces; `None` if the object presses on a rib, which carries no stated loads.
    ///
    /// # Errors
    /// [`StaticsError`] if the beams have no equilibrium under these forces.
    pub fn validity(&self, finger: &Finger) -> Result<Option<Validity>, StaticsError> {
        // A contact on a clamped part does not bend the finger.
        let bending: Vec<&SeenContact> = self.contacts.iter().filter(|seen| !seen.clamped).collect();
        if bending.iter().any(|seen| seen.wall.plate().is_none()) {
            return Ok(None);
        }
        let loads = bending.into_iter().filter_map(|seen| match seen.contact.position {
            ContactPosition::Node(node) => Some(Load::at_node(node, seen.force)),
            ContactPosition::At(PlatePosition { plate, s_mm }) => {
                let s_mm = s_mm.min(finger.plate_length_mm(plate));
                (s_mm > 0.0).then(|| Load::at_position(PlatePosition { plate, s_mm }, seen.force))
            }
        });
        Validity::under(finger, loads).map(Some)
    }
}

/// Forces sensed in one step of a contact scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedStep {
    /// Every contact that is not clamped, from base to tip.
    pub contacts: Vec<SensedContact>,
    /// Sum of the contact forces along the object's motion.
    pub total: SensedForce,
}

/// A contact as read by the camera, with the sensed force along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedContact {
    /// Position and direction as read by the camera, which sensing receives.
    pub read: MeasuredContact,
    /// True and sensed force along the normal.
    pub force: SensedForce,
}

/// A sensed force beside the true force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedForce {
    /// True force, N.
    pub true_n: f64,
    /// Sensed force, N.
    pub sensed_n: f64,
    /// Stated standard deviation, N.
    pub sigma_n: f64,
}

impl SensedForce {
    /// Relative error: sensed / true - 1.
    pub fn relative_error(&self) -> f64 {
        self.sensed_n / self.true_n - 1.0
    }

    /// Error in stated standard deviations.
    pub fn standardised_error(&self) -> f64 {
        (self.sensed_n - self.true_n) / self.sigma_n
    }
}

impl ContactScene {
    /// Prepares a scene for pressing, with its object in front of its finger. `corners` (mm) are a polygon's corners from its file; they are ignored
    /// for other outlines.
    ///
    /// # Errors
    /// [`PressError`] for an outline that cannot be pressed.
    pub fn new(scene: &Scene, object: &ObjectDescription, corners: &[Vector]) -> Result<ContactScene, PressError> {
        Ok(ContactScene {
            scene: scene.as_simulated(),
            object: PreparedObject::new(scene, object, corners)?,
            elements: None,
            assumed_friction: object.friction,
            stop: Arc::default(),
        })
    }

    /// The same scene on a mesh with exactly this number of elements in each member.
    pub fn with_fineness(self, elements: usize) -> ContactScene {
        ContactScene { elements: Some(elements), ..self }
    }

    /// The same scene with another bound of the friction coefficient for sensing; the default is the object's coefficient.
    pub fn with_assumed_friction(self, assumed_friction: f64) -> ContactScene {
        ContactScene { assumed_friction, ..self }
    }

    /// The same scene, whose press ends before its next step once the flag is set, with [`ContactError::Stopped`](crate::ContactError::Stopped).
    pub fn with_stop(self, stop: Arc<AtomicBool>) -> ContactScene {
        ContactScene { stop, ..self }
    }

    /// Whether the press shall end.
    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The finger of the scene.
    pub fn finger(&self) -> &Finger {
        &self.scene.finger
    }

    /// Number of steps.
    pub fn step_count(&self) -> usize {
        self.object.steps.len()
    }

    /// The scene, [as simulated](Scene::as_simulated).
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The object of the scene.
    pub fn object(&self) -> &PreparedObject {
        &self.object
    }

    /// Senses the forces of a step from observed key nodes and observed contacts. Key nodes and contacts are observed with noise of `noise_mm`
    /// (standard deviation of a coordinate, mm), drawn from `standard_normal`. Sensed forces lie within the cone of the assumed friction coefficient.
    /// `None` if no contact deforms the finger.
    ///
    /// # Errors
    /// [`NotSensed`] if the object touches more than the plates, or if the forces are not identifiable.
    pub fn sense(
        &self,
        step: &SceneStep,
        noise_mm: f64,
        mut standard_normal: impl FnMut() -> f64,
    ) -> Result<Option<SensedStep>, NotSensed> {
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
