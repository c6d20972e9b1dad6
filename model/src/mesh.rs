//! A finger divided into beam elements.
//!
//! Members are the ribs, and the segments of the plates between key nodes. The length of each member between its rigid arms is divided into equal
//! elements. Key node `n` of the finger is node `n - 1` of the frame. The frame numbers the key nodes first, then the joints between ribs and
//! brackets, then the nodes inside members.

mod apportion;
mod build;
mod levels;
mod load;
mod prepared;
mod shape;
mod zones;

pub use levels::MeshLevels;
pub use load::{Load, LoadError};
pub use shape::{FingerShape, NodeMotion};

use crate::Vector;
use crate::finger::{Finger, MarkerPoints, NodeId, Part, PlatePosition};
use crate::frame::{BeamEnd, FrameLoad, FrameMotion, NodeIndex, PlaneFrame};
use build::{hinge_node, line_lengths};
use prepared::Prepared;

/// Number of points at which the normal of a plate segment is sampled to compute its mean.
const NORMALS: usize = 5;

/// Error for a requested number of mesh nodes that is too small or too large.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected {fewest} (one element per member) to {MOST_NODES} mesh nodes, found {found}")]
pub struct MeshSizeError {
    /// Number of nodes of the finger's coarsest mesh.
    pub fewest: usize,
    /// The requested number of nodes.
    pub found: usize,
}

/// Largest number of mesh nodes that is accepted.
const MOST_NODES: usize = 200_000;

/// A member of the finger, with its nodes and elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The part of the finger that the member belongs to.
    pub part: Part,
    /// Frame nodes along the member from one key node to the other, both included. For a rib on brackets, these nodes run from joint to joint.
    pub nodes: Vec<NodeIndex>,
    /// Indices of the member's elements in the frame, in the order of the nodes. Empty for an undeformable rib, and for a plate member between ribs that
    /// share a junction.
    pub members: std::ops::Range<usize>,
}

/// A segment of a plate that can carry a load.
#[derive(Debug, Clone, Copy, PartialEq)]
enum PlateSpan {
    /// A rigid arm with the position of its node along the plate, mm from the base.
    Arm { end: BeamEnd, node_mm: f64 },
    /// An elastic element, with its start and end along the plate, mm from the base.
    Element { member: usize, from_mm: f64, to_mm: f64 },
}

/// A finger divided into elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    finger: Finger,
    frame: PlaneFrame,
    lines: Vec<Line>,
    /// Groups of lines that are computed together in SIMD lanes; see [`Mesh::alike_lines`].
    alike: Vec<Vec<usize>>,
    /// Segments of front and back plate from base to tip, each with the position of the end nearer to the tip, mm from the base.
    plates: [Vec<(f64, PlateSpan)>; 2],
    /// Number of elements of each line (member of the finger); the last entry is for the base line.
    elements: Vec<usize>,
    /// Number of nodes, including those that are counted but not built.
    node_count: usize,
    prepared: Prepared,
}

impl Mesh {
    /// The coarsest mesh, with one element per member: 25 nodes for the paper's finger.
    pub fn key_nodes(finger: &Finger) -> Mesh {
        Mesh::build(finger, &vec![1; line_lengths(finger).len()])
    }

    /// A mesh of `nodes` nodes. `nodes - key nodes + lines` elements are distributed over members and base line in proportion to length, by the
    /// largest-remainder method. Each line has at least one element. The base line lies between two clamps, so its elements are counted but not
    /// built.
    ///
    /// # Errors
    /// [`MeshSizeError`] for fewer nodes than the finger has key nodes, or for more than 200 000.
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

    /// Returns the mesh with every element divided into `times` elements.
    pub fn refined(&self, times: usize) -> Mesh {
        Mesh::build(&self.finger, &self.elements.iter().map(|elements| times.max(1) * elements).collect::<Vec<_>>())
    }

    /// Whether at least one member consists of a single element.
    pub fn has_single_elements(&self) -> bool {
        self.lines.iter().any(|line| line.members.len() == 1)
    }

    /// Number of elements, including those that are counted but not built: on the base line and on undeformable ribs.
    pub fn element_count(&self) -> usize {
        self.elements.iter().sum()
    }

    /// The finger that this mesh divides.
    pub fn finger(&self) -> &Finger {
        &self.finger
    }

    /// The frame that consists of the finger's elements.
    pub fn frame(&self) -> &PlaneFrame {
        &self.frame
    }

    /// The members of the finger, each with its nodes and elements.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Groups of line indices for SIMD lanes. The lines of a group are all ribs or all plate members, and have equal numbers of elements.
    pub(crate) fn alike_lines(&self) -> &[Vec<usize>] {
        &self.alike
    }

    /// Number of nodes, including those that are counted but not built: on the base line and on undeformable ribs.
    pub fn node_count(&self) -> usize {
        self.node_count
    }

    /// The frame node that coincides with a key node.
    pub fn frame_node(&self, node: NodeId) -> NodeIndex {
        node.0 - 1
    }

    /// The frame node of the joint between a key node's bracket and its rib. Equals [`frame_node`](Mesh::frame_node) if the node has no rib, or if the
    /// finger has no brackets.
    pub fn hinge_node(&self, node: NodeId) -> NodeIndex {
        hinge_node(&self.finger, node)
    }

    /// The frame node that moves with the marker of a key node.
    pub fn marker_node(&self, node: NodeId) -> NodeIndex {
        match self.finger.description().markers_on {
            MarkerPoints::Junctions => self.frame_node(node),
            MarkerPoints::Hinges => self.hinge_node(node),
        }
    }

    /// Vector from a key node to its marker, mm: undeformed if `linear`, otherwise rotated by the motion.
    pub(crate) fn marker_lever(&self, node: NodeId, motion: &FrameMotion, linear: bool) -> Vector {
        let undeformed = self.finger.marker_offset(node);
        if linear {
            return undeformed;
        }
        undeformed + motion.displacements[self.marker_node(node)] - motion.displacements[self.frame_node(node)]
    }

    /// Rotation of the plate's normal at a load towards the tip, rad. The result is the mean over points of a plate segment of length `over_mm` with the load
    /// at its middle. Points beyond an end of the plate are moved to that end. If the length is zero, returns the rotation at the load alone.
    ///
    /// # Errors
    /// [`LoadError`] as for [`frame_load`](Mesh::frame_load).
    pub fn normal_turn(&self, motion: &FrameMotion, load: &Load, over_mm: f64) -> Result<f64, LoadError> {
        let PlatePosition { plate, s_mm: middle_mm } = match *load {
            Load::Plate { at, .. } => at,
            Load::Node { node, .. } => self.finger.plate_position(node),
        };
        let at = |load: &Load| Ok(plate.turn_sign() * self.frame.rotation_at(motion, &self.frame_load(load)?));
        let rotation = at(load)?;
        if over_mm <= 0.0 {
            return Ok(rotation);
        }
        let length_mm = self.finger.plate_length_mm(plate);
        let mut sum = 0.0;
        for i in 0..NORMALS {
            let share = (i as f64 + 0.5) / NORMALS as f64 - 0.5;
            let s_mm = (middle_mm + share * over_mm).clamp(f64::EPSILON * length_mm, length_mm);
            sum += at(&Load::at_position(PlatePosition { plate, s_mm }, Vector::zeros()))?;
        }
        Ok(sum / NORMALS as f64)
    }

    /// Position of a point on the middle line of a deformed plate, mm, finger frame.
    ///
    /// # Errors
    /// [`LoadError`] if the position is not on its plate.
    pub fn plate_point(&self, motion: &FrameMotion, at: impl Into<PlatePosition>) -> Result<Vector, LoadError> {
        let at = at.into();
        let load = self.frame_load(&Load::at_position(at, Vector::zeros()))?;
        Ok(self.finger.plate_point(at.plate, at.s_mm) + self.frame.displacement_at(motion, &load))
    }

    /// Converts a load on the finger to a load on the frame.
    ///
    /// # Errors
    /// [`LoadError`] for a node that does not exist or is clamped, or for a position off its plate.
    pub fn frame_load(&self, load: &Load) -> Result<FrameLoad, LoadError> {
        match *load {
            Load::Node { node, force, moment_nmm } => {
                let key_nodes = self.finger.key_node_count();
                if !(1..=key_nodes).contains(&node.0) {
                    Err(LoadError::NodeMissing { node, key_nodes })
                } else if self.finger.is_clamped(node) {
                    Err(LoadError::NodeClamped { node })
                } else {
                    Ok(FrameLoad::Node { node: self.frame_node(node), force, moment_nmm })
                }
            }
            Load::Plate { at: at @ PlatePosition { plate, s_mm }, force } => {
                let length_mm = self.finger.plate_length_mm(plate);
                let spans = &self.plates[plate.index()];
                let Some((_, span)) = (s_mm > 0.0).then(|| spans.iter().find(|(end, _)| s_mm <= *end)).flatten() else {
                    return Err(LoadError::PositionOffPlate { at, length_mm });
                };
                Ok(match *span {
                    PlateSpan::Arm { end, node_mm } => {
                        let arm = self.finger.tangent(plate) * (s_mm - node_mm);
                        FrameLoad::Arm { end: BeamEnd { arm, ..end }, force }
                    }
                    PlateSpan::Element { member, from_mm, to_mm } => {
                        FrameLoad::Interior { member, xi: (s_mm - from_mm) / (to_mm - from_mm), force }
                    }
                })
            }
        }
    }

    /// Motions of the key nodes for a given motion of the frame.
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
}
