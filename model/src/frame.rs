//! A plane frame: nodes, supports and the beams between them, with rigid arms, pins and rigid links.
//!
//! This is what the solvers in [`crate::statics`] see; [`crate::mesh`] makes one from a finger, and verification
//! problems build theirs by hand.
//!
//! Translations belong to nodes. Rotations are separate: a node carries one, the *rotation slot* that its beams are
//! clamped to, but a pin gives a beam end a slot of its own, and a rigid link lets two nodes share one. So hinges and
//! undeformable members are exact, without penalty stiffness.

use crate::Vector;
use crate::element::{Beam, EndMotion, Response};
use nalgebra::{SMatrix, SVector};

/// Index of a node of a frame, from 0.
pub type NodeIndex = usize;
/// Index of a rotation slot, from 0; node `n` starts with slot `n`.
pub type RotationSlot = usize;

/// Axial and bending rigidity of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// EA, N.
    pub axial_rigidity_n: f64,
    /// EI, N mm^2.
    pub bending_rigidity_nmm2: f64,
}

impl Section {
    /// A rectangular strip of the given thickness (in the plane) and depth (out of it), for Young's modulus in MPa.
    pub fn rectangle(thickness_mm: f64, depth_mm: f64, youngs_modulus_mpa: f64) -> Section {
        let axial_rigidity_n = youngs_modulus_mpa * depth_mm * thickness_mm;
        Section { axial_rigidity_n, bending_rigidity_nmm2: axial_rigidity_n * thickness_mm * thickness_mm / 12.0 }
    }

    /// The same section with its modulus multiplied by a factor.
    pub fn scaled(self, factor: f64) -> Section {
        Section {
            axial_rigidity_n: self.axial_rigidity_n * factor,
            bending_rigidity_nmm2: self.bending_rigidity_nmm2 * factor,
        }
    }
}

/// Where a beam ends: at a node, at the end of a rigid arm that turns with `rotation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamEnd {
    /// The node.
    pub node: NodeIndex,
    /// The rotation the end is clamped to: the node's own, or a pin's.
    pub rotation: RotationSlot,
    /// From the node to the end of the beam, undeformed, mm; zero without an arm.
    pub arm: Vector,
}

/// A beam with its two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Member {
    /// The elastic part.
    pub beam: Beam,
    /// First and second end.
    pub ends: [BeamEnd; 2],
}

/// A node that follows another one rigidly: u = u_master + (R(rotation) - 1) lever.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RigidLink {
    master: NodeIndex,
    rotation: RotationSlot,
    lever: Vector,
}

/// A node of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FrameNode {
    position: Vector,
    rotation: RotationSlot,
    fixed: [bool; 2],
    link: Option<RigidLink>,
}

/// A plane frame. See the [module](self) for its parts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneFrame {
    nodes: Vec<FrameNode>,
    rotation_fixed: Vec<bool>,
    members: Vec<Member>,
}

impl PlaneFrame {
    /// A frame without nodes.
    pub fn new() -> PlaneFrame {
        PlaneFrame::default()
    }

    /// Adds a free node at a position in mm and gives it a rotation slot.
    pub fn add_node(&mut self, position: Vector) -> NodeIndex {
        let rotation = self.add_rotation();
        self.nodes.push(FrameNode { position, rotation, fixed: [false; 2], link: None });
        self.nodes.len() - 1
    }

    /// Adds a rotation slot that belongs to no node: a pin for the beams clamped to it.
    pub fn add_rotation(&mut self) -> RotationSlot {
        self.rotation_fixed.push(false);
        self.rotation_fixed.len() - 1
    }

    /// Holds a node in x, y and rotation, each where `true`.
    pub fn support(&mut self, node: NodeIndex, [x, y, rotation]: [bool; 3]) {
        let at = &mut self.nodes[node];
        at.fixed = [x, y];
        self.rotation_fixed[at.rotation] = rotation;
    }

    /// Joins two free nodes by an undeformable bar. `hinged`: pinned at both nodes; otherwise they turn together.
    ///
    /// The second node loses its translations, which follow from the first node's and the bar's rotation.
    pub fn link_rigidly(&mut self, first: NodeIndex, second: NodeIndex, hinged: bool) {
        let lever = self.position(second) - self.position(first);
        let rotation = if hinged {
            self.add_rotation()
        } else {
            self.nodes[second].rotation = self.nodes[first].rotation;
            self.nodes[first].rotation
        };
        self.nodes[second].link = Some(RigidLink { master: first, rotation, lever });
    }

    /// A beam end clamped to a node, without an arm.
    pub fn clamped_end(&self, node: NodeIndex) -> BeamEnd {
        BeamEnd { node, rotation: self.nodes[node].rotation, arm: Vector::zeros() }
    }

    /// Adds a beam between two ends. Direction and length follow from the nodes and the arms.
    pub fn add_member(&mut self, ends: [BeamEnd; 2], section: Section) -> usize {
        let between = self.position(ends[1].node) + ends[1].arm - self.position(ends[0].node) - ends[0].arm;
        let length_mm = between.norm();
        let beam = Beam {
            direction: between / length_mm,
            length_mm,
            axial_rigidity_n: section.axial_rigidity_n,
            bending_rigidity_nmm2: section.bending_rigidity_nmm2,
        };
        self.members.push(Member { beam, ends });
        self.members.len() - 1
    }

    /// Adds a beam clamped to both nodes.
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
pub struct FrameMotion {
    /// Displacement of each node, mm.
    pub displacements: Vec<Vector>,
    /// Rotation of each slot, rad.
    pub rotations: Vec<f64>,
}

impl FrameMotion {
    /// The frame at rest.
    pub fn at_rest(frame: &PlaneFrame) -> FrameMotion {
        FrameMotion {
            displacements: vec![Vector::zeros(); frame.nodes.len()],
            rotations: vec![0.0; frame.rotation_fixed.len()],
        }
    }

    /// Largest displacement of a node, mm.
    pub fn largest_displacement(&self) -> f64 {
        self.displacements.iter().map(|u| u.norm()).fold(0.0, f64::max)
    }
}

/// Coordinates on which the motion of a beam end may depend: x and y of its node (or of the node's master), the
/// rotation it is clamped to, the rotation of the node's rigid link.
const END_COORDINATES: usize = 4;
/// Coordinates of both ends.
pub(crate) const MEMBER_COORDINATES: usize = 2 * END_COORDINATES;

/// A point fixed rigidly to a node: its position depends on the node's translation, on `rotation` through `arm`, and on
/// the rotation of the rigid link that may carry the node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attachment {
    pub node: NodeIndex,
    pub rotation: RotationSlot,
    pub arm: Vector,
}

impl From<BeamEnd> for Attachment {
    fn from(end: BeamEnd) -> Attachment {
        Attachment { node: end.node, rotation: end.rotation, arm: end.arm }
    }
}

/// Numbers the unknowns of a frame: equation of each free translation and rotation, `None` where it is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Equations {
    translations: Vec<[Option<usize>; 2]>,
    rotations: Vec<Option<usize>>,
    count: usize,
}

impl Equations {
    /// Numbers nodes in their order, each with its x, y and rotation, then the remaining rotations.
    pub fn of(frame: &PlaneFrame) -> Equations {
        let mut count = 0;
        let mut next = || {
            count += 1;
            Some(count - 1)
        };
        let mut translations = vec![[None; 2]; frame.nodes.len()];
        let mut rotations = vec![None; frame.rotation_fixed.len()];
        // A slot that no beam, node or link uses would be a free unknown without stiffness.
        let mut used = vec![false; rotations.len()];
        for end in frame.members.iter().flat_map(|m| m.ends) {
            used[end.rotation] = true;
        }
        for link in frame.nodes.iter().filter_map(|node| node.link) {
            used[link.rotation] = true;
        }
        for (node, equation) in frame.nodes.iter().zip(&mut translations) {
            if node.link.is_none() {
                *equation = node.fixed.map(|fixed| if fixed { None } else { next() });
            }
            let slot = node.rotation;
            if used[slot] && !frame.rotation_fixed[slot] && rotations[slot].is_none() {
                rotations[slot] = next();
            }
        }
        for slot in 0..rotations.len() {
            if used[slot] && !frame.rotation_fixed[slot] && rotations[slot].is_none() {
                rotations[slot] = next();
            }
        }
        Equations { translations, rotations, count }
    }

    /// Number of unknowns.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds a correction of all unknowns to a motion and lets linked nodes follow.
    pub fn advance(&self, frame: &PlaneFrame, motion: &mut FrameMotion, correction: &[f64], linear: bool) {
        for (u, equations) in motion.displacements.iter_mut().zip(&self.translations) {
            for (value, equation) in u.iter_mut().zip(equations) {
                *value += equation.map_or(0.0, |e| correction[e]);
            }
        }
        for (value, equation) in motion.rotations.iter_mut().zip(&self.rotations) {
            *value += equation.map_or(0.0, |e| correction[e]);
        }
        for (n, node) in frame.nodes.iter().enumerate() {
            if let Some(link) = node.link {
                motion.displacements[n] =
                    motion.displacements[link.master] + swing(link.lever, motion.rotations[link.rotation], linear);
            }
        }
    }

    /// Equations of the coordinates that an attachment depends on.
    fn of_attachment(&self, frame: &PlaneFrame, at: &Attachment) -> [Option<usize>; END_COORDINATES] {
        let node = &frame.nodes[at.node];
        let carrier = node.link.map_or(at.node, |link| link.master);
        let [x, y] = self.translations[carrier];
        [x, y, self.rotations[at.rotation], node.link.and_then(|link| self.rotations[link.rotation])]
    }

    /// Equations of the coordinates of a pair of attachments.
    pub(crate) fn of_pair(&self, frame: &PlaneFrame, ends: &[Attachment; 2]) -> [Option<usize>; MEMBER_COORDINATES] {
        let [a, b] = ends.map(|end| self.of_attachment(frame, &end));
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]
    }
}

/// Displacement of the end of a lever that turns by `rotation`: (R - 1) lever, without cancellation for small turns.
fn swing(lever: Vector, rotation: f64, linear: bool) -> Vector {
    let quarter = Vector::new(-lever.y, lever.x);
    if linear {
        return quarter * rotation;
    }
    let half = (0.5 * rotation).sin();
    quarter * rotation.sin() - lever * (2.0 * half * half)
}

/// The lever turned by `rotation` (or left as it is), mm.
fn turned(lever: Vector, rotation: f64, linear: bool) -> Vector {
    if linear { lever } else { lever + swing(lever, rotation, false) }
}

impl PlaneFrame {
    /// Motion of an attached point.
    pub(crate) fn motion_at(&self, motion: &FrameMotion, at: &Attachment, linear: bool) -> EndMotion {
        let rotation = motion.rotations[at.rotation];
        EndMotion { displacement: motion.displacements[at.node] + swing(at.arm, rotation, linear), rotation }
    }

    /// First derivatives of an attached point's x, y and rotation by its [`END_COORDINATES`], and the two levers,
    /// turned, that its second derivatives are made of.
    fn attachment_derivatives(
        &self,
        motion: &FrameMotion,
        at: &Attachment,
        linear: bool,
    ) -> (SMatrix<f64, 3, END_COORDINATES>, [Vector; 2]) {
        let arm = turned(at.arm, motion.rotations[at.rotation], linear);
        let lever = self.nodes[at.node]
            .link
            .map_or(Vector::zeros(), |link| turned(link.lever, motion.rotations[link.rotation], linear));
        let first = SMatrix::<f64, 3, END_COORDINATES>::new(
            1.0, 0.0, -arm.y, -lever.y, //
            0.0, 1.0, arm.x, lever.x, //
            0.0, 0.0, 1.0, 0.0,
        );
        (first, [arm, lever])
    }

    /// Chain rule from the motions of two attached points to the coordinates of the frame.
    ///
    /// The points move on circles about their nodes, so a turned lever v adds -f . v to the second derivative by its
    /// rotation, f the gradient at the point.
    pub(crate) fn pull_back(
        &self,
        motion: &FrameMotion,
        ends: &[Attachment; 2],
        response: &Response,
        linear: bool,
    ) -> (SVector<f64, MEMBER_COORDINATES>, SMatrix<f64, MEMBER_COORDINATES, MEMBER_COORDINATES>) {
        let mut first = SMatrix::<f64, 6, MEMBER_COORDINATES>::zeros();
        let mut second = SVector::<f64, MEMBER_COORDINATES>::zeros();
        for (i, end) in ends.iter().enumerate() {
            let (derivatives, levers) = self.attachment_derivatives(motion, end, linear);
            first.fixed_view_mut::<3, END_COORDINATES>(3 * i, END_COORDINATES * i).copy_from(&derivatives);
            if !linear {
                let force = Vector::new(response.gradient[3 * i], response.gradient[3 * i + 1]);
                for (k, lever) in levers.iter().enumerate() {
                    second[END_COORDINATES * i + 2 + k] = -force.dot(lever);
                }
            }
        }
        let gradient = first.transpose() * response.gradient;
        let mut tangent = first.transpose() * response.tangent * first;
        for k in 0..MEMBER_COORDINATES {
            tangent[(k, k)] += second[k];
        }
        (gradient, tangent)
    }
}
