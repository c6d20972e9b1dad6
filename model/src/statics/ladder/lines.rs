//! Lines with the loads that stand between their ends, condensed.

use super::chain::numbers;
use super::{Ladder, Location};
use crate::Kinematics;
use crate::element::Response;
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};

impl Ladder<'_> {
    /// Condenses every line with the loads that stand on it.
    pub(super) fn condense_lines(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        let (frame, kinematics, locations, rest) = (self.mesh.frame(), self.kinematics, &self.locations, &self.rest);
        self.energy = 0.0;
        for (index, (chain, line)) in self.chains.iter_mut().zip(self.mesh.lines()).enumerate() {
            let energy = &mut self.energy;
            chain.condense(line.members.clone().enumerate().map(|(i, member)| {
                let mut response = match rest.get(member) {
                    None => frame.member_response(motion, &frame.members()[member], kinematics),
                    Some(tangent) => {
                        let (energy, gradient) = frame.member_linear_forces(motion, &frame.members()[member]);
                        Response { energy, gradient, tangent: *tangent }
                    }
                };
                *energy += response.energy;
                let here = Location::Inside { line: index, element: i };
                for load in loads.iter().filter(|load| stands_on(load, frame, locations, member, here)) {
                    let potential = inside_load(load, frame, kinematics, motion, factor);
                    response.gradient += potential.gradient;
                    response.tangent += potential.tangent;
                }
                response
            }));
        }
    }

    /// Condenses the gradients of every line with the linear stiffness that is there.
    pub(super) fn load_lines(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        let (frame, locations) = (self.mesh.frame(), &self.locations);
        self.energy = 0.0;
        for (index, (chain, line)) in self.chains.iter_mut().zip(self.mesh.lines()).enumerate() {
            let sum = &mut self.energy;
            chain.load(line.members.clone().enumerate().map(|(i, member)| {
                let (energy, mut gradient) = frame.member_linear_forces(motion, &frame.members()[member]);
                *sum += energy;
                let here = Location::Inside { line: index, element: i };
                for load in loads.iter().filter(|load| stands_on(load, frame, locations, member, here)) {
                    gradient += inside_load(load, frame, Kinematics::Linear, motion, factor).gradient;
                }
                numbers(&gradient)
            }));
        }
    }
}

/// Whether a load stands on a member between two key nodes: inside it, or on the node where it begins (`here`).
fn stands_on(load: &FrameLoad, frame: &PlaneFrame, locations: &[Location], member: usize, here: Location) -> bool {
    match *load {
        FrameLoad::Interior { member: loaded, .. } => loaded == member,
        FrameLoad::Node { .. } | FrameLoad::Arm { .. } => locations[load.at_end(frame).0.node] == here,
    }
}

/// Potential of a load that stands on a member, by the motion of its nodes.
#[cold]
fn inside_load(
    load: &FrameLoad,
    frame: &PlaneFrame,
    kinematics: Kinematics,
    motion: &FrameMotion,
    factor: f64,
) -> Response {
    if let FrameLoad::Interior { member, xi, force } = *load {
        return frame.interior_load(motion, member, kinematics, xi, force * factor);
    }
    let (end, force, moment_nmm) = load.at_end(frame);
    frame.end_load(motion, end, force * factor, moment_nmm * factor, kinematics == Kinematics::Linear)
}
