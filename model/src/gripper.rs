//! The gripper's slider-rocker linkage: it relates the motor's angle to the placements of the two fingers.
//!
//! A screw moves a nut along the axis between two mirrored linkages. In each linkage, a rocker rotates about a joint that is fixed to the gripper. A link
//! connects the end of the rocker to the nut. The finger is mounted on the link.

mod budget;
mod placement;

pub use budget::{LinkageErrors, NodeErrors};
pub use placement::Placement;

use crate::{Finger, Vector};
use nalgebra::Rotation2;
use std::f64::consts::PI;

/// A pose counts as singular if the sine of the angle between rocker and link is below this limit. In a singular pose, the nut is at an end of its
/// reach.
const SINGULAR_SINE: f64 = 1e-6;

/// Dimensions of the linkage.
///
/// # Frame
/// The mechanism frame has its origin at the fixed joint of one rocker, and y along the screw. The nut is at (l4, l3), and the mirror axis is x = l4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperDescription {
    /// Travel of the nut per revolution of the motor, mm; p_s of eq. (6).
    pub screw_pitch_mm: f64,
    /// Height of the nut at motor angle 0, mm; l03 of eq. (6).
    pub slider_mm: f64,
    /// Lengths of rocker and link, mm; l1 and l2 of eqs (7) and (8).
    pub link_mm: [f64; 2],
    /// Distance of the fixed joint from the screw's axis, mm; l4 of eq. (7).
    pub fixed_joint_mm: f64,
    /// Assembly mode: which of the two possible positions the joint between rocker and link has.
    pub assembly: Assembly,
}

/// Assembly mode: which of its two possible positions the joint between rocker and link has at motor angle 0. At all other angles, the joint between
/// rocker and link stays on the same side of the line from fixed joint to nut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Assembly {
    /// Of its two possible positions, the joint between rocker and link has the position farther from the screw's axis.
    #[default]
    Outer,
    /// Of its two possible positions, the joint between rocker and link has the position nearer to the screw's axis.
    Inner,
}

/// Error for a linkage that cannot close at motor angle 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "expected rocker and link that span the distance from nut to fixed joint ({apart_mm:.2} mm at motor angle 0), \
        found a reach of {shortest_mm:.2} to {longest_mm:.2} mm"
)]
pub struct ImpossibleLinkage {
    /// Smallest distance that rocker and link can bridge, mm.
    pub shortest_mm: f64,
    /// Largest distance that rocker and link can bridge, mm.
    pub longest_mm: f64,
    /// Distance from the fixed joint to the nut at motor angle 0, mm.
    pub apart_mm: f64,
}

/// A gripper with two mirrored fingers and a linkage that has been checked.
///
/// # Reference
/// Xu et al. (IEEE T-RO 2021), eqs (6)-(9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gripper {
    description: GripperDescription,
    /// Side on which the joint between rocker and link lies, seen from the fixed joint towards the nut: 1 for left, -1 for right.
    side: f64,
}

/// A pose of the linkage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkagePose {
    /// Height of the nut, mm; l3 of eq. (6).
    pub slider_mm: f64,
    /// Inclination of the rocker, rad; phi1 of eqs (7) and (8).
    pub phi1_rad: f64,
    /// Inclination of the link, rad; phi2 of eqs (7) and (8). The finger rotates with the link.
    pub phi2_rad: f64,
    /// Position of the middle of the finger's base line, mm, mechanism frame; P of eq. (9).
    pub base: Vector,
}

impl LinkagePose {
    /// Whether rocker and link are collinear. In a collinear pose, the nut is at an end of its reach, and the derivative of the opening with respect
    /// to the motor's angle is infinite.
    pub fn is_singular(&self) -> bool {
        (self.phi1_rad + self.phi2_rad).sin().abs() < SINGULAR_SINE
    }

    /// Transforms a point (mm) from the finger frame to the mechanism frame. Eq. (9) expects the coordinates in the order y, x.
    pub fn in_mechanism(&self, point: Vector) -> Vector {
        self.base + Rotation2::new(self.phi2_rad) * point.yx()
    }
}

impl Gripper {
    /// Checks that the linkage closes. The lengths in `description` and the pitch must be positive.
    ///
    /// # Errors
    /// [`ImpossibleLinkage`] if rocker and link cannot reach from the fixed joint to the nut at motor angle 0.
    pub fn new(description: GripperDescription) -> Result<Gripper, ImpossibleLinkage> {
        let GripperDescription { slider_mm, assembly, .. } = description;
        // If the line from fixed joint to nut points upwards, its left side faces away from the screw's axis.
        let outer = if slider_mm < 0.0 { -1.0 } else { 1.0 };
        let side = if assembly == Assembly::Outer { outer } else { -outer };
        let gripper = Gripper { description, side };
        match gripper.with_slider(slider_mm) {
            Some(_) => Ok(gripper),
            None => {
                let [rocker, link] = description.link_mm;
                let apart_mm = slider_mm.hypot(description.fixed_joint_mm);
                Err(ImpossibleLinkage { shortest_mm: (rocker - link).abs(), longest_mm: rocker + link, apart_mm })
            }
        }
    }

    /// Dimensions of the linkage.
    pub fn description(&self) -> &GripperDescription {
        &self.description
    }

    /// Height of the nut, mm, at a motor angle in degrees, by eq. (6).
    pub fn slider_mm(&self, motor_deg: f64) -> f64 {
        self.description.slider_mm + motor_deg / 360.0 * self.description.screw_pitch_mm
    }

    /// Motor angle, degrees, at which the nut has the height `slider_mm`, mm.
    fn motor_deg(&self, slider_mm: f64) -> f64 {
        (slider_mm - self.description.slider_mm) / self.description.screw_pitch_mm * 360.0
    }

    /// Pose of the linkage at a motor angle in degrees. `None` if the linkage cannot reach that angle.
    pub fn pose(&self, motor_deg: f64) -> Option<LinkagePose> {
        self.with_slider(self.slider_mm(motor_deg))
    }

    /// Pose of the linkage with the nut at a height in mm, from the intersection of the circles of rocker and link. `None` if the nut cannot reach that
    /// height.
    fn with_slider(&self, slider_mm: f64) -> Option<LinkagePose> {
        let [rocker, link] = self.description.link_mm;
        let nut = Vector::new(self.description.fixed_joint_mm, slider_mm);
        let apart = nut.norm();
        let along = (rocker * rocker - link * link + apart * apart) / (2.0 * apart);
        let square = (rocker - along) * (rocker + along);
        let reached = square >= 0.0 && self.is_on_the_same_way(slider_mm);
        reached.then(|| {
            let across = self.side * square.sqrt();
            let base = (nut * along + Vector::new(-nut.y, nut.x) * across) / apart;
            let rest = nut - base;
            LinkagePose { slider_mm, phi1_rad: base.y.atan2(-base.x), phi2_rad: rest.y.atan2(rest.x), base }
        })
    }

    /// Whether the nut can move from its height at motor angle 0 to the height `slider_mm` (mm) without passing heights at which the linkage cannot close.
    fn is_on_the_same_way(&self, slider_mm: f64) -> bool {
        self.least_slider_mm().is_none() || slider_mm.signum() == self.description.slider_mm.signum()
    }

    /// Smallest distance between the heights of nut and fixed joint, mm. `None` if the linkage lets the nut pass the height of the fixed joint.
    fn least_slider_mm(&self) -> Option<f64> {
        let [rocker, link] = self.description.link_mm;
        let square = (rocker - link).powi(2) - self.description.fixed_joint_mm.powi(2);
        (square >= 0.0).then(|| square.sqrt())
    }

    /// Placements of the two fingers in the gripper's frame, left finger first. The frame has its origin on the screw's axis, x to the right and y towards
    /// the tips.
    pub fn fingers(&self, pose: &LinkagePose) -> [Placement; 2] {
        let across = Vector::new(self.description.fixed_joint_mm, 0.0);
        let left = Placement { origin: pose.base - across, angle_rad: 0.5 * PI + pose.phi2_rad, mirrored: true };
        let origin = Vector::new(-left.origin.x, left.origin.y);
        [left, Placement { origin, angle_rad: 0.5 * PI - pose.phi2_rad, mirrored: false }]
    }

    /// Motor angles at the two ends of the nut's reach, degrees; the smaller angle first.
    pub fn reach_deg(&self) -> [f64; 2] {
        let [rocker, link] = self.description.link_mm;
        let most = ((rocker + link).powi(2) - self.description.fixed_joint_mm.powi(2)).max(0.0).sqrt();
        let ends = match self.least_slider_mm() {
            None => [-most, most],
            Some(least) if self.description.slider_mm < 0.0 => [-most, -least],
            Some(least) => [least, most],
        };
        ends.map(|slider_mm| self.motor_deg(slider_mm))
    }

    /// Distance between the tips of the two undeformed fingers, mm; negative if the tips have passed each other.
    pub fn opening_mm(&self, finger: &Finger, pose: &LinkagePose) -> f64 {
        2.0 * (self.description.fixed_joint_mm - pose.in_mechanism(finger.position(finger.tip())).x)
    }

    /// Change of the opening per revolution of the motor, mm; `None` in a singular pose.
    ///
    /// # Reference
    /// By eq. (7) the opening is 2 r cos(phi2 - beta), see [`motor_deg_for_opening`](Gripper::motor_deg_for_opening). The derivatives of eqs (7)
    /// and (8) give d phi2 / d l3 = sin phi1 / (l2 sin(phi1 + phi2)).
    pub fn opening_per_turn_mm(&self, finger: &Finger, pose: &LinkagePose) -> Option<f64> {
        let [radius_mm, beta_rad] = self.opening_arm(finger);
        let LinkagePose { phi1_rad, phi2_rad, .. } = *pose;
        let turn_per_mm = phi1_rad.sin() / (self.description.link_mm[1] * (phi1_rad + phi2_rad).sin());
        let by_turn_mm = -2.0 * radius_mm * (phi2_rad - beta_rad).sin();
        (!pose.is_singular()).then_some(by_turn_mm * turn_per_mm * self.description.screw_pitch_mm)
    }

    /// Motor angle, degrees, at which the tips of the undeformed fingers are `opening_mm` apart. If there are several such angles, returns the angle nearest to
    /// 0; `None` without such an angle.
    ///
    /// # Reference
    /// By eq. (7), the joint of rocker and link lies at x = l4 - l2 cos phi2. For a tip at (x, y) of the finger frame, the opening is therefore a single
    /// cosine: 2 ((l2 - y) cos phi2 + x sin phi2). Eq. (7) then gives phi1, and eq. (8) l3.
    pub fn motor_deg_for_opening(&self, finger: &Finger, opening_mm: f64) -> Option<f64> {
        let [rocker, link] = self.description.link_mm;
        let [radius_mm, beta_rad] = self.opening_arm(finger);
        let away_rad = (opening_mm / (2.0 * radius_mm)).acos();
        let motor_deg = [away_rad, -away_rad].into_iter().flat_map(|away_rad| {
            let phi2_rad = beta_rad + away_rad;
            let phi1_rad = ((link * phi2_rad.cos() - self.description.fixed_joint_mm) / rocker).acos();
            [phi1_rad, -phi1_rad]
                .map(|phi1_rad| (phi2_rad, self.motor_deg(rocker * phi1_rad.sin() + link * phi2_rad.sin())))
        });
        // Keeps the angles at which the pose has the assembly mode of this linkage. A NaN angle has no pose.
        let reached = motor_deg.filter(|(phi2_rad, motor_deg)| {
            let turned = self.pose(*motor_deg).map(|pose| (pose.phi2_rad - phi2_rad).rem_euclid(2.0 * PI));
            turned.is_some_and(|turned| turned.min(2.0 * PI - turned) < SINGULAR_SINE)
        });
        reached.map(|(_, motor_deg)| motor_deg).min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// Returns r (mm) and beta (rad) in the formula r cos(phi2 - beta) for half of the opening.
    fn opening_arm(&self, finger: &Finger) -> [f64; 2] {
        let tip = finger.position(finger.tip());
        let inwards = self.description.link_mm[1] - tip.y;
        [inwards.hypot(tip.x), tip.x.atan2(inwards)]
    }
}
