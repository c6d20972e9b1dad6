//! A plane frame: nodes, supports, and beams with rigid arms, pins and rigid links.
//!
//! The solvers in [`crate::statics`] work on a frame. [`crate::mesh`] builds the frame of a finger; reference problems build their own frames.
//!
//! Translations belong to nodes. Rotations are numbered separately from the nodes: each rotation has a *rotation slot*. The beams clamped at a node
//! share the node's slot. A pin gives a beam end a separate slot; a rigid link without hinges lets two nodes share a slot. Rotation slots and rigid
//! links represent hinges and undeformable members exactly, without penalty stiffness.

mod equations;
mod links;
mod loads;
mod members;

pub use equations::Equations;
pub(crate) use equations::MEMBER_COORDINATES;
pub use loads::FrameLoad;
pub(crate) use members::{end_motions, swing};

use crate::Vector;
use crate::element::Beam;
use crate::number::Number;
use links::RigidLink;
use nalgebra::Vector2;

/// Index of a node in a frame, from 0.
pub type NodeIndex = usize;
/// Index of a rotation slot, from 0. Each node and each pin gets the next slot when it is added.
pub type RotationSlot = usize;

/// Rigidities of a beam's cross-section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Axial rigidity EA, N.
    pub axial_rigidity_n: f64,
    /// Bending rigidity EI, N mm^2.
    pub bending_rigidity_nmm2: f64,
    /// Ratio EA / (kappa G A) of axial to shear rigidity, dimensionless; zero for a beam without shear deformation.
    pub shear_flexibility: f64,
    /// Distances of the elastic axis from the beam's line at both ends, positive to the left of its direction, mm.
    pub axis_mm: [f64; 2],
}

impl Section {
    /// A rectangular strip with the given in-plane thickness (mm), out-of-plane depth (mm) and Young's modulus (MPa), without shear deformation.
    pub fn rectangle(thickness_mm: f64, depth_mm: f64, youngs_modulus_mpa: f64) -> Section {
        let axial_rigidity_n = youngs_modulus_mpa * depth_mm * thickness_mm;
        let bending_rigidity_nmm2 = axial_rigidity_n * thickness_mm * thickness_mm / 12.0;
        Section { axial_rigidity_n, bending_rigidity_nmm2, shear_flexibility: 0.0, axis_mm: [0.0; 2] }
    }

    /// Shear parameter Phi = 12 EI / (kappa G A L^2) of a beam of this section and of length L (mm), dimensionless.
    pub fn shear_parameter(&self, length_mm: f64) -> f64 {
        12.0 * self.bending_rigidity_nmm2 * self.shear_flexibility / (self.axial_rigidity_n * length_mm * length_mm)
    }

    /// Returns the section with all rigidities multiplied by a dimensionless factor.
    pub fn scaled(self, factor: f64) -> Section {
        Section {
            axial_rigidity_n: self.axial_rigidity_n * factor,
            bending_rigidity_nmm2: self.bending_rigidity_nmm2 * factor,
            ..self
        }
    }
}

/// End of a beam: at a node, or at the end of a rigid arm that starts at the node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamEnd<R = f64> {
    /// The node with which the end moves.
    pub node: NodeIndex,
    /// Rotation slot to which the end is clamped: the slot of the node or of a pin.
    pub rotation: RotationSlot,
    /// Undeformed vector from the node to the end of the beam, mm; zero without an arm.
    pub arm: Vector2<R>,
}

/// An elastic beam with its two ends in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member<R = f64> {
    /// The elastic beam between the ends.
    pub beam: Beam<R>,
    /// First and second end.
    pub ends: [BeamEnd<R>; 2],
}

/// A node of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FrameNode {
    /// Undeformed position, mm.
    position: Vector,
    /// Rotation slot of the node.
    rotation: RotationSlot,
    /// Whether the displacements of the node along x and along y are fixed.
    fixed: [bool; 2],
    /// The rigid link by which the node follows another node; `None` for an independent node.
    link: Option<RigidLink>,
}

/// A plane frame; the [module documentation](self) describes its parts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneFrame {
    nodes: Vec<FrameNode>,
    /// Whether each rotation slot is fixed.
    rotation_fixed: Vec<bool>,
    members: Vec<Member>,
}

impl PlaneFrame {
    /// Adds a free node at a position in mm, gives it a rotation slot, and returns its index.
    pub fn add_node(&mut self, position: Vector) -> NodeIndex {
        let rotation = self.add_rotation();
        self.nodes.push(FrameNode { position, rotation, fixed: [false; 2], link: None });
        self.nodes.len() - 1
    }

    /// Adds a rotation slot without a node and returns its index. A beam end that uses this slot is pinned to its node.
    pub fn add_rotation(&mut self) -> RotationSlot {
        self.rotation_fixed.push(false);
        self.rotation_fixed.len() - 1
    }

    /// Fixes (`true`) or frees (`false`) each of x, y and rotation of a node.
    pub fn support(&mut self, node: NodeIndex, [x, y, rotation]: [bool; 3]) {
        let at = &mut self.nodes[node];
        at.fixed = [x, y];
        self.rotation_fixed[at.rotation] = rotation;
    }

    /// A beam end clamped to a node without an arm.
    pub fn clamped_end(&self, node: NodeIndex) -> BeamEnd {
        BeamEnd { node, rotation: self.nodes[node].rotation, arm: Vector::zeros() }
    }

    /// Adds a beam between two ends and returns the index of the beam. Direction and length of the beam follow from the positions of nodes and arms.
    pub fn add_member(&mut self, ends: [BeamEnd; 2], section: Section) -> usize {
        let between = self.position(ends[1].node) + ends[1].arm - self.position(ends[0].node) - ends[0].arm;
        let length_mm = between.norm();
        let beam = Beam {
            direction: between / length_mm,
            length_mm,
            axial_rigidity_n: section.axial_rigidity_n,
            bending_rigidity_nmm2: section.bending_rigidity_nmm2,
            sway_factor: 1.0 / (1.0 + section.shear_parameter(length_mm)),
            axis_mm: section.axis_mm,
        };
        self.members.push(Member { beam, ends });
        self.members.len() - 1
    }

    /// Adds a beam clamped to both nodes and returns its index.
    pub fn add_beam(&mut self, first: NodeIndex, second: NodeIndex, section: Section) -> usize {
        self.add_member([self.clamped_end(first), self.clamped_end(second)], section)
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Undeformed position of a node, mm.
    pub fn position(&self, node: NodeIndex) -> Vector {
        self.nodes[node].position
    }

    /// The rotation slot of a node.
    pub fn rotation_of(&self, node: NodeIndex) -> RotationSlot {
        self.nodes[node].rotation
    }

    /// The beams, in the order in which they were added.
    pub fn members(&self) -> &[Member] {
        &self.members
    }
}

/// Displacements of all nodes and rotations of all slots of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameMotion<R = f64> {
    /// Displacement of each node, mm, by node index.
    pub displacements: Vec<Vector2<R>>,
    /// Rotation of each slot, rad, by slot index.
    pub rotations: Vec<R>,
}

impl FrameMotion {
    /// Adds `factor` (dimensionless) times a motion of the same frame.
    pub(crate) fn add(&mut self, other: &FrameMotion, factor: f64) {
        self.displacements.iter_mut().zip(&other.displacements).for_each(|(own, other)| *own += factor * other);
        self.rotations.iter_mut().zip(&other.rotations).for_each(|(own, other)| *own += factor * other);
    }

    /// The zero motion of a frame.
    pub fn at_rest(frame: &PlaneFrame) -> FrameMotion {
        FrameMotion::of_zeros(frame, 0.0)
    }

    /// Whether the motion has as many displacements and rotations as a frame.
    pub(crate) fn fits(&self, frame: &PlaneFrame) -> bool {
        self.displacements.len() == frame.nodes.len() && self.rotations.len() == frame.rotation_fixed.len()
    }

    /// Whether all displacements and rotations are zero.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.displacements.iter().all(|u| *u == Vector::zeros()) && self.rotations.iter().all(|turn| *turn == 0.0)
    }

    /// Largest magnitude of a node's displacement, mm.
    pub fn largest_displacement(&self) -> f64 {
        self.displacements.iter().map(|u| u.norm_squared()).fold(0.0, f64::max).sqrt()
    }

    /// Largest magnitude of a rotation, rad.
    pub fn largest_rotation(&self) -> f64 {
        self.rotations.iter().fold(0.0, |largest, rotation| rotation.abs().max(largest))
    }
}

impl<R: Number> FrameMotion<R> {
    /// The zero motion of a frame, in the number type of `like`.
    pub(crate) fn of_zeros(frame: &PlaneFrame, like: R) -> FrameMotion<R> {
        let zero = like.zero();
        FrameMotion {
            displacements: vec![Vector2::new(zero, zero); frame.nodes.len()],
            rotations: vec![zero; frame.rotation_fixed.len()],
        }
    }

    /// The motion of an empty frame, which has no nodes and no slots.
    pub(crate) fn empty() -> FrameMotion<R> {
        FrameMotion { displacements: Vec::new(), rotations: Vec::new() }
    }

    /// Copies the motion in one SIMD lane to a scalar motion.
    pub(crate) fn copy_lane(&self, lane: usize, motion: &mut FrameMotion) {
        for (u, lanes) in motion.displacements.iter_mut().zip(&self.displacements) {
            (u.x, u.y) = (lanes.x.lane(lane), lanes.y.lane(lane));
        }
        for (rotation, lanes) in motion.rotations.iter_mut().zip(&self.rotations) {
            *rotation = lanes.lane(lane);
        }
    }

    /// Overwrites the motion in one SIMD lane with a scalar motion.
    pub(crate) fn set_lane(&mut self, lane: usize, motion: &FrameMotion) {
        for (lanes, u) in self.displacements.iter_mut().zip(&motion.displacements) {
            lanes.x.set_lane(lane, u.x);
            lanes.y.set_lane(lane, u.y);
        }
        for (lanes, rotation) in self.rotations.iter_mut().zip(&motion.rotations) {
            lanes.set_lane(lane, *rotation);
        }
    }
}
