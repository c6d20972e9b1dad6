//! Condensation of lines (plate members and ribs), together with the loads between their ends.

use super::balance::Balance;
use super::brackets::Brackets;
use super::cantilever::Joint;
use super::chain::{Chain, ChainForces, Element, joints_of};
use super::elements::{Elements, OneLine};
use super::ends::numbers;
use super::factor::Factor;
use crate::Kinematics;
use crate::element::{Previous, Response};
use crate::frame::FrameMotion;
use crate::number::Number;

/// Storage for the results of condensing one line, or several lines in SIMD lanes: stiffness, forces, and a joint for each element except the first.
pub(super) struct Condensed<'a, R: Number> {
    pub chain: &'a mut Chain<R>,
    pub joints: &'a mut [Joint<R>],
    pub forces: &'a mut ChainForces<R>,
    /// Forward substitutions y = L^-1 g, one per joint.
    pub ys: &'a mut [[R; 3]],
    /// Shapes at the last linearised motion, one per element.
    pub previous: &'a mut [Previous<R>],
}

impl<R: Number> Condensed<'_, R> {
    /// Condenses a line of at least one element with its loads.
    #[inline(always)]
    pub(super) fn condense<'l>(
        self,
        elements: impl Elements<R>,
        motion: &FrameMotion<R>,
        (kinematics, extrapolates): (Kinematics, bool),
        load_on: impl Fn(usize) -> Option<&'l Response<R>>,
        brackets: Option<Brackets<R>>,
    ) where
        R: 'l,
    {
        let Condensed { chain, joints, forces, ys, previous } = self;
        let linear = kinematics == Kinematics::Linear;
        let first = elements.member(0);
        let straight = joints.is_empty();
        let mut elastic = first.elastic(motion, kinematics, &mut previous[0], (extrapolates, straight));
        forces.energy = elastic.response.energy;
        let load = load_on(0);
        if joints.is_empty() {
            if let Some(load) = load {
                elastic.response.gradient += load.gradient;
                elastic.response.tangent += load.tangent;
            }
            chain.take(forces, &elastic.response);
        } else {
            let element = Element { elastic, load, lever: first.lever(motion, linear) };
            let mut partial = chain.begin(forces, &element);
            for (i, joint) in joints.iter_mut().enumerate() {
                let member = elements.member(i + 1);
                let elastic = member.elastic(motion, kinematics, &mut previous[i + 1], (extrapolates, straight));
                forces.energy += elastic.response.energy;
                let element = Element { elastic, load: load_on(i + 1), lever: member.lever(motion, linear) };
                chain.extend(&mut partial, (joint, &mut ys[i]), forces, &element);
            }
            chain.end(&partial, forces);
        }
        chain.finish(forces, brackets, linear);
    }
}

impl<R: Number> Balance<'_, R> {
    /// Condenses every line with its loads.
    #[inline(always)]
    pub(super) fn condense_lines(&mut self, stiffness: &mut Factor<R>, motion: &FrameMotion<R>) {
        for index in 0..self.mesh.lines().len() {
            self.condense_line(index, stiffness, motion);
        }
        self.sum_energy();
    }

    /// Condenses one line with its loads.
    #[inline(always)]
    pub(super) fn condense_line(&mut self, index: usize, stiffness: &mut Factor<R>, motion: &FrameMotion<R>) {
        let (frame, line, linear) = (self.mesh.frame(), &self.mesh.lines()[index], self.linear());
        if line.members.is_empty() {
            return;
        }
        let (joints, applied) = (joints_of(line), &self.applied);
        let made = Condensed {
            chain: &mut stiffness.chains[index],
            joints: &mut stiffness.joints[joints.clone()],
            forces: &mut self.forces[index],
            ys: &mut self.ys[joints],
            previous: &mut self.previous[line.members.clone()],
        };
        let elements = OneLine { frame, line, like: self.energy };
        let load_on = |element: usize| applied.on_member(line.members.start + element);
        let brackets = Brackets::of(frame, line, motion, linear);
        made.condense(elements, motion, (self.kinematics, self.extrapolates), load_on, brackets);
    }

    /// Sums the elastic energy in the order of the lines, so that the result is bitwise reproducible.
    #[inline(always)]
    pub(super) fn sum_energy(&mut self) {
        self.energy = self.energy.zero();
        for forces in &self.forces {
            self.energy += forces.energy;
        }
    }
}

impl Balance<'_> {
    /// Condenses the gradients of every line for small displacements. If `unmoved`, the motion is zero and elements have no forces.
    pub(super) fn load_lines(&mut self, stiffness: &Factor, motion: &FrameMotion, unmoved: bool) {
        let (frame, applied) = (self.mesh.frame(), &self.applied);
        self.energy = 0.0;
        if unmoved {
            for (previous, member) in self.previous.iter_mut().zip(frame.members()) {
                *previous = Previous::at_rest(&member.beam);
            }
        }
        for (index, (chain, line)) in stiffness.chains.iter().zip(self.mesh.lines()).enumerate() {
            let inner = joints_of(line);
            let (forces, ys) = (&mut self.forces[index], &mut self.ys[inner.clone()]);
            if unmoved && !applied.on_any_member(&line.members) {
                *forces = ChainForces::none(0.0);
                ys.fill([0.0; 3]);
                continue;
            }
            let sum = &mut self.energy;
            let gradients = line.members.clone().map(|at| {
                let (energy, mut gradient) = frame.members()[at].linear_forces(motion);
                *sum += energy;
                if let Some(load) = applied.on_member(at) {
                    gradient += load.gradient;
                }
                numbers(&gradient)
            });
            chain.load(&stiffness.joints[inner], forces, ys, gradients);
        }
    }

    /// Adds the applied loads between the ends of lines to the lines' condensed gradients.
    pub(super) fn add_to_lines(&mut self, stiffness: &Factor) {
        let applied = &self.applied;
        for (index, (chain, line)) in stiffness.chains.iter().zip(self.mesh.lines()).enumerate() {
            if !applied.on_any_member(&line.members) {
                continue;
            }
            let inner = joints_of(line);
            let on_element = |element: usize| {
                applied.on_member(line.members.start + element).map_or([0.0; 6], |load| numbers(&load.gradient))
            };
            let (forces, ys) = (&mut self.forces[index], &mut self.ys[inner.clone()]);
            chain.add_load(&stiffness.joints[inner], forces, ys, on_element);
        }
    }
}
