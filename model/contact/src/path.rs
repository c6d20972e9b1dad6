//! Motion of a pressed object: its starting position, and the steps of the hand.

use crate::outline::{ContactOutline, OutlineError};
use crate::pressing::Push;
use finray_model::finger::Plate;
use finray_model::scene::{ObjectDescription, ObjectMotion, Until};
use finray_model::{Finger, Scene, Vector};

/// Why an object cannot be pressed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PressError {
    /// The outline is invalid.
    #[error(transparent)]
    Outline(#[from] OutlineError),
    /// The object is free: the scene prescribes no hand motion for the object.
    #[error(
        "the object is free (mass_g): use `finray grasp`, or state its path, either by at_mm with travel_mm or \
            force_n, or by path_mm"
    )]
    Free,
}

/// An object prepared for pressing.
#[derive(Debug, Clone)]
pub struct PreparedObject {
    /// Outline of the object.
    pub outline: ContactOutline,
    /// Coefficient of friction, dimensionless.
    pub friction: f64,
    /// Starting position in the finger frame, mm.
    pub start: Vector,
    /// Unit vector of the motion in the finger frame; on a path, the direction at the end of the first step.
    pub along: Vector,
    /// Motion of the hand, step by step.
    pub steps: Vec<HandStep>,
}

/// Motion of the hand that moves the object, in one step.
#[derive(Debug, Clone, PartialEq)]
pub struct HandStep {
    /// Corners of the path that the object passes in the step, in the finger frame, mm.
    pub corners: Vec<Vector>,
    /// Position or force at the end of the step.
    pub end: Push,
    /// Unit vector of the motion at the end of the step, in the finger frame.
    pub along: Vector,
}

impl PreparedObject {
    /// Prepares the object of a scene. `corners` (mm) are a polygon's corners from its file; they are ignored for other outlines.
    ///
    /// # Errors
    /// [`PressError`] for a free object, or corners that form no valid outline.
    pub fn new(scene: &Scene, object: &ObjectDescription, corners: &[Vector]) -> Result<PreparedObject, PressError> {
        let finger = &scene.finger;
        let outline = ContactOutline::of_object(object, corners)?;
        let share = |step: usize| step as f64 / object.steps as f64;
        let (start, along, steps) = match &object.motion {
            ObjectMotion::Free { .. } => return Err(PressError::Free),
            ObjectMotion::Press { at_mm, direction_deg, until } => {
                let along = finger.direction(*direction_deg);
                let start = first_touch(finger, scene.contact.rod_radius_mm, &outline, *at_mm, along);
                let step = |step| {
                    let end = match until {
                        Until::Travel(travel_mm) => Push::To(start + along * (travel_mm * share(step))),
                        Until::Force(force_n) => Push::With(force_n * share(step)),
                    };
                    HandStep { corners: Vec::new(), end, along }
                };
                (start, along, (1..=object.steps).map(step).collect())
            }
            ObjectMotion::Path(points) => {
                let steps: Vec<HandStep> =
                    (1..=object.steps).map(|step| step_on_path(points, share(step - 1), share(step))).collect();
                (points[0], steps.first().map_or(finger.direction(0.0), |step| step.along), steps)
            }
        };
        Ok(PreparedObject { outline, friction: object.friction, start, along, steps })
    }
}

/// Position of an object (mm, finger frame) on its line of motion at which it first meets the straight line over the undeformed finger's rods.
fn first_touch(finger: &Finger, rod_radius_mm: f64, outline: &ContactOutline, at_mm: f64, along: Vector) -> Vector {
    let inward = finger.direction(0.0);
    let surface_mm = rod_radius_mm.max(0.5 * finger.description().front.thickness_mm);
    let distance_mm = (outline.reach_mm(inward, 0.0) + surface_mm) / along.dot(&inward);
    finger.plate_point(Plate::Front, at_mm) - along * distance_mm
}

/// Hand motion between two points of a path, given as shares (0 to 1) of the path's length.
fn step_on_path(points: &[Vector], from: f64, to: f64) -> HandStep {
    let segments: Vec<&[Vector]> = points.windows(2).filter(|pair| pair[0] != pair[1]).collect();
    let total: f64 = segments.iter().map(|pair| (pair[1] - pair[0]).norm()).sum();
    let (mut begins, mut corners) = (0.0, Vec::new());
    for (i, pair) in segments.iter().enumerate() {
        let way = pair[1] - pair[0];
        let ends = begins + way.norm();
        // Rounding may put the end of a step beyond the path; the last segment then contains this end.
        if to * total <= ends || i + 1 == segments.len() {
            let share = ((to * total - begins) / way.norm()).min(1.0);
            return HandStep { corners, end: Push::To(pair[0] + way * share), along: way.normalize() };
        }
        if from * total < ends {
            corners.push(pair[1]);
        }
        begins = ends;
    }
    HandStep { corners, end: Push::To(points[0]), along: Vector::x() }
}
