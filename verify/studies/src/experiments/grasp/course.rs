//! The course of a grasp: motion of motor and gripper, step by step, and the end of the grasp.

use super::balance::imbalance;
use super::obstacles::Obstacle;
use super::sensed::{FingerStep, SeenFinger};
use super::way::{on_way, part_of_way};
use super::{GraspError, GraspScene, GraspStep, finger_name, force_of};
use crate::prelude::*;
use finray_contact::{Drive, GraspFailure, TouchedBody, World};
use std::collections::VecDeque;

/// Phase of a grasp: the gripper's action in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// The gripper closes without contact.
    Approach,
    /// The gripper closes on the object.
    Close,
    /// The gripper holds the object in position.
    Hold,
    /// The gripper moves along the first part of its path.
    Lift,
    /// The gripper moves along the middle parts of its path.
    Carry,
    /// The gripper moves along the last part of its path, down to the support.
    Place,
    /// The gripper opens.
    Open,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&format!("{self:?}").to_lowercase())
    }
}

/// Outcome of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum GraspEnd {
    /// The grasp is complete, as defined by the scene.
    #[error("done")]
    Done,
    /// The caller stopped the grasp.
    #[error("stopped")]
    Stopped,
    /// The motor reached its last angle without contact.
    #[error("out of reach: the fingers touch nothing up to a motor angle of {motor_deg} degrees")]
    OutOfReach {
        /// Motor angle, degrees.
        motor_deg: f64,
    },
    /// The motor reached its last angle before the target force was sensed.
    #[error(
        "too weak: at the last motor angle, {motor_deg} degrees, {sensed_n:.3} N are sensed, less than until_force_n"
    )]
    TooWeak {
        /// Motor angle, degrees.
        motor_deg: f64,
        /// Sensed force at the end, N.
        sensed_n: f64,
    },
    /// The object lost contact with the fingers.
    #[error("drop: the fingers do not hold the object")]
    Dropped,
    /// The object slid through the fingers.
    #[error("slip: the object has slid by {slid_mm:.1} mm between the fingers")]
    Slipped {
        /// Sliding distance, mm.
        slid_mm: f64,
    },
    /// A finger touches something other than the object.
    #[error("{0}")]
    Obstructed(#[from] Obstacle),
    /// No equilibrium of fingers and object was found, or a finger folds.
    #[error("{0}")]
    Halted(#[from] GraspFailure),
}

/// Number of steps over which the weight of an unsupported object is applied, or a force is held before the path begins.
const HOLD_STEPS: usize = 5;
/// Same as [`HOLD_STEPS`], for a grasp in which each step is a frame of the camera.
const HOLD_FRAMES: usize = 30;
/// An object has slipped if its displacement relative to the gripper exceeds this share of the object's size.
const SLIPPED: f64 = 0.5;
/// Controller gain. In each frame the motor corrects this share of the missing force, divided by (delay in frames + 1).
const GAIN: f64 = 0.5;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    Close,
    Hold { left: usize },
    Way { step: usize },
    Open,
    Done,
}

/// State of a grasp in progress.
#[derive(Clone)]
pub(super) struct Course<'s, 'm> {
    scene: &'s GraspScene,
    world: World<'m>,
    task: Task,
    phase: Phase,
    step: usize,
    motor_deg: f64,
    gripper_mm: Vector,
    weight_share: f64,
    /// Sensed forces so far (mean total of both fingers, N) with their motor angles (degrees), the newest last.
    sensed: VecDeque<(f64, f64)>,
    /// Position of the object in the gripper's frame at the beginning of the path, mm.
    held_at: Option<Vector>,
}

impl<'s, 'm> Course<'s, 'm> {
    pub(super) fn new(scene: &'s GraspScene, mesh: &'m Mesh) -> Result<Course<'s, 'm>, GraspError> {
        let motor_deg = scene.grasp.motor_deg[0];
        let weight_share = if scene.grasp.support.is_some() { 1.0 } else { 0.0 };
        let object = [scene.centre_mm.x, scene.centre_mm.y, scene.object.rotation_deg.to_radians()];
        let placements = scene.placements(motor_deg, Vector::zeros()).unwrap_or_default();
        let drive = Drive { placements, weight: scene.weight() * weight_share, gripper: Vector::zeros() };
        let world = World::new(
            &[mesh, mesh],
            scene.scene.contact.rod_radius_mm,
            (scene.shape.clone(), scene.object.friction),
            object,
            drive,
            scene.support(),
        )?;
        if let Some(finger) = (0..2).find(|finger| world.is_inside(*finger)) {
            return Err(GraspError::AcrossFinger { finger: finger_name(finger) });
        }
        if let Err(obstacle) = scene.require_clear(&world) {
            return Err(GraspError::Obstructed { obstacle, motor_deg });
        }
        let sensed = VecDeque::new();
        Ok(Course {
            scene,
            world,
            task: Task::Close,
            phase: Phase::Approach,
            step: 0,
            motor_deg,
            gripper_mm: Vector::zeros(),
            weight_share,
            sensed,
            held_at: None,
        })
    }

    fn step_deg(&self) -> f64 {
        let grasp = &self.scene.grasp;
        grasp.frames_per_s.map_or(grasp.step_deg, |rate| grasp.motor_deg_per_s / rate)
    }

    /// Continues closing from this state under another scene with the same fingers and object.
    pub(super) fn closing_on(&self, scene: &'s GraspScene) -> Course<'s, 'm> {
        Course { scene, task: Task::Close, ..self.clone() }
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.motor_deg == self.scene.grasp.motor_deg[1]
    }

    pub(super) fn closes(&self) -> bool {
        self.task == Task::Close
    }

    /// Copies the next step from another course that has already computed this step with the same closing motion.
    pub(super) fn follow(&mut self, other: &Course<'_, 'm>) {
        (self.world, self.motor_deg, self.phase) = (other.world.clone(), other.motor_deg, other.phase);
        self.step += 1;
    }

    /// Mean of both fingers' true forces across the gripper, N.
    pub(super) fn force_n(&self) -> f64 {
        let on_object = [0, 1].map(|finger| force_of(&self.world, TouchedBody::Finger(finger)).x.abs());
        0.5 * on_object.iter().sum::<f64>()
    }

    /// Advances by one step and settles the world, unless the grasp ends in this step.
    pub(super) fn advance(&mut self) -> Result<(), GraspEnd> {
        let grasp = &self.scene.grasp;
        let [from_deg, to_deg] = grasp.motor_deg;
        match self.task {
            Task::Close => self.motor_deg = towards(self.motor_deg, to_deg, self.step_deg()),
            Task::Hold { .. } => {
                let steps = self.hold_steps() as f64;
                self.weight_share = (self.weight_share + 1.0 / steps).min(1.0);
                self.correct_motor();
            }
            Task::Way { step } => {
                self.gripper_mm = on_way(&grasp.path_mm, step as f64 / grasp.path_steps as f64);
                self.phase = self.phase_on_way(step);
                self.correct_motor();
            }
            Task::Open => self.motor_deg = towards(self.motor_deg, from_deg, self.step_deg()),
            Task::Done => return Err(GraspEnd::Done),
        }
        self.step += 1;
        let placements = self.scene.placements(self.motor_deg, self.gripper_mm).unwrap_or_default();
        let weight = self.scene.weight() * self.weight_share;
        let drive = Drive { placements, weight, gripper: self.gripper_mm };
        self.world.advance(&drive)?;
        self.scene.require_clear(&self.world)?;
        let touches = self.world.contacts().iter().any(|contact| matches!(contact.partner, TouchedBody::Finger(_)));
        if self.task == Task::Close {
            self.phase = if touches { Phase::Close } else { Phase::Approach };
        }
        Ok(())
    }

    pub(super) fn seen(&self) -> [SeenFinger; 2] {
        let contacts = self.world.contacts();
        [0, 1].map(|finger| {
            let placement = self.world.placements()[finger];
            // The object pushes the left finger to the left.
            let outwards = Vector::new(if finger == 0 { -1.0 } else { 1.0 }, 0.0);
            let of_finger = contacts.iter().filter(|contact| contact.partner == TouchedBody::Finger(finger));
            SeenFinger {
                placement,
                in_gripper: Placement { origin: placement.origin - self.gripper_mm, ..placement },
                shape: self.world.finger_shape(finger),
                touches: of_finger.filter_map(|contact| contact.touch).collect(),
                object: self.world.object(),
                along: placement.axes().transpose() * outwards,
                on_object: force_of(&self.world, TouchedBody::Finger(finger)),
            }
        })
    }

    pub(super) fn step(&mut self, fingers: [FingerStep; 2]) -> GraspStep {
        if let [Some(left_n), Some(right_n)] = fingers.each_ref().map(FingerStep::sensed_total_n) {
            self.sensed.push_back((0.5 * (left_n + right_n), self.motor_deg));
        } else if let Some(&last) = self.sensed.back() {
            // If sensing was refused, the step has no new force, so the last sensed force is repeated.
            self.sensed.push_back(last);
        }
        let weight = self.scene.weight() * self.weight_share;
        GraspStep {
            step: self.step,
            motor_deg: self.motor_deg,
            phase: self.phase,
            gripper_mm: self.gripper_mm,
            object: self.world.object(),
            weight,
            support_force: force_of(&self.world, TouchedBody::Support),
            imbalance: imbalance(&self.world, weight),
            energy: *self.world.account(),
            fingers,
        }
    }

    /// Chooses the next task after a step. Returns the outcome if the grasp has ended.
    pub(super) fn judge(&mut self, step: &GraspStep) -> Option<GraspEnd> {
        if self.world.is_folded() {
            return Some(GraspFailure::Folded.into());
        }
        let grasp = &self.scene.grasp;
        let [from_deg, to_deg] = grasp.motor_deg;
        let touches = step.fingers.iter().any(|finger| !finger.contacts.is_empty());
        match self.task {
            Task::Close => {
                let is_enough = |target_n: f64| self.late_n().is_some_and(|sensed_n| sensed_n >= target_n);
                let at_end = self.is_at_end();
                match grasp.until_force_n {
                    Some(target_n) if !is_enough(target_n) => {
                        let sensed_n = self.late_n().unwrap_or(0.0);
                        return at_end.then_some(match touches {
                            true => GraspEnd::TooWeak { motor_deg: to_deg, sensed_n },
                            false => GraspEnd::OutOfReach { motor_deg: to_deg },
                        });
                    }
                    None if !at_end => return None,
                    _ => {}
                }
                if !touches {
                    return Some(GraspEnd::OutOfReach { motor_deg: to_deg });
                }
                let is_held = grasp.holds || self.weight_share < 1.0;
                self.task = if is_held { Task::Hold { left: self.hold_steps() } } else { self.after_hold() };
                self.phase = if is_held { Phase::Hold } else { self.phase };
            }
            Task::Hold { left: 1 } => self.task = self.after_hold(),
            Task::Hold { left } => self.task = Task::Hold { left: left - 1 },
            Task::Way { step: at } => {
                if let Some(ended) = self.lost(step, touches) {
                    return Some(ended);
                }
                self.task = if at < grasp.path_steps { Task::Way { step: at + 1 } } else { self.after_way() };
            }
            Task::Open if self.motor_deg == from_deg => self.task = Task::Done,
            Task::Open | Task::Done => {}
        }
        None
    }

    /// Reason for the loss of the object on the path; `None` if the object is held.
    fn lost(&self, step: &GraspStep, touches: bool) -> Option<GraspEnd> {
        let at = Vector::new(step.object[0], step.object[1]) - step.gripper_mm;
        let slid_mm = (at - self.held_at.unwrap_or(at)).norm();
        let on_support = step.support_force.norm() > 0.0;
        match (touches, slid_mm > SLIPPED * self.scene.shape.size_mm()) {
            (false, _) if !(on_support && self.phase == Phase::Place) => Some(GraspEnd::Dropped),
            (_, true) if self.phase != Phase::Place => Some(GraspEnd::Slipped { slid_mm }),
            _ => None,
        }
    }

    fn hold_steps(&self) -> usize {
        if self.scene.grasp.frames_per_s.is_some() { HOLD_FRAMES } else { HOLD_STEPS }
    }

    fn after_hold(&mut self) -> Task {
        if self.scene.grasp.path_mm.is_empty() {
            return self.after_way();
        }
        let [x, y, _] = self.world.object();
        self.held_at = Some(Vector::new(x, y) - self.gripper_mm);
        Task::Way { step: 1 }
    }

    fn after_way(&mut self) -> Task {
        if !self.scene.grasp.opens {
            return Task::Done;
        }
        self.phase = Phase::Open;
        Task::Open
    }

    /// Force known to the controller, N: the force sensed `delay_frames` frames earlier.
    fn late_n(&self) -> Option<f64> {
        let at = self.sensed.len().checked_sub(1 + self.scene.grasp.delay_frames)?;
        Some(self.sensed[at].0)
    }

    /// Moves the motor to reduce the difference from the target force; the stiffness observed while closing converts force into motor angle.
    fn correct_motor(&mut self) {
        let grasp = &self.scene.grasp;
        let (Some(target_n), true, Some(sensed_n)) = (grasp.until_force_n, grasp.holds, self.late_n()) else { return };
        let closing = (grasp.motor_deg[1] - grasp.motor_deg[0]).signum();
        let Some(stiffness) = self.stiffness() else { return };
        let gain = GAIN / (1.0 + grasp.delay_frames as f64);
        let most_deg = self.step_deg();
        let wanted_deg = (gain * (target_n - sensed_n) / stiffness).clamp(-most_deg, most_deg);
        let [a, b] = grasp.motor_deg;
        self.motor_deg = (self.motor_deg + closing * wanted_deg).clamp(a.min(b), a.max(b));
    }

    /// Force per degree of closing, N/deg, from the frames in which the sensed force rises from half the target to the target.
    fn stiffness(&self) -> Option<f64> {
        let target_n = self.scene.grasp.until_force_n?;
        let end = self.sensed.iter().position(|(sensed_n, _)| *sensed_n >= target_n)?;
        let half = self.sensed.iter().take(end).rposition(|(sensed_n, _)| *sensed_n < 0.5 * target_n).unwrap_or(0);
        let [(from_n, from_deg), (to_n, to_deg)] = [self.sensed[half], self.sensed[end]];
        let stiffness = (to_n - from_n) / (to_deg - from_deg).abs();
        (stiffness.is_finite() && stiffness > 0.0).then_some(stiffness)
    }

    /// Phase on the path: the first part is lifting; the last part is placing if it returns to the support.
    fn phase_on_way(&self, step: usize) -> Phase {
        let grasp = &self.scene.grasp;
        let at = step as f64 / grasp.path_steps as f64;
        let part = part_of_way(&grasp.path_mm, at);
        let height = |point: &Vector| -point.dot(&grasp.gravity_m_s2);
        let last = grasp.path_mm.len() - 1;
        let comes_down = grasp.path_mm.last().is_some_and(|end| height(end) <= 1e-9) && grasp.support.is_some();
        match part {
            0 => Phase::Lift,
            part if part == last && comes_down => Phase::Place,
            _ => Phase::Carry,
        }
    }
}

fn towards(from: f64, to: f64, step: f64) -> f64 {
    if (to - from).abs() <= step * (1.0 + 1e-9) { to } else { from + step.copysign(to - from) }
}
