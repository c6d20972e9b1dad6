//! A fin-ray finger: geometry and material of two plates in a V and of the ribs between them.

mod description;
mod model_error;
mod one_piece;
mod placement;
mod sections;
mod side_faces;
mod stiffness_error;
mod thickness_error;

pub use description::*;
pub use model_error::{FingerKind, ModelError};
pub(crate) use sections::SectionFactors;
pub use side_faces::{SIDE_FACE_ERROR, SideFaces};
pub use stiffness_error::StiffnessError;
pub use thickness_error::{StiffnessChange, ThicknessError};

use crate::Vector;
use one_piece::OnePiece;
use placement::{check_lists, check_room, check_sizes, check_zones, place_ribs, place_tip};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Number of a key node. Key nodes are the ends of the plates and of the ribs. As in Xu et al. (2021), key nodes are numbered from 1: from the back
/// base along the back plate to the tip, then along the front plate to the front base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NodeId(pub usize);

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A point of a finger: a key node, or the joint of the rib at a key node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FingerPoint {
    /// A key node.
    Node(NodeId),
    /// The joint between a rib and its bracket. The node is the key node that carries the bracket.
    Hinge(NodeId),
}

/// A finger whose geometry has been checked, with the positions of its key nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Finger {
    description: FingerDescription,
    tip: Vector,
    /// Positions of the front and the back end of each rib along the plates, mm from the base.
    ribs: Vec<[f64; 2]>,
    /// Members by the rule for a finger of one piece; `None` without stated fillets.
    one_piece: Option<OnePiece>,
}

impl Finger {
    /// Checks a description and computes the positions of the key nodes.
    ///
    /// # Errors
    /// [`ImpossibleFinger`] with the offending key. Possible causes of the error are sizes out of range, plates that form no triangle, brackets
    /// without room for ribs, and rigid arms longer than the members. Other causes of the error are zones or ribs off the plates, and ribs that cross
    /// or coincide.
    pub fn new(description: FingerDescription) -> Result<Finger, ImpossibleFinger> {
        let d = &description;
        check_sizes(d)?;
        let tip = place_tip(d)?;
        let ribs = place_ribs(d)?;
        check_zones(d)?;
        let mut finger = Finger { tip, ribs, description, one_piece: None };
        check_lists(&finger)?;
        if let Some(fillets) = finger.description.fillets {
            finger.one_piece = Some(OnePiece::new(&finger, fillets)?);
        }
        check_room(&finger)?;
        Ok(finger)
    }

    /// The description of this finger.
    pub fn description(&self) -> &FingerDescription {
        &self.description
    }

    /// Number of ribs.
    pub fn rib_count(&self) -> usize {
        self.ribs.len()
    }

    /// Number of key nodes: 2 r + 3 for r ribs.
    pub fn key_node_count(&self) -> usize {
        2 * self.ribs.len() + 3
    }

    /// The key node at the tip, where the two plates meet.
    pub fn tip(&self) -> NodeId {
        NodeId(self.ribs.len() + 2)
    }

    /// The two clamped key nodes: at the base of the back plate, and at the base of the front plate.
    pub fn clamped_nodes(&self) -> [NodeId; 2] {
        [NodeId(1), NodeId(self.key_node_count())]
    }

    /// Whether a node is clamped. The clamped nodes are the base nodes and the ends of ribs in a corner of the base.
    pub fn is_clamped(&self, node: NodeId) -> bool {
        self.clamped_nodes().contains(&self.junction(node))
    }

    /// The node that represents all key nodes at the point of `node`. All key nodes at one point move and rotate together. The representative node is
    /// the base node if the base is at the point, otherwise the node of the rib nearest to the base. Returns `node` if no other key node is at this
    /// point.
    pub fn junction(&self, node: NodeId) -> NodeId {
        let last = self.key_node_count();
        if !(1..=last).contains(&node.0) {
            return node;
        }
        let (plate, mut level) =
            if node <= self.tip() { (Plate::Back, node.0 - 1) } else { (Plate::Front, last - node.0) };
        while level > 0 && self.level_mm(plate, level - 1) == self.level_mm(plate, level) {
            level -= 1;
        }
        NodeId(if plate == Plate::Back { level + 1 } else { last - level })
    }

    /// Whether two ribs share a junction with a plate, or a rib ends in a corner of the base.
    pub fn has_shared_junctions(&self) -> bool {
        (1..=self.key_node_count()).map(NodeId).any(|node| self.junction(node) != node)
    }

    /// The nodes of the front plate that can touch an object, one per point, from the tip to the last node before the front base.
    pub fn contact_nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> + ExactSizeIterator + Clone + use<> {
        let nodes = (self.tip().0..self.key_node_count()).map(NodeId);
        nodes.filter(|node| self.junction(*node) == *node).collect::<Vec<_>>().into_iter()
    }

    /// The nodes that are not clamped, in ascending order.
    pub fn free_nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> + ExactSizeIterator + Clone + use<> {
        let nodes = (2..self.key_node_count()).map(NodeId);
        nodes.filter(|node| !self.is_clamped(*node)).collect::<Vec<_>>().into_iter()
    }

    /// The free nodes with a marker, in ascending order; a camera measures these nodes.
    pub fn marked_nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> + ExactSizeIterator + Clone + use<> {
        self.free_nodes().filter(|node| self.has_marker(*node)).collect::<Vec<_>>().into_iter()
    }

    /// Front and back node of rib `index`; ribs are numbered from 0 at the base.
    pub fn rib_nodes(&self, index: usize) -> [NodeId; 2] {
        [NodeId(self.key_node_count() - 1 - index), NodeId(index + 2)]
    }

    /// The key nodes of a plate, from its base to the tip.
    pub fn plate_nodes(&self, part: Plate) -> Vec<NodeId> {
        match part {
            Plate::Back => (1..=self.tip().0).map(NodeId).collect(),
            Plate::Front => (self.tip().0..=self.key_node_count()).rev().map(NodeId).collect(),
        }
    }

    /// Positions of the [`plate_nodes`](Finger::plate_nodes) along the plate, mm from the base.
    pub fn plate_positions_mm(&self, part: Plate) -> Vec<f64> {
        (0..=self.rib_count() + 1).map(|level| self.level_mm(part, level)).collect()
    }

    /// Position along the plate of the [`plate_nodes`](Finger::plate_nodes) entry at index `level`, mm from the base.
    fn level_mm(&self, part: Plate, level: usize) -> f64 {
        let column = usize::from(part == Plate::Back);
        match level.checked_sub(1) {
            None => 0.0,
            Some(rib) => self.ribs.get(rib).map_or(self.plate_length_mm(part), |ends_mm| ends_mm[column]),
        }
    }

    /// Length of a plate, mm.
    pub fn plate_length_mm(&self, part: Plate) -> f64 {
        match part {
            Plate::Front => self.description.front_length_mm,
            Plate::Back => self.description.back_length_mm,
        }
    }

    /// Lengths of the rigid arms at both ends of a plate member, mm. A plate member is the segment between two neighbouring key nodes of a plate; its
    /// arms model rods, clips and rigid ends, or junctions with fillets. A member between ribs that share a junction has zero length and no arms. Members are numbered from 0 at
    /// the base.
    pub fn member_arms_mm(&self, part: Plate, member: usize) -> [f64; 2] {
        let [from_mm, to_mm] = [member, member + 1].map(|level| self.level_mm(part, level));
        if from_mm == to_mm {
            return [0.0; 2];
        }
        let side = usize::from(part == Plate::Back);
        let RigidEnds { base_mm, tip_mm } = self.description.rigid_ends[side];
        let clip_mm = self.description.ribs.clip_mm[side] / 2.0;
        let first = match member {
            0 => base_mm,
            // This member lies next to a rib that ends in a corner of the base.
            _ if from_mm == 0.0 => base_mm.max(clip_mm),
            _ => clip_mm,
        };
        let second = if member == self.rib_count() { tip_mm } else { clip_mm };
        let FingerDescription { rod_arm_mm, clamp_arm_mm, .. } = self.description;
        let at_clamp_mm = clamp_arm_mm.filter(|_| from_mm == 0.0).unwrap_or(rod_arm_mm);
        let one_piece = self.one_piece_member(part.into(), member);
        let [start_mm, end_mm] = one_piece.map_or([at_clamp_mm, rod_arm_mm], |member| member.arms_mm);
        [first.max(start_mm), second.max(end_mm)]
    }

    /// Lengths of the rigid arms at the front and the back end of a rib, mm; ribs are numbered from 0 at the base.
    pub fn rib_arms_mm(&self, index: usize) -> [f64; 2] {
        if let Some(member) = self.one_piece_member(Part::Ribs, index) {
            return member.arms_mm;
        }
        let FingerDescription { rod_arm_mm, rib_arm_mm, clamp_arm_mm, .. } = self.description;
        let arm_mm = rib_arm_mm.unwrap_or(rod_arm_mm);
        self.rib_nodes(index).map(|node| clamp_arm_mm.filter(|_| self.is_clamped(node)).unwrap_or(arm_mm))
    }

    /// Position of the clamped end of a plate, mm, finger frame.
    pub fn base(&self, part: Plate) -> Vector {
        let half = 0.5 * self.description.base_width_mm;
        match part {
            Plate::Front => Vector::new(0.0, half),
            Plate::Back => Vector::new(0.0, -half),
        }
    }

    /// Undeformed position of a point of a plate, mm, finger frame; `s_mm` is its distance from the base along the plate.
    pub fn plate_point(&self, part: Plate, s_mm: f64) -> Vector {
        let base = self.base(part);
        base + (self.tip - base) * (s_mm / self.plate_length_mm(part))
    }

    /// Undeformed position of a key node, mm, finger frame.
    pub fn position(&self, node: NodeId) -> Vector {
        let count = self.ribs.len();
        let last = self.key_node_count();
        match node.0 {
            n if n == count + 2 => self.tip,
            1 => self.base(Plate::Back),
            n if n == last => self.base(Plate::Front),
            n if n < count + 2 => self.plate_point(Plate::Back, self.ribs[n - 2][1]),
            n => self.plate_point(Plate::Front, self.ribs[last - 1 - n][0]),
        }
    }

    /// Unit normal of an undeformed plate, towards the other plate.
    pub fn inward(&self, part: Plate) -> Vector {
        let along = self.tangent(part);
        match part {
            Plate::Front => Vector::new(along.y, -along.x),
            Plate::Back => Vector::new(-along.y, along.x),
        }
    }

    /// Vector of the undeformed bracket at a key node, mm, from the node to the joint with the rib. Zero for a node without rib.
    pub fn bracket(&self, node: NodeId) -> Vector {
        let last = self.key_node_count();
        let bracket_mm = |rib: usize| self.description.ribs.bracket_mm.of(rib);
        match node.0 {
            n if n > 1 && n < self.tip().0 => self.inward(Plate::Back) * bracket_mm(n - 2)[1],
            n if n > self.tip().0 && n < last => self.inward(Plate::Front) * bracket_mm(last - 1 - n)[0],
            _ => Vector::zeros(),
        }
    }

    /// Undeformed position of the joint between a rib and its bracket, mm, finger frame. Equals the node's position if the node has no bracket or no rib.
    pub fn hinge(&self, node: NodeId) -> Vector {
        self.position(node) + self.bracket(node)
    }

    /// Whether any rib is joined to a plate by a bracket.
    pub fn has_brackets(&self) -> bool {
        self.rib_count() > 0
            && self.description.ribs.bracket_mm.all().iter().flatten().any(|length_mm| *length_mm != 0.0)
    }

    /// Length of a rib between its joints, mm; ribs are numbered from 0 at the base.
    pub fn rib_length_mm(&self, index: usize) -> f64 {
        let [front, back] = self.rib_nodes(index).map(|node| self.hinge(node));
        (front - back).norm()
    }

    /// Vector from a key node to its marker in the undeformed finger, mm; the vector rotates with the plate.
    pub fn marker_offset(&self, node: NodeId) -> Vector {
        match self.description.markers_on {
            MarkerPoints::Junctions => Vector::zeros(),
            MarkerPoints::Hinges => self.bracket(node),
        }
    }

    /// Undeformed position of a key node's marker, mm, finger frame.
    pub fn marker_position(&self, node: NodeId) -> Vector {
        self.position(node) + self.marker_offset(node)
    }

    /// Whether a node has a marker. If markers are on hinges, only the ends of ribs have a marker. Key nodes at the same point share the marker of their
    /// [`junction`](Finger::junction).
    pub fn has_marker(&self, node: NodeId) -> bool {
        let is_end_of_rib = || node != self.tip() && !self.is_clamped(node);
        self.junction(node) == node && (self.description.markers_on == MarkerPoints::Junctions || is_end_of_rib())
    }

    /// Undeformed position of a point, mm, finger frame.
    pub fn point(&self, point: FingerPoint) -> Vector {
        match point {
            FingerPoint::Node(node) => self.position(node),
            FingerPoint::Hinge(node) => self.hinge(node),
        }
    }

    /// Points along the front plate, the back plate, and each rib with its brackets, for drawings.
    pub fn outline(&self) -> Vec<(Part, Vec<FingerPoint>)> {
        let plates = [Plate::Front, Plate::Back].map(|plate| {
            (Part::from(plate), self.plate_nodes(plate).into_iter().map(FingerPoint::Node).collect::<Vec<_>>())
        });
        let rib = |index| {
            let [front, back] = self.rib_nodes(index);
            let joints = [FingerPoint::Hinge(back), FingerPoint::Hinge(front)];
            let points = [FingerPoint::Node(back)].into_iter().chain(joints).chain([FingerPoint::Node(front)]);
            let is_seen = |point: &FingerPoint| self.has_brackets() || matches!(point, FingerPoint::Node(_));
            (Part::Ribs, points.filter(is_seen).collect())
        };
        plates.into_iter().chain((0..self.rib_count()).map(rib)).collect()
    }

    /// Position of a node along the front plate, mm from the front base; `None` for nodes of the back plate.
    pub fn front_position_mm(&self, node: NodeId) -> Option<f64> {
        let from_base = self.key_node_count().checked_sub(node.0)?;
        self.plate_positions_mm(Plate::Front).get(from_base).copied()
    }

    /// Position of a key node on its plate; the tip counts as a node of the front plate.
    pub fn plate_position(&self, node: NodeId) -> PlatePosition {
        match self.front_position_mm(node) {
            Some(s_mm) => s_mm.into(),
            None => PlatePosition { plate: Plate::Back, s_mm: self.level_mm(Plate::Back, node.0 - 1) },
        }
    }

    /// Unit vector along an undeformed plate towards the tip.
    pub fn tangent(&self, plate: Plate) -> Vector {
        (self.tip - self.base(plate)).normalize()
    }

    /// Unit vector along the undeformed front plate towards the tip.
    pub fn front_tangent(&self) -> Vector {
        self.tangent(Plate::Front)
    }

    /// Unit vector at the angle `angle_deg` from the inward normal of the undeformed front plate; degrees, positive towards the tip.
    pub fn direction(&self, angle_deg: f64) -> Vector {
        self.direction_on(Plate::Front, angle_deg)
    }

    /// Unit vector at the angle `angle_deg` from the inward normal of an undeformed plate; degrees, positive towards the tip.
    pub fn direction_on(&self, plate: Plate, angle_deg: f64) -> Vector {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        self.inward(plate) * cos + self.tangent(plate) * sin
    }

    /// Angle between a direction and the inward normal of the undeformed front plate; degrees, positive towards the tip.
    pub fn angle_deg(&self, direction: Vector) -> f64 {
        self.angle_on_deg(Plate::Front, direction)
    }

    /// Angle between a direction and the inward normal of an undeformed plate; degrees, positive towards the tip.
    pub fn angle_on_deg(&self, plate: Plate, direction: Vector) -> f64 {
        direction.dot(&self.tangent(plate)).atan2(direction.dot(&self.inward(plate))).to_degrees()
    }

    /// Returns the finger with all moduli multiplied by a dimensionless factor.
    ///
    /// # Errors
    /// [`ImpossibleFinger`] if a modulus is no longer positive and finite.
    pub fn with_modulus_factor(&self, factor: f64) -> Result<Finger, ImpossibleFinger> {
        let mut description = self.description.clone();
        description.multiply_moduli(factor);
        Finger::new(description)
    }
}

/// One of the two side plates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Plate {
    /// The plate on the contact side (positive y).
    Front,
    /// The plate that faces away from the contact (negative y).
    Back,
}

/// A position on the middle line of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stored", into = "Stored")]
pub struct PlatePosition {
    /// The plate.
    pub plate: Plate,
    /// Distance from the plate's base along the undeformed plate, mm.
    pub s_mm: f64,
}

/// A position on the front plate, mm from its base.
impl From<f64> for PlatePosition {
    fn from(s_mm: f64) -> PlatePosition {
        PlatePosition { plate: Plate::Front, s_mm }
    }
}

/// Writes the distance from the base in mm, after `back:` on the back plate.
impl fmt::Display for PlatePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plate = if self.plate == Plate::Back { "back:" } else { "" };
        write!(f, "{plate}{}", self.s_mm)
    }
}

/// A [`PlatePosition`] in files: a number on the front plate, and otherwise the distance from the base of the back plate.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Stored {
    Front(f64),
    Back { back: f64 },
}

impl From<Stored> for PlatePosition {
    fn from(stored: Stored) -> PlatePosition {
        match stored {
            Stored::Front(s_mm) => s_mm.into(),
            Stored::Back { back } => PlatePosition { plate: Plate::Back, s_mm: back },
        }
    }
}

impl From<PlatePosition> for Stored {
    fn from(PlatePosition { plate, s_mm }: PlatePosition) -> Stored {
        if plate == Plate::Front { Stored::Front(s_mm) } else { Stored::Back { back: s_mm } }
    }
}

impl fmt::Display for Plate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Plate::Back { "back" } else { "front" })
    }
}

impl Plate {
    /// Index of the plate in arrays ordered `[front, back]`: 0 or 1.
    pub(crate) fn index(self) -> usize {
        usize::from(self == Plate::Back)
    }

    /// Sign of a rotation from x to y as a change of an angle on the plate, which counts from the inward normal towards the tip: 1 or -1.
    pub(crate) fn turn_sign(self) -> f64 {
        if self == Plate::Front { 1.0 } else { -1.0 }
    }
}

impl From<Plate> for Part {
    fn from(plate: Plate) -> Part {
        match plate {
            Plate::Front => Part::Front,
            Plate::Back => Part::Back,
        }
    }
}

/// A share in per cent with two decimals, for messages.
fn percent(share: f64) -> f64 {
    (1e4 * share).round() / 1e2
}
