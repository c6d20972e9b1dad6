//! A chain of elements - a plate between two key nodes, or a rib - condensed onto its two ends.
//!
//! The elements are put behind each other as a [`Cantilever`], so the work is proportional to their number. What the
//! stiffness needs is apart from what forces need: the stiffness at rest serves many loads.

use super::SMALL_PIVOT;
use super::block::Block;
use super::cantilever::{Cantilever, Deflection, Forces, Joint};
use crate::Vector;
use crate::element::{ElementVector, Response, quarter_turn};
use crate::frame::{FrameMotion, PlaneFrame};
use crate::mesh::Line;
use std::ops::Range;

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

/// An element of a chain, with what stands on it.
pub(super) struct Element {
    pub elastic: Response,
    pub load: Option<Response>,
    /// From its first to its second node, mm.
    pub lever: Vector,
}

/// The stiffness of a chain, condensed; its [`Joint`]s, one for each element but the first, are kept elsewhere.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    /// From the first to the second node of the first element, and of the whole chain, mm.
    first_lever: Vector,
    lever: Vector,
    /// The two end rotations of a pinned member, which belong to nothing else, with the ends' displacements.
    pins: Option<Block<2, 6>>,
    /// By its two ends.
    pub stiffness: EndsMatrix,
    pub positive: bool,
    /// Whether no element is so soft beside those before it that the difference has lost digits that may count.
    pub accurate: bool,
    /// The diagonal of the stiffness before pins were released.
    pub diagonal: Ends,
}

impl Chain {
    pub(super) fn new(frame: &PlaneFrame, line: &Line) -> Chain {
        let members = &frame.members()[line.members.clone()];
        let pinned = members.first().is_some_and(|m| m.ends[0].rotation != frame.rotation_of(m.ends[0].node));
        Chain {
            first_lever: Vector::zeros(),
            lever: Vector::zeros(),
            pins: pinned.then(Block::empty),
            stiffness: [[0.0; 6]; 6],
            positive: true,
            accurate: true,
            diagonal: [0.0; 6],
        }
    }

    /// Whether its ends have rotations of their own.
    pub(super) fn is_pinned(&self) -> bool {
        self.pins.is_some()
    }

    /// Takes the stiffness and gradient of its only element.
    #[inline(always)]
    pub(super) fn take(&mut self, forces: &mut ChainForces, element: &Response) {
        // Symmetric: columns are rows.
        self.stiffness = element.tangent.data.0;
        self.positive = true;
        forces.work = 0.0;
        forces.gradient = numbers(&element.gradient);
        forces.raw = forces.gradient;
        self.finish(forces);
    }

    /// Condenses the elements' stiffness and gradients, given from the first to the second end; `ys` gets the y of each
    /// joint.
    #[inline(always)]
    pub(super) fn condense(
        &mut self,
        joints: &mut [Joint],
        forces: &mut ChainForces,
        ys: &mut [[f64; 3]],
        elements: impl Iterator<Item = Element>,
    ) {
        (self.positive, self.accurate) = (true, true);
        forces.work = 0.0;
        let mut joints = joints.iter_mut().zip(ys);
        let mut condensed = None;
        for element in elements {
            let (next, next_carried, gradient) = element.cantilever();
            let Some((so_far, carried)) = &mut condensed else {
                (self.first_lever, forces.raw) = (next.lever(), gradient);
                condensed = Some((next, next_carried));
                continue;
            };
            let Some((joint, y)) = joints.next() else { break };
            let before = so_far.diagonal();
            so_far.extend(joint, &next);
            self.positive &= joint.positive();
            self.accurate &= so_far.diagonal().iter().zip(before).all(|(now, before)| *now > SMALL_PIVOT * before);
            *y = carried.extend(joint, &next_carried);
            forces.work += joint.work(y);
            forces.raw[3..].copy_from_slice(&gradient[3..]);
        }
        if let Some((whole, carried)) = condensed {
            self.lever = whole.lever();
            self.stiffness = whole.on_ends();
            forces.gradient = carried.on_ends();
            self.finish(forces);
        }
    }

    /// Notes the diagonal and releases pins.
    #[inline(always)]
    fn finish(&mut self, forces: &mut ChainForces) {
        self.diagonal = std::array::from_fn(|i| self.stiffness[i][i]);
        if let Some(block) = &mut self.pins {
            eliminate_pins(block, &mut self.stiffness);
            self.positive = self.positive && block.positive();
        }
        self.release_pins(forces);
    }

    /// Condenses other gradients with the stiffness that is there.
    #[inline(always)]
    pub(super) fn load(
        &self,
        joints: &[Joint],
        forces: &mut ChainForces,
        ys: &mut [[f64; 3]],
        mut gradients: impl Iterator<Item = Ends>,
    ) {
        forces.work = 0.0;
        let Some(first) = gradients.next() else { return };
        (forces.gradient, forces.raw) = (first, first);
        if !joints.is_empty() {
            let mut carried = Forces::on(&first, self.first_lever);
            for ((joint, y), next) in joints.iter().zip(ys).zip(gradients) {
                *y = carried.extend(joint, &Forces::on(&next, joint.lever()));
                forces.work += joint.work(y);
                forces.raw[3..].copy_from_slice(&next[3..]);
            }
            forces.gradient = carried.on_ends();
        }
        self.release_pins(forces);
    }

    /// Condenses the gradient of pinned ends.
    fn release_pins(&self, forces: &mut ChainForces) {
        if let Some(block) = &self.pins {
            forces.pins_y = pass_pins(block, &mut forces.gradient);
            forces.work += block.work(&forces.pins_y);
        }
    }

    /// Gradients at the two ends that stand for gradients at the two nodes of one element.
    pub(super) fn condensed_gradient(&self, joints: &[Joint], element: usize, on_element: Ends) -> Ends {
        let mut gradient = on_element;
        if !joints.is_empty() {
            let on = |at: usize| if at == element { on_element } else { [0.0; 6] };
            let mut carried = Forces::on(&on(0), self.first_lever);
            for (i, joint) in joints.iter().enumerate() {
                carried.extend(joint, &Forces::on(&on(i + 1), joint.lever()));
            }
            gradient = carried.on_ends();
        }
        if let Some(block) = &self.pins {
            pass_pins(block, &mut gradient);
        }
        gradient
    }

    /// Logarithm of the determinant of pinned rotations.
    pub(super) fn log_determinant(&self) -> f64 {
        self.pins.as_ref().map_or(0.0, Block::log_determinant)
    }

    /// Carries the corrections of the two ends back to the nodes between them (and to the rotations of pinned ends).
    pub(super) fn correct(
        &self,
        Solved { joints, ys, between }: Solved,
        forces: &ChainForces,
        motion: &mut FrameMotion,
        [first, second]: [&[f64; 3]; 2],
    ) {
        let mut ends = joined(first, second);
        if let Some(block) = &self.pins {
            [ends[2], ends[5]] = block.motion(&forces.pins_y, &ends);
            for (slot, turn) in between.ends.into_iter().zip([ends[2], ends[5]]) {
                motion.rotations[slot] += turn;
            }
        }
        let [x, y, turn, end_x, end_y, end_turn] = ends;
        let arm = quarter_turn(self.lever) * turn;
        let mut deflection: Deflection = [end_x - x - arm.x, end_y - y - arm.y, end_turn - turn, turn];
        let mut lever = self.lever;
        let displacements = &mut motion.displacements[between.nodes.clone()];
        let rotations = &mut motion.rotations[between.rotations.clone()];
        let inner = displacements.iter_mut().zip(rotations);
        for (((u, rotation), joint), y_joint) in inner.zip(joints).zip(ys).rev() {
            deflection = joint.shortened(y_joint, &deflection);
            lever -= joint.lever();
            *u += Vector::new(x + deflection[0] - lever.y * turn, y + deflection[1] + lever.x * turn);
            *rotation += turn + deflection[2];
        }
    }
}

impl Element {
    /// Its stiffness and forces, and the gradients on its two nodes.
    #[inline(always)]
    fn cantilever(&self) -> (Cantilever, Forces, Ends) {
        let mut gradient = numbers(&self.elastic.gradient);
        let mut cantilever = Cantilever::of_element(&self.elastic, Vector::new(gradient[3], gradient[4]), self.lever);
        if let Some(load) = &self.load {
            cantilever.add_load(load);
            for (sum, part) in gradient.iter_mut().zip(&load.gradient) {
                *sum += part;
            }
        }
        (cantilever, Forces::on(&gradient, self.lever), gradient)
    }
}

/// What forces a chain has, condensed.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainForces {
    pins_y: [f64; 2],
    /// By its two ends.
    pub gradient: Ends,
    /// Gradients at the two ends before anything was condensed onto them.
    pub raw: Ends,
    /// Work of the residual on the correction of what was eliminated, N mm.
    pub work: f64,
}

impl ChainForces {
    pub(super) const NONE: ChainForces = ChainForces { pins_y: [0.0; 2], gradient: [0.0; 6], raw: [0.0; 6], work: 0.0 };
}

/// What is between the ends of a chain: its joints, the y of each, and its nodes.
pub(super) struct Solved<'a> {
    pub joints: &'a [Joint],
    pub ys: &'a [[f64; 3]],
    pub between: &'a Between,
}

/// Where in a motion a chain's nodes are: those between its ends follow each other.
#[derive(Debug, Clone)]
pub(super) struct Between {
    pub nodes: Range<usize>,
    pub rotations: Range<usize>,
    /// Rotation slots that the two ends are clamped to: at a pinned end the pin's.
    ends: [usize; 2],
}

impl Between {
    pub(super) fn of(frame: &PlaneFrame, line: &Line) -> Between {
        let [first, .., last] = &frame.members()[line.members.clone()] else {
            let ends = match frame.members().get(line.members.start) {
                Some(only) if !line.members.is_empty() => only.ends.map(|end| end.rotation),
                _ => [0; 2],
            };
            return Between { nodes: 0..0, rotations: 0..0, ends };
        };
        let count = line.members.len() - 1;
        let inner = first.ends[1];
        Between {
            nodes: inner.node..inner.node + count,
            rotations: inner.rotation..inner.rotation + count,
            ends: [first.ends[0].rotation, last.ends[1].rotation],
        }
    }
}

/// The joints of a line among one for each member: one for each of its elements but the first.
pub(super) fn joints_of(line: &Line) -> Range<usize> {
    match line.members.len() {
        0 => line.members.clone(),
        _ => line.members.start + 1..line.members.end,
    }
}

/// Takes the pinned rotations out of the gradient of the ends; returns their y.
fn pass_pins(block: &Block<2, 6>, gradient: &mut Ends) -> [f64; 2] {
    let y = block.forward(&[gradient[2], gradient[5]]);
    (gradient[2], gradient[5]) = (0.0, 0.0);
    block.reduce_gradient(&y, gradient);
    y
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
