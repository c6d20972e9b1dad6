//! A member's elements condensed onto its two ends.
//!
//! A chain of elements has its unknowns in a row. They are eliminated one node after the other, always between the
//! first end and the next node, so the work is proportional to the number of elements.

use super::SMALL_PIVOT;
use super::block::Block;
use crate::element::{ElementVector, Response};
use crate::frame::{FrameMotion, PlaneFrame};
use crate::mesh::Line;

/// x, y and rotation of a first end, then of a second.
pub(super) type Ends = [f64; 6];
/// Second derivatives by [`Ends`], symmetric: only the upper triangle is kept up to date.
pub(super) type EndsMatrix = [[f64; 6]; 6];

/// The two ends of [`Ends`].
pub(super) fn halves(ends: &Ends) -> [[f64; 3]; 2] {
    let [a, b, c, d, e, f] = *ends;
    [[a, b, c], [d, e, f]]
}

/// Two ends as [`Ends`].
pub(super) fn joined(first: &[f64; 3], second: &[f64; 3]) -> Ends {
    [first[0], first[1], first[2], second[0], second[1], second[2]]
}

/// The numbers of an element's vector.
pub(super) fn numbers(vector: &ElementVector) -> Ends {
    vector.data.0[0]
}

/// The elimination of one chain, kept for the way back.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    /// Frame nodes from the first to the second end.
    nodes: Vec<usize>,
    /// Rotation slot of each of them: at a pinned end the pin's.
    rotations: Vec<usize>,
    /// The nodes between the elements, with the first end and the next node; and y = L^-1 g of each.
    inner: Vec<(Block<3, 6>, [f64; 3])>,
    /// The two end rotations of a pinned member, which belong to nothing else, with the ends' displacements.
    pins: Option<(Block<2, 6>, [f64; 2])>,
    /// The chain's stiffness, condensed.
    pub stiffness: EndsMatrix,
    /// Its gradient, condensed.
    pub gradient: Ends,
    /// Gradients at the two ends before anything was condensed onto them.
    pub raw: Ends,
    /// Work of the residual on the correction of what was eliminated, N mm.
    pub work: f64,
    pub positive: bool,
    /// Whether no pivot between the ends is small: a stiff section between soft ones leaves the node after it little.
    pub accurate: bool,
    /// Stiffness of the two ends, its diagonal, before anything was condensed onto them.
    pub raw_diagonal: Ends,
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
        Chain {
            nodes: line.nodes.clone(),
            rotations,
            inner: vec![(Block::empty(), [0.0; 3]); line.members.len().saturating_sub(1)],
            pins: pinned.then(|| (Block::empty(), [0.0; 2])),
            stiffness: [[0.0; 6]; 6],
            gradient: [0.0; 6],
            raw: [0.0; 6],
            work: 0.0,
            positive: true,
            accurate: true,
            raw_diagonal: [0.0; 6],
        }
    }

    /// Condenses the elements' stiffness and gradients, given from the first to the second end.
    #[inline(always)]
    pub(super) fn condense(&mut self, elements: impl Iterator<Item = Response>) {
        self.work = 0.0;
        self.positive = true;
        self.accurate = true;
        for (i, element) in elements.enumerate() {
            // Symmetric: columns are rows.
            let (next, next_gradient) = (&element.tangent.data.0, numbers(&element.gradient));
            match i.checked_sub(1).and_then(|before| self.inner.get_mut(before)) {
                None => {
                    for k in 0..3 {
                        self.raw_diagonal[k] = next[k][k];
                    }
                    self.stiffness = *next;
                    self.gradient = next_gradient;
                    self.raw = next_gradient;
                }
                Some((block, y)) => {
                    eliminate_node(block, &mut self.stiffness, next);
                    self.positive &= block.positive();
                    let raw = &self.raw_diagonal;
                    let limits = std::array::from_fn(|k| SMALL_PIVOT * (raw[3 + k] + next[k][k]));
                    self.accurate &= block.pivots_exceed(&limits);
                    *y = pass_node(block, &mut self.gradient, &next_gradient);
                    self.work += block.work(y);
                    self.raw[3..].copy_from_slice(&next_gradient[3..]);
                }
            }
            for k in 3..6 {
                self.raw_diagonal[k] = next[k][k];
            }
        }
        if let Some((block, _)) = &mut self.pins {
            eliminate_pins(block, &mut self.stiffness);
            self.positive &= block.positive();
        }
        self.release_pins();
    }

    /// Condenses other gradients with the stiffness that is there.
    #[inline(always)]
    pub(super) fn load(&mut self, gradients: impl Iterator<Item = Ends>) {
        self.work = 0.0;
        for (i, next) in gradients.enumerate() {
            match i.checked_sub(1).and_then(|before| self.inner.get_mut(before)) {
                None => (self.gradient, self.raw) = (next, next),
                Some((block, y)) => {
                    *y = pass_node(block, &mut self.gradient, &next);
                    self.work += block.work(y);
                    self.raw[3..].copy_from_slice(&next[3..]);
                }
            }
        }
        self.release_pins();
    }

    /// Condenses the gradient of pinned ends.
    fn release_pins(&mut self) {
        if let Some((block, y)) = &mut self.pins {
            *y = pass_pins(block, &mut self.gradient);
            self.work += block.work(y);
        }
    }

    /// Gradients at the two ends that stand for gradients at the two nodes of one element.
    pub(super) fn condensed_gradient(&self, element: usize, on_element: Ends) -> Ends {
        let mut gradient = on_element;
        if element > 0 {
            gradient = [0.0; 6];
            pass_node(&self.inner[element - 1].0, &mut gradient, &on_element);
        }
        for (block, _) in self.inner.iter().skip(element) {
            pass_node(block, &mut gradient, &[0.0; 6]);
        }
        if let Some((block, _)) = &self.pins {
            pass_pins(block, &mut gradient);
        }
        gradient
    }

    /// Logarithm of the determinant of what was eliminated.
    pub(super) fn log_determinant(&self) -> f64 {
        let inner: f64 = self.inner.iter().map(|(block, _)| block.log_determinant()).sum();
        inner + self.pins.as_ref().map_or(0.0, |(block, _)| block.log_determinant())
    }

    /// Carries the corrections of the two ends back to the nodes between them (and to the rotations of pinned ends).
    pub(super) fn correct(&self, motion: &mut FrameMotion, first: &[f64; 3], second: &[f64; 3]) {
        let mut ends = joined(first, second);
        if let Some((block, y)) = &self.pins {
            [ends[2], ends[5]] = block.motion(y, &ends);
            motion.rotations[self.rotations[0]] += ends[2];
            motion.rotations[self.rotations[self.nodes.len() - 1]] += ends[5];
        }
        for (i, (block, y)) in self.inner.iter().enumerate().rev() {
            let [x, y, rotation] = block.motion(y, &ends);
            (ends[3], ends[4], ends[5]) = (x, y, rotation);
            let u = &mut motion.displacements[self.nodes[i + 1]];
            u.x += x;
            u.y += y;
            motion.rotations[self.rotations[i + 1]] += rotation;
        }
    }
}

/// Moves the gradient between the first end and a node on to the next node; returns y of the node.
fn pass_node(block: &Block<3, 6>, gradient: &mut Ends, next: &Ends) -> [f64; 3] {
    let [[a, b, c], [d, e, f]] = halves(gradient);
    let y = block.forward(&[d + next[0], e + next[1], f + next[2]]);
    *gradient = [a, b, c, next[3], next[4], next[5]];
    block.reduce_gradient(&y, gradient);
    y
}

/// Takes the pinned rotations out of the gradient of the ends; returns their y.
fn pass_pins(block: &Block<2, 6>, gradient: &mut Ends) -> [f64; 2] {
    let y = block.forward(&[gradient[2], gradient[5]]);
    (gradient[2], gradient[5]) = (0.0, 0.0);
    block.reduce_gradient(&y, gradient);
    y
}

/// Eliminates the node between what is condensed so far and the next element; leaves the first end and the next node.
#[inline(always)]
fn eliminate_node(block: &mut Block<3, 6>, so_far: &mut EndsMatrix, next: &EndsMatrix) {
    let mut own = [[0.0; 3]; 3];
    let mut coupling = [[0.0; 6]; 3];
    for i in 0..3 {
        for j in 0..3 {
            own[i][j] = so_far[3 + i][3 + j] + next[i][j];
            coupling[i][j] = so_far[j][3 + i];
            coupling[i][3 + j] = next[i][3 + j];
        }
    }
    block.factorise(&own, &coupling);
    for i in 0..3 {
        for j in 0..3 {
            so_far[i][3 + j] = 0.0;
            so_far[3 + i][3 + j] = next[3 + i][3 + j];
        }
    }
    block.reduce_stiffness(so_far);
}

/// Takes the pinned rotations out of the stiffness of the ends.
fn eliminate_pins(block: &mut Block<2, 6>, stiffness: &mut EndsMatrix) {
    let own = [[stiffness[2][2], stiffness[2][5]], [0.0, stiffness[5][5]]];
    let upper = |i: usize, j: usize| stiffness[i.min(j)][i.max(j)];
    let mut coupling = [2, 5].map(|i| std::array::from_fn(|j| upper(i, j)));
    for row in coupling.iter_mut().chain(stiffness.iter_mut()) {
        (row[2], row[5]) = (0.0, 0.0);
    }
    (stiffness[2], stiffness[5]) = ([0.0; 6], [0.0; 6]);
    block.factorise(&own, &coupling);
    block.reduce_stiffness(stiffness);
}
