//! Lines with the loads that stand between their ends, condensed.

use super::chain::{ChainForces, Element, joints_of, numbers};
use super::factor::Factor;
use super::{Ladder, Location};
use crate::Kinematics;
use crate::element::Response;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;

impl Ladder<'_> {
    /// Condenses every line with the loads that stand on it.
    pub(super) fn condense_lines(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        let Ladder { mesh, kinematics, ref places, .. } = *self;
        let frame = mesh.frame();
        let standing = Standing { mesh, kinematics, motion, loads, places, factor };
        self.energy = 0.0;
        for (index, (chain, line)) in self.own.chains.iter_mut().zip(mesh.lines()).enumerate() {
            let forces = &mut self.forces[index];
            let loaded = standing.on_line(index);
            let members = &frame.members()[line.members.clone()];
            if let [only] = members {
                let mut response = frame.member_response(motion, only, kinematics);
                self.energy += response.energy;
                if let Some(load) = if loaded { standing.on_element(index, 0) } else { None } {
                    response.gradient += load.gradient;
                    response.tangent += load.tangent;
                }
                chain.take(forces, &response);
                continue;
            }
            let energy = &mut self.energy;
            let elements = members.iter().enumerate().map(|(i, member)| {
                let elastic = frame.member_response(motion, member, kinematics);
                *energy += elastic.energy;
                let load = if loaded { standing.on_element(index, i) } else { None };
                Element { elastic, load, lever: frame.lever(motion, member, kinematics == Kinematics::Linear) }
            });
            let inner = joints_of(line);
            chain.condense(&mut self.own.joints[inner.clone()], forces, &mut self.ys[inner], elements);
        }
    }

    /// Condenses the gradients of every line with the stiffness of small displacements. `unmoved`: the motion is none, and
    /// so are the forces of elements.
    pub(super) fn load_lines(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64, unmoved: bool) {
        let Ladder { mesh, kinematics, ref places, .. } = *self;
        let frame = mesh.frame();
        let standing = Standing { mesh, kinematics, motion, loads, places, factor };
        let Factor { chains, joints, .. } = Factor::chosen(mesh, &self.own, self.rests);
        self.energy = 0.0;
        for (index, (chain, line)) in chains.iter().zip(mesh.lines()).enumerate() {
            let inner = joints_of(line);
            let (forces, ys) = (&mut self.forces[index], &mut self.ys[inner.clone()]);
            let loaded = standing.on_line(index);
            if unmoved && !loaded {
                *forces = ChainForces::NONE;
                ys.fill([0.0; 3]);
                continue;
            }
            let sum = &mut self.energy;
            let gradients = frame.members()[line.members.clone()].iter().enumerate().map(|(i, member)| {
                let (energy, mut gradient) = frame.member_linear_forces(motion, member);
                *sum += energy;
                if let Some(load) = if loaded { standing.on_element(index, i) } else { None } {
                    gradient += load.gradient;
                }
                numbers(&gradient)
            });
            chain.load(&joints[inner], forces, ys, gradients);
        }
    }
}

/// The loads, and where they stand.
struct Standing<'a> {
    mesh: &'a Mesh,
    kinematics: Kinematics,
    motion: &'a FrameMotion,
    loads: &'a [FrameLoad],
    places: &'a [Location],
    factor: f64,
}

impl Standing<'_> {
    /// Whether any stands between the ends of a line.
    fn on_line(&self, index: usize) -> bool {
        self.places.iter().any(|place| matches!(place, Location::Inside { line, .. } if *line == index))
    }

    /// Potential of those that stand inside an element or on the node where it begins, by the motion of its two nodes.
    #[cold]
    fn on_element(&self, line: usize, element: usize) -> Option<Response> {
        let here = Location::Inside { line, element };
        let standing = self.loads.iter().zip(self.places).filter(|(_, place)| **place == here);
        standing.map(|(load, _)| self.potential(load)).reduce(|mut sum, part| {
            sum.energy += part.energy;
            sum.gradient += part.gradient;
            sum.tangent += part.tangent;
            sum
        })
    }

    fn potential(&self, load: &FrameLoad) -> Response {
        let frame = self.mesh.frame();
        if let FrameLoad::Interior { member, xi, force } = *load {
            return frame.interior_load(self.motion, member, self.kinematics, xi, force * self.factor);
        }
        let (end, force, moment_nmm) = load.at_end(frame);
        let linear = self.kinematics == Kinematics::Linear;
        frame.end_load(self.motion, end, force * self.factor, moment_nmm * self.factor, linear)
    }
}
