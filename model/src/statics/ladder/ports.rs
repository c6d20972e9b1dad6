//! A finger condensed onto a few of its mesh nodes, the ports: motions of the ports under forces on the ports.
//!
//! Contact forces are unknown and act on few nodes. The equilibrium equations of a finger in contact therefore need, beside the residual, only the
//! compliance between the nodes that are touched.

use super::balance::line_ends;
use super::chain::{Between, joints_of};
use super::ends::{Ends, joined};
use super::factor::Factor;
use super::loads::location;
use super::{Ladder, Location, dispatched};
use crate::frame::{FrameLoad, FrameMotion, NodeIndex};
use crate::statics::EquilibriumEquations;
use nalgebra::DMatrix;

/// Forward substitutions y = L^-1 g of a gradient g: of rungs, tip, and the joints of a loaded line.
struct Substituted<'a> {
    rungs: &'a [Ends],
    tip: &'a [f64; 3],
    joints_of: &'a dyn Fn(usize) -> Option<&'a [[f64; 3]]>,
}

impl Ladder<'_> {
    /// Evaluates residual and tangent as [`linearise`](EquilibriumEquations::linearise) does, with springs of `stiffness` (N/mm) that hold every key
    /// node at its displacement in `from`. Returns `false` if the tangent is not positive definite.
    pub fn linearise_with_springs(
        &mut self,
        motion: &FrameMotion,
        loads: &[FrameLoad],
        (stiffness, from): (f64, &FrameMotion),
    ) -> bool {
        if stiffness == 0.0 {
            return self.linearise(motion, loads, 1.0);
        }
        self.rests = false;
        self.balance.take_off_loads();
        self.balance.apply_loads(0, motion, loads, 1.0);
        self.balance.applied.add_springs(self.mesh, motion, (stiffness, from));
        self.factorise(motion);
        dispatched::eliminate_gradient(&mut self.balance, &self.own);
        self.own.positive
    }

    /// Compliance between nodes at key nodes or inside plates, at the last linearised motion. Rows are x, y (mm) and rotation (rad) of each port;
    /// columns are unit forces (1 N along x and y) and moments (1 N mm) on each port.
    pub fn compliance_at(&mut self, ports: &[NodeIndex]) -> DMatrix<f64> {
        let places: Vec<Location> = ports.iter().map(|node| location(self.mesh, *node)).collect();
        let mut compliance = DMatrix::zeros(3 * ports.len(), 3 * ports.len());
        let (mut ys, mut scratch) = (Vec::new(), self.at_rest());
        for column in 0..3 * ports.len() {
            let mut unit = [0.0; 3];
            // A gradient is minus a force.
            unit[column % 3] = -1.0;
            let mut tip = self.take_off();
            let mut loaded = None;
            match places[column / 3] {
                Location::Clamped => continue,
                Location::Tip => tip = unit,
                Location::Rung { rung, row } => self.waiting[rung][row..row + 3].copy_from_slice(&unit),
                Location::Inside { line, element } => {
                    let stiffness = Factor::chosen(self.mesh, &self.own, self.rests);
                    let joints = &stiffness.joints[joints_of(&self.mesh.lines()[line])];
                    let on_element = |at: usize| if at == element { joined(&unit, &[0.0; 3]) } else { [0.0; 6] };
                    ys.clear();
                    let (on_ends, _) = stiffness.chains[line].carried_gradient(joints, on_element, |_, y| ys.push(y));
                    tip = self.put_on(line, &on_ends, tip);
                    loaded = Some(line);
                }
            }
            let tip_y = self.substitute(&tip);
            let of_line = |line: usize| (loaded == Some(line)).then_some(&ys[..]);
            let substituted = Substituted { rungs: &self.waiting, tip: &tip_y, joints_of: &of_line };
            self.motions_at((ports, &places), &substituted, &mut scratch, |row, value| {
                compliance[(row, column)] = value
            });
        }
        compliance
    }

    /// Newton's correction of nodes at key nodes or inside plates, to first order: x, y (mm) and rotation (rad) of each port.
    pub fn correction_at(&self, ports: &[NodeIndex]) -> Vec<f64> {
        let places: Vec<Location> = ports.iter().map(|node| location(self.mesh, *node)).collect();
        let mut correction = vec![0.0; 3 * ports.len()];
        let of_line = |line: usize| Some(&self.balance.ys[joints_of(&self.mesh.lines()[line])]);
        let substituted = Substituted { rungs: &self.balance.rung_ys, tip: &self.balance.tip_y, joints_of: &of_line };
        let mut scratch = self.at_rest();
        self.motions_at((ports, &places), &substituted, &mut scratch, |row, value| correction[row] = value);
        correction
    }

    /// Passes x, y and rotation of each port to `write`, with their row, by back substitution.
    fn motions_at(
        &self,
        (ports, places): (&[NodeIndex], &[Location]),
        substituted: &Substituted,
        scratch: &mut FrameMotion,
        mut write: impl FnMut(usize, f64),
    ) {
        let (stiffness, frame) = (self.factor(), self.mesh.frame());
        let mut below = [0.0; 6];
        let motion = |(rung, y): (&super::rung::Rung<f64>, &Ends)| {
            below = rung.motion(y, &below).0;
            below
        };
        let rungs: Vec<Ends> = stiffness.rungs.iter().zip(substituted.rungs).map(motion).collect();
        let tip = stiffness.tip.motion(substituted.tip, rungs.last().unwrap_or(&[0.0; 6]));
        let mut last_line = None;
        for (port, (node, place)) in ports.iter().zip(places).enumerate() {
            let moved = match *place {
                Location::Clamped => [0.0; 3],
                Location::Tip => tip,
                Location::Rung { rung, row } => [rungs[rung][row], rungs[rung][row + 1], rungs[rung][row + 2]],
                Location::Inside { line, .. } => {
                    let along = &self.mesh.lines()[line];
                    let joints = &stiffness.joints[joints_of(along)];
                    let between = Between::of(frame, along);
                    if last_line.replace(line) != Some(line) {
                        scratch.displacements[between.nodes.clone()].fill(crate::Vector::zeros());
                        scratch.rotations[between.rotations.clone()].fill(0.0);
                        let still = vec![[0.0; 3]; joints.len()];
                        let ys = (substituted.joints_of)(line).unwrap_or(&still);
                        let ends = line_ends(stiffness, line, &rungs, &tip);
                        let inner = (joints, ys, &between);
                        stiffness.chains[line].correct(inner, &self.balance.forces[line], scratch, &ends);
                    }
                    let u = scratch.displacements[*node];
                    [u.x, u.y, scratch.rotations[frame.rotation_of(*node)]]
                }
            };
            moved.into_iter().enumerate().for_each(|(axis, value)| write(3 * port + axis, value));
        }
    }
}
