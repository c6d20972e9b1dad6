//! Rigid brackets that hold the ends of a chain off the key nodes.
//!
//! A bracket v turns with its key node: the end of the chain moves by u + w quarter_turn(v) when the node moves by u and turns
//! by w. A chain keeps its own rotations there (those of the key nodes where it is not pinned), so its stiffness and gradient
//! by its ends become those by the key nodes by the same chain rule as over the arms of a beam.

use super::ends::{Ends, EndsMatrix};
use crate::finger::Part;
use crate::frame::{FrameMotion, PlaneFrame};
use crate::mesh::Line;
use crate::number::Number;
use nalgebra::Vector2;

/// The brackets at the first and the second end of a chain in their current directions, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Brackets<R>([Vector2<R>; 2]);

impl<R: Number> Brackets<R> {
    /// Those of a line, if it ends at any.
    #[inline(always)]
    pub(super) fn of(frame: &PlaneFrame, line: &Line, motion: &FrameMotion<R>, linear: bool) -> Option<Brackets<R>> {
        let ends = [line.nodes[0], line.nodes[line.nodes.len() - 1]];
        // A plate's node that an undeformable rib carries is a key node itself.
        if line.part != Part::Ribs || !ends.iter().any(|node| frame.is_linked(*node)) {
            return None;
        }
        let zero = motion.rotations[0].zero();
        let bracket =
            |node| frame.turned_levers(node, motion, linear).next().map_or(Vector2::new(zero, zero), |(_, v)| v);
        Some(Brackets(ends.map(bracket)))
    }

    /// In one lane.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> Brackets<f64> {
        Brackets(self.0.map(|v| v.map(|x| x.lane(lane))))
    }

    /// Of several lines, one a lane.
    #[inline(always)]
    pub(super) fn of_lanes(lanes: &[Brackets<f64>], like: R) -> Brackets<R> {
        let of = |lane: usize| &lanes[lane.min(lanes.len() - 1)].0;
        let bracket =
            |end: usize| Vector2::new(like.of_lanes(|lane| of(lane)[end].x), like.of_lanes(|lane| of(lane)[end].y));
        Brackets([bracket(0), bracket(1)])
    }

    /// Gradients at the key nodes for gradients at the ends.
    #[inline(always)]
    pub(super) fn carry_gradient(&self, gradient: &mut Ends<R>) {
        for (i, v) in self.0.iter().enumerate() {
            let moment = v.x * gradient[3 * i + 1] - v.y * gradient[3 * i];
            gradient[3 * i + 2] += moment;
        }
    }

    /// Second derivatives by the key nodes for those by the ends: in the upper triangle.
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

    /// What forces at the ends add to the stiffness as the brackets turn; `gradient` is that of the elements at the ends, N.
    #[inline(always)]
    pub(super) fn add_turning(&self, gradient: &Ends<R>, stiffness: &mut EndsMatrix<R>) {
        for (i, v) in self.0.iter().enumerate() {
            stiffness[3 * i + 2][3 * i + 2] -= gradient[3 * i] * v.x + gradient[3 * i + 1] * v.y;
        }
    }

    /// Size of the terms that the stiffness against each rotation is summed from.
    #[inline(always)]
    pub(super) fn carry_diagonal(&self, diagonal: &mut Ends<R>) {
        for (i, v) in self.0.iter().enumerate() {
            let turning = v.y * v.y * diagonal[3 * i] + v.x * v.x * diagonal[3 * i + 1];
            diagonal[3 * i + 2] += turning;
        }
    }

    /// Corrections of the ends by those of the key nodes.
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
