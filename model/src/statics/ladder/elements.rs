//! The elements of one line, or of several lines in SIMD lanes, accessed through one trait.
//!
//! Lines are independent until they are condensed onto the key nodes. Lines with the same number of elements can therefore be computed by the same
//! instructions, one line per lane. Each line keeps its own beams, motion and loads.

use crate::element::Beam;
use crate::frame::{BeamEnd, FrameMotion, Member, NodeIndex, PlaneFrame, RotationSlot};
use crate::mesh::Line;
use crate::number::Number;
use nalgebra::Vector2;

/// Number of lanes of the widest supported SIMD register.
const MOST_LANES: usize = 8;

/// The elements of a line from one key node to the other, with the indices of the line's nodes in a motion.
pub(super) trait Elements<R: Number>: Copy {
    /// Number of elements.
    fn count(&self) -> usize;

    /// The element with the given index, counted from 0.
    fn member(&self, index: usize) -> Member<R>;

    /// The node before element `index`; if `index` is the number of elements, the node after the last element.
    fn node(&self, index: usize) -> NodeIndex;

    /// The rotation slot of the node that [`node`](Elements::node) returns.
    fn rotation(&self, index: usize) -> RotationSlot;
}

/// One line of a frame. The indices of the line's nodes and rotations refer to the motion of the frame.
#[derive(Clone, Copy)]
pub(super) struct OneLine<'a, R> {
    pub frame: &'a PlaneFrame,
    pub line: &'a Line,
    /// An arbitrary value of the number type, from which other values of this type are made.
    pub like: R,
}

impl<R: Number> Elements<R> for OneLine<'_, R> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.line.members.len()
    }

    #[inline(always)]
    fn member(&self, index: usize) -> Member<R> {
        self.frame.members()[self.line.members.start + index].in_numbers(self.like)
    }

    #[inline(always)]
    fn node(&self, index: usize) -> NodeIndex {
        self.line.nodes[index]
    }

    #[inline(always)]
    fn rotation(&self, index: usize) -> RotationSlot {
        self.frame.rotation_of(self.line.nodes[index])
    }
}

/// Lines with equal numbers of elements, one line per lane. The common motion of the lines lists nodes and rotations from the first to the last node,
/// then the rotations to which the ends are clamped.
#[derive(Clone, Copy)]
pub(super) struct ParallelLines<'a, R> {
    frame: &'a PlaneFrame,
    /// The line in each lane. Unused lanes repeat the last line.
    lines: [&'a Line; MOST_LANES],
    members: [&'a [Member]; MOST_LANES],
    /// Indices of each line's first inner node and of this node's rotation slot. The indices of the line's other inner nodes and rotation slots
    /// follow consecutively.
    inner: [(NodeIndex, RotationSlot); MOST_LANES],
    like: R,
}

impl<'a, R: Number> ParallelLines<'a, R> {
    /// Assigns the lines with the given indices to lanes.
    #[inline(always)]
    pub(super) fn new(frame: &'a PlaneFrame, all: &'a [Line], lines: &[usize], like: R) -> ParallelLines<'a, R> {
        let members_of = |line: &Line| &frame.members()[line.members.clone()];
        let first = &all[lines[0]];
        let mut abreast = ParallelLines {
            frame,
            lines: [first; MOST_LANES],
            members: [members_of(first); MOST_LANES],
            inner: [(0, 0); MOST_LANES],
            like,
        };
        for lane in 0..R::LANES {
            let line = &all[lines[lane.min(lines.len() - 1)]];
            let members = members_of(line);
            let inner = members[0].ends[1];
            (abreast.lines[lane], abreast.members[lane]) = (line, members);
            abreast.inner[lane] = (inner.node, inner.rotation);
        }
        abreast
    }

    /// Copies the motion of the lines from the motion of the frame.
    #[inline(always)]
    pub(super) fn take_motion(&self, of_frame: &FrameMotion, motion: &mut FrameMotion<R>) {
        let (count, like) = (self.count(), self.like);
        motion.displacements.resize(count + 1, Vector2::new(like, like));
        motion.rotations.resize(count + 3, like);
        for i in 1..count {
            let at = |lane: usize| &of_frame.displacements[self.inner[lane].0 + i - 1];
            motion.displacements[i] = Vector2::new(like.of_lanes(|lane| at(lane).x), like.of_lanes(|lane| at(lane).y));
            motion.rotations[i] = like.of_lanes(|lane| of_frame.rotations[self.inner[lane].1 + i - 1]);
        }
        for (i, element, end) in [(0, 0, 0), (count, count - 1, 1)] {
            let node = |lane: usize| self.lines[lane].nodes[i];
            let at = |lane: usize| &of_frame.displacements[node(lane)];
            motion.displacements[i] = Vector2::new(like.of_lanes(|lane| at(lane).x), like.of_lanes(|lane| at(lane).y));
            motion.rotations[i] = like.of_lanes(|lane| of_frame.rotations[self.frame.rotation_of(node(lane))]);
            let rotation = |lane: usize| of_frame.rotations[self.members[lane][element].ends[end].rotation];
            motion.rotations[count + 1 + end] = like.of_lanes(rotation);
        }
    }

    /// Copies the motion of the inner nodes in one lane to the motion of the frame.
    #[inline(always)]
    pub(super) fn put_inner_motion(&self, motion: &FrameMotion<R>, lane: usize, of_frame: &mut FrameMotion) {
        let (node, rotation) = self.inner[lane];
        let inner = 1..self.count();
        for (of_frame, u) in of_frame.displacements[node..].iter_mut().zip(&motion.displacements[inner.clone()]) {
            *of_frame = Vector2::new(u.x.lane(lane), u.y.lane(lane));
        }
        for (of_frame, turn) in of_frame.rotations[rotation..].iter_mut().zip(&motion.rotations[inner]) {
            *of_frame = turn.lane(lane);
        }
    }
}

/// Methods instead of closures: closures would not be inlined, and each lane operation would become a function call.
impl<R: Number> ParallelLines<'_, R> {
    #[inline(always)]
    fn beam(&self, index: usize) -> Beam<R> {
        let (like, beam) = (self.like, |lane: usize| &self.members[lane][index].beam);
        Beam {
            direction: Vector2::new(
                like.of_lanes(|lane| beam(lane).direction.x),
                like.of_lanes(|lane| beam(lane).direction.y),
            ),
            length_mm: like.of_lanes(|lane| beam(lane).length_mm),
            axial_rigidity_n: like.of_lanes(|lane| beam(lane).axial_rigidity_n),
            bending_rigidity_nmm2: like.of_lanes(|lane| beam(lane).bending_rigidity_nmm2),
            sway_factor: like.of_lanes(|lane| beam(lane).sway_factor),
            axis_mm: [like.of_lanes(|lane| beam(lane).axis_mm[0]), like.of_lanes(|lane| beam(lane).axis_mm[1])],
        }
    }

    /// Rigid arm at an element's end, mm. Only the first and the last end of a line have arms and pins.
    #[inline(always)]
    fn arm(&self, index: usize, end: usize) -> Vector2<R> {
        let arm = |lane: usize| &self.members[lane][index].ends[end].arm;
        Vector2::new(self.like.of_lanes(|lane| arm(lane).x), self.like.of_lanes(|lane| arm(lane).y))
    }

    #[inline(always)]
    fn first_end(&self, index: usize) -> BeamEnd<R> {
        match index {
            0 => BeamEnd { node: 0, rotation: self.count() + 1, arm: self.arm(index, 0) },
            _ => self.between(index),
        }
    }

    #[inline(always)]
    fn second_end(&self, index: usize) -> BeamEnd<R> {
        let count = self.count();
        match index + 1 == count {
            true => BeamEnd { node: count, rotation: count + 2, arm: self.arm(index, 1) },
            false => self.between(index + 1),
        }
    }

    /// The beam end at an inner node.
    #[inline(always)]
    fn between(&self, node: NodeIndex) -> BeamEnd<R> {
        BeamEnd { node, rotation: node, arm: Vector2::new(self.like.zero(), self.like.zero()) }
    }
}

impl<R: Number> Elements<R> for ParallelLines<'_, R> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.members[0].len()
    }

    #[inline(always)]
    fn member(&self, index: usize) -> Member<R> {
        Member { beam: self.beam(index), ends: [self.first_end(index), self.second_end(index)] }
    }

    #[inline(always)]
    fn node(&self, index: usize) -> NodeIndex {
        index
    }

    #[inline(always)]
    fn rotation(&self, index: usize) -> RotationSlot {
        index
    }
}
