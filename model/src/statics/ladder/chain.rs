//! A member's elements condensed onto its two ends.
//!
//! A chain of elements has its unknowns in a row. They are eliminated one node after the other, always between the
//! first end and the next node, so the work is proportional to the number of elements.

use super::ldl::Ldl;
use crate::frame::{FrameMotion, PlaneFrame};
use crate::{element::Response, mesh::Line};
use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2, Vector3};

/// Stiffness and gradient of a chain by the motions of its two ends, x, y and rotation each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Condensed {
    pub aa: Matrix3<f64>,
    pub ab: Matrix3<f64>,
    pub bb: Matrix3<f64>,
    pub a: Vector3<f64>,
    pub b: Vector3<f64>,
}

impl Condensed {
    pub(super) fn of(response: &Response) -> Condensed {
        let k = &response.tangent;
        Condensed {
            aa: k.fixed_view::<3, 3>(0, 0).into_owned(),
            ab: k.fixed_view::<3, 3>(0, 3).into_owned(),
            bb: k.fixed_view::<3, 3>(3, 3).into_owned(),
            a: response.gradient.fixed_rows::<3>(0).into_owned(),
            b: response.gradient.fixed_rows::<3>(3).into_owned(),
        }
    }
}

/// How an eliminated node moves: by itself, and with the first end and the next node.
#[derive(Debug, Clone, Copy)]
struct Eliminated {
    alone: Vector3<f64>,
    with_first: Matrix3<f64>,
    with_next: Matrix3<f64>,
}

/// How the rotations of a pinned member move: by themselves, and with the four displacements of its ends.
#[derive(Debug, Clone, Copy)]
struct PinnedRotations {
    alone: Vector2<f64>,
    with_ends: SMatrix<f64, 2, 4>,
}

/// The elimination of one chain, kept for the way back.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    /// Frame nodes from the first to the second end.
    nodes: Vec<usize>,
    /// Rotation slot of each of them: at a pinned end the pin's.
    rotations: Vec<usize>,
    pinned: bool,
    inner: Vec<Eliminated>,
    ends: Option<PinnedRotations>,
    pub condensed: Condensed,
    /// Gradients at the two ends before anything was condensed onto them.
    pub raw: [Vector3<f64>; 2],
    /// Work of the residual on the correction of what was eliminated, N mm.
    pub work: f64,
    pub positive: bool,
}

impl Chain {
    pub(super) fn new(frame: &PlaneFrame, line: &Line) -> Chain {
        let members = &frame.members()[line.members.clone()];
        let rotations: Vec<usize> = members
            .iter()
            .map(|member| member.ends[0].rotation)
            .chain(members.last().map(|member| member.ends[1].rotation))
            .collect();
        let pinned = members.first().is_some_and(|m| m.ends[0].rotation != frame.rotation_of(m.ends[0].node));
        let zero = Condensed {
            aa: Matrix3::zeros(),
            ab: Matrix3::zeros(),
            bb: Matrix3::zeros(),
            a: Vector3::zeros(),
            b: Vector3::zeros(),
        };
        Chain {
            nodes: line.nodes.clone(),
            rotations,
            pinned,
            inner: Vec::with_capacity(line.members.len().saturating_sub(1)),
            ends: None,
            condensed: zero,
            raw: [Vector3::zeros(); 2],
            work: 0.0,
            positive: true,
        }
    }

    /// Condenses the elements' responses, given from the first to the second end.
    pub(super) fn condense(&mut self, elements: impl Iterator<Item = Condensed>) {
        self.inner.clear();
        self.work = 0.0;
        self.positive = true;
        let mut elements = elements;
        let Some(mut so_far) = elements.next() else { return };
        let mut raw = [so_far.a, so_far.b];
        for next in elements {
            let ldl = Ldl::of(&(so_far.bb + next.aa));
            self.positive &= ldl.positive;
            let gradient = so_far.b + next.a;
            let alone = ldl.solve(&gradient);
            let with_first = ldl.solve(&so_far.ab.transpose());
            let with_next = ldl.solve(&next.ab);
            self.work += gradient.dot(&alone);
            raw[1] = next.b;
            so_far = Condensed {
                aa: so_far.aa - so_far.ab * with_first,
                ab: -so_far.ab * with_next,
                bb: next.bb - next.ab.transpose() * with_next,
                a: so_far.a - so_far.ab * alone,
                b: next.b - next.ab.transpose() * alone,
            };
            self.inner.push(Eliminated { alone, with_first, with_next });
        }
        self.raw = raw;
        self.condensed = if self.pinned { self.release(so_far) } else { so_far };
    }

    /// Eliminates the rotations of a pinned member, which belong to nothing else.
    fn release(&mut self, c: Condensed) -> Condensed {
        let rotations = Matrix2::new(c.aa[(2, 2)], c.ab[(2, 2)], c.ab[(2, 2)], c.bb[(2, 2)]);
        let with = SMatrix::<f64, 2, 4>::new(
            c.aa[(2, 0)],
            c.aa[(2, 1)],
            c.ab[(2, 0)],
            c.ab[(2, 1)], //
            c.ab[(0, 2)],
            c.ab[(1, 2)],
            c.bb[(2, 0)],
            c.bb[(2, 1)],
        );
        let ldl = Ldl::of(&rotations);
        self.positive &= ldl.positive;
        let gradient = Vector2::new(c.a[2], c.b[2]);
        let alone = ldl.solve(&gradient);
        let with_ends = ldl.solve(&with);
        self.work += gradient.dot(&alone);
        self.ends = Some(PinnedRotations { alone, with_ends });
        let less = with.transpose() * with_ends;
        let less_gradient = with.transpose() * alone;
        let mut out = Condensed {
            aa: Matrix3::zeros(),
            ab: Matrix3::zeros(),
            bb: Matrix3::zeros(),
            a: Vector3::zeros(),
            b: Vector3::zeros(),
        };
        for i in 0..2 {
            for j in 0..2 {
                out.aa[(i, j)] = c.aa[(i, j)] - less[(i, j)];
                out.ab[(i, j)] = c.ab[(i, j)] - less[(i, 2 + j)];
                out.bb[(i, j)] = c.bb[(i, j)] - less[(2 + i, 2 + j)];
            }
            out.a[i] = c.a[i] - less_gradient[i];
            out.b[i] = c.b[i] - less_gradient[2 + i];
        }
        out
    }

    /// Forces on the two ends that stand for forces on the two nodes of one element.
    pub(super) fn condensed_forces(&self, element: usize, forces: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
        let mut first = Vector3::zeros();
        let mut here = forces[0];
        if element == 0 {
            (first, here) = (forces[0], Vector3::zeros());
        } else {
            let node = &self.inner[element - 1];
            first -= node.with_first.transpose() * here;
            here = -(node.with_next.transpose() * here);
        }
        here += forces[1];
        for node in self.inner.iter().skip(element) {
            first -= node.with_first.transpose() * here;
            here = -(node.with_next.transpose() * here);
        }
        [first, here]
    }

    /// Carries the corrections of the two ends back to the nodes between them (and to the rotations of pinned ends).
    pub(super) fn correct(&self, motion: &mut FrameMotion, first: Vector3<f64>, second: Vector3<f64>) {
        let (mut first, mut next) = (first, second);
        let last = self.nodes.len() - 1;
        if let Some(pins) = &self.ends {
            let ends = nalgebra::Vector4::new(first[0], first[1], second[0], second[1]);
            let turned = -(pins.alone + pins.with_ends * ends);
            (first[2], next[2]) = (turned[0], turned[1]);
            motion.rotations[self.rotations[0]] += turned[0];
            motion.rotations[self.rotations[last]] += turned[1];
        }
        for (i, node) in self.inner.iter().enumerate().rev() {
            next = -(node.alone + node.with_first * first + node.with_next * next);
            let u = &mut motion.displacements[self.nodes[i + 1]];
            u.x += next[0];
            u.y += next[1];
            motion.rotations[self.rotations[i + 1]] += next[2];
        }
    }
}
