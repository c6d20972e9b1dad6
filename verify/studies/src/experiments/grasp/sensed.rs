//! What a camera sees of a finger in a grasp, and the forces that are sensed from it.

use super::GraspScene;
use crate::experiments::contact_scene::{
    OutlineEstimator, SeenContact, SensedContact, SensedStep, TurnedOutline, baseline_mm, contacts_sensed,
    seen_contacts,
};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use finray_imaging::locate::Observer;
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_lattice::skin::Touch;
use finray_model::sensor::Refusal;
use nalgebra::Rotation2;
use std::borrow::Cow;

/// What sees the fingers.
#[derive(Debug, Clone)]
pub enum Eyes {
    /// Positions of the markers with noise of a standard deviation, mm, on each coordinate.
    Noise(f64),
    /// Images, one a finger. The camera stands before each finger as the scene has it, in the frame of the finger at its motor angle, or on the gripper,
    /// in its frame ([`GraspDescription::camera_on_gripper`](finray_model::scene::GraspDescription)). Points of outlines have the noise of a standard
    /// deviation, mm.
    Images {
        /// The camera.
        camera: Box<Camera>,
        /// The markers.
        markers: Markers,
        /// Noise of every channel of every pixel, grey levels of 255.
        grey_noise: f64,
        /// Blur, px.
        blur_px: f64,
        /// Standard deviation of a coordinate of a point of an outline, mm.
        outline_noise_mm: f64,
    },
}

impl Eyes {
    /// The same before a finger anywhere on the gripper, where the camera stands. Markers on a mirrored finger stand up to its other side.
    fn before(&self, finger: Option<&Placement>) -> Cow<'_, Eyes> {
        let mut eyes = Cow::Borrowed(self);
        if let (Some(placement), Eyes::Images { .. }) = (finger, self)
            && let Eyes::Images { camera, markers, .. } = eyes.to_mut()
        {
            camera.pose = camera.pose.of_placed_finger(placement);
            markers.height_mm *= if placement.mirrored { -1.0 } else { 1.0 };
        }
        eyes
    }

    /// Standard deviations of a coordinate of a marker and of a point of an outline, mm; `None` where observations state it.
    fn noise_mm(&self) -> [Option<f64>; 2] {
        match self {
            Eyes::Noise(noise_mm) => [Some(*noise_mm); 2],
            Eyes::Images { outline_noise_mm, .. } => [None, Some(*outline_noise_mm)],
        }
    }

    /// What is seen of the markers of a bent finger.
    fn observed(&self, finger: &Finger, shape: &FingerShape, noise: &mut Noise) -> Result<Observation, NotSensed> {
        let (camera, markers, disturbances) = match self {
            Eyes::Noise(noise_mm) => {
                let seen = noise.on(&Measurement::of_shape(finger, shape), *noise_mm);
                return Ok(Observation::of_displacements(&seen));
            }
            &Eyes::Images { ref camera, ref markers, grey_noise, blur_px, .. } => {
                let seed = (noise.evenly([0.0, 1.0]) * f64::from(u32::MAX)) as u64;
                (camera, markers, Disturbances { grey_noise, blur_px, seed, ..Disturbances::default() })
            }
        };
        let not_seen = |reason: &dyn std::fmt::Display| NotSensed::NotSeen(reason.to_string());
        let request = RenderRequest { camera, finger, shape, markers, references: &[], hidden: &[], disturbances };
        let image = render(&request).map_err(|error| not_seen(&error))?;
        let mut observer = Observer::with(finger, camera, markers, None).map_err(|error| not_seen(&error))?;
        observer.observe(&image).map_err(|error| not_seen(&error))
    }
}

/// A finger at rest in a grasp, before anything is sensed.
#[derive(Debug, Clone)]
pub struct SeenFinger {
    /// Its frame in the world.
    pub placement: Placement,
    /// The same in the frame of the gripper.
    pub in_gripper: Placement,
    /// Its shape.
    pub shape: FingerShape,
    /// What the object does to it, in its own frame.
    pub touches: Vec<Touch>,
    /// Position of the object, mm, and its angle, rad, in the world.
    pub object: [f64; 3],
    /// Unit vector from the object to the finger across the gripper, in the finger's frame.
    pub along: Vector,
    /// Force on the object, world, N.
    pub on_object: Vector,
}

/// A finger in a step of a grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerStep {
    /// Its frame in the world.
    pub placement: Placement,
    /// Its shape, in its own frame.
    pub shape: FingerShape,
    /// Contacts with their true forces, in its own frame, from base to tip.
    pub contacts: Vec<SeenContact>,
    /// Force on the object, N.
    pub on_object: Vector,
    /// Across the gripper, what it presses on the object with where it can be sensed (not at the clamp), N.
    pub total_n: f64,
    /// Forces sensed, and their sum across the gripper; nothing where nothing touches.
    pub sensed: Result<Option<SensedStep>, NotSensed>,
}

impl FingerStep {
    /// Contacts with what was sensed of each.
    pub fn contacts_sensed(&self) -> impl Iterator<Item = (&SeenContact, Option<SensedContact>)> {
        let sensed = self.sensed.as_ref().ok().and_then(Option::as_ref);
        contacts_sensed(&self.contacts, sensed)
    }

    /// The sensed sum across the gripper, N: nothing where nothing touches, `None` where it was refused.
    pub fn sensed_total_n(&self) -> Option<f64> {
        match &self.sensed {
            Ok(Some(sensed)) => Some(sensed.total.sensed_n),
            Ok(None) => Some(0.0),
            Err(_) => None,
        }
    }
}

impl GraspScene {
    /// Senses one finger.
    pub(super) fn sense(&self, lattice: &Lattice, seen: SeenFinger, eyes: &Eyes, noise: &mut Noise) -> FingerStep {
        let outline = self.outline_of(&seen);
        let finger = &self.scene.finger;
        let contacts = seen_contacts(lattice, &seen.touches, |touch| {
            let object = seen.placement.inwards(position(&seen));
            baseline_mm(finger, self.scene.contact.rod_radius_mm, &outline, object, touch)
        });
        let felt: Vec<SeenContact> = contacts.iter().filter(|contact| !contact.clamped).copied().collect();
        let total_n = 0.0 + felt.iter().map(|contact| contact.force.dot(&seen.along)).sum::<f64>();
        let mut sense = || {
            if felt.is_empty() {
                return Ok(None);
            }
            let on_gripper = self.grasp.camera_on_gripper.then_some(&seen.in_gripper);
            let eyes = eyes.before(on_gripper);
            let observation = eyes.observed(finger, &seen.shape, noise)?;
            let [marker_noise_mm, outline_noise_mm] = eyes.noise_mm();
            let estimator = OutlineEstimator {
                scene: &self.scene,
                friction: self.object.friction,
                marker_noise_mm,
                outline_noise_mm: outline_noise_mm.unwrap_or_default(),
                estimator: self.estimator.as_ref().map(|(id, networks)| (*id, networks)),
            };
            Ok(Some(estimator.sense(&felt, &observation, seen.along, || noise.standard_normal())?))
        };
        let sensed = sense();
        let SeenFinger { placement, shape, on_object, .. } = seen;
        FingerStep { placement, shape, contacts, on_object, total_n, sensed }
    }

    /// Outline of the object, about its own point, in the frame of a finger.
    fn outline_of(&self, seen: &SeenFinger) -> TurnedOutline {
        let (turn, axes) = (Rotation2::new(seen.object[2]), seen.placement.axes());
        match &self.outline {
            TurnedOutline::Disc(radius_mm) => TurnedOutline::Disc(*radius_mm),
            TurnedOutline::Polygon(corners) => {
                TurnedOutline::Polygon(corners.iter().map(|corner| axes.transpose() * (turn * corner)).collect())
            }
        }
    }
}

fn position(seen: &SeenFinger) -> Vector {
    Vector::new(seen.object[0], seen.object[1])
}

/// Why no force was sensed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotSensed {
    /// The sensor refuses.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The image does not show the finger.
    #[error("the image: {0}")]
    NotSeen(String),
}
