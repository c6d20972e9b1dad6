//! What a camera sees of a finger in a grasp, and the forces that are sensed from it.

use super::GraspScene;
use crate::estimators::EstimatorError;
use crate::experiments::contact_scene::{
    OutlineEstimator, SeenContact, SensedContact, SensedStep, TurnedOutline, baseline_mm, seen_contacts,
};
use crate::sampling::noise::Noise;
use finray_imaging::locate::Locator;
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_lattice::Lattice;
use finray_lattice::skin::Touch;
use finray_model::camera::Camera;
use finray_model::gripper::Placement;
use finray_model::measurement::{Marker, Measurement};
use finray_model::mesh::FingerShape;
use finray_model::scene::Markers;
use finray_model::sensing::SensingError;
use finray_model::{Finger, Vector};
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
    /// The same before a finger that stands somewhere on the gripper, where the camera stands on it. Markers on a mirrored finger, which is one turned
    /// about its axis, stand up to its other side.
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
        let mut felt = sensed.map(|sensed| sensed.contacts.iter().copied()).into_iter().flatten();
        self.contacts.iter().map(move |seen| (seen, if seen.clamped { None } else { felt.next() }))
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
        let rod_radius_mm = self.contact.rod_radius_mm;
        let contacts = seen_contacts(lattice, &seen.touches, |touch| {
            baseline_mm(&self.finger, rod_radius_mm, &outline, seen.placement.inwards(position(&seen)), touch)
        });
        let felt: Vec<SeenContact> = contacts.iter().filter(|contact| !contact.clamped).copied().collect();
        let total_n = 0.0 + felt.iter().map(|contact| contact.force.dot(&seen.along)).sum::<f64>();
        let mut sense = || {
            if felt.is_empty() {
                return Ok(None);
            }
            let (measurement, [marker_noise_mm, outline_noise_mm]) = {
                let on_gripper = self.grasp.camera_on_gripper.then_some(&seen.in_gripper);
                measured(&self.finger, &seen.shape, &eyes.before(on_gripper), noise)?
            };
            let friction = self.object.friction;
            let watcher =
                OutlineEstimator { finger: &self.finger, rod_radius_mm, friction, marker_noise_mm, outline_noise_mm };
            let standard_normal = || noise.standard_normal();
            Ok(Some(match &self.estimator {
                None => watcher.sense(&felt, &measurement, seen.along, standard_normal)?,
                Some((id, networks)) => {
                    watcher.sense_by((*id, networks), &felt, &measurement, seen.along, standard_normal)?
                }
            }))
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
    /// The search with errors in all variables refuses.
    #[error(transparent)]
    Refused(#[from] SensingError),
    /// The estimator refuses.
    #[error(transparent)]
    RefusedBy(#[from] EstimatorError),
    /// The image does not show the finger.
    #[error("the image: {0}")]
    NotSeen(String),
}

/// Displacements of the markers as `eyes` see them, with the standard deviations of a marker's and an outline point's coordinate, mm.
fn measured(
    finger: &Finger,
    shape: &FingerShape,
    eyes: &Eyes,
    noise: &mut Noise,
) -> Result<(Measurement, [f64; 2]), NotSensed> {
    let (camera, markers, [grey_noise, blur_px, outline_noise_mm]) = match eyes {
        Eyes::Noise(noise_mm) => {
            let mut seen = Measurement::of_shape(finger, shape);
            seen.add_noise(*noise_mm, || noise.standard_normal());
            return Ok((seen, [*noise_mm; 2]));
        }
        Eyes::Images { camera, markers, grey_noise, blur_px, outline_noise_mm } => {
            (camera, markers, [*grey_noise, *blur_px, *outline_noise_mm])
        }
    };
    let not_seen = |reason: String| NotSensed::NotSeen(reason);
    let seed = (noise.evenly([0.0, 1.0]) * f64::from(u32::MAX)) as u64;
    let disturbances = Disturbances { grey_noise, blur_px, seed, ..Disturbances::default() };
    let request = RenderRequest { camera, finger, shape, markers, references: &[], hidden: &[], disturbances };
    let image = render(&request).map_err(|error| not_seen(error.to_string()))?;
    let mut locator = Locator::new(finger, camera, markers).map_err(|error| not_seen(error.to_string()))?;
    let located = locator.locate(&image).map_err(|error| not_seen(error.to_string()))?;
    let clamped = finger.clamped_nodes();
    let markers = located.iter().filter(|located| !clamped.contains(&located.node)).map(|located| Marker {
        node: located.node,
        displacement: located.position - finger.position(located.node),
        weight: 1.0,
    });
    let measurement = Measurement::new(finger, markers).map_err(|error| not_seen(error.to_string()))?;
    let squares = located.iter().map(|located| located.sd_mm * located.sd_mm).sum::<f64>();
    Ok((measurement, [(squares / located.len().max(1) as f64).sqrt(), outline_noise_mm]))
}
