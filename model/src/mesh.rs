//! A finger divided into beam elements.
//!
//! Members are the pieces of plate between key nodes, and the ribs. Each is divided evenly between its rigid arms.
//! Node `n` of the finger is node `n - 1` of the frame; the joints of ribs on brackets come next, then nodes made by refinement.

mod apportion;
mod prepared;
mod zones;

use crate::Vector;
use crate::finger::{Finger, FingerPoint, Joints, MarkerPoints, NodeId, Part, Plate, Zone};
use crate::frame::{BeamEnd, FrameLoad, FrameMotion, NodeIndex, PlaneFrame, Section, swing};
use prepared::Prepared;
use zones::{ElementPositions, mean_compliance};

/// Points at which a normal is taken that is averaged over a length of plate.
const NORMALS: usize = 5;

/// A dead load on a finger, in the finger frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Force (N) and moment (N mm) on a key node.
    Node {
        /// The node.
        node: NodeId,
        /// Force, N.
        force: Vector,
        /// Moment, N mm, from x to y.
        moment_nmm: f64,
    },
    /// Force (N) at a position of the front plate.
    Front {
        /// Position along the plate from the front base, mm.
        s_mm: f64,
        /// Force, N.
        force: Vector,
    },
}

impl Load {
    /// A force on a node, without moment.
    pub fn at_node(node: NodeId, force: Vector) -> Load {
        Load::Node { node, force, moment_nmm: 0.0 }
    }

    /// A force at a position of the front plate.
    pub fn at_position(s_mm: f64, force: Vector) -> Load {
        Load::Front { s_mm, force }
    }
}

/// A load that the finger cannot take.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LoadError {
    /// No such node.
    #[error("node {node} does not exist: the finger has the key nodes 1 to {key_nodes}")]
    NodeMissing {
        /// The node asked for.
        node: NodeId,
        /// Number of key nodes.
        key_nodes: usize,
    },
    /// The node is held.
    #[error("node {node} is clamped: a load there moves nothing and cannot be felt")]
    NodeClamped {
        /// The node asked for.
        node: NodeId,
    },
    /// The position is not on the free front plate.
    #[error(
        "the position s = {s_mm} mm is not on the front plate, which reaches from 0 (clamped) to {length_mm} mm (tip)"
    )]
    PositionOffPlate {
        /// The position asked for, mm.
        s_mm: f64,
        /// Length of the front plate, mm.
        length_mm: f64,
    },
}

/// Too few or too many nodes for a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected {fewest} (the key nodes alone) to {MOST_NODES} mesh nodes, found {found}")]
pub struct MeshSizeError {
    /// The smallest mesh of this finger.
    pub fewest: usize,
    /// The number that was given.
    pub found: usize,
}

/// Largest mesh that is made, far beyond any use.
const MOST_NODES: usize = 200_000;

/// A member, as the nodes along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its part.
    pub part: Part,
    /// Frame nodes from one key node to the other, both included; of a rib on brackets from joint to joint.
    pub nodes: Vec<NodeIndex>,
    /// Its elements in the same order, as members of the frame; empty for a rib that does not deform.
    pub members: std::ops::Range<usize>,
}

/// A piece of the front plate that a load may stand on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FrontSpan {
    /// A rigid arm and the node it belongs to.
    Arm { end: BeamEnd, node_mm: f64 },
    /// An elastic element.
    Element { member: usize, from_mm: f64, to_mm: f64 },
}

/// A finger divided into elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    finger: Finger,
    frame: PlaneFrame,
    lines: Vec<Line>,
    /// Pieces of the front plate from base to tip, each with the position where it ends.
    front: Vec<(f64, FrontSpan)>,
    /// Elements of each line, the base line last.
    elements: Vec<usize>,
    node_count: usize,
    prepared: Prepared,
}

impl Mesh {
    /// The coarsest mesh: one element a member, 25 nodes for the paper's finger.
    pub fn key_nodes(finger: &Finger) -> Mesh {
        Mesh::build(finger, &vec![1; line_lengths(finger).len()])
    }

    /// A mesh of `nodes` nodes. The members and the base line share `nodes - key nodes + lines` elements in proportion
    /// to their length, by largest remainder, at least one each; the base line lies between two clamps, so its elements
    /// are only counted.
    ///
    /// # Errors
    /// [`MeshSizeError`] for fewer nodes than key nodes, or absurdly many.
    pub fn with_nodes(finger: &Finger, nodes: usize) -> Result<Mesh, MeshSizeError> {
        let fewest = finger.key_node_count();
        if !(fewest..=MOST_NODES).contains(&nodes) {
            return Err(MeshSizeError { fewest, found: nodes });
        }
        let lengths = line_lengths(finger);
        Ok(Mesh::build(finger, &apportion::by_largest_remainder(nodes - fewest + lengths.len(), &lengths)))
    }

    /// A mesh with the same number of elements in every member.
    pub fn with_elements_per_member(finger: &Finger, elements: usize) -> Mesh {
        Mesh::build(finger, &vec![elements.max(1); line_lengths(finger).len()])
    }

    /// The same finger with every element divided into `times`.
    pub fn refined(&self, times: usize) -> Mesh {
        Mesh::build(&self.finger, &self.elements.iter().map(|elements| times.max(1) * elements).collect::<Vec<_>>())
    }

    /// Whether a member is one element only.
    pub fn has_single_elements(&self) -> bool {
        self.lines.iter().any(|line| line.members.len() == 1)
    }

    /// Number of elements, those of the base line and of undeformable ribs counted too.
    pub fn element_count(&self) -> usize {
        self.elements.iter().sum()
    }

    /// The finger that is meshed.
    pub fn finger(&self) -> &Finger {
        &self.finger
    }

    /// The frame that stands for the finger.
    pub fn frame(&self) -> &PlaneFrame {
        &self.frame
    }

    /// The members of the finger, for drawing.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Number of nodes, those of the base line and of undeformable ribs counted too.
    pub fn node_count(&self) -> usize {
        self.node_count
    }

    /// The frame node of a key node.
    pub fn frame_node(&self, node: NodeId) -> NodeIndex {
        node.0 - 1
    }

    /// The frame node of a key node's joint with its rib: that of the key node itself without brackets, or without rib.
    pub fn hinge_node(&self, node: NodeId) -> NodeIndex {
        hinge_node(&self.finger, node)
    }

    /// The frame node that the marker of a key node moves with.
    pub fn marker_node(&self, node: NodeId) -> NodeIndex {
        match self.finger.description().markers_on {
            MarkerPoints::Junctions => self.frame_node(node),
            MarkerPoints::Hinges => self.hinge_node(node),
        }
    }

    /// From a key node to its marker, mm, in its current direction, or undeformed.
    pub(crate) fn marker_lever(&self, node: NodeId, motion: &FrameMotion, linear: bool) -> Vector {
        let undeformed = self.finger.marker_offset(node);
        if linear {
            return undeformed;
        }
        undeformed + motion.displacements[self.marker_node(node)] - motion.displacements[self.frame_node(node)]
    }

    /// By how much the normal of the front plate is turned where a load acts, rad; the mean over a length of plate about it, as far as
    /// the plate goes.
    ///
    /// # Errors
    /// [`LoadError`] as of [`frame_load`](Mesh::frame_load).
    pub(crate) fn normal_turn(&self, motion: &FrameMotion, load: &Load, over_mm: f64) -> Result<f64, LoadError> {
        let at = |load: &Load| Ok(self.frame.rotation_at(motion, &self.frame_load(load)?));
        let middle_mm = match *load {
            Load::Front { s_mm, .. } => Some(s_mm),
            Load::Node { node, .. } => self.finger.front_position_mm(node),
        };
        let Some(middle_mm) = middle_mm.filter(|_| over_mm > 0.0) else { return at(load) };
        let length_mm = self.finger.plate_length_mm(Plate::Front);
        let mut sum = 0.0;
        for i in 0..NORMALS {
            let share = (i as f64 + 0.5) / NORMALS as f64 - 0.5;
            let s_mm = (middle_mm + share * over_mm).clamp(f64::EPSILON * length_mm, length_mm);
            sum += at(&Load::at_position(s_mm, Vector::zeros()))?;
        }
        Ok(sum / NORMALS as f64)
    }

    /// A point of the deformed front plate's middle line, mm.
    ///
    /// # Errors
    /// [`LoadError`] for a position that is not on the front plate.
    pub(crate) fn front_point(&self, motion: &FrameMotion, s_mm: f64) -> Result<Vector, LoadError> {
        let load = self.frame_load(&Load::at_position(s_mm, Vector::zeros()))?;
        Ok(self.finger.plate_point(Plate::Front, s_mm) + self.frame.displacement_at(motion, &load))
    }

    /// Places a load on the frame.
    ///
    /// # Errors
    /// [`LoadError`] for a node that is missing or clamped, or a position that is not on the front plate.
    pub fn frame_load(&self, load: &Load) -> Result<FrameLoad, LoadError> {
        match *load {
            Load::Node { node, force, moment_nmm } => {
                let key_nodes = self.finger.key_node_count();
                if !(1..=key_nodes).contains(&node.0) {
                    Err(LoadError::NodeMissing { node, key_nodes })
                } else if self.finger.clamped_nodes().contains(&node) {
                    Err(LoadError::NodeClamped { node })
                } else {
                    Ok(FrameLoad::Node { node: self.frame_node(node), force, moment_nmm })
                }
            }
            Load::Front { s_mm, force } => {
                let length_mm = self.finger.plate_length_mm(Plate::Front);
                let piece = (s_mm > 0.0).then(|| self.front.iter().find(|(end, _)| s_mm <= *end)).flatten();
                let Some((_, piece)) = piece else {
                    return Err(LoadError::PositionOffPlate { s_mm, length_mm });
                };
                Ok(match *piece {
                    FrontSpan::Arm { end, node_mm } => {
                        let arm = self.finger.front_tangent() * (s_mm - node_mm);
                        FrameLoad::Arm { end: BeamEnd { arm, ..end }, force }
                    }
                    FrontSpan::Element { member, from_mm, to_mm } => {
                        FrameLoad::Interior { member, xi: (s_mm - from_mm) / (to_mm - from_mm), force }
                    }
                })
            }
        }
    }

    /// Motions of the key nodes in a motion of the frame.
    pub fn shape(&self, motion: &FrameMotion) -> FingerShape {
        let motions = (1..=self.finger.key_node_count())
            .map(NodeId)
            .map(|node| {
                let index = self.frame_node(node);
                NodeMotion {
                    node,
                    position: self.frame.position(index),
                    displacement: motion.displacements[index],
                    rotation: motion.rotations[self.frame.rotation_of(index)],
                    hinge_position: self.finger.hinge(node),
                    hinge_displacement: motion.displacements[self.hinge_node(node)],
                }
            })
            .collect();
        FingerShape { motions }
    }

    fn build(finger: &Finger, elements: &[usize]) -> Mesh {
        let mut frame = PlaneFrame::new();
        for node in (1..=finger.key_node_count()).map(NodeId) {
            frame.add_node(finger.position(node));
        }
        for node in finger.clamped_nodes() {
            frame.support(node.0 - 1, [true; 3]);
        }
        if finger.has_brackets() {
            for node in (0..finger.rib_count()).flat_map(|rib| finger.rib_nodes(rib)) {
                frame.add_node(finger.hinge(node));
            }
        }
        // Links first: they decide which rotation the beams at a node are clamped to.
        for rib in 0..finger.rib_count() {
            link_rib(&mut frame, finger, rib);
        }
        let mut mesh = Mesh {
            finger: finger.clone(),
            frame,
            lines: Vec::new(),
            front: Vec::new(),
            elements: elements.to_vec(),
            node_count: finger.key_node_count() + elements.iter().map(|n| n - 1).sum::<usize>(),
            prepared: Prepared::default(),
        };
        let mut elements = elements.iter().copied();
        let mut next = || elements.next().unwrap_or(1);
        for plate in [Plate::Back, Plate::Front] {
            for member in 0..=finger.rib_count() {
                mesh.add_plate_member(plate, member, next());
            }
        }
        for rib in 0..finger.rib_count() {
            mesh.add_rib(rib, next());
        }
        mesh
    }

    fn add_plate_member(&mut self, plate: Plate, member: usize, elements: usize) {
        let arms_mm = self.finger.member_arms_mm(plate, member);
        let (nodes, positions) = (self.finger.plate_nodes(plate), self.finger.plate_positions_mm(plate));
        let (nodes, positions) = ([nodes[member], nodes[member + 1]], [positions[member], positions[member + 1]]);
        let along = (self.finger.plate_point(plate, 1.0) - self.finger.base(plate)).normalize();
        let [from, to] = nodes.map(|node| self.frame_node(node));
        let ends = [
            BeamEnd { arm: along * arms_mm[0], ..self.frame.clamped_end(from) },
            BeamEnd { arm: along * -arms_mm[1], ..self.frame.clamped_end(to) },
        ];
        let elements_at = ElementPositions::new(positions, arms_mm, elements);
        let free = elements_at.free();
        // `section` is there for plates by construction.
        let Some(section) = self.finger.section(plate.into()) else { return };
        let zones: Vec<Zone> =
            self.finger.description().zones.iter().filter(|zone| zone.part == Part::from(plate)).copied().collect();
        let position = |i: usize| elements_at.start(i);
        let sections: Vec<Section> = (0..elements)
            .map(|i| section.scaled(1.0 / mean_compliance(&zones, position(i), position(i + 1))))
            .collect();
        let first_member = self.frame.members().len();
        self.add_line(plate.into(), ends, &sections);
        if plate == Plate::Front {
            if arms_mm[0] > 0.0 {
                self.front.push((free[0], FrontSpan::Arm { end: ends[0], node_mm: positions[0] }));
            }
            for i in 0..elements {
                let member = first_member + i;
                let piece = FrontSpan::Element { member, from_mm: position(i), to_mm: position(i + 1) };
                self.front.push((position(i + 1), piece));
            }
            if arms_mm[1] > 0.0 {
                self.front.push((positions[1], FrontSpan::Arm { end: ends[1], node_mm: positions[1] }));
            }
        }
    }

    fn add_rib(&mut self, rib: usize, elements: usize) {
        let [front, back] = self.finger.rib_nodes(rib).map(|node| self.hinge_node(node));
        let Some(section) = self.finger.section(Part::Ribs) else {
            let at = self.frame.members().len();
            self.lines.push(Line { part: Part::Ribs, nodes: vec![back, front], members: at..at });
            return;
        };
        let along = (self.frame.position(front) - self.frame.position(back)).normalize();
        let arm = along * self.finger.description().rod_arm_mm;
        let hinged = self.finger.description().ribs.joints == Joints::Hinged;
        let ends = [(back, arm), (front, -arm)].map(|(node, arm)| {
            let rotation = if hinged { self.frame.add_rotation() } else { self.frame.rotation_of(node) };
            BeamEnd { node, rotation, arm }
        });
        let position = self.finger.plate_positions_mm(Plate::Front)[rib + 1];
        let zones = self.finger.description().zones.iter();
        let factor: f64 =
            zones.filter(|zone| zones::holds_rib(zone, position)).map(|zone| zone.modulus_factor).product();
        self.add_line(Part::Ribs, ends, &vec![section.scaled(factor); elements]);
    }

    /// Adds a straight chain of equal elements between two ends, one section each.
    fn add_line(&mut self, part: Part, ends: [BeamEnd; 2], sections: &[Section]) {
        let [from, to] = ends.map(|end| self.frame.position(end.node) + end.arm);
        let first_member = self.frame.members().len();
        let mut nodes = vec![ends[0].node];
        let mut before = ends[0];
        for (i, section) in sections.iter().enumerate() {
            let after = if i + 1 == sections.len() {
                ends[1]
            } else {
                let node = self.frame.add_node(from + (to - from) * ((i + 1) as f64 / sections.len() as f64));
                self.frame.clamped_end(node)
            };
            self.frame.add_member([before, after], *section);
            nodes.push(after.node);
            before = after;
        }
        self.lines.push(Line { part, nodes, members: first_member..self.frame.members().len() });
    }
}

/// See [`Mesh::hinge_node`].
fn hinge_node(finger: &Finger, node: NodeId) -> NodeIndex {
    let key_nodes = finger.key_node_count();
    let has_rib = node.0 > 1 && node.0 < key_nodes && node != finger.tip();
    match finger.has_brackets() && has_rib {
        // As [`Mesh::build`] adds them: front then back, from base to tip.
        true if node < finger.tip() => key_nodes + 2 * (node.0 - 2) + 1,
        true => key_nodes + 2 * (key_nodes - 1 - node.0),
        false => node.0 - 1,
    }
}

/// Links what moves rigidly with the ends of a rib: the brackets, and a rib that does not deform.
fn link_rib(frame: &mut PlaneFrame, finger: &Finger, rib: usize) {
    let [front, back] = finger.rib_nodes(rib).map(|node| node.0 - 1);
    let [front_hinge, back_hinge] = finger.rib_nodes(rib).map(|node| hinge_node(finger, node));
    let hinged = finger.description().ribs.joints == Joints::Hinged;
    let deforms = finger.description().ribs.strip.is_some();
    match (finger.has_brackets(), deforms, hinged) {
        (false, true, _) => {}
        (false, false, _) => frame.link_rigidly(back, front, hinged),
        (true, false, true) => {
            frame.link_rigidly(back, back_hinge, false);
            frame.link_rigidly(back_hinge, front_hinge, true);
            frame.link_rigidly(front_hinge, front, false);
        }
        (true, _, _) => {
            if !deforms {
                frame.link_rigidly(back, front, false);
            }
            frame.link_rigidly(back, back_hinge, false);
            frame.link_rigidly(front, front_hinge, false);
        }
    }
}

/// Lengths of the lines that share the elements: back plate and front plate from base to tip, ribs from base to tip,
/// base line.
fn line_lengths(finger: &Finger) -> Vec<f64> {
    let plates = [Plate::Back, Plate::Front].into_iter().flat_map(|plate| {
        let positions = finger.plate_positions_mm(plate);
        positions.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>()
    });
    let ribs = (0..finger.rib_count()).map(|rib| finger.rib_length_mm(rib));
    plates.chain(ribs).chain(std::iter::once(finger.description().base_width_mm)).collect()
}

/// Motion of one key node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeMotion {
    /// The node.
    pub node: NodeId,
    /// Undeformed position, mm.
    pub position: Vector,
    /// Displacement, mm.
    pub displacement: Vector,
    /// Rotation, rad; at a hinge the plate's.
    pub rotation: f64,
    /// Undeformed position of the joint of its rib, mm: its own where no bracket holds the rib off the plate.
    pub hinge_position: Vector,
    /// Displacement of that joint, mm.
    pub hinge_displacement: Vector,
}

impl NodeMotion {
    /// Undeformed position of the node's marker on a finger, mm.
    pub fn marker_position(&self, finger: &Finger) -> Vector {
        self.position + finger.marker_offset(self.node)
    }

    /// Displacement of the node's marker on a finger, mm.
    pub fn marker_displacement(&self, finger: &Finger) -> Vector {
        match finger.description().markers_on {
            MarkerPoints::Junctions => self.displacement,
            MarkerPoints::Hinges => self.hinge_displacement,
        }
    }
}

/// The key nodes of a deformed finger, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerShape {
    motions: Vec<NodeMotion>,
}

impl FingerShape {
    /// The shape in which every key node has the displacement (mm) and rotation (rad) that `motion` gives it.
    pub fn new(finger: &Finger, motion: impl FnMut(NodeId) -> (Vector, f64)) -> FingerShape {
        FingerShape::turning(finger, motion, false)
    }

    /// The same where rotations are small: brackets turn linearly.
    pub fn of_linear(finger: &Finger, motion: impl FnMut(NodeId) -> (Vector, f64)) -> FingerShape {
        FingerShape::turning(finger, motion, true)
    }

    fn turning(finger: &Finger, mut motion: impl FnMut(NodeId) -> (Vector, f64), linear: bool) -> FingerShape {
        let motions = (1..=finger.key_node_count()).map(NodeId).map(|node| {
            let (displacement, rotation) = motion(node);
            let hinge_displacement = displacement + swing(finger.bracket(node), rotation, linear);
            NodeMotion {
                node,
                position: finger.position(node),
                displacement,
                rotation,
                hinge_position: finger.hinge(node),
                hinge_displacement,
            }
        });
        FingerShape { motions: motions.collect() }
    }

    /// All key nodes in their order.
    pub fn motions(&self) -> &[NodeMotion] {
        &self.motions
    }

    /// One key node, which must be one of the finger's.
    pub fn motion(&self, node: NodeId) -> &NodeMotion {
        &self.motions[node.0 - 1]
    }

    /// Position of a point, mm.
    pub fn point(&self, point: FingerPoint) -> Vector {
        match point {
            FingerPoint::Node(node) => self.motion(node).position + self.motion(node).displacement,
            FingerPoint::Hinge(node) => self.motion(node).hinge_position + self.motion(node).hinge_displacement,
        }
    }

    /// Largest displacement of a key node, mm.
    pub fn largest_displacement_mm(&self) -> f64 {
        self.motions.iter().map(|m| m.displacement.norm()).fold(0.0, f64::max)
    }
}
