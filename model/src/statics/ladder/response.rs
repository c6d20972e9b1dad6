//! Sensitivities of a finger in equilibrium to small additional loads, from the factored tangent.

use super::chain::joints_of;
use super::ends::{Ends, joined, numbers};
use super::factor::Factor;
use super::loads::place;
use super::{Ladder, Location, dispatched};
use crate::Vector;
use crate::element::quarter_turn;
use crate::finger::Plate;
use crate::frame::{FrameLoad, FrameMotion};

/// Line, element, and a gradient with respect to the motions of the element's two nodes. The gradient is minus the forces, N and N mm.
type OnElement = (usize, usize, Ends);

impl Ladder<'_> {
    /// Writes to `out` the markers' first-order displacements, mm, due to the additional `load` at the last linearised `motion`. `out` is indexed by key node
    /// from 0.
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
        let on = self.placed(load, numbers(&gradient));
        self.respond_to(motion, on, out);
    }

    /// Writes to `out` the markers' first-order displacements per mm that a load moves along its `plate` towards the tip, mm per mm. `out` is indexed by
    /// key node from 0.
    pub fn moved_load(&mut self, motion: &FrameMotion, load: &FrameLoad, plate: Plate, out: &mut [Vector]) {
        let frame = self.mesh.frame();
        let slope = match *load {
            // The elements of the plates point from base to tip, the direction in which the load moves.
            FrameLoad::Interior { member, xi, force } => {
                frame.interior_load_slope(motion, member, self.kinematics, xi, force)
            }
            FrameLoad::Node { .. } | FrameLoad::Arm { .. } => {
                let (end, force, _) = load.at_end(frame);
                frame.arm_load_slope(motion, end, self.mesh.finger().tangent(plate), force, self.linear())
            }
        };
        let on = self.placed(load, numbers(&-slope));
        self.respond_to(motion, on, out);
    }

    /// Writes to `out` the markers' first-order displacements per unit of ln(modulus), mm, at the last linearised `motion`. `shares` pairs a member's
    /// index with the derivative of the member's ln(stiffness). The additional load consists of the member's nodal forces times the derivative of the
    /// member's ln(stiffness). `out` is indexed by key node from 0.
    pub fn stiffened(&mut self, motion: &FrameMotion, shares: &[(usize, f64)], out: &mut [Vector]) {
        let members = self.mesh.frame().members();
        let mut share_of = vec![0.0; members.len()];
        for &(member, share) in shares {
            share_of[member] += share;
        }
        let tip = self.take_off();
        let tip = self.mesh.lines().iter().enumerate().fold(tip, |tip, (index, line)| {
            if line.members.clone().all(|member| share_of[member] == 0.0) {
                return tip;
            }
            let forces = |element: usize| {
                let member = line.members.start + element;
                numbers(&(members[member].response(motion, self.kinematics).gradient * share_of[member]))
            };
            let on_ends = self.condensed(index, forces);
            self.put_on(index, &on_ends, tip)
        });
        self.respond(motion, &tip, out);
    }

    /// Writes to `out` the markers' first-order displacements by Newton's correction at the last linearised `motion`, mm. `out` is indexed by key node
    /// from 0.
    pub fn corrected_markers(&self, motion: &FrameMotion, out: &mut [Vector]) {
        self.moved_markers(motion, &self.balance.rung_ys, &self.balance.tip_y, out);
    }

    /// Changes the loads of the last linearisation at `motion`, without a new tangent. Newton's correction then leads to first order to the equilibrium
    /// under the loads `after`. `springs` are those of the linearisation: see [`linearise_with_springs`](Self::linearise_with_springs).
    pub fn change_loads(
        &mut self,
        motion: &FrameMotion,
        before: &[FrameLoad],
        after: &[FrameLoad],
        springs: (f64, &FrameMotion),
    ) {
        let stiffness = Factor::chosen(self.mesh, &self.own, self.rests);
        self.balance.take_off_loads();
        self.balance.apply_loads(0, motion, before, -1.0);
        self.balance.apply_loads(0, motion, after, 1.0);
        self.balance.add_to_lines(stiffness);
        // The gradients of lines are sums now; those of key nodes are taken from the loads.
        self.balance.take_off_loads();
        self.balance.apply_loads(0, motion, after, 1.0);
        if springs.0 != 0.0 {
            self.balance.applied.add_springs(self.mesh, motion, springs);
        }
        dispatched::eliminate_gradient(&mut self.balance, stiffness);
    }

    /// Assigns the gradient of a load to the loaded element, or to an element that ends at the loaded node.
    fn placed(&self, load: &FrameLoad, gradient: Ends) -> OnElement {
        let line = match place(self.mesh, load) {
            Location::Inside { line, element } => return (line, element, gradient),
            Location::Tip => self.factor().plate_members(self.waiting.len())[0],
            Location::Rung { rung, row } => self.factor().plate_members(rung)[row / 3],
            // A load on a clamped node causes no motion.
            Location::Clamped => return (0, 0, [0.0; 6]),
        };
        let [x, y, moment, ..] = gradient;
        let element = self.mesh.lines()[line].members.len() - 1;
        (line, element, joined(&[0.0; 3], &[x, y, moment]))
    }

    /// Writes to `out` the markers' response to a gradient on one element.
    fn respond_to(&mut self, motion: &FrameMotion, (line, element, gradient): OnElement, out: &mut [Vector]) {
        let on_element = |at: usize| if at == element { gradient } else { [0.0; 6] };
        let on_ends = self.condensed(line, on_element);
        let tip = self.take_off();
        let tip = self.put_on(line, &on_ends, tip);
        self.respond(motion, &tip, out);
    }

    /// Gradients on the elements of a line, condensed onto the line's ends.
    fn condensed(&self, line: usize, on_element: impl Fn(usize) -> Ends) -> Ends {
        let stiffness = self.factor();
        let joints = &stiffness.joints[joints_of(&self.mesh.lines()[line])];
        stiffness.chains[line].condensed_gradient(joints, on_element)
    }

    /// Clears the gradients on the rungs and returns a zero gradient for the tip.
    pub(super) fn take_off(&mut self) -> [f64; 3] {
        self.waiting.fill([0.0; 6]);
        [0.0; 3]
    }

    /// Adds gradients at the ends of a line to the gradients on the rungs (nodes of one rib each). Returns the gradient on the tip.
    pub(super) fn put_on(&mut self, line: usize, on_ends: &Ends, mut tip: [f64; 3]) -> [f64; 3] {
        let per_plate = self.waiting.len() + 1;
        // Level (0 is the base, r + 1 is rung r) and row of each end of the line.
        let ends = match line {
            back if back < per_plate => [(back, 0), (back + 1, 0)],
            front if front < 2 * per_plate => [(front - per_plate, 3), (front - per_plate + 1, 3)],
            rib => [(rib - 2 * per_plate + 1, 0), (rib - 2 * per_plate + 1, 3)],
        };
        for ((level, row), end) in ends.into_iter().zip([0, 3]) {
            let sum = match level {
                0 => continue,
                level if level == per_plate => &mut tip[..],
                level => &mut self.waiting[level - 1][row..row + 3],
            };
            for i in 0..3 {
                sum[i] += on_ends[end + i];
            }
        }
        tip
    }

    /// Forward and back substitution for rungs and tip, with the stored factors. Gradients inside lines must already be condensed.
    fn respond(&mut self, motion: &FrameMotion, tip: &[f64; 3], out: &mut [Vector]) {
        let tip_y = self.substitute(tip);
        self.moved_markers(motion, &self.waiting, &tip_y, out);
    }

    /// Replaces the gradients on the rungs by their forward substitutions y = L^-1 g. Returns the forward substitution of the tip's gradient.
    pub(super) fn substitute(&mut self, tip: &[f64; 3]) -> [f64; 3] {
        let stiffness = Factor::chosen(self.mesh, &self.own, self.rests);
        let tip_y = stiffness.tip.forward(tip);
        for at in (0..self.waiting.len()).rev() {
            let mut gradient = [0.0; 6];
            match stiffness.rungs.get(at + 1) {
                Some(above) => above.reduce_gradient(&self.waiting[at + 1], &mut gradient),
                None => stiffness.tip.reduce_gradient(&tip_y, &mut gradient),
            }
            for (sum, on_rung) in gradient.iter_mut().zip(&self.waiting[at]) {
                *sum += on_rung;
            }
            self.waiting[at] = stiffness.rungs[at].forward(&gradient);
        }
        tip_y
    }

    /// Writes to `out` the markers' first-order displacements by back substitution from the forward substitutions y of rungs and tip.
    fn moved_markers(&self, motion: &FrameMotion, rung_ys: &[Ends], tip_y: &[f64; 3], out: &mut [Vector]) {
        let stiffness = self.factor();
        out.fill(Vector::zeros());
        let finger = self.mesh.finger();
        let mut below = [0.0; 6];
        for (at, (rung, y)) in stiffness.rungs.iter().zip(rung_ys).enumerate() {
            (below, _) = rung.motion(y, &below);
            for (node, row) in finger.rib_nodes(at).into_iter().zip([3, 0]) {
                let marker = self.mesh.marker_lever(node, motion, self.linear());
                let moved = Vector::new(below[row], below[row + 1]) + quarter_turn(marker) * below[row + 2];
                out[self.mesh.frame_node(node)] = moved;
            }
        }
        let [x, y, _] = stiffness.tip.motion(tip_y, &below);
        out[self.mesh.frame_node(finger.tip())] = Vector::new(x, y);
    }
}
