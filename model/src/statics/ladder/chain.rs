//! A chain of elements condensed onto its two ends: a plate member between two key nodes, or a rib.
//!
//! The elements are appended one by one to a [`Cantilever`], so the work is proportional to the number of elements. Stiffness and forces are stored
//! separately, because many loads use the stiffness at rest.

use super::SMALL_PIVOT;
use super::block::Block;
use super::brackets::Brackets;
use super::cantilever::{Cantilever, Deflection, Forces, Joint};
use super::ends::{Ends, EndsMatrix, numbers};
use crate::element::{Elastic, Response, quarter_turn};
use crate::frame::{FrameMotion, PlaneFrame};
use crate::mesh::Line;
use crate::number::Number;
use finray_numerics::linear::copy_lane;
use nalgebra::Vector2;
use std::ops::Range;

/// An element of a chain with its loads.
pub(super) struct Element<'a, R: Number> {
    /// Elastic energy, with its derivatives with respect to the motions of the two nodes.
    pub elastic: Elastic<R>,
    /// Potential of the loads on the element.
    pub load: Option<&'a Response<R>>,
    /// Vector from the element's first to its second node, mm.
    pub lever: Vector2<R>,
}

/// Condensed stiffness of a chain. The [`Joint`]s of the chain, one for each element except the first, are stored in [`Factor`](super::Factor).
#[derive(Debug, Clone)]
pub(super) struct Chain<R: Number = f64> {
    /// Vector from the first node of the chain to the second node of its first element, mm.
    first_lever: Vector2<R>,
    /// Vector from the first to the last node of the chain, mm.
    lever: Vector2<R>,
    /// Elimination of the two end rotations of a pinned member; `None` without pins.
    pins: Option<Block<R, 2, 6>>,
    /// Brackets between the chain's ends and the key nodes; `None` without brackets.
    brackets: Option<Brackets<R>>,
    /// Condensed stiffness with respect to the motions of the chain's two ends, or of the key nodes if the chain has brackets.
    pub stiffness: EndsMatrix<R>,
    pub positive: R::Mask,
    /// Lanes without significant loss of digits by cancellation. Digits are lost if an element is much softer than the elements before it.
    pub accurate: R::Mask,
    /// Diagonal of the stiffness before the pinned rotations are eliminated.
    pub diagonal: Ends<R>,
}

impl<R: Number> Chain<R> {
    /// The chain of a line before its condensation, in the number type of `like`.
    #[inline(always)]
    pub(super) fn new(frame: &PlaneFrame, line: &Line, like: R) -> Chain<R> {
        let zero = like.zero();
        let members = &frame.members()[line.members.clone()];
        let pinned = members.first().is_some_and(|m| m.ends[0].rotation != frame.rotation_of(m.ends[0].node));
        Chain {
            first_lever: Vector2::new(zero, zero),
            lever: Vector2::new(zero, zero),
            pins: pinned.then(|| Block::empty(like)),
            brackets: None,
            stiffness: [[zero; 6]; 6],
            positive: like.always(),
            accurate: like.always(),
            diagonal: [zero; 6],
        }
    }

    /// Copies one SIMD lane to a chain of the same kind. Only the upper triangle of a symmetric matrix is copied.
    #[inline(always)]
    pub(super) fn copy_lane(&self, lane: usize, one: &mut Chain) {
        let like = self.lever.x;
        for (lanes, one) in [(&self.first_lever, &mut one.first_lever), (&self.lever, &mut one.lever)] {
            (one.x, one.y) = (lanes.x.lane(lane), lanes.y.lane(lane));
        }
        if let (Some(lanes), Some(one)) = (&self.pins, &mut one.pins) {
            lanes.copy_lane(lane, one);
        }
        one.brackets = self.brackets.as_ref().map(|brackets| brackets.lane(lane));
        for i in 0..6 {
            for k in i..6 {
                one.stiffness[i][k] = self.stiffness[i][k].lane(lane);
            }
        }
        copy_lane(&self.diagonal, lane, &mut one.diagonal);
        (one.positive, one.accurate) = (like.holds(self.positive, lane), like.holds(self.accurate, lane));
    }

    /// Whether the ends of the chain are pinned and therefore rotate independently of the key nodes.
    pub(super) fn is_pinned(&self) -> bool {
        self.pins.is_some()
    }

    /// Stores stiffness and gradient of a chain with a single element.
    #[inline(always)]
    pub(super) fn take(&mut self, forces: &mut ChainForces<R>, element: &Response<R>) {
        // The matrix is symmetric, so its columns serve as rows.
        self.stiffness = element.tangent.data.0;
        (self.positive, self.accurate) = (forces.work.always(), forces.work.always());
        forces.work = forces.work.zero();
        forces.gradient = numbers(&element.gradient);
        forces.raw = forces.gradient;
    }

    /// Begins the condensation of several elements with the first element; the other elements follow in order.
    #[inline(always)]
    pub(super) fn begin(&mut self, forces: &mut ChainForces<R>, first: &Element<R>) -> PartialChain<R> {
        (self.positive, self.accurate) = (forces.work.always(), forces.work.always());
        forces.work = forces.work.zero();
        let (stiffness, carried, gradient) = first.cantilever();
        (self.first_lever, forces.raw) = (first.lever, gradient);
        (stiffness, carried)
    }

    /// Appends the next element and stores in `y` the forward substitution y = L^-1 g of the element's joint.
    #[inline(always)]
    pub(super) fn extend(
        &mut self,
        partial: &mut PartialChain<R>,
        (joint, y): (&mut Joint<R>, &mut [R; 3]),
        forces: &mut ChainForces<R>,
        element: &Element<R>,
    ) {
        let (stiffness, carried) = partial;
        let (next, next_carried, gradient) = element.cantilever();
        let before = stiffness.diagonal();
        stiffness.extend(joint, &next);
        let like = forces.work;
        self.positive = like.both(self.positive, joint.block.factor.positive);
        let now = stiffness.diagonal();
        for i in 0..3 {
            self.accurate = like.both(self.accurate, now[i].exceeds(before[i] * SMALL_PIVOT));
        }
        *y = carried.extend(joint, &next_carried);
        forces.work += joint.block.work(y);
        forces.raw[3..].copy_from_slice(&gradient[3..]);
    }

    /// Stores the stiffness and gradient of the completed chain.
    #[inline(always)]
    pub(super) fn end(&mut self, (stiffness, carried): &PartialChain<R>, forces: &mut ChainForces<R>) {
        self.lever = stiffness.lever;
        self.stiffness = stiffness.on_ends();
        forces.gradient = carried.on_ends();
    }

    /// Stores the diagonal, eliminates pinned rotations, and transforms stiffness and gradient from the ends of brackets to the key nodes.
    #[inline(always)]
    pub(super) fn finish(&mut self, forces: &mut ChainForces<R>, brackets: Option<Brackets<R>>, linear: bool) {
        for i in 0..6 {
            self.diagonal[i] = self.stiffness[i][i];
        }
        if let Some(block) = &mut self.pins {
            eliminate_pins(block, &mut self.stiffness);
            self.positive = forces.work.both(self.positive, block.factor.positive);
        }
        self.brackets = brackets;
        if let Some(brackets) = &self.brackets {
            brackets.carry_diagonal(&mut self.diagonal);
            brackets.carry_stiffness(&mut self.stiffness);
            if !linear {
                brackets.add_turning(&forces.raw, &mut self.stiffness);
            }
        }
        self.release(forces);
    }

    /// Condenses new gradients with the stored stiffness, which does not change.
    #[inline(always)]
    pub(super) fn load(
        &self,
        joints: &[Joint<R>],
        forces: &mut ChainForces<R>,
        ys: &mut [[R; 3]],
        mut gradients: impl Iterator<Item = Ends<R>>,
    ) {
        forces.work = forces.work.zero();
        let Some(first) = gradients.next() else { return };
        (forces.gradient, forces.raw) = (first, first);
        if !joints.is_empty() {
            let mut carried = Forces::on(&first, self.first_lever);
            for ((joint, y), next) in joints.iter().zip(ys).zip(gradients) {
                *y = carried.extend(joint, &Forces::on(&next, joint.lever));
                forces.work += joint.block.work(y);
                forces.raw[3..].copy_from_slice(&next[3..]);
            }
            forces.gradient = carried.on_ends();
        }
        self.release(forces);
    }

    /// Eliminates pinned rotations from the gradient, and transforms the gradient from the ends of brackets to the key nodes.
    #[inline(always)]
    fn release(&self, forces: &mut ChainForces<R>) {
        if let Some(block) = &self.pins {
            forces.pins_y = pass_pins(block, &mut forces.gradient);
            forces.work += block.work(&forces.pins_y);
        }
        if let Some(brackets) = &self.brackets {
            brackets.carry_gradient(&mut forces.gradient);
        }
    }

    /// Gradient with respect to the motions of the chain's two ends, or of the key nodes if the chain has brackets. This gradient is equivalent to
    /// the gradients `on_element` with respect to the motions of each element's nodes. `passed` receives the index of each joint and the forward
    /// substitution y = L^-1 g of the joint. Also returns the forward substitution of pinned rotations.
    pub(super) fn carried_gradient(
        &self,
        joints: &[Joint<R>],
        on_element: impl Fn(usize) -> Ends<R>,
        mut passed: impl FnMut(usize, [R; 3]),
    ) -> (Ends<R>, Option<[R; 2]>) {
        let mut gradient = on_element(0);
        if !joints.is_empty() {
            let mut carried = Forces::on(&gradient, self.first_lever);
            for (i, joint) in joints.iter().enumerate() {
                passed(i, carried.extend(joint, &Forces::on(&on_element(i + 1), joint.lever)));
            }
            gradient = carried.on_ends();
        }
        let pins_y = self.pins.as_ref().map(|block| pass_pins(block, &mut gradient));
        if let Some(brackets) = &self.brackets {
            brackets.carry_gradient(&mut gradient);
        }
        (gradient, pins_y)
    }

    /// Gradient at the chain's ends that is equivalent to the gradients `on_element` with respect to the motions of each element's nodes.
    pub(super) fn condensed_gradient(&self, joints: &[Joint<R>], on_element: impl Fn(usize) -> Ends<R>) -> Ends<R> {
        self.carried_gradient(joints, on_element, |_, _| {}).0
    }

    /// Adds the gradients `on_element` to condensed forces, with the stored stiffness. The work of the forces remains that of the other gradients.
    pub(super) fn add_load(
        &self,
        joints: &[Joint<R>],
        forces: &mut ChainForces<R>,
        ys: &mut [[R; 3]],
        on_element: impl Fn(usize) -> Ends<R>,
    ) {
        let add = |sum: &mut [R], parts: &[R]| sum.iter_mut().zip(parts).for_each(|(sum, part)| *sum += *part);
        let (gradient, pins_y) = self.carried_gradient(joints, on_element, |i, y| add(&mut ys[i], &y));
        add(&mut forces.gradient, &gradient);
        if let Some(pins_y) = pins_y {
            add(&mut forces.pins_y, &pins_y);
        }
    }

    /// Corrections of the chain's two ends, computed from the corrections of the key nodes.
    #[inline(always)]
    pub(super) fn carried(&self, key_nodes: &Ends<R>) -> Ends<R> {
        self.brackets.as_ref().map_or(*key_nodes, |brackets| brackets.carried(key_nodes))
    }

    /// Natural logarithm of the determinant of the stiffness of the pinned rotations; 0 without pins.
    pub(super) fn log_determinant(&self) -> R {
        self.pins.as_ref().map_or(self.lever.x.zero(), |block| block.factor.log_determinant())
    }

    /// Back substitution: computes the corrections of inner nodes and pinned rotations from the corrections of the two ends. The arguments describe
    /// the interior of the chain: its joints (one elimination per element), the forward substitution y = L^-1 g of each joint, and the inner nodes.
    #[inline(always)]
    pub(super) fn correct(
        &self,
        (joints, ys, between): (&[Joint<R>], &[[R; 3]], &Between),
        forces: &ChainForces<R>,
        motion: &mut FrameMotion<R>,
        ends: &Ends<R>,
    ) {
        let mut ends = *ends;
        if let Some(block) = &self.pins {
            [ends[2], ends[5]] = block.motion(&forces.pins_y, &ends);
            let [first, second] = between.ends;
            motion.rotations[first] += ends[2];
            motion.rotations[second] += ends[5];
        }
        let [x, y, turn, end_x, end_y, end_turn] = ends;
        let arm = quarter_turn(self.lever);
        let mut deflection: Deflection<R> = [end_x - x - arm.x * turn, end_y - y - arm.y * turn, end_turn - turn, turn];
        let mut lever = self.lever;
        let displacements = &mut motion.displacements[between.nodes.clone()];
        let rotations = &mut motion.rotations[between.rotations.clone()];
        let inner = displacements.iter_mut().zip(rotations);
        for (((u, rotation), joint), y_joint) in inner.zip(joints).zip(ys).rev() {
            deflection = joint.shortened(y_joint, &deflection);
            lever.x -= joint.lever.x;
            lever.y -= joint.lever.y;
            u.x += x + deflection[0] - lever.y * turn;
            u.y += y + deflection[1] + lever.x * turn;
            *rotation += turn + deflection[2];
        }
    }
}

impl<R: Number> Element<'_, R> {
    /// The element as a cantilever: its stiffness, its forces, and the gradient with respect to the motions of its two nodes.
    #[inline(always)]
    fn cantilever(&self) -> (Cantilever<R>, Forces<R>, Ends<R>) {
        let Elastic { response, turning_force, .. } = &self.elastic;
        let mut gradient = numbers(&response.gradient);
        let mut cantilever = Cantilever::of_element(response, *turning_force, self.lever);
        if let Some(load) = self.load {
            cantilever.add_load(load);
            for i in 0..6 {
                gradient[i] += load.gradient[i];
            }
        }
        (cantilever, Forces::on(&gradient, self.lever), gradient)
    }
}

/// Condensed forces of a chain.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainForces<R: Number> {
    pins_y: [R; 2],
    /// Gradient with respect to the motions of the two ends, or of the key nodes if the chain has brackets; N and N mm.
    pub gradient: Ends<R>,
    /// Gradient at both ends before any condensation, N and N mm. Only the first element contributes at the first end, and only the last element at
    /// the second end.
    pub raw: Ends<R>,
    /// Work of the residual on the corrections of the eliminated unknowns, N mm.
    pub work: R,
    /// Elastic energy of the elements, N mm.
    pub energy: R,
}

impl<R: Number> ChainForces<R> {
    /// Zero forces, in the number type of `like`.
    #[inline(always)]
    pub(super) fn none(like: R) -> ChainForces<R> {
        let zero = like.zero();
        ChainForces { pins_y: [zero; 2], gradient: [zero; 6], raw: [zero; 6], work: zero, energy: zero }
    }

    /// Copies one SIMD lane to `one`.
    #[inline(always)]
    pub(super) fn copy_lane(&self, lane: usize, one: &mut ChainForces<f64>) {
        copy_lane(&self.pins_y, lane, &mut one.pins_y);
        copy_lane(&self.gradient, lane, &mut one.gradient);
        copy_lane(&self.raw, lane, &mut one.raw);
        (one.work, one.energy) = (self.work.lane(lane), self.energy.lane(lane));
    }
}

/// The elements of a chain that are already condensed, as a cantilever with its forces.
pub(super) type PartialChain<R> = (Cantilever<R>, Forces<R>);

/// Index ranges of a chain's inner nodes and inner rotations in a motion. Inner nodes and inner rotations are numbered consecutively.
#[derive(Debug, Clone)]
pub(super) struct Between {
    pub nodes: Range<usize>,
    pub rotations: Range<usize>,
    /// Rotation slots to which the two ends are clamped; at a pinned end, the slot of the pin.
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

/// Range of a line's joints in an array with one entry per member. All elements of the line except the first have a joint.
pub(super) fn joints_of(line: &Line) -> Range<usize> {
    match line.members.len() {
        0 => line.members.clone(),
        _ => line.members.start + 1..line.members.end,
    }
}

/// Eliminates the pinned rotations from the gradient of the ends. Returns y = L^-1 g of this elimination.
#[inline(always)]
fn pass_pins<R: Number>(block: &Block<R, 2, 6>, gradient: &mut Ends<R>) -> [R; 2] {
    let y = block.forward(&[gradient[2], gradient[5]]);
    (gradient[2], gradient[5]) = (y[0].zero(), y[0].zero());
    block.reduce_gradient(&y, gradient);
    y
}

/// Eliminates the pinned rotations from the stiffness of the ends.
#[inline(always)]
fn eliminate_pins<R: Number>(block: &mut Block<R, 2, 6>, stiffness: &mut EndsMatrix<R>) {
    let zero = stiffness[0][0].zero();
    let own = [[stiffness[2][2], stiffness[2][5]], [zero, stiffness[5][5]]];
    let upper = |i: usize, j: usize| stiffness[i.min(j)][i.max(j)];
    let mut coupling = [2, 5].map(|i| std::array::from_fn(|j| upper(i, j)));
    for row in coupling.iter_mut().chain(stiffness.iter_mut()) {
        (row[2], row[5]) = (zero, zero);
    }
    (stiffness[2], stiffness[5]) = ([zero; 6], [zero; 6]);
    block.factorise(&own, &coupling);
    block.reduce_stiffness(stiffness);
}
