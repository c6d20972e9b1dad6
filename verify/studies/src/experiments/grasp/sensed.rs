//! Observation of a finger in a grasp by a camera, and the forces sensed from this observation.

use super::GraspScene;
use crate::prelude::*;
use crate::sampling::noise::Noise;
use finray_contact::Touch;
use finray_contact::outline::ContactOutline;
use finray_contact::press::{
    OutlineEstimator, SeenContact, SensedContact, SensedStep, baseline_mm, contacts_sensed, seen_contacts,
};
use finray_imaging::locate::Observer;
use finray_imaging::render::{Disturbances, RenderRequest, render};
use image::RgbImage;
use nalgebra::Rotation2;
use std::borrow::Cow;

/// Method by which the fingers of a gripper are observed.
#[derive(Debug, Clone)]
pub enum Eyes {
    /// Marker positions with noise of this standard deviation (mm) on each coordinate.
    Noise(f64),
    /// Images, one for each finger. The pose of the camera is relative to each finger's frame, which follows from the motor angle. If the camera is
    /// on the gripper ([`GraspDescription::camera_on_gripper`](finray_model::scene::GraspDescription)), the pose is relative to the gripper's frame.
    Images {
        /// The camera; its pose is relative to the finger or the gripper.
        camera: Box<Camera>,
        /// The markers of the finger.
        markers: Markers,
        /// Standard deviation of the noise of every channel of every pixel, in grey levels (0 to 255).
        grey_noise: f64,
        /// Standard deviation of the blur, px.
        blur_px: f64,
        /// Standard deviation of a coordinate of an outline point, mm.
        outline_noise_mm: f64,
        /// Whether fingers without contact are also rendered. No force is sensed from the image of a finger without contact.
        renders_free: bool,
    },
}

impl Eyes {
    /// Converts a camera on the gripper to the frame of a finger. On a mirrored finger the markers are on the other side.
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

    /// Standard deviations of a coordinate of a marker and of an outline point, mm; `None` if the observations state the standard deviation.
    fn noise_mm(&self) -> [Option<f64>; 2] {
        match self {
            Eyes::Noise(noise_mm) => [Some(*noise_mm); 2],
            Eyes::Images { outline_noise_mm, .. } => [None, Some(*outline_noise_mm)],
        }
    }

    /// Renders the image of a finger. `None` without a camera, or for a finger without contact if `renders_free` is false. Fails if the camera does
    /// not see the finger. Each image draws one number from `noise`, even if it is not rendered, so the noise of the other images remains the same.
    fn image(
        &self,
        finger: &Finger,
        shape: &FingerShape,
        is_free: bool,
        noise: &mut Noise,
    ) -> Option<Result<RgbImage, NotSensed>> {
        let &Eyes::Images { ref camera, ref markers, grey_noise, blur_px, renders_free, .. } = self else {
            return None;
        };
        let seed = (noise.evenly([0.0, 1.0]) * f64::from(u32::MAX)) as u64;
        let disturbances = Disturbances { grey_noise, blur_px, seed, ..Disturbances::default() };
        let request = RenderRequest { disturbances, ..RenderRequest::of(camera, finger, shape, markers) };
        (renders_free || !is_free).then(|| render(&request).map_err(not_seen))
    }

    /// Observes the markers of a deformed finger; if there is a camera, in the finger's image. Fails if the image does not show the finger.
    fn observed(
        &self,
        finger: &Finger,
        shape: &FingerShape,
        image: Option<&Result<RgbImage, NotSensed>>,
        noise: &mut Noise,
    ) -> Result<Observation, NotSensed> {
        match (self, image) {
            (Eyes::Noise(noise_mm), _) => {
                let seen = noise.on(&Measurement::of_shape(finger, shape), *noise_mm);
                Ok(Observation::of_displacements(&seen))
            }
            (Eyes::Images { camera, markers, .. }, Some(image)) => {
                let image = image.as_ref().map_err(Clone::clone)?;
                let mut observer = Observer::with(finger, camera, markers, None).map_err(not_seen)?;
                observer.observe(image).map_err(not_seen)
            }
            (Eyes::Images { .. }, None) => Err(not_seen("no image was rendered")),
        }
    }
}

fn not_seen(reason: impl std::fmt::Display) -> NotSensed {
    NotSensed::NotSeen(reason.to_string())
}

/// A finger at rest in a grasp, before sensing.
#[derive(Debug, Clone)]
pub struct SeenFinger {
    /// Frame of the finger in the world.
    pub placement: Placement,
    /// Frame of the finger relative to the gripper's frame.
    pub in_gripper: Placement,
    /// Shape of the finger.
    pub shape: FingerShape,
    /// Contacts at which the object touches the finger, in the finger's frame.
    pub touches: Vec<Touch>,
    /// Position (mm) and angle (rad) of the object in the world.
    pub object: [f64; 3],
    /// Unit vector from the object to the finger, across the gripper, in the finger's frame.
    pub along: Vector,
    /// Force of the finger on the object in the world frame, N.
    pub on_object: Vector,
}

/// A finger in a step of a grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerStep {
    /// Frame of the finger in the world.
    pub placement: Placement,
    /// Shape of the finger, in its own frame.
    pub shape: FingerShape,
    /// Contacts with their true forces, in the finger's frame, from base to tip.
    pub contacts: Vec<SeenContact>,
    /// Force of the finger on the object in the world frame, N.
    pub on_object: Vector,
    /// Total force across the gripper, N, without contacts at the clamp, whose forces cannot be sensed.
    pub total_n: f64,
    /// Sensed forces, and their sum across the gripper; `None` if no contact deforms the finger.
    pub sensed: Result<Option<SensedStep>, NotSensed>,
}

impl FingerStep {
    /// Contacts, each with its sensed force.
    pub fn contacts_sensed(&self) -> impl Iterator<Item = (&SeenContact, Option<SensedContact>)> {
        let sensed = self.sensed.as_ref().ok().and_then(Option::as_ref);
        contacts_sensed(&self.contacts, sensed)
    }

    /// Sensed sum across the gripper, N: 0 without contact, `None` if sensing was refused.
    pub fn sensed_total_n(&self) -> Option<f64> {
        match &self.sensed {
            Ok(Some(sensed)) => Some(sensed.total.sensed_n),
            Ok(None) => Some(0.0),
            Err(_) => None,
        }
    }
}

impl GraspScene {
    /// Senses the forces on a finger. Also returns the finger's image, if the image was rendered.
    pub(super) fn sense(&self, seen: SeenFinger, eyes: &Eyes, noise: &mut Noise) -> (FingerStep, Option<RgbImage>) {
        let outline = self.outline_of(&seen);
        let finger = &self.scene.finger;
        let contacts = seen_contacts(finger, &seen.touches, |touch| {
            let object = seen.placement.inwards(position(&seen));
            baseline_mm(finger, self.scene.contact.rod_radius_mm, &outline, object, touch)
        });
        let felt: Vec<SeenContact> = contacts.iter().filter(|contact| !contact.clamped).copied().collect();
        let total_n = 0.0 + felt.iter().map(|contact| contact.force.dot(&seen.along)).sum::<f64>();
        let on_gripper = self.grasp.camera_on_gripper.then_some(&seen.in_gripper);
        let eyes = eyes.before(on_gripper);
        let image = eyes.image(finger, &seen.shape, felt.is_empty(), noise);
        let mut sense = || {
            if felt.is_empty() {
                return Ok(None);
            }
            let observation = eyes.observed(finger, &seen.shape, image.as_ref(), noise)?;
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
        (FingerStep { placement, shape, contacts, on_object, total_n, sensed }, image.and_then(Result::ok))
    }

    /// Outline of the object about its reference point, in the frame of a finger.
    fn outline_of(&self, seen: &SeenFinger) -> ContactOutline {
        let turn = Rotation2::new(seen.object[2]).into_inner();
        self.shape.mapped(seen.placement.axes().transpose() * turn)
    }
}

fn position(seen: &SeenFinger) -> Vector {
    Vector::new(seen.object[0], seen.object[1])
}

/// Why no force was sensed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotSensed {
    /// The forces are not sensed.
    #[error(transparent)]
    Refused(#[from] finray_contact::press::NotSensed),
    /// The image does not show the finger.
    #[error("the image does not show the finger: {0}")]
    NotSeen(String),
}
