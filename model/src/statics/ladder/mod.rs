//! The finger as a ladder: plates condensed onto the key nodes, then pairs of key nodes eliminated from tip to base.
//!
//! A finger's equations have one long direction only. Members condense onto their ends ([`chain`]), which leaves the
//! back and front node of each rib as a block of six unknowns that is coupled to its two neighbours alone: a block
//! tridiagonal system. Its elimination from the tip costs a fixed number of operations a rib and touches no heap. The
//! general sparse path ([`SparseEquations`](super::SparseEquations)) solves any frame and is what this one is checked
//! against.

mod block;
mod chain;
mod ldl;
mod lines;
mod response;
mod retraction;
mod rung;

use super::EquilibriumEquations;
use crate::element::ElementMatrix;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
use crate::{Kinematics, Vector};
use block::Block;
use chain::{Chain, Ends, EndsMatrix, halves};
use retraction::Retraction;
use rung::{RigidRib, Rung};

/// A pivot below this share of what the elements put on its diagonal has lost digits to cancellation that may count: the
/// paper's finger keeps 2e-2 on 25 nodes and 3e-4 on 684; thin plates, and random fingers that miss 1e-8, keep less.
const SMALL_PIVOT: f64 = 1e-3;

/// Where a frame node is in the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Location {
    Clamped,
    Tip,
    Rung {
        rung: usize,
        row: usize,
    },
    /// Inside a line, `element` elements from its first end.
    Inside {
        line: usize,
        element: usize,
    },
}

/// Block elimination of a finger's equations.
#[derive(Debug, Clone)]
pub struct Ladder<'m> {
    mesh: &'m Mesh,
    kinematics: Kinematics,
    /// Tangents of the members at rest, where they never change: with linear kinematics.
    rest: Vec<ElementMatrix>,
    chains: Vec<Chain>,
    locations: Vec<Location>,
    /// From the base to the tip.
    rungs: Vec<Rung>,
    /// The tip, with the back and front node of the last rung; and y = L^-1 g of it.
    tip: Block<3, 6>,
    tip_y: [f64; 3],
    /// Whether the stiffness is eliminated; the linear one never changes.
    factored: bool,
    /// Whether no pivot of the elimination has lost more than three digits to cancellation.
    accurate: bool,
    energy: f64,
    work: f64,
    /// One for each rung and one for the tip: their corrections on the way back.
    corrections: Vec<Ends>,
    /// One for each rung: what waits for the way back when loads are added.
    waiting: Vec<Ends>,
    /// Where rotations are large and lines have inner nodes.
    retraction: Option<Retraction>,
}

impl<'m> Ladder<'m> {
    /// Finds the order of elimination, once a mesh.
    pub fn new(mesh: &'m Mesh, kinematics: Kinematics) -> Ladder<'m> {
        let (frame, finger) = (mesh.frame(), mesh.finger());
        let chains: Vec<Chain> = mesh.lines().iter().map(|line| Chain::new(frame, line)).collect();
        let mut locations = vec![Location::Clamped; frame.node_count()];
        locations[mesh.frame_node(finger.tip())] = Location::Tip;
        for rung in 0..finger.rib_count() {
            let [front, back] = finger.rib_nodes(rung);
            locations[mesh.frame_node(back)] = Location::Rung { rung, row: 0 };
            locations[mesh.frame_node(front)] = Location::Rung { rung, row: 3 };
        }
        for (line, along) in mesh.lines().iter().enumerate() {
            for (i, &node) in along.nodes.iter().enumerate().skip(1) {
                if i + 1 < along.nodes.len() {
                    locations[node] = Location::Inside { line, element: i };
                }
            }
        }
        let rest = match kinematics {
            Kinematics::Linear => {
                let at_rest = FrameMotion::at_rest(frame);
                frame.members().iter().map(|m| frame.member_response(&at_rest, m, kinematics).tangent).collect()
            }
            Kinematics::Corotational | Kinematics::CorotationalChord => Vec::new(),
        };
        let bends = kinematics != Kinematics::Linear && frame.node_count() > finger.key_node_count();
        Ladder {
            mesh,
            kinematics,
            rest,
            chains,
            locations,
            rungs: vec![Rung::empty(); finger.rib_count()],
            tip: Block::empty(),
            tip_y: [0.0; 3],
            factored: false,
            accurate: false,
            energy: 0.0,
            work: 0.0,
            corrections: vec![[0.0; 6]; finger.rib_count()],
            waiting: vec![[0.0; 6]; finger.rib_count()],
            retraction: bends.then(|| Retraction::new(frame)),
        }
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// Lines of the two plate members above rung `level - 1` (level 0 is the base), back then front; the lines are
    /// numbered back plate, front plate, ribs, each from the base.
    fn plate_members(&self, level: usize) -> [usize; 2] {
        [level, self.rungs.len() + 1 + level]
    }

    fn rib(&self, rung: usize) -> usize {
        2 * (self.rungs.len() + 1) + rung
    }

    /// Gradient of the loads that stand on the key nodes at a position (a rung's row or the tip), and its derivative by the
    /// node's rotation: the end of an arm moves on a circle.
    fn loads_at(&self, location: Location, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> ([f64; 3], f64) {
        let frame = self.mesh.frame();
        let (mut gradient, mut curvature) = ([0.0; 3], 0.0);
        for load in loads.iter().filter(|load| !matches!(load, FrameLoad::Interior { .. })) {
            let (end, force, moment_nmm) = load.at_end(frame);
            if self.locations[end.node] == location {
                let potential = frame.end_load(motion, end, force * factor, moment_nmm * factor, self.linear());
                for (sum, part) in gradient.iter_mut().zip(&potential.gradient) {
                    *sum += part;
                }
                curvature += potential.tangent[(2, 2)];
            }
        }
        (gradient, curvature)
    }

    /// Stiffness of a rung's two nodes before anything above it is eliminated.
    #[inline(always)]
    fn rung_stiffness(&self, level: usize) -> EndsMatrix {
        let stiffness = |line: usize| &self.chains[line].stiffness;
        let [below, above] = [self.plate_members(level), self.plate_members(level + 1)];
        // A rib joins the rung's two nodes; one that does not deform has no stiffness of its own.
        let mut sum = *stiffness(self.rib(level));
        for i in 0..3 {
            for j in i..3 {
                sum[i][j] += stiffness(below[0])[3 + i][3 + j] + stiffness(above[0])[i][j];
                sum[3 + i][3 + j] += stiffness(below[1])[3 + i][3 + j] + stiffness(above[1])[i][j];
            }
        }
        sum
    }

    /// Sum over the lines that end at a rung of something that they have at their ends.
    #[inline(always)]
    fn rung_sum(&self, level: usize, of: impl Fn(&Chain) -> &Ends) -> Ends {
        let at_ends = |line: usize| of(&self.chains[line]);
        let [below, above] = [self.plate_members(level), self.plate_members(level + 1)];
        let mut sum = *at_ends(self.rib(level));
        for i in 0..3 {
            sum[i] += at_ends(below[0])[3 + i] + at_ends(above[0])[i];
            sum[3 + i] += at_ends(below[1])[3 + i] + at_ends(above[1])[i];
        }
        sum
    }

    /// The undeformable rib of a rung, if it has one.
    fn rigid_rib(&self, level: usize, motion: &FrameMotion, front_load: &[f64; 3]) -> Option<RigidRib> {
        let frame = self.mesh.frame();
        let front = self.mesh.frame_node(self.mesh.finger().rib_nodes(level)[0]);
        let (slot, lever) = frame.link_of(front, motion, self.linear())?;
        let front_pull = if self.linear() {
            Vector::zeros()
        } else {
            let raw = self.rung_sum(level, |chain| &chain.raw);
            Vector::new(raw[3] + front_load[0], raw[4] + front_load[1])
        };
        Some(RigidRib { lever, together: slot == frame.rotation_of(front), front_pull })
    }

    /// Eliminates the stiffness from tip to base; `false` if it is not positive definite.
    fn eliminate_stiffness(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        let mut positive = self.chains.iter().all(|chain| chain.positive);
        self.accurate = self.chains.iter().all(|chain| chain.accurate);
        let count = self.rungs.len();
        let [back, front] = self.plate_members(count).map(|line| &self.chains[line].stiffness);
        let mut tip = [[0.0; 3]; 3];
        let mut coupling = [[0.0; 6]; 3];
        for i in 0..3 {
            for j in 0..3 {
                tip[i][j] = back[3 + i][3 + j] + front[3 + i][3 + j];
                coupling[i][j] = back[j][3 + i];
                coupling[i][3 + j] = front[j][3 + i];
            }
        }
        tip[2][2] += self.loads_at(Location::Tip, motion, loads, factor).1;
        self.tip.factorise(&tip, &coupling);
        positive &= self.tip.positive();
        let [back, front] = self.plate_members(count).map(|line| &self.chains[line].raw_diagonal);
        self.accurate &= self.tip.pivots_exceed(&[3, 4, 5].map(|i| SMALL_PIVOT * (back[i] + front[i])));
        for level in (0..count).rev() {
            let mut stiffness = self.rung_stiffness(level);
            match self.rungs.get(level + 1) {
                Some(above) => above.reduce_stiffness(&mut stiffness),
                None => self.tip.reduce_stiffness(&mut stiffness),
            }
            let mut front_load = [0.0; 3];
            for row in [0, 3] {
                let curvature;
                (front_load, curvature) = self.loads_at(Location::Rung { rung: level, row }, motion, loads, factor);
                stiffness[row + 2][row + 2] += curvature;
            }
            let rib = self.rigid_rib(level, motion, &front_load);
            let [back, front] = self.plate_members(level).map(|line| &self.chains[line].stiffness);
            self.rungs[level].eliminate(rib, &stiffness, back, front);
            positive &= self.rungs[level].positive();
            let limits = self.rung_sum(level, |chain| &chain.raw_diagonal).map(|sum| SMALL_PIVOT * sum);
            self.accurate &= self.rungs[level].pivots_exceed(&limits);
        }
        positive
    }

    /// Eliminates the gradient from tip to base with the stiffness that is there.
    fn eliminate_gradient(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        self.work = self.chains.iter().map(|chain| chain.work).sum();
        let count = self.rungs.len();
        let (mut tip, _) = self.loads_at(Location::Tip, motion, loads, factor);
        for line in self.plate_members(count) {
            for (sum, part) in tip.iter_mut().zip(&self.chains[line].gradient[3..]) {
                *sum += part;
            }
        }
        self.tip_y = self.tip.forward(&tip);
        self.work += self.tip.work(&self.tip_y);
        for level in (0..count).rev() {
            let mut gradient = self.rung_sum(level, |chain| &chain.gradient);
            match self.rungs.get(level + 1) {
                Some(above) => above.reduce_gradient(above.y(), &mut gradient),
                None => self.tip.reduce_gradient(&self.tip_y, &mut gradient),
            }
            for row in [0, 3] {
                let (load, _) = self.loads_at(Location::Rung { rung: level, row }, motion, loads, factor);
                for (sum, part) in gradient[row..].iter_mut().zip(&load) {
                    *sum += part;
                }
            }
            self.work += self.rungs[level].load(&gradient);
        }
    }
}

impl EquilibriumEquations for Ladder<'_> {
    fn at_rest(&self) -> FrameMotion {
        FrameMotion::at_rest(self.mesh.frame())
    }

    fn kinematics(&self) -> Kinematics {
        self.kinematics
    }

    fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        if self.linear() && self.factored {
            self.load_lines(motion, loads, factor);
        } else {
            self.condense_lines(motion, loads, factor);
            self.factored = self.eliminate_stiffness(motion, loads, factor);
        }
        self.eliminate_gradient(motion, loads, factor);
        self.factored
    }

    fn keeps_digits(&self) -> bool {
        self.accurate
    }

    fn log_determinant(&mut self) -> Option<f64> {
        let chains: f64 = self.chains.iter().map(Chain::log_determinant).sum();
        let rungs: f64 = self.rungs.iter().map(Rung::log_determinant).sum();
        Some(chains + rungs + self.tip.log_determinant()).filter(|sum| sum.is_finite())
    }

    fn forget_factor(&mut self) {
        self.factored = false;
    }

    fn elastic_energy(&self) -> f64 {
        self.energy
    }

    fn correct(&mut self, motion: &mut FrameMotion) -> f64 {
        let mut retraction = self.retraction.take();
        if let Some(retraction) = &mut retraction {
            retraction.remember(motion);
        }
        let frame = self.mesh.frame();
        let linear = self.linear();
        let count = self.rungs.len();
        let mut below = [0.0; 6];
        for (level, rung) in self.rungs.iter().enumerate() {
            let (correction, link_rotation) = rung.motion(rung.y(), &below);
            self.corrections[level] = correction;
            let [front, back] = self.mesh.finger().rib_nodes(level).map(|node| self.mesh.frame_node(node));
            for (node, row) in [(back, 0), (front, 3)] {
                let u = &mut motion.displacements[node];
                u.x += correction[row];
                u.y += correction[row + 1];
            }
            motion.rotations[frame.rotation_of(back)] += correction[2];
            if frame.rotation_of(front) != frame.rotation_of(back) {
                motion.rotations[frame.rotation_of(front)] += correction[5];
            }
            if let (Some((slot, _)), Some(turn)) = (frame.link_of(front, motion, linear), link_rotation) {
                motion.rotations[slot] += turn;
            }
            below = correction;
        }
        let tip = self.tip.motion(&self.tip_y, &below);
        let tip_node = self.mesh.frame_node(self.mesh.finger().tip());
        let u = &mut motion.displacements[tip_node];
        u.x += tip[0];
        u.y += tip[1];
        motion.rotations[frame.rotation_of(tip_node)] += tip[2];
        frame.follow_links(motion, linear);

        // Back along the chains, from the corrections of their ends (back, front).
        let at = |level: usize| match level {
            0 => [[0.0; 3]; 2],
            level if level == count + 1 => [tip; 2],
            level => halves(&self.corrections[level - 1]),
        };
        let mut correct_line = |line: usize, first: &[f64; 3], second: &[f64; 3]| {
            self.chains[line].correct(motion, first, second);
            if let Some(retraction) = &mut retraction {
                let key_nodes = [first, second].map(|correction| Vector::new(correction[0], correction[1]));
                retraction.mend(frame, &self.mesh.lines()[line], motion, key_nodes);
            }
        };
        for level in 0..=count {
            let (lower, upper) = (at(level), at(level + 1));
            for (side, line) in self.plate_members(level).into_iter().enumerate() {
                correct_line(line, &lower[side], &upper[side]);
            }
        }
        for rung in 0..count {
            if !self.mesh.lines()[self.rib(rung)].members.is_empty() {
                let [back, front] = at(rung + 1);
                correct_line(self.rib(rung), &back, &front);
            }
        }
        self.retraction = retraction;
        self.work
    }
}
