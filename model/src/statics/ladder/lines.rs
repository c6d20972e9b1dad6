//! Lines with the loads that stand between their ends, condensed.

use super::balance::Balance;
use super::brackets::Brackets;
use super::chain::{ChainForces, Element, joints_of, numbers};
use super::factor::Factor;
use crate::Kinematics;
use crate::frame::FrameMotion;
use crate::number::Number;

impl<R: Number> Balance<'_, R> {
    /// Condenses every line with the loads that stand on it.
    #[inline(always)]
    pub(super) fn condense_lines(&mut self, stiffness: &mut Factor<R>, motion: &FrameMotion<R>) {
        let (frame, kinematics, applied) = (self.mesh.frame(), self.kinematics, &self.applied);
        let linear = kinematics == Kinematics::Linear;
        self.energy = self.energy.zero();
        for (index, line) in self.mesh.lines().iter().enumerate() {
            let (chain, forces) = (&mut stiffness.chains[index], &mut self.forces[index]);
            let count = line.members.len();
            let mut growing = None;
            for at in line.members.clone() {
                let member = &frame.members()[at];
                let mut elastic = frame.member_response(motion, member, kinematics);
                self.energy += elastic.energy;
                let load = applied.on_member(at);
                if count == 1 {
                    if let Some(load) = load {
                        elastic.gradient += load.gradient;
                        elastic.tangent += load.tangent;
                    }
                    chain.take(forces, &elastic);
                    break;
                }
                let element = Element { elastic, load, lever: frame.lever(motion, member, linear) };
                match &mut growing {
                    None => growing = Some(chain.begin(forces, &element)),
                    Some(growing) => {
                        chain.extend(growing, (&mut stiffness.joints[at], &mut self.ys[at]), forces, &element);
                    }
                }
            }
            if let Some(growing) = &growing {
                chain.end(growing, forces);
            }
            if count > 0 {
                chain.finish(forces, Brackets::of(frame, line, motion, linear), linear);
            }
        }
    }
}

impl Balance<'_> {
    /// Condenses the gradients of every line with the stiffness of small displacements. `unmoved`: the motion is none, and
    /// so are the forces of elements.
    pub(super) fn load_lines(&mut self, stiffness: &Factor, motion: &FrameMotion, unmoved: bool) {
        let (frame, applied) = (self.mesh.frame(), &self.applied);
        self.energy = 0.0;
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
                let (energy, mut gradient) = frame.member_linear_forces(motion, &frame.members()[at]);
                *sum += energy;
                if let Some(load) = applied.on_member(at) {
                    gradient += load.gradient;
                }
                numbers(&gradient)
            });
            chain.load(&stiffness.joints[inner], forces, ys, gradients);
        }
    }
}
