//! The elements of a line, and of several lines side by side: as a line's equations meet them.
//!
//! Lines do not see each other until they are condensed onto the key nodes. So those of as many elements go through the same
//! instructions, one a lane, with what each has by itself: its beams, its motion, its loads.

use crate::element::Beam;
use crate::frame::{BeamEnd, FrameMotion, Member, NodeIndex, PlaneFrame, RotationSlot};
use crate::mesh::Line;
use crate::number::Number;
use nalgebra::Vector2;

/// Lanes of the widest register that any machine has.
const MOST_LANES: usize = 8;

/// The elements of a line from one key node to the other, and where in a motion their nodes are.
pub(super) trait Elements<R: Number>: Copy {
    /// How many there are.
    fn count(&self) -> usize;

    /// One of them.
    fn member(&self, index: usize) -> Member<R>;

    /// The node before an element, or after the last one.
    fn node(&self, index: usize) -> NodeIndex;

    /// The rotation of that node.
    fn rotation(&self, index: usize) -> RotationSlot;
}

/// A line of a frame. Its motion is the frame's.
#[derive(Clone, Copy)]
pub(super) struct OneLine<'a, R> {
    pub frame: &'a PlaneFrame,
    pub line: &'a Line,
    /// Any number of those that are computed with.
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

/// Lines of as many elements each, one a lane: nodes and rotations from first to last, then those that clamp the ends.
#[derive(Clone, Copy)]
pub(super) struct ParallelLines<'a, R> {
    frame: &'a PlaneFrame,
    /// In each lane; where there are fewer lines, the last one again.
    lines: [&'a Line; MOST_LANES],
    members: [&'a [Member]; MOST_LANES],
    /// The first node between the ends of each, and its rotation: others follow.
    inner: [(NodeIndex, RotationSlot); MOST_LANES],
    like: R,
}

impl<'a, R: Number> ParallelLines<'a, R> {
    /// Some of a frame's lines.
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

    /// Takes their motion out of the frame's.
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

    /// Puts the motion of the nodes between the ends of one line into the frame's.
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

/// Methods, not closures, which would not be inlined: lanes would be computed by calls of single instructions.
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
        }
    }

    /// Of an element's end. Arms and pins are at the two ends of a line alone.
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

    /// The end of an element at a node between others.
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
