//! The finger as a ladder: plates condensed onto the key nodes, then pairs of key nodes eliminated from tip to base.
//!
//! A finger's equations have one long direction only. Members condense onto their ends ([`chain`]), which leaves the
//! back and front node of each rib as a block of six unknowns that is coupled to its two neighbours alone: a block
//! tridiagonal system. Its elimination from the tip costs a fixed number of operations a rib and touches no heap. The
//! general sparse path ([`SparseEquations`](super::SparseEquations)) solves any frame and is what this one is checked
//! against.

mod chain;
mod ldl;
mod response;
mod rung;

use super::{EquilibriumEquations, FrameLoad};
use crate::Kinematics;
use crate::frame::{FrameMotion, PlaneFrame};
use crate::mesh::Mesh;
use chain::{Chain, Condensed};
use nalgebra::{Matrix3, Vector3};
use rung::{Rung, Vector6};

/// Where a frame node is in the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Clamped,
    Tip,
    Rung {
        rung: usize,
        row: usize,
    },
    /// Inside a line, so many elements from its first end.
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
    chains: Vec<Chain>,
    places: Vec<Place>,
    /// From the base to the tip.
    rungs: Vec<Rung>,
    energy: f64,
    work: f64,
    /// Corrections of the rungs' nodes and of the tip, kept for the way back along the chains.
    corrections: Vec<Vector6>,
    tip: TipElimination,
    tip_factor: ldl::Ldl<3>,
}

/// How the tip moves: by itself, and with the nodes of the last rung (back, front).
#[derive(Debug, Clone, Copy)]
struct TipElimination {
    alone: Vector3<f64>,
    with: [Matrix3<f64>; 2],
}

impl<'m> Ladder<'m> {
    /// Finds the order of elimination, once a mesh.
    pub fn new(mesh: &'m Mesh, kinematics: Kinematics) -> Ladder<'m> {
        let (frame, finger) = (mesh.frame(), mesh.finger());
        let chains: Vec<Chain> = mesh.lines().iter().map(|line| Chain::new(frame, line)).collect();
        let mut places = vec![Place::Clamped; frame.node_count()];
        places[mesh.frame_node(finger.tip())] = Place::Tip;
        for rung in 0..finger.rib_count() {
            let [front, back] = finger.rib_nodes(rung);
            places[mesh.frame_node(back)] = Place::Rung { rung, row: 0 };
            places[mesh.frame_node(front)] = Place::Rung { rung, row: 3 };
        }
        for (line, along) in mesh.lines().iter().enumerate() {
            for (i, &node) in along.nodes.iter().enumerate().skip(1) {
                if i + 1 < along.nodes.len() {
                    places[node] = Place::Inside { line, element: i };
                }
            }
        }
        Ladder {
            mesh,
            kinematics,
            chains,
            places,
            rungs: vec![Rung::default(); finger.rib_count()],
            energy: 0.0,
            work: 0.0,
            corrections: vec![Vector6::zeros(); finger.rib_count()],
            tip: TipElimination { alone: Vector3::zeros(), with: [Matrix3::zeros(); 2] },
            tip_factor: ldl::Ldl::of(&Matrix3::identity()),
        }
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// Lines of the two plates' stretches above rung `level - 1` (level 0 is the base), back then front; the lines are
    /// numbered back plate, front plate, ribs, each from the base.
    fn stretches(&self, level: usize) -> [usize; 2] {
        [level, self.rungs.len() + 1 + level]
    }

    fn rib(&self, rung: usize) -> usize {
        2 * (self.rungs.len() + 1) + rung
    }

    /// Condenses every line with the loads that stand on it.
    fn condense_lines(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        let frame: &PlaneFrame = self.mesh.frame();
        let kinematics = self.kinematics;
        let linear = self.linear();
        let places = &self.places;
        for (index, (chain, line)) in self.chains.iter_mut().zip(self.mesh.lines()).enumerate() {
            let mut energy = 0.0;
            let elements = line.members.clone().enumerate().map(|(i, member)| {
                let mut response = frame.member_response(motion, &frame.members()[member], kinematics);
                energy += response.energy;
                for load in loads {
                    let potential = match *load {
                        FrameLoad::Interior { member: loaded, xi, force } if loaded == member => {
                            frame.interior_load(motion, member, kinematics, xi, force * factor)
                        }
                        FrameLoad::Interior { .. } => continue,
                        FrameLoad::Node { .. } | FrameLoad::Arm { .. } => {
                            let (end, force, moment_nmm) = load.at_end(frame);
                            // A node between two elements counts with the one that begins there.
                            let here = Place::Inside { line: index, element: i };
                            if places[end.node] != here {
                                continue;
                            }
                            frame.end_load(motion, end, force * factor, moment_nmm * factor, linear)
                        }
                    };
                    response.gradient += potential.gradient;
                    response.tangent += potential.tangent;
                }
                Condensed::of(&response)
            });
            chain.condense(elements);
            self.energy += energy;
        }
    }

    /// Adds what ends at the key nodes: condensed lines, and loads on the nodes themselves.
    fn fill_rungs(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> (Matrix3<f64>, Vector3<f64>) {
        let (mut tip, mut tip_gradient) = (Matrix3::zeros(), Vector3::zeros());
        let count = self.rungs.len();
        for (level, rung) in self.rungs.iter_mut().enumerate() {
            *rung = Rung::default();
            for (side, row) in [(0, 0), (1, 3)] {
                let below = &self.chains[[level, count + 1 + level][side]];
                rung.add_node(row, &below.condensed.bb, &below.condensed.b, &below.raw[1]);
                let above = &self.chains[[level + 1, count + 2 + level][side]];
                rung.add_node(row, &above.condensed.aa, &above.condensed.a, &above.raw[0]);
            }
            // Ribs run from the back to the front node; one that does not deform has no chain.
            let rib = &self.chains[2 * (count + 1) + level];
            rung.add_node(0, &rib.condensed.aa, &rib.condensed.a, &rib.raw[0]);
            rung.add_node(3, &rib.condensed.bb, &rib.condensed.b, &rib.raw[1]);
            rung.couple(&rib.condensed.ab);
        }
        for line in self.stretches(count) {
            tip += self.chains[line].condensed.bb;
            tip_gradient += self.chains[line].condensed.b;
        }
        let frame = self.mesh.frame();
        for load in loads {
            if matches!(load, FrameLoad::Interior { .. }) {
                continue;
            }
            let (end, force, moment_nmm) = load.at_end(frame);
            let potential = frame.end_load(motion, end, force * factor, moment_nmm * factor, self.linear());
            let gradient = potential.gradient.fixed_rows::<3>(0).into_owned();
            let tangent = potential.tangent.fixed_view::<3, 3>(0, 0).into_owned();
            match self.places[end.node] {
                Place::Clamped | Place::Inside { .. } => {}
                Place::Tip => {
                    tip += tangent;
                    tip_gradient += gradient;
                }
                Place::Rung { rung, row } => self.rungs[rung].add_node(row, &tangent, &gradient, &gradient),
            }
        }
        (tip, tip_gradient)
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
        self.energy = 0.0;
        self.condense_lines(motion, loads, factor);
        let (tip, tip_gradient) = self.fill_rungs(motion, loads, factor);
        self.work = self.chains.iter().map(|chain| chain.work).sum();
        let mut positive = self.chains.iter().all(|chain| chain.positive);

        // The tip first: it couples to both nodes of the last rung.
        let ldl = ldl::Ldl::of(&tip);
        positive &= ldl.positive;
        let count = self.rungs.len();
        let couplings = self.stretches(count).map(|line| self.chains[line].condensed.ab);
        let alone = ldl.solve(&tip_gradient);
        self.work += tip_gradient.dot(&alone);
        self.tip_factor = ldl;
        self.tip = TipElimination { alone, with: couplings.map(|ab| ldl.solve(&ab.transpose())) };
        if let Some(last) = self.rungs.last_mut() {
            last.subtract_tip(&couplings, &self.tip.with, &alone);
        }
        let frame = self.mesh.frame();
        let linear = self.linear();
        for level in (0..count).rev() {
            let [back, front] = self.stretches(level).map(|line| self.chains[line].condensed.ab);
            let front_node = self.mesh.frame_node(self.mesh.finger().rib_nodes(level)[0]);
            let link = frame.link_of(front_node, motion, linear);
            let together = link.is_some_and(|(slot, _)| slot == frame.rotation_of(front_node));
            let (rungs, above) = self.rungs.split_at_mut(level);
            let rung = &mut above[0];
            positive &= rung.eliminate(link.map(|(_, lever)| lever), together, linear, &back, &front);
            self.work += rung.work;
            if let Some(below) = rungs.last_mut() {
                below.subtract(rung, &back, &front);
            }
        }
        positive
    }

    fn elastic_energy(&self) -> f64 {
        self.energy
    }

    fn correct(&mut self, motion: &mut FrameMotion) -> f64 {
        let frame = self.mesh.frame();
        let linear = self.linear();
        let count = self.rungs.len();
        let mut below = Vector6::zeros();
        for (level, rung) in self.rungs.iter().enumerate() {
            let (correction, link_rotation) = rung.correction(&below);
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
        let halves = [below.fixed_rows::<3>(0).into_owned(), below.fixed_rows::<3>(3).into_owned()];
        let tip = -(self.tip.alone + self.tip.with[0] * halves[0] + self.tip.with[1] * halves[1]);
        let tip_node = self.mesh.frame_node(self.mesh.finger().tip());
        let u = &mut motion.displacements[tip_node];
        u.x += tip[0];
        u.y += tip[1];
        motion.rotations[frame.rotation_of(tip_node)] += tip[2];

        // Back along the chains, from the corrections of their ends.
        let at = |level: usize, row: usize| match level {
            0 => Vector3::zeros(),
            level if level == count + 1 => tip,
            level => self.corrections[level - 1].fixed_rows::<3>(row).into_owned(),
        };
        for level in 0..=count {
            for (side, line) in self.stretches(level).into_iter().enumerate() {
                self.chains[line].correct(motion, at(level, 3 * side), at(level + 1, 3 * side));
            }
        }
        for rung in 0..count {
            if !self.mesh.lines()[self.rib(rung)].members.is_empty() {
                self.chains[self.rib(rung)].correct(motion, at(rung + 1, 0), at(rung + 1, 3));
            }
        }
        frame.follow_links(motion, linear);
        self.work
    }
}
