//! Sensitivities of the finger in equilibrium to small added loads, from the factored tangent.

use super::chain::{Ends, joined, joints_of, numbers};
use super::factor::Factor;
use super::loads::{element_of, place};
use super::{Ladder, Location};
use crate::Vector;
use crate::element::quarter_turn;
use crate::frame::{FrameLoad, FrameMotion};

/// A gradient on the two nodes of an element of a line: minus the forces there.
struct OnElement {
    line: usize,
    element: usize,
    gradient: Ends,
}

impl Ladder<'_> {
    /// How the markers move, by key node and to first order, when a load is added to the finger in its last linearised `motion`: a
    /// column of the tangent compliance, mm per unit of the load.
    pub fn added_load(&mut self, motion: &FrameMotion, load: &FrameLoad, out: &mut [Vector]) {
        let frame = self.mesh.frame();
        let gradient = match *load {
            FrameLoad::Interior { member, xi, force } => {
                frame.interior_load(motion, member, self.kinematics, xi, force).gradient
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => {
                let (end, force, moment_nmm) = load.at_end(frame);
                frame.end_load(motion, end, force, moment_nmm, self.linear()).gradient
            }
        };
        self.respond(motion, &self.placed(load, numbers(&gradient)), out);
    }

    /// How the markers move, by key node and to first order, per mm that a load moves along the front plate towards the tip.
    pub fn moved_load(&mut self, motion: &FrameMotion, load: &FrameLoad, out: &mut [Vector]) {
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
        self.respond(motion, &self.placed(load, numbers(&-slope)), out);
    }

    /// How the markers move, by key node and to first order, in the finger in its last linearised `motion` when a member stiffens: mm per
    /// unit of ln(modulus). Its forces grow in proportion to its modulus, so they are the added load.
    pub fn stiffened_member(&mut self, motion: &FrameMotion, member: usize, out: &mut [Vector]) {
        let response = self.mesh.frame().members()[member].response(motion, self.kinematics);
        let (line, element) = element_of(self.mesh, member);
        self.respond(motion, &OnElement { line, element, gradient: numbers(&response.gradient) }, out);
    }

    /// The element that takes the gradient of a load: its own, or one that ends or begins at its node.
    fn placed(&self, load: &FrameLoad, gradient: Ends) -> OnElement {
        let line = match place(self.mesh, load) {
            Location::Inside { line, element } => return OnElement { line, element, gradient },
            Location::Tip => self.factor().plate_members(self.waiting.len())[0],
            Location::Rung { rung, row } => self.factor().plate_members(rung)[row / 3],
            // A load on a clamp moves nothing.
            Location::Clamped => return OnElement { line: 0, element: 0, gradient: [0.0; 6] },
        };
        let [x, y, moment, ..] = gradient;
        let element = self.mesh.lines()[line].members.len() - 1;
        OnElement { line, element, gradient: joined(&[0.0; 3], &[x, y, moment]) }
    }

    /// One forward and one backward pass along the rungs with the factors that are there; nodes between the key nodes
    /// are not computed.
    fn respond(&mut self, motion: &FrameMotion, on: &OnElement, out: &mut [Vector]) {
        let OnElement { line, element, gradient } = *on;
        let count = self.waiting.len();
        let stiffness = Factor::chosen(self.mesh, &self.own, self.rests);
        let joints = &stiffness.joints[joints_of(&self.mesh.lines()[line])];
        let on_ends = stiffness.chains[line].condensed_gradient(joints, element, gradient);
        // Level (0 is the base, rung r is level r + 1) and row in it of the line's two ends.
        let per_plate = count + 1;
        let ends = match line {
            back if back < per_plate => [(back, 0), (back + 1, 0)],
            front if front < 2 * per_plate => [(front - per_plate, 3), (front - per_plate + 1, 3)],
            rib => [(rib - 2 * per_plate + 1, 0), (rib - 2 * per_plate + 1, 3)],
        };
        let at_tip = ends[1].0 == per_plate;
        let tip = if at_tip { [on_ends[3], on_ends[4], on_ends[5]] } else { [0.0; 3] };
        let tip_y = stiffness.tip.forward(&tip);
        for at in (0..count).rev() {
            let mut gradient = [0.0; 6];
            match stiffness.rungs.get(at + 1) {
                Some(above) => above.reduce_gradient(&self.waiting[at + 1], &mut gradient),
                None => stiffness.tip.reduce_gradient(&tip_y, &mut gradient),
            }
            for ((level, row), end) in ends.into_iter().zip([0, 3]) {
                if level == at + 1 {
                    for i in 0..3 {
                        gradient[row + i] += on_ends[end + i];
                    }
                }
            }
            self.waiting[at] = stiffness.rungs[at].forward(&gradient);
        }
        out.fill(Vector::zeros());
        let finger = self.mesh.finger();
        let mut below = [0.0; 6];
        for (at, (rung, waiting)) in stiffness.rungs.iter().zip(&self.waiting).enumerate() {
            (below, _) = rung.motion(waiting, &below);
            for (node, row) in finger.rib_nodes(at).into_iter().zip([3, 0]) {
                let marker = self.mesh.marker_lever(node, motion, self.linear());
                let moved = Vector::new(below[row], below[row + 1]) + quarter_turn(marker) * below[row + 2];
                out[self.mesh.frame_node(node)] = moved;
            }
        }
        let [x, y, _] = stiffness.tip.motion(&tip_y, &below);
        out[self.mesh.frame_node(finger.tip())] = Vector::new(x, y);
    }
}
