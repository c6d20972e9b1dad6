//! Residual of a finger's equilibrium equations: elimination of the residual with a factored stiffness, and Newton's correction.

use super::chain::{Between, ChainForces, joints_of};
use super::elements::OneLine;
use super::ends::{Ends, halves, joined};
use super::factor::Factor;
use super::loads::Applied;
use super::retraction::Retraction;
use super::rung::RigidRib;
use crate::Kinematics;
use crate::element::Previous;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
use crate::number::Number;
use nalgebra::Vector2;

/// Forces and buffers for one motion under one load, or for several motions in SIMD lanes. The stiffness is stored separately, in [`Factor`].
#[derive(Debug, Clone)]
pub(in crate::statics) struct Balance<'m, R: Number = f64> {
    pub(super) mesh: &'m Mesh,
    pub(super) kinematics: Kinematics,
    pub(super) applied: Applied<R>,
    /// Condensed forces of each line.
    pub(super) forces: Vec<ChainForces<R>>,
    /// Forward substitution y = L^-1 g of each joint (elimination of one element of a chain).
    pub(super) ys: Vec<[R; 3]>,
    /// Shape of each member at the last linearised motion.
    pub(in crate::statics) previous: Vec<Previous<R>>,
    /// Whether the next tangent is computed with forces that are extrapolated from the previous shapes.
    pub(in crate::statics) extrapolates: bool,
    /// Forward substitution y = L^-1 g of each rung (pair of key nodes joined by a rib).
    pub(super) rung_ys: Vec<Ends<R>>,
    /// Forward substitution y = L^-1 g of the tip.
    pub(super) tip_y: [R; 3],
    /// Elastic energy of all lines (plate members and ribs), N mm.
    pub(in crate::statics) energy: R,
    /// Work of the residual on the correction, N mm.
    work: R,
    /// Corrections of the nodes of each rung (pair of key nodes joined by a rib), mm and rad; back substitution sets them.
    corrections: Vec<Ends<R>>,
    /// Correction of the tip, mm and rad.
    tip_correction: [R; 3],
    /// Updates the nodes inside lines after a correction. `None` with linear kinematics, or if no line has inner nodes.
    pub(super) retraction: Option<Retraction<R>>,
}

impl<'m, R: Number> Balance<'m, R> {
    /// Allocates the arrays for a mesh, in the number type of `like`.
    pub(in crate::statics) fn new(mesh: &'m Mesh, kinematics: Kinematics, like: R) -> Balance<'m, R> {
        let (frame, rungs, zero) = (mesh.frame(), mesh.finger().rib_count(), like.zero());
        let bends = kinematics != Kinematics::Linear && mesh.lines().iter().any(|line| line.members.len() > 1);
        Balance {
            mesh,
            kinematics,
            applied: Applied::none(rungs, like),
            forces: vec![ChainForces::none(like); mesh.lines().len()],
            ys: vec![[zero; 3]; frame.members().len()],
            previous: frame.members().iter().map(|member| Previous::at_rest(&member.beam.in_numbers(like))).collect(),
            extrapolates: false,
            rung_ys: vec![[zero; 6]; rungs],
            tip_y: [zero; 3],
            energy: zero,
            work: zero,
            corrections: vec![[zero; 6]; rungs],
            tip_correction: [zero; 3],
            retraction: bends.then(|| Retraction::new(frame, like)),
        }
    }

    pub(super) fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// Removes all loads.
    pub(in crate::statics) fn take_off_loads(&mut self) {
        self.applied.clear();
    }

    /// Adds `factor` times the loads in one lane. `motion` is the motion in that lane.
    pub(in crate::statics) fn apply_loads(
        &mut self,
        lane: usize,
        motion: &FrameMotion,
        loads: &[FrameLoad],
        factor: f64,
    ) {
        self.applied.add(lane, (self.mesh, self.kinematics), motion, loads, factor);
    }

    /// The undeformable rib of the rung `level`; `None` if the rib is deformable.
    #[inline(always)]
    fn rigid_rib(&self, stiffness: &Factor<R>, level: usize, motion: &FrameMotion<R>) -> Option<RigidRib<R>> {
        let frame = self.mesh.frame();
        let [front, back] = self.mesh.finger().rib_nodes(level).map(|node| self.mesh.frame_node(node));
        if !frame.is_linked(front) {
            return None;
        }
        let zero = self.work.zero();
        let (with_back, with_front) = (frame.rotation_of(back), frame.rotation_of(front));
        let mut levers = [Vector2::new(zero, zero); 3];
        for (slot, lever) in frame.turned_levers(front, motion, self.linear()) {
            let sum = &mut levers[if slot == with_back {
                0
            } else if slot == with_front {
                2
            } else {
                1
            }];
            *sum = Vector2::new(sum.x + lever.x, sum.y + lever.y);
        }
        let front_pull = if self.linear() {
            Vector2::new(zero, zero)
        } else {
            let raw = stiffness.rung_sum(level, |line| &self.forces[line].raw);
            let load = &self.applied.on_rung(level, 3).gradient;
            Vector2::new(raw[3] + load[0], raw[4] + load[1])
        };
        Some(RigidRib { levers, together: with_back == with_front, front_pull })
    }

    /// Factorises the tangent stiffness at a motion under the applied loads, and stores the condensed forces.
    #[inline(always)]
    pub(in crate::statics) fn factorise(&mut self, stiffness: &mut Factor<R>, motion: &FrameMotion<R>) {
        self.condense_lines(stiffness, motion);
        self.eliminate_rungs(stiffness, motion);
    }

    /// Eliminates the tip, then the rungs (pairs of key nodes joined by a rib) towards the base. The lines must already be condensed.
    #[inline(always)]
    pub(super) fn eliminate_rungs(&mut self, stiffness: &mut Factor<R>, motion: &FrameMotion<R>) {
        stiffness.eliminate_tip(self.applied.on_tip());
        for level in (0..self.rung_ys.len()).rev() {
            let rib = self.rigid_rib(stiffness, level, motion);
            stiffness.eliminate_rung(level, rib, [0, 3].map(|row| self.applied.on_rung(level, row)));
        }
    }

    /// Eliminates the gradient from tip to base, with a stiffness that is already factored.
    #[inline(always)]
    pub(in crate::statics) fn eliminate_gradient(&mut self, stiffness: &Factor<R>) {
        let count = self.rung_ys.len();
        let mut tip = self.applied.on_tip().gradient;
        for line in stiffness.plate_members(count) {
            for i in 0..3 {
                tip[i] += self.forces[line].gradient[3 + i];
            }
        }
        self.tip_y = stiffness.tip.forward(&tip);
        let mut work = self.work.zero();
        for forces in &self.forces {
            work += forces.work;
        }
        work += stiffness.tip.work(&self.tip_y);
        for level in (0..count).rev() {
            let mut gradient = stiffness.rung_sum(level, |line| &self.forces[line].gradient);
            match stiffness.rungs.get(level + 1) {
                Some(above) => above.reduce_gradient(&self.rung_ys[level + 1], &mut gradient),
                None => stiffness.tip.reduce_gradient(&self.tip_y, &mut gradient),
            }
            for row in [0, 3] {
                let load = &self.applied.on_rung(level, row).gradient;
                for i in 0..3 {
                    gradient[row + i] += load[i];
                }
            }
            self.rung_ys[level] = stiffness.rungs[level].forward(&gradient);
            work += stiffness.rungs[level].work(&self.rung_ys[level]);
        }
        self.work = work;
    }

    /// Adds Newton's correction to the linearised motion. Returns the squared energy norm of the correction, N mm.
    #[inline(always)]
    pub(in crate::statics) fn correct(&mut self, stiffness: &Factor<R>, motion: &mut FrameMotion<R>) -> R {
        let work = self.correct_nodes(stiffness, motion);
        self.mend_lines(stiffness, motion);
        work
    }

    /// Adds Newton's correction without the [`Retraction`], so the inner nodes of a line move along straight lines. Returns the squared energy norm
    /// of the correction, N mm.
    #[inline(always)]
    pub(super) fn correct_nodes(&mut self, stiffness: &Factor<R>, motion: &mut FrameMotion<R>) -> R {
        if let Some(retraction) = &mut self.retraction {
            retraction.before.clone_from(motion);
        }
        let (mesh, frame, finger, linear) = (self.mesh, self.mesh.frame(), self.mesh.finger(), self.linear());
        let zero = self.work.zero();
        let mut below = [zero; 6];
        for (level, rung) in stiffness.rungs.iter().enumerate() {
            let (correction, link_rotation) = rung.motion(&self.rung_ys[level], &below);
            self.corrections[level] = correction;
            let [front, back] = finger.rib_nodes(level).map(|node| mesh.frame_node(node));
            for (node, row) in [(back, 0), (front, 3)] {
                // A tied node moves with a node of the rung below; `follow_links` later sets its motion.
                if rung.tied_row() == Some(row) {
                    continue;
                }
                let u = &mut motion.displacements[node];
                u.x += correction[row];
                u.y += correction[row + 1];
                if node == back || frame.rotation_of(front) != frame.rotation_of(back) {
                    motion.rotations[frame.rotation_of(node)] += correction[row + 2];
                }
            }
            if let Some(turn) = link_rotation {
                let of_nodes = [back, front].map(|node| frame.rotation_of(node));
                if let Some(slot) = frame.lever_rotations(front).find(|slot| !of_nodes.contains(slot)) {
                    motion.rotations[slot] += turn;
                }
            }
            below = correction;
        }
        let tip = stiffness.tip.motion(&self.tip_y, &below);
        self.tip_correction = tip;
        let tip_node = mesh.frame_node(finger.tip());
        let u = &mut motion.displacements[tip_node];
        u.x += tip[0];
        u.y += tip[1];
        motion.rotations[frame.rotation_of(tip_node)] += tip[2];
        frame.follow_links(motion, linear);

        // Back substitution along each chain, starting from the corrections of the chain's ends.
        for (index, line) in mesh.lines().iter().enumerate() {
            let joints = joints_of(line);
            if line.members.is_empty() || (joints.is_empty() && !stiffness.chains[index].is_pinned()) {
                continue;
            }
            let ends = self.line_ends(stiffness, index);
            let between = Between::of(frame, line);
            let inner = (&stiffness.joints[joints.clone()], &self.ys[joints], &between);
            stiffness.chains[index].correct(inner, &self.forces[index], motion, &ends);
        }
        self.work
    }

    /// Moves and rotates the nodes inside lines by the [`Retraction`] of the last correction.
    #[inline(always)]
    pub(super) fn mend_lines(&mut self, stiffness: &Factor<R>, motion: &mut FrameMotion<R>) {
        let Some(mut retraction) = self.retraction.take() else { return };
        let (frame, like) = (self.mesh.frame(), self.work);
        for (index, line) in self.mesh.lines().iter().enumerate().filter(|(_, line)| line.members.len() > 1) {
            retraction.mend(OneLine { frame, line, like }, motion, self.end_nodes(stiffness, index));
        }
        self.retraction = Some(retraction);
    }

    /// Corrections of the two ends of a line.
    #[inline(always)]
    fn line_ends(&self, stiffness: &Factor<R>, index: usize) -> Ends<R> {
        line_ends(stiffness, index, &self.corrections, &self.tip_correction)
    }

    /// Displacements of the first and last node of a line in the last correction, mm.
    #[inline(always)]
    pub(super) fn end_nodes(&self, stiffness: &Factor<R>, index: usize) -> [Vector2<R>; 2] {
        let [x, y, _, end_x, end_y, _] = self.line_ends(stiffness, index);
        [Vector2::new(x, y), Vector2::new(end_x, end_y)]
    }
}

/// Motions of the two ends of a line for given motions of the rungs and of the tip.
#[inline(always)]
pub(super) fn line_ends<R: Number>(stiffness: &Factor<R>, index: usize, rungs: &[Ends<R>], tip: &[R; 3]) -> Ends<R> {
    let count = rungs.len();
    // Level of the first end, and the plate (0 back, 1 front) of each end.
    let (level, sides) = match index {
        back if back <= count => (back, [0, 0]),
        front if front < 2 * (count + 1) => (front - (count + 1), [1, 1]),
        rib => (rib - 2 * (count + 1) + 1, [0, 1]),
    };
    let upper = if sides[0] == sides[1] { level + 1 } else { level };
    // Level 0 is the base; the rungs follow, then the tip.
    let key_motion = |level: usize, side: usize| match level {
        0 => [tip[0].zero(); 3],
        level if level > count => *tip,
        level => halves(&rungs[level - 1])[side],
    };
    stiffness.chains[index].carried(&joined(&key_motion(level, sides[0]), &key_motion(upper, sides[1])))
}

impl Balance<'_> {
    /// Largest magnitude of a key node's displacement in the last correction, mm.
    pub(super) fn largest_correction(&self) -> f64 {
        let nodes = self.corrections.iter().flat_map(halves).chain([self.tip_correction]);
        nodes.map(|[x, y, _]| x * x + y * y).fold(0.0, f64::max).sqrt()
    }
}
