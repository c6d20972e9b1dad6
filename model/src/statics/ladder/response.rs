//! What small added loads do to the finger in equilibrium: sensitivities from the factored tangent.

use super::rung::Vector6;
use super::{Ladder, Place};
use crate::Vector;
use crate::element::ElementVector;
use crate::frame::FrameMotion;
use crate::statics::FrameLoad;
use nalgebra::Vector3;

/// Forces on the two nodes of an element of a line.
struct OnElement {
    line: usize,
    element: usize,
    forces: [Vector3<f64>; 2],
}

impl OnElement {
    fn new(line: usize, element: usize, forces: &ElementVector) -> OnElement {
        let forces = [forces.fixed_rows::<3>(0).into_owned(), forces.fixed_rows::<3>(3).into_owned()];
        OnElement { line, element, forces }
    }
}

impl Ladder<'_> {
    /// How the key nodes move, to first order, when a load is added to the finger in its last linearised `motion`: a
    /// column of the tangent compliance, mm per unit of the load.
    pub fn added_load(&self, motion: &FrameMotion, load: &FrameLoad, out: &mut [Vector]) {
        let frame = self.mesh.frame();
        let forces = match *load {
            FrameLoad::Interior { member, xi, force } => {
                -frame.interior_load(motion, member, self.kinematics, xi, force).gradient
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => {
                let (end, force, moment_nmm) = load.at_end(frame);
                -frame.end_load(motion, end, force, moment_nmm, self.linear()).gradient
            }
        };
        self.respond(&self.placed(load, &forces), out);
    }

    /// How the key nodes move, to first order, per mm that a load moves along the front plate towards the tip.
    pub fn moved_load(&self, motion: &FrameMotion, load: &FrameLoad, out: &mut [Vector]) {
        let frame = self.mesh.frame();
        let slope = match *load {
            // Elements of the front plate run from the base to the tip.
            FrameLoad::Interior { member, xi, force } => {
                frame.interior_load_slope(motion, member, self.kinematics, xi, force)
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => {
                let (end, force, _) = load.at_end(frame);
                frame.arm_load_slope(motion, end, self.mesh.finger().front_tangent(), force, self.linear())
            }
        };
        self.respond(&self.placed(load, &slope), out);
    }

    /// The element that takes the forces of a load: its own, or one that ends or begins at its node.
    fn placed(&self, load: &FrameLoad, forces: &ElementVector) -> OnElement {
        if let FrameLoad::Interior { member, .. } = *load {
            let lines = self.mesh.lines().iter().enumerate();
            let line = lines.filter(|(_, line)| line.members.contains(&member)).map(|(i, _)| i).next().unwrap_or(0);
            return OnElement::new(line, member - self.mesh.lines()[line].members.start, forces);
        }
        let (end, _, _) = load.at_end(self.mesh.frame());
        let count = self.rungs.len();
        let (line, inside) = match self.places[end.node] {
            Place::Inside { line, element } => (line, Some(element)),
            Place::Tip => (self.stretches(count)[0], None),
            Place::Rung { rung, row } => (self.stretches(rung)[row / 3], None),
            // A load on a clamp moves nothing.
            Place::Clamped => return OnElement::new(self.stretches(0)[0], 0, &ElementVector::zeros()),
        };
        match inside {
            Some(element) => OnElement::new(line, element, forces),
            None => {
                let last = self.mesh.lines()[line].members.len() - 1;
                let at_end = [Vector3::zeros(), forces.fixed_rows::<3>(0).into_owned()];
                OnElement { line, element: last, forces: at_end }
            }
        }
    }

    /// One forward and one backward pass along the rungs with the factors that are there; nodes between the key nodes
    /// are not computed.
    fn respond(&self, on: &OnElement, out: &mut [Vector]) {
        let OnElement { line, element, forces } = *on;
        let count = self.rungs.len();
        let [first, second] = self.chains[line].condensed_forces(element, forces);
        // Levels and rows of the line's two ends.
        let stretch = count + 1;
        let (level, row) = if line < stretch { (line, 0) } else { (line - stretch, 3) };
        let force_at = |at: usize| {
            let mut forces = Vector6::zeros();
            for (end_level, force) in [(level, first), (level + 1, second)] {
                if end_level == at + 1 {
                    let mut part = forces.fixed_rows_mut::<3>(row);
                    part += force;
                }
            }
            forces
        };
        let tip_force = if level == count { second } else { Vector3::zeros() };
        let mut passed = Vector6::zeros();
        for (side, with) in self.tip.with.iter().enumerate() {
            passed.fixed_rows_mut::<3>(3 * side).copy_from(&(-(with.transpose() * tip_force)));
        }
        // The answers wait in `out` until what is below is known; forward from the tip.
        let mut waiting = vec![Vector6::zeros(); count];
        for at in (0..count).rev() {
            let forces = force_at(at) + passed;
            waiting[at] = self.rungs[at].answer(&forces);
            passed = self.rungs[at].passed_down(&forces);
        }
        out.fill(Vector::zeros());
        let finger = self.mesh.finger();
        let mut below = Vector6::zeros();
        for (at, rung) in self.rungs.iter().enumerate() {
            below = waiting[at] + rung.carried(&below);
            let [front, back] = finger.rib_nodes(at).map(|node| self.mesh.frame_node(node));
            out[back] = Vector::new(below[0], below[1]);
            out[front] = Vector::new(below[3], below[4]);
        }
        let halves = [below.fixed_rows::<3>(0).into_owned(), below.fixed_rows::<3>(3).into_owned()];
        let tip = self.tip_factor.solve(&tip_force) - self.tip.with[0] * halves[0] - self.tip.with[1] * halves[1];
        out[self.mesh.frame_node(finger.tip())] = Vector::new(tip[0], tip[1]);
    }
}
