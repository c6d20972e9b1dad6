//! A plane frame: nodes, supports and the beams between them, with rigid arms, pins and rigid links.
//!
//! This is what the solvers in [`crate::statics`] see; [`crate::mesh`] makes one from a finger, and verification
//! problems build theirs by hand.
//!
//! Translations belong to nodes. Rotations are separate: a node carries one, the *rotation slot* that its beams are
//! clamped to, but a pin gives a beam end a slot of its own, and a rigid link lets two nodes share one. So hinges and
//! undeformable members are exact, without penalty stiffness.

use crate::Vector;
use crate::element::{Beam, ElementVector, EndMotion, Kinematics, Response};
use crate::statics::FrameLoad;
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

    /// Moves linked nodes to where their masters and links carry them.
    pub(crate) fn follow_links(&self, motion: &mut FrameMotion, linear: bool) {
        for (n, node) in self.nodes.iter().enumerate() {
            if let Some(link) = node.link {
                motion.displacements[n] =
                    motion.displacements[link.master] + swing(link.lever, motion.rotations[link.rotation], linear);
            }
        }
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

/// Coordinates on which the motion of a node may depend: its x and y (or its master's), its rotation, the rotation of
/// its rigid link.
const NODE_COORDINATES: usize = 4;
/// Coordinates of two nodes.
pub(crate) const MEMBER_COORDINATES: usize = 2 * NODE_COORDINATES;

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
        frame.follow_links(motion, linear);
    }

    /// Equations of the coordinates that a beam end depends on.
    fn of_end(&self, frame: &PlaneFrame, end: &BeamEnd) -> [Option<usize>; NODE_COORDINATES] {
        let node = &frame.nodes[end.node];
        let carrier = node.link.map_or(end.node, |link| link.master);
        let [x, y] = self.translations[carrier];
        [x, y, self.rotations[end.rotation], node.link.and_then(|link| self.rotations[link.rotation])]
    }

    /// Equations of the coordinates of two beam ends.
    pub(crate) fn of_ends(&self, frame: &PlaneFrame, ends: &[BeamEnd; 2]) -> [Option<usize>; MEMBER_COORDINATES] {
        let [a, b] = ends.map(|end| self.of_end(frame, &end));
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

#[inline(always)]
fn end_motion(motion: &FrameMotion, end: &BeamEnd, linear: bool) -> EndMotion {
    let rotation = motion.rotations[end.rotation];
    let mut displacement = motion.displacements[end.node];
    if end.arm != Vector::zeros() {
        displacement += swing(end.arm, rotation, linear);
    }
    EndMotion { displacement, rotation }
}

/// The lever turned by `rotation` (or left as it is), mm.
fn turned(lever: Vector, rotation: f64, linear: bool) -> Vector {
    if linear { lever } else { lever + swing(lever, rotation, false) }
}

impl PlaneFrame {
    /// Motion of the elastic part's two ends.
    #[inline(always)]
    pub(crate) fn end_motions(&self, motion: &FrameMotion, ends: &[BeamEnd; 2], linear: bool) -> [EndMotion; 2] {
        // Not by `map`, which goes through memory.
        [end_motion(motion, &ends[0], linear), end_motion(motion, &ends[1], linear)]
    }

    /// Energy, nodal forces and tangent of a member by the motions of its two nodes, arms included.
    #[inline(always)]
    pub(crate) fn member_response(&self, motion: &FrameMotion, member: &Member, kinematics: Kinematics) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let motions = self.end_motions(motion, &member.ends, linear);
        let mut response = member.beam.response(kinematics, &motions);
        self.carry_over_arms(motion, &member.ends, &mut response, linear);
        response
    }

    /// Energy and nodal forces of a member with small displacements, arms included.
    pub(crate) fn member_linear_forces(&self, motion: &FrameMotion, member: &Member) -> (f64, ElementVector) {
        let motions = self.end_motions(motion, &member.ends, true);
        let (energy, mut gradient) = member.beam.linear_forces(&motions);
        for (i, end) in member.ends.iter().enumerate() {
            gradient[3 * i + 2] += end.arm.x * gradient[3 * i + 1] - end.arm.y * gradient[3 * i];
        }
        (energy, gradient)
    }

    /// Chain rule from the ends of the elastic part over the arms to the nodes.
    ///
    /// The end of an arm v moves on a circle about its node, so it adds -f . v to the second derivative by the
    /// rotation, f the gradient at the end.
    pub(crate) fn carry_over_arms(
        &self,
        motion: &FrameMotion,
        ends: &[BeamEnd; 2],
        response: &mut Response,
        linear: bool,
    ) {
        for (i, end) in ends.iter().enumerate().filter(|(_, end)| end.arm != Vector::zeros()) {
            let arm = turned(end.arm, motion.rotations[end.rotation], linear);
            let (x, y, theta) = (3 * i, 3 * i + 1, 3 * i + 2);
            let force = Vector::new(response.gradient[x], response.gradient[y]);
            response.gradient[theta] += arm.perp(&force);
            // Rotating by the node adds -arm.y times the row of x and arm.x times that of y; likewise the columns.
            let tangent = &mut response.tangent;
            for k in 0..6 {
                tangent[(theta, k)] += arm.x * tangent[(y, k)] - arm.y * tangent[(x, k)];
            }
            for k in 0..6 {
                tangent[(k, theta)] += arm.x * tangent[(k, y)] - arm.y * tangent[(k, x)];
            }
            if !linear {
                tangent[(theta, theta)] -= force.dot(&arm);
            }
        }
    }

    /// The lever that carries a linked node, in its current direction, and the slot it turns with.
    pub(crate) fn link_of(
        &self,
        node: NodeIndex,
        motion: &FrameMotion,
        linear: bool,
    ) -> Option<(RotationSlot, Vector)> {
        let link = self.nodes[node].link?;
        Some((link.rotation, turned(link.lever, motion.rotations[link.rotation], linear)))
    }

    /// Chain rule from two nodes to the coordinates of the frame, over the rigid links that may carry them; the second
    /// derivatives are those of [`carry_over_arms`](PlaneFrame::carry_over_arms).
    pub(crate) fn carry_over_links(
        &self,
        motion: &FrameMotion,
        nodes: [NodeIndex; 2],
        response: &Response,
        linear: bool,
    ) -> (SVector<f64, MEMBER_COORDINATES>, SMatrix<f64, MEMBER_COORDINATES, MEMBER_COORDINATES>) {
        let mut first = SMatrix::<f64, 6, MEMBER_COORDINATES>::zeros();
        let mut second = [0.0; 2];
        for (i, node) in nodes.into_iter().enumerate() {
            first.fixed_view_mut::<3, 3>(3 * i, NODE_COORDINATES * i).fill_with_identity();
            if let Some((_, lever)) = self.link_of(node, motion, linear) {
                let column = NODE_COORDINATES * i + 3;
                first[(3 * i, column)] = -lever.y;
                first[(3 * i + 1, column)] = lever.x;
                if !linear {
                    second[i] = -(response.gradient[3 * i] * lever.x + response.gradient[3 * i + 1] * lever.y);
                }
            }
        }
        let mut tangent = first.transpose() * response.tangent * first;
        for (i, second) in second.into_iter().enumerate() {
            tangent[(NODE_COORDINATES * i + 3, NODE_COORDINATES * i + 3)] += second;
        }
        (first.transpose() * response.gradient, tangent)
    }
}

/// Potentials of dead loads (minus their work), by the motions of the nodes that carry them.
impl PlaneFrame {
    /// Of a force between the ends of a member, by the motions of its two nodes.
    pub(crate) fn interior_load(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        xi: f64,
        force: Vector,
    ) -> Response {
        let linear = kinematics == Kinematics::Linear;
        let member = &self.members[member];
        let motions = self.end_motions(motion, &member.ends, linear);
        let mut potential = member.beam.interior_work(kinematics, xi, -force, &motions);
        self.carry_over_arms(motion, &member.ends, &mut potential, linear);
        potential
    }

    /// Of a force and moment at the end of an arm, by the motion of its node (the first three coordinates).
    pub(crate) fn end_load(
        &self,
        motion: &FrameMotion,
        end: BeamEnd,
        force: Vector,
        moment_nmm: f64,
        linear: bool,
    ) -> Response {
        let mut potential = Response { energy: 0.0, gradient: SVector::zeros(), tangent: SMatrix::zeros() };
        potential.gradient.fixed_rows_mut::<3>(0).copy_from_slice(&[-force.x, -force.y, -moment_nmm]);
        self.carry_over_arms(motion, &[end, end], &mut potential, linear);
        potential
    }

    /// How the forces of a load on its member's nodes change per mm that the load moves towards the second end.
    pub(crate) fn interior_load_slope(
        &self,
        motion: &FrameMotion,
        member: usize,
        kinematics: Kinematics,
        xi: f64,
        force: Vector,
    ) -> ElementVector {
        let linear = kinematics == Kinematics::Linear;
        let member = &self.members[member];
        let motions = self.end_motions(motion, &member.ends, linear);
        let gradient = member.beam.interior_load_slope(kinematics, xi, force, &motions);
        let mut slope = Response { energy: 0.0, gradient, tangent: SMatrix::zeros() };
        self.carry_over_arms(motion, &member.ends, &mut slope, linear);
        slope.gradient
    }

    /// The same for a load on an arm that lengthens in the direction `along` (undeformed).
    pub(crate) fn arm_load_slope(
        &self,
        motion: &FrameMotion,
        end: BeamEnd,
        along: Vector,
        force: Vector,
        linear: bool,
    ) -> ElementVector {
        let along = turned(along, motion.rotations[end.rotation], linear);
        ElementVector::new(0.0, 0.0, along.perp(&force), 0.0, 0.0, 0.0)
    }

    /// Rotation of what carries a load, rad.
    pub(crate) fn rotation_at(&self, motion: &FrameMotion, load: &FrameLoad) -> f64 {
        match *load {
            FrameLoad::Interior { member, xi, .. } => {
                let member = &self.members[member];
                member.beam.interior_rotation(xi, &self.end_motions(motion, &member.ends, false))
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => motion.rotations[load.at_end(self).0.rotation],
        }
    }
}
