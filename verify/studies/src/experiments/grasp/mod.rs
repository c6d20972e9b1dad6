//! Grasps: a gripper closes on a free object, carries it and puts it down, and senses the forces meanwhile.
//!
//! The motor's angle says where the undeformed fingers stand ([`Gripper`], eqs (6)-(9) of the paper); [`World`] finds fingers, object and contact
//! forces at rest, step by step; what a camera sees of that goes to the estimator ([`Eyes`]). It never gets the true forces.

mod balance;
mod course;
pub mod file;
pub mod modules;
pub mod observations;
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

use crate::experiments::contact_scene::{OutlineError, TurnedOutline, simulated};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use course::Course;
use finray_lattice::grasp::{Account, TouchedBody, World, WorldError, surface::Shape};
use finray_model::estimators::network::Networks;
use finray_model::keys::{GRASP, GRIPPER, OBJECT, SceneTable};
use finray_model::scene::{GraspDescription, ObjectMotion};
use rapier2d::parry::query::intersection_test;
use rapier2d::parry::shape::Triangle;
use rapier2d::prelude::{Pose, Vector as EngineVector};

/// Segments of plate between two rods. Forces are sensed with converged beams: with three, a wedge that presses 5 N between two rods is sensed 0.5 %
/// off, twice what noise of 0.067 mm does to it; with six, a quarter of that.
pub const FINENESS: usize = 6;
/// A newton is this many g m/s^2.
const GRAMS_M_S2_A_NEWTON: f64 = 1000.0;

/// Why a scene is no grasp.
#[derive(Debug, thiserror::Error)]
pub enum GraspError {
    /// A table is missing.
    #[error("{table} is missing: expected a table {outline}")]
    Missing {
        /// Its name.
        table: &'static str,
        /// The table with its required keys.
        outline: String,
    },
    /// The object is moved by a hand.
    #[error("object.mass_g is missing: expected a free object with mass_g and centre_mm, found one that a hand moves")]
    NotFree,
    /// The outline.
    #[error(transparent)]
    Outline(#[from] OutlineError),
    /// A corner of the way is beyond the support.
    #[error("grasp.path_mm: point {corner} leads through the support, {depth_mm:.3} mm deep")]
    ThroughSupport {
        /// Its number, from 1.
        corner: usize,
        /// How deep, mm.
        depth_mm: f64,
    },
    /// The object is inside a finger, or lies across it behind its front.
    #[error("the object lies across the {finger} finger where it starts")]
    AcrossFinger {
        /// Left or right.
        finger: &'static str,
    },
    /// A finger is in the way of the other one, or of the table.
    #[error("grasp.motor_deg: {obstacle} where the gripper starts, at a motor angle of {motor_deg:?} degrees")]
    Obstructed {
        /// What it is.
        obstacle: Obstacle,
        /// The motor's angle, degrees.
        motor_deg: f64,
    },
    /// The object overlaps something where it starts.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

/// A scene with a gripper and a free object.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspScene {
    /// As it is [`simulated`].
    scene: Scene,
    gripper: Gripper,
    grasp: GraspDescription,
    object: ObjectDescription,
    outline: TurnedOutline,
    shape: Shape,
    mass_g: f64,
    centre_mm: Vector,
    fineness: usize,
    /// What senses, if not the search with errors in all variables.
    estimator: Option<(EstimatorId, Networks)>,
}

/// One step of a grasp, at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspStep {
    /// Its number, from 1.
    pub step: usize,
    /// The motor's angle, degrees.
    pub motor_deg: f64,
    /// What the gripper does.
    pub phase: Phase,
    /// Where the gripper is, mm: its frame in the one where it started.
    pub gripper_mm: Vector,
    /// Left and right finger.
    pub fingers: [FingerStep; 2],
    /// Position of the object's point, mm, and its angle, rad, in the frame of the gripper where it started.
    pub object: [f64; 3],
    /// Weight of the object, N.
    pub weight: Vector,
    /// Force of the support on the object, N.
    pub support_force: Vector,
    /// How far forces and moments on the object, and on each finger's base, are from balance, as a share of the largest force.
    pub imbalance: f64,
    /// Where the work of the motor went so far.
    pub energy: Account,
}

impl GraspStep {
    /// Force of both fingers on the object, N.
    pub fn force_on_object(&self) -> Vector {
        self.fingers.iter().map(|finger| finger.on_object).sum()
    }
}

impl GraspScene {
    /// Prepares a scene; `corners` (mm) are those of a polygon's file, unused otherwise.
    ///
    /// # Errors
    /// [`GraspError`].
    pub fn new(scene: &Scene, corners: &[Vector]) -> Result<GraspScene, GraspError> {
        let missing = |table: &dyn SceneTable, outline| GraspError::Missing { table: table.path(), outline };
        let gripper = scene.gripper.ok_or_else(|| missing(&GRIPPER, GRIPPER.outline()))?;
        let grasp = scene.grasp.clone().ok_or_else(|| missing(&GRASP, GRASP.outline()))?;
        let keys = [OBJECT.shape.name, OBJECT.mass_g.name, OBJECT.centre_mm.name];
        let object = scene.object.clone().ok_or_else(|| missing(&OBJECT, OBJECT.with(&keys)))?;
        let ObjectMotion::Free { mass_g, centre_mm } = object.motion else { return Err(GraspError::NotFree) };
        let outline = TurnedOutline::new(&ObjectDescription { rotation_deg: 0.0, ..object.clone() }, corners)?;
        let shape = outline.shape();
        let down = grasp.gravity_m_s2.try_normalize(0.0);
        if let Some(down) = down.filter(|_| grasp.support.is_some()) {
            let depth = |point: &Vector| point.dot(&down);
            if let Some((i, deep)) = grasp.path_mm.iter().enumerate().find(|(_, point)| depth(point) > 1e-9) {
                return Err(GraspError::ThroughSupport { corner: i + 1, depth_mm: depth(deep) });
            }
        }
        Ok(GraspScene {
            scene: simulated(scene),
            gripper,
            grasp,
            object,
            outline,
            shape,
            mass_g,
            centre_mm,
            fineness: FINENESS,
            estimator: None,
        })
    }

    /// The same with another number of segments a plate member.
    pub fn with_fineness(self, fineness: usize) -> GraspScene {
        GraspScene { fineness, ..self }
    }

    /// The same sensed by an estimator, with networks to choose from: see [`OutlineEstimator`](crate::experiments::contact_scene::OutlineEstimator).
    pub fn with_estimator(self, estimator: EstimatorId, networks: Networks) -> GraspScene {
        GraspScene { estimator: Some((estimator, networks)), ..self }
    }

    /// Which estimator senses, if not the search with errors in all variables.
    pub fn estimator(&self) -> Option<EstimatorId> {
        self.estimator.as_ref().map(|(id, _)| *id)
    }

    /// The finger.
    pub fn finger(&self) -> &Finger {
        &self.scene.finger
    }

    /// What the gripper does.
    pub fn grasp(&self) -> &GraspDescription {
        &self.grasp
    }

    /// Outline of the object about its own point, closed, mm.
    pub fn outline(&self) -> Vec<Vector> {
        self.outline.points()
    }

    /// Height of the support along gravity, as a point of it and the upward normal, in the frame of the gripper where it started.
    pub fn support(&self) -> Option<(Vector, Vector)> {
        let down = self.grasp.gravity_m_s2.try_normalize(0.0).filter(|_| self.grasp.support.is_some())?;
        let lowest_mm = self.shape.reach_mm(down, self.object.rotation_deg.to_radians());
        Some((self.centre_mm + down * lowest_mm, -down))
    }

    /// Steps that it has at most, but for those in which a force is held.
    pub fn most_steps(&self) -> usize {
        let [from_deg, to_deg] = self.grasp.motor_deg;
        let step_deg = self.grasp.frames_per_s.map_or(self.grasp.step_deg, |rate| self.grasp.motor_deg_per_s / rate);
        let closing = ((to_deg - from_deg).abs() / step_deg).ceil() as usize;
        let way = if self.grasp.path_mm.is_empty() { 0 } else { self.grasp.path_steps };
        closing * if self.grasp.opens { 2 } else { 1 } + way
    }

    /// Which of two fingers the object lies across at the start, by the triangle of middle lines: what the front meets is outside.
    fn finger_across(&self, placements: &[Placement]) -> Option<usize> {
        let object = self.outline.engine_shape().ok()?;
        let engine = |point: Vector| EngineVector::new(point.x, point.y);
        let start = Pose::new(engine(self.centre_mm), self.object.rotation_deg.to_radians());
        let length_mm = self.scene.finger.plate_length_mm(Plate::Front);
        let corners = [(Plate::Front, 0.0), (Plate::Front, length_mm), (Plate::Back, 0.0)];
        let corners = corners.map(|(plate, s_mm)| self.scene.finger.plate_point(plate, s_mm));
        placements.iter().position(|placement| {
            let [base, tip, back] = corners.map(|corner| engine(placement.outwards(corner)));
            intersection_test(&Pose::IDENTITY, &Triangle::new(base, tip, back), &start, &*object.0)
                .is_ok_and(|found| found.intersecting)
        })
    }

    fn weight(&self) -> Vector {
        self.grasp.gravity_m_s2 * (self.mass_g / GRAMS_M_S2_A_NEWTON)
    }

    /// Where the fingers stand at a motor angle, the gripper moved by a vector, mm; `None` out of reach.
    fn placements(&self, motor_deg: f64, moved: Vector) -> Option<Vec<Placement>> {
        let pose = self.gripper.pose(motor_deg)?;
        let gripper = Placement { origin: moved, angle_rad: 0.0, mirrored: false };
        Some(self.gripper.fingers(&pose).iter().map(|finger| finger.within(&gripper)).collect())
    }

    /// Grasps; `each` is handed every step as soon as it rests. `eyes` are what sees the fingers.
    ///
    /// # Errors
    /// [`GraspError`] if it cannot begin.
    pub fn run(&self, eyes: &Eyes, seed: u64, mut each: impl FnMut(&GraspStep)) -> Result<GraspEnd, GraspError> {
        let lattice = Lattice::new(&self.scene.finger, self.fineness)?;
        let mut course = Course::new(self, &lattice)?;
        Ok(self.go_on(&mut course, &lattice, eyes, &mut Noise::new(seed), &mut each))
    }

    /// Goes on to the end of a course.
    fn go_on(
        &self,
        course: &mut Course,
        lattice: &Lattice,
        eyes: &Eyes,
        noise: &mut Noise,
        each: &mut dyn FnMut(&GraspStep),
    ) -> GraspEnd {
        loop {
            if let Err(ended) = course.advance() {
                return ended;
            }
            if let Some(ended) = self.look(course, lattice, eyes, noise, each) {
                return ended;
            }
        }
    }

    /// Senses where a course has come to rest; how it ended, if it did.
    fn look(
        &self,
        course: &mut Course,
        lattice: &Lattice,
        eyes: &Eyes,
        noise: &mut Noise,
        each: &mut dyn FnMut(&GraspStep),
    ) -> Option<GraspEnd> {
        let sensed = course.seen().map(|seen| self.sense(lattice, seen, eyes, noise));
        let step = course.step(sensed);
        each(&step);
        course.judge(&step)
    }
}

/// Which finger, in words.
pub fn finger_name(finger: usize) -> &'static str {
    if finger == 0 { "left" } else { "right" }
}

/// Sum of the forces of one partner on the object, N.
fn force_of(world: &World, partner: TouchedBody) -> Vector {
    world.contacts().iter().filter(|contact| contact.partner == partner).map(|contact| contact.force).sum()
}
