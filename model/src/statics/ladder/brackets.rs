//! Rigid brackets between the ends of a chain (a condensed rib) and the key nodes.
//!
//! A bracket, given by the vector v, rotates with its key node. If a key node moves by u and rotates by w, the end of the chain at its bracket v
//! moves by u + w quarter_turn(v). The equations of a chain use the rotations of the chain's ends. The rotations of the chain's ends equal the
//! rotations of the key nodes unless the chain is pinned. The chain rule for rigid arms then transforms stiffness and gradient from the ends of the
//! chain to the key nodes.

use super::ends::{Ends, EndsMatrix};
use crate::finger::Part;
use crate::frame::{FrameMotion, PlaneFrame};
use crate::mesh::Line;
use crate::number::Number;
use nalgebra::Vector2;

/// The brackets at the first and second end of a chain, in their current directions, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Brackets<R>([Vector2<R>; 2]);

impl<R: Number> Brackets<R> {
    /// The brackets of a line; `None` if the line has none.
    #[inline(always)]
    pub(super) fn of(frame: &PlaneFrame, line: &Line, motion: &FrameMotion<R>, linear: bool) -> Option<Brackets<R>> {
        let ends = [line.nodes[0], line.nodes[line.nodes.len() - 1]];
        // A linked node at the end of a plate member is a key node that follows an undeformable rib. Such a node has no bracket.
        if line.part != Part::Ribs || !ends.iter().any(|node| frame.is_linked(*node)) {
            return None;
        }
        let zero = motion.rotations[0].zero();
        let bracket =
            |node| frame.turned_levers(node, motion, linear).next().map_or(Vector2::new(zero, zero), |(_, v)| v);
        Some(Brackets(ends.map(bracket)))
    }

    /// The brackets in one SIMD lane.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> Brackets<f64> {
        Brackets(self.0.map(|v| v.map(|x| x.lane(lane))))
    }

    /// The brackets of several lines, one line per SIMD lane.
    #[inline(always)]
    pub(super) fn of_lanes(lanes: &[Brackets<f64>], like: R) -> Brackets<R> {
        let of = |lane: usize| &lanes[lane.min(lanes.len() - 1)].0;
        let bracket =
            |end: usize| Vector2::new(like.of_lanes(|lane| of(lane)[end].x), like.of_lanes(|lane| of(lane)[end].y));
        Brackets([bracket(0), bracket(1)])
    }

    /// Transforms a gradient with respect to the motions of the chain's ends into the gradient with respect to the motions of the key nodes.
    #[inline(always)]
    pub(super) fn carry_gradient(&self, gradient: &mut Ends<R>) {
        for (i, v) in self.0.iter().enumerate() {
            let moment = v.x * gradient[3 * i + 1] - v.y * gradient[3 * i];
            gradient[3 * i + 2] += moment;
        }
    }

    /// Transforms the stiffness at the chain's ends into the stiffness at the key nodes. Only the upper triangle is read.
    #[inline(always)]
    pub(super) fn carry_stiffness(&self, stiffness: &mut EndsMatrix<R>) {
        for row in 1..6 {
            for column in 0..row {
                stiffness[row][column] = stiffness[column][row];
            }
        }
        for row in stiffness.iter_mut() {
            self.carry_gradient(row);
        }
        for (i, v) in self.0.iter().enumerate() {
            for column in 0..6 {
                let moment = v.x * stiffness[3 * i + 1][column] - v.y * stiffness[3 * i][column];
                stiffness[3 * i + 2][column] += moment;
            }
        }
    }

    /// Adds the geometric stiffness that forces cause on rotating brackets. `gradient` contains the elements' forces at the chain's ends, N.
    #[inline(always)]
    pub(super) fn add_turning(&self, gradient: &Ends<R>, stiffness: &mut EndsMatrix<R>) {
        for (i, v) in self.0.iter().enumerate() {
            stiffness[3 * i + 2][3 * i + 2] -= gradient[3 * i] * v.x + gradient[3 * i + 1] * v.y;
        }
    }

    /// Adds the brackets' terms to the sum of the diagonal terms of each rotation. A pivot that is small compared with this sum indicates
    /// cancellation.
    #[inline(always)]
    pub(super) fn carry_diagonal(&self, diagonal: &mut Ends<R>) {
        for (i, v) in self.0.iter().enumerate() {
            let turning = v.y * v.y * diagonal[3 * i] + v.x * v.x * diagonal[3 * i + 1];
            diagonal[3 * i + 2] += turning;
        }
    }

    /// Corrections of the chain's ends, computed from the corrections of the key nodes.
    #[inline(always)]
    pub(super) fn carried(&self, key_nodes: &Ends<R>) -> Ends<R> {
        let mut ends = *key_nodes;
        for (i, v) in self.0.iter().enumerate() {
            let turn = key_nodes[3 * i + 2];
            ends[3 * i] -= v.y * turn;
            ends[3 * i + 1] += v.x * turn;
        }
        ends
    }
}
