//! Potentials of the loads, as functions of the motions of the key nodes and of the elements between key nodes.

use super::Location;
use crate::Kinematics;
use crate::element::Response;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
use crate::number::Number;
use nalgebra::{SMatrix, SVector};
use std::ops::Range;

/// Derivatives of the loads' potential with respect to the motion of one key node.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnNode<R> {
    /// First derivatives with respect to x and y (N) and to the rotation (N mm).
    pub gradient: [R; 3],
    /// Second derivative with respect to the rotation, N mm. This derivative is not zero for a load on a rigid arm, because the end of the arm moves
    /// on a circle.
    pub curvature: R,
    /// Second derivative with respect to x and with respect to y, N/mm: springs that hold the node.
    pub spring: R,
}

/// Potentials of all loads at one motion of the finger.
#[derive(Debug, Clone)]
pub(super) struct Applied<R> {
    nothing: OnNode<R>,
    /// Potentials on key nodes: back and front node of each rib, then the tip.
    on_nodes: Vec<OnNode<R>>,
    /// Index of each loaded element, with the potential of the loads between its two nodes or on its first node.
    on_members: Vec<(usize, Response<R>)>,
}

impl<R: Number> Applied<R> {
    /// No loads, for a ladder of `rungs` rungs (one per rib), in the number type of `like`.
    pub(super) fn none(rungs: usize, like: R) -> Applied<R> {
        let nothing = OnNode { gradient: [like.zero(); 3], curvature: like.zero(), spring: like.zero() };
        Applied { nothing, on_nodes: vec![nothing; 2 * rungs + 1], on_members: Vec::new() }
    }

    /// Removes all loads.
    pub(super) fn clear(&mut self) {
        self.on_nodes.fill(self.nothing);
        self.on_members.clear();
    }

    /// The loads on a key node of a rung (one per rib, from the base). `row` is 0 for the back node and 3 for the front node.
    #[inline(always)]
    pub(super) fn on_rung(&self, rung: usize, row: usize) -> &OnNode<R> {
        &self.on_nodes[2 * rung + row / 3]
    }

    /// The loads on the tip.
    #[inline(always)]
    pub(super) fn on_tip(&self) -> &OnNode<R> {
        &self.on_nodes[self.on_nodes.len() - 1]
    }

    /// The loads on an element between key nodes; `None` without loads.
    #[inline(always)]
    pub(super) fn on_member(&self, member: usize) -> Option<&Response<R>> {
        self.on_members.iter().find(|(loaded, _)| *loaded == member).map(|(_, potential)| potential)
    }

    /// Whether a load acts on at least one element of a range.
    #[inline(always)]
    pub(super) fn on_any_member(&self, members: &Range<usize>) -> bool {
        self.on_members.iter().any(|(loaded, _)| members.contains(loaded))
    }

    /// Adds `factor` times the loads in one SIMD lane. `motion` is the motion in that lane.
    pub(super) fn add(
        &mut self,
        lane: usize,
        (mesh, kinematics): (&Mesh, Kinematics),
        motion: &FrameMotion,
        loads: &[FrameLoad],
        factor: f64,
    ) {
        let frame = mesh.frame();
        for load in loads {
            if let FrameLoad::Interior { member, xi, force } = *load {
                let potential = frame.interior_load(motion, member, kinematics, xi, force * factor);
                self.add_to_member(lane, member, &potential);
                continue;
            }
            let (end, force, moment_nmm) = load.at_end(frame);
            let linear = kinematics == Kinematics::Linear;
            let potential = frame.end_load(motion, end, force * factor, moment_nmm * factor, linear);
            let place = location(mesh, end.node);
            if let Location::Inside { line, element } = place {
                self.add_to_member(lane, mesh.lines()[line].members.start + element, &potential);
                continue;
            }
            // A load on a clamped node causes no motion.
            let Some(OnNode { gradient, curvature, .. }) = self.on_node_mut(place) else { continue };
            for (sum, part) in gradient.iter_mut().zip(&potential.gradient) {
                add_in_lane(sum, lane, *part);
            }
            add_in_lane(curvature, lane, potential.tangent[(2, 2)]);
        }
    }

    /// Loads on the key node at a location; `None` for a clamped node or a node inside a line.
    fn on_node_mut(&mut self, place: Location) -> Option<&mut OnNode<R>> {
        match place {
            Location::Rung { rung, row } => self.on_nodes.get_mut(2 * rung + row / 3),
            Location::Tip => self.on_nodes.last_mut(),
            Location::Clamped | Location::Inside { .. } => None,
        }
    }

    fn add_to_member(&mut self, lane: usize, member: usize, potential: &Response) {
        let found = self.on_members.iter().position(|(loaded, _)| *loaded == member);
        let index = found.unwrap_or_else(|| {
            let zero = self.nothing.curvature;
            let none = Response { energy: zero, gradient: SVector::repeat(zero), tangent: SMatrix::repeat(zero) };
            self.on_members.push((member, none));
            self.on_members.len() - 1
        });
        let (_, sum) = &mut self.on_members[index];
        let pairs = sum.gradient.iter_mut().zip(&potential.gradient);
        for (sum, part) in pairs.chain(sum.tangent.iter_mut().zip(&potential.tangent)) {
            add_in_lane(sum, lane, *part);
        }
    }
}

impl Applied<f64> {
    /// Adds springs of `stiffness` (N/mm) that hold every key node at its displacement in `from`.
    pub(super) fn add_springs(&mut self, mesh: &Mesh, motion: &FrameMotion, (stiffness, from): (f64, &FrameMotion)) {
        for node in 0..mesh.finger().key_node_count() {
            let moved = motion.displacements[node] - from.displacements[node];
            if let Some(on_node) = self.on_node_mut(location(mesh, node)) {
                on_node.gradient[0] += stiffness * moved.x;
                on_node.gradient[1] += stiffness * moved.y;
                on_node.spring += stiffness;
            }
        }
    }
}

fn add_in_lane<R: Number>(sum: &mut R, lane: usize, part: f64) {
    sum.set_lane(lane, sum.lane(lane) + part);
}

/// Location of a frame node in the ladder. A tied node has the location of the node to which it is tied.
pub(super) fn location(mesh: &Mesh, node: usize) -> Location {
    let (finger, node) = (mesh.finger(), mesh.frame().tied_to(node));
    if node == mesh.frame_node(finger.tip()) {
        return Location::Tip;
    }
    let mut ribs = (0..finger.rib_count()).map(|rung| (rung, finger.rib_nodes(rung).map(|id| mesh.frame_node(id))));
    if let Some((rung, [front, _])) = ribs.find(|(_, nodes)| nodes.contains(&node)) {
        return Location::Rung { rung, row: if node == front { 3 } else { 0 } };
    }
    let mut lines = mesh.lines().iter().enumerate();
    // Inner nodes of a line are numbered consecutively.
    let found = lines.find_map(|(line, along)| {
        let inner = &along.nodes[1..along.nodes.len() - 1];
        inner.binary_search(&node).ok().map(|i| Location::Inside { line, element: i + 1 })
    });
    found.unwrap_or(Location::Clamped)
}

/// Location of a load in the ladder.
pub(super) fn place(mesh: &Mesh, load: &FrameLoad) -> Location {
    if let FrameLoad::Interior { member, .. } = *load {
        let (line, element) = element_of(mesh, member);
        return Location::Inside { line, element };
    }
    location(mesh, load.at_end(mesh.frame()).0.node)
}

/// The index of the line that contains a member, and the member's index in that line.
pub(super) fn element_of(mesh: &Mesh, member: usize) -> (usize, usize) {
    let found = mesh.lines().iter().enumerate().find(|(_, line)| line.members.contains(&member));
    found.map_or((0, 0), |(index, line)| (index, member - line.members.start))
}
