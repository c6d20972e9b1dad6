//! Grasps: a gripper closes on a free object, carries it and puts it down, while the forces are sensed.
//!
//! The motor angle determines the coordinate frames of the undeformed fingers ([`Gripper`], eqs (6)-(9) of the paper). [`World`] computes the
//! equilibrium of fingers and object, with their contact forces, step by step. The estimator gets only the camera's view of the fingers ([`Eyes`]),
//! never the true forces.

mod balance;
mod course;
pub mod file;
pub mod modules;
mod obstacles;
mod outlook;
pub mod rates;
mod sensed;
pub mod study;
mod summary;
mod way;

pub use course::{GraspEnd, Phase};
pub use obstacles::Obstacle;
pub use outlook::{LoopFigures, loop_figures};
pub use sensed::{Eyes, FingerStep, NotSensed, SeenFinger};
pub use summary::{SensedSummary, Summary};

use crate::prelude::*;
use crate::sampling::noise::Noise;
use course::Course;
use finray_contact::outline::{ContactOutline, OutlineError};
use finray_contact::{Account, TouchedBody, World, WorldError};
use finray_model::estimators::network::Networks;
use finray_model::keys::{GRASP, GRIPPER, OBJECT, SceneTable};
use finray_model::scene::{GraspDescription, ObjectMotion};
use image::RgbImage;
use std::ops::ControlFlow;

/// Number of elements of each member. Twice as many change the forces of the shipped grasps by less than 0.2 %.
pub const FINENESS: usize = 4;
/// One newton in g m/s^2.
const GRAMS_M_S2_A_NEWTON: f64 = 1000.0;

/// Why a scene cannot be grasped.
#[derive(Debug, thiserror::Error)]
pub enum GraspError {
    /// A table of the scene is missing.
    #[error("{table} is missing: expected a table {outline}")]
    Missing {
        /// Name of the table.
        table: &'static str,
        /// The table with its required keys, as text.
        outline: String,
    },
    /// The scene prescribes the path of the object, but a grasped object must be free.
    #[error(
        "object.mass_g is missing: expected a free object with mass_g and centre_mm, found an object on a \
            prescribed path"
    )]
    NotFree,
    /// The outline of the object is invalid.
    #[error(transparent)]
    Outline(#[from] OutlineError),
    /// A corner of the path is below the support.
    #[error("grasp.path_mm: point {corner} leads {depth_mm:.3} mm below the surface of the support")]
    ThroughSupport {
        /// Number of the corner, from 1.
        corner: usize,
        /// Depth below the support, mm.
        depth_mm: f64,
    },
    /// The object is inside a finger.
    #[error("the object overlaps the {finger} finger at the start: check centre_mm")]
    AcrossFinger {
        /// Name of the finger: left or right.
        finger: &'static str,
    },
    /// A finger touches the other finger or the table at the start.
    #[error("grasp.motor_deg: {obstacle} where the gripper starts, at a motor angle of {motor_deg:?} degrees")]
    Obstructed {
        /// Body that the finger touches.
        obstacle: Obstacle,
        /// Motor angle, degrees.
        motor_deg: f64,
    },
    /// The object overlaps a finger or the support at the start, or a finger cannot be used for contact.
    #[error(transparent)]
    World(#[from] WorldError),
}

/// A scene with a gripper and a free object.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspScene {
    /// The scene, [as simulated](Scene::as_simulated).
    scene: Scene,
    gripper: Gripper,
    grasp: GraspDescription,
    object: ObjectDescription,
    shape: ContactOutline,
    mass_g: f64,
    centre_mm: Vector,
    fineness: usize,
    /// Estimator that senses the forces; `None` if the contacts count as measured values with errors (errors in all variables).
    estimator: Option<(EstimatorId, Networks)>,
}

/// Equilibrium of gripper and object after one step of a grasp.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspStep {
    /// Number of the step, from 1.
    pub step: usize,
    /// Motor angle, degrees.
    pub motor_deg: f64,
    /// Phase of the grasp.
    pub phase: Phase,
    /// Displacement of the gripper's frame from its initial position, mm.
    pub gripper_mm: Vector,
    /// Left and right finger.
    pub fingers: [FingerStep; 2],
    /// Position (mm) of the object's reference point and angle of the object (rad), in the gripper's initial frame.
    pub object: [f64; 3],
    /// Weight of the object in the gripper's initial frame, N.
    pub weight: Vector,
    /// Force of the support on the object in the gripper's initial frame, N.
    pub support_force: Vector,
    /// Largest imbalance of forces and moments on the object and on each finger's base, relative to the largest force, dimensionless.
    pub imbalance: f64,
    /// Work and energy since the start of the grasp, N mm.
    pub energy: Account,
}

/// Receives every step of a grasp, with the image of each finger; `None` for an image that was not rendered.
type Each<'e> = dyn FnMut(&GraspStep, [Option<RgbImage>; 2]) -> ControlFlow<()> + 'e;

impl GraspStep {
    /// Force of both fingers on the object, N.
    pub fn force_on_object(&self) -> Vector {
        self.fingers.iter().map(|finger| finger.on_object).sum()
    }
}

impl GraspScene {
    /// Prepares a scene. `corners` (mm) are the corners in a polygon's file; other outlines ignore them.
    ///
    /// # Errors
    /// [`GraspError`] if the scene cannot be grasped.
    pub fn new(scene: &Scene, corners: &[Vector]) -> Result<GraspScene, GraspError> {
        let missing = |table: &dyn SceneTable, outline| GraspError::Missing { table: table.path(), outline };
        let gripper = scene.gripper.ok_or_else(|| missing(&GRIPPER, GRIPPER.outline()))?;
        let grasp = scene.grasp.clone().ok_or_else(|| missing(&GRASP, GRASP.outline()))?;
        let keys = [OBJECT.shape.name, OBJECT.mass_g.name, OBJECT.centre_mm.name];
        let object = scene.object.clone().ok_or_else(|| missing(&OBJECT, OBJECT.with(&keys)))?;
        let ObjectMotion::Free { mass_g, centre_mm } = object.motion else { return Err(GraspError::NotFree) };
        let shape = ContactOutline::of_object(&ObjectDescription { rotation_deg: 0.0, ..object.clone() }, corners)?;
        let down = grasp.gravity_m_s2.try_normalize(0.0);
        if let Some(down) = down.filter(|_| grasp.support.is_some()) {
            let depth = |point: &Vector| point.dot(&down);
            if let Some((i, deep)) = grasp.path_mm.iter().enumerate().find(|(_, point)| depth(point) > 1e-9) {
                return Err(GraspError::ThroughSupport { corner: i + 1, depth_mm: depth(deep) });
            }
        }
        Ok(GraspScene {
            scene: scene.as_simulated(),
            gripper,
            grasp,
            object,
            shape,
            mass_g,
            centre_mm,
            fineness: FINENESS,
            estimator: None,
        })
    }

    /// The same grasp with another number of elements of each member.
    pub fn with_fineness(self, fineness: usize) -> GraspScene {
        GraspScene { fineness, ..self }
    }

    /// The same grasp with an estimator and its networks: see [`OutlineEstimator`](finray_contact::press::OutlineEstimator).
    pub fn with_estimator(self, estimator: EstimatorId, networks: Networks) -> GraspScene {
        GraspScene { estimator: Some((estimator, networks)), ..self }
    }

    /// Estimator that senses the forces; `None` if the contacts count as measured values with errors (errors in all variables).
    pub fn estimator(&self) -> Option<EstimatorId> {
        self.estimator.as_ref().map(|(id, _)| *id)
    }

    /// The finger of the scene.
    pub fn finger(&self) -> &Finger {
        &self.scene.finger
    }

    /// Motion of the gripper, from the scene.
    pub fn grasp(&self) -> &GraspDescription {
        &self.grasp
    }

    /// Outline of the object about its reference point, closed, mm.
    pub fn outline(&self) -> Vec<Vector> {
        self.shape.points()
    }

    /// Plane of the support, in the gripper's initial frame: a point (mm) and the upward unit normal. `None` without support or gravity.
    pub fn support(&self) -> Option<(Vector, Vector)> {
        let down = self.grasp.gravity_m_s2.try_normalize(0.0).filter(|_| self.grasp.support.is_some())?;
        let lowest_mm = self.shape.reach_mm(down, self.object.rotation_deg.to_radians());
        Some((self.centre_mm + down * lowest_mm, -down))
    }

    /// Largest number of steps, not counting steps in which a force is held.
    pub fn most_steps(&self) -> usize {
        let [from_deg, to_deg] = self.grasp.motor_deg;
        let step_deg = self.grasp.frames_per_s.map_or(self.grasp.step_deg, |rate| self.grasp.motor_deg_per_s / rate);
        let closing = ((to_deg - from_deg).abs() / step_deg).ceil() as usize;
        let way = if self.grasp.path_mm.is_empty() { 0 } else { self.grasp.path_steps };
        closing * if self.grasp.opens { 2 } else { 1 } + way
    }

    fn weight(&self) -> Vector {
        self.grasp.gravity_m_s2 * (self.mass_g / GRAMS_M_S2_A_NEWTON)
    }

    /// Frames of both fingers at a motor angle (degrees), with the gripper displaced by `moved` (mm); `None` if the angle is out of reach.
    fn placements(&self, motor_deg: f64, moved: Vector) -> Option<Vec<Placement>> {
        let pose = self.gripper.pose(motor_deg)?;
        let gripper = Placement { origin: moved, angle_rad: 0.0, mirrored: false };
        Some(self.gripper.fingers(&pose).iter().map(|finger| finger.within(&gripper)).collect())
    }

    /// Runs the grasp. `each` receives the equilibrium of every step; `eyes` is the method by which the fingers are observed.
    ///
    /// # Errors
    /// [`GraspError`] if the grasp cannot start.
    pub fn run(&self, eyes: &Eyes, seed: u64, mut each: impl FnMut(&GraspStep)) -> Result<GraspEnd, GraspError> {
        self.run_with_images(eyes, seed, |step, _| {
            each(step);
            ControlFlow::Continue(())
        })
    }

    /// Runs the grasp. `each` receives the equilibrium of every step, with the images of the left and the right finger. An image is `None` if it was
    /// not rendered ([`Eyes::Images`]). The grasp ends if `each` returns [`ControlFlow::Break`].
    ///
    /// # Errors
    /// [`GraspError`] if the grasp cannot start.
    pub fn run_with_images(
        &self,
        eyes: &Eyes,
        seed: u64,
        mut each: impl FnMut(&GraspStep, [Option<RgbImage>; 2]) -> ControlFlow<()>,
    ) -> Result<GraspEnd, GraspError> {
        let mesh = Mesh::with_elements_per_member(&self.scene.finger, self.fineness);
        let mut course = Course::new(self, &mesh)?;
        Ok(self.go_on(&mut course, eyes, &mut Noise::new(seed), &mut each))
    }

    fn go_on(&self, course: &mut Course, eyes: &Eyes, noise: &mut Noise, each: &mut Each) -> GraspEnd {
        loop {
            if let Err(ended) = course.advance() {
                return ended;
            }
            if let Some(ended) = self.look(course, eyes, noise, each) {
                return ended;
            }
        }
    }

    /// Senses the forces in the present step of a grasp. Returns the outcome if the grasp has ended.
    fn look(&self, course: &mut Course, eyes: &Eyes, noise: &mut Noise, each: &mut Each) -> Option<GraspEnd> {
        let [left, right] = course.seen().map(|seen| self.sense(seen, eyes, noise));
        let step = course.step([left.0, right.0]);
        let goes_on = each(&step, [left.1, right.1]);
        course.judge(&step).or(goes_on.is_break().then_some(GraspEnd::Stopped))
    }
}

/// Name of a finger: left (0) or right (1).
pub fn finger_name(finger: usize) -> &'static str {
    if finger == 0 { "left" } else { "right" }
}

/// Sum of the forces of one body on the object, N.
fn force_of(world: &World, partner: TouchedBody) -> Vector {
    world.contacts().iter().filter(|contact| contact.partner == partner).map(|contact| contact.force).sum()
}
