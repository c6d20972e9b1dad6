//! The finger as a ladder: plates condensed onto the key nodes, then pairs of key nodes eliminated from tip to base.
//!
//! A finger's equations have one long direction only. Members condense onto their ends ([`chain`]), which leaves the
//! back and front node of each rib as a block of six unknowns that is coupled to its two neighbours alone: a block
//! tridiagonal system. Its elimination from the tip costs a fixed number of operations a rib and touches no heap. The
//! general sparse path ([`SparseEquations`](super::SparseEquations)) solves any frame and is what this one is checked
//! against.
//!
//! Stiffness and forces are apart: [`Factor`] is what a tangent needs, and that at rest is made once for a mesh. Linear
//! solutions need no other, and a co-rotational one begins with it.

mod block;
mod cantilever;
mod chain;
mod factor;
mod ldl;
mod lines;
mod response;
mod retraction;
mod rung;

use super::EquilibriumEquations;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
use crate::{Kinematics, Vector};
use chain::{Between, ChainForces, Ends, Solved, halves, joints_of};
use factor::Factor;
use retraction::Retraction;
use rung::RigidRib;

/// A pivot below this share of what members put on its diagonal has lost digits to cancellation that may count, and so
/// has an element's share of a member's stiffness: the paper's finger keeps 2e-2 on any mesh; thin plates, and random
/// fingers that miss 1e-8, keep less.
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
    /// The stiffness away from rest.
    own: Factor,
    /// Whether the last linearised motion has the stiffness at rest, which the mesh keeps.
    rests: bool,
    /// Whether a linear factor of our own is wanted, and whether it is there.
    forgotten: bool,
    factored: bool,
    /// Where each load of the last linearisation stands.
    places: Vec<Location>,
    /// One for each line.
    forces: Vec<ChainForces>,
    /// y = L^-1 g of everything that is eliminated: each joint, each rung, the tip.
    ys: Vec<[f64; 3]>,
    rung_ys: Vec<Ends>,
    tip_y: [f64; 3],
    energy: f64,
    work: f64,
    largest_correction: f64,
    /// One for each rung: their corrections on the way back.
    corrections: Vec<Ends>,
    /// One for each rung: what waits for the way back when loads are added.
    waiting: Vec<Ends>,
    /// Where rotations are large and lines have inner nodes.
    retraction: Option<Retraction>,
}

impl<'m> Ladder<'m> {
    /// Room for the elimination.
    pub fn new(mesh: &'m Mesh, kinematics: Kinematics) -> Ladder<'m> {
        let (frame, rungs) = (mesh.frame(), mesh.finger().rib_count());
        let bends = kinematics != Kinematics::Linear && frame.node_count() > mesh.finger().key_node_count();
        Ladder {
            mesh,
            kinematics,
            own: Factor::none(),
            rests: false,
            forgotten: false,
            factored: false,
            places: Vec::new(),
            forces: vec![ChainForces::NONE; mesh.lines().len()],
            ys: vec![[0.0; 3]; frame.members().len()],
            rung_ys: vec![[0.0; 6]; rungs],
            tip_y: [0.0; 3],
            energy: 0.0,
            work: 0.0,
            largest_correction: 0.0,
            corrections: vec![[0.0; 6]; rungs],
            waiting: vec![[0.0; 6]; rungs],
            retraction: bends.then(|| Retraction::new(frame)),
        }
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// The stiffness that was last used.
    fn factor(&self) -> &Factor {
        Factor::chosen(self.mesh, &self.own, self.rests)
    }

    /// Where a node of the frame is.
    fn location(&self, node: usize) -> Location {
        let (mesh, finger) = (self.mesh, self.mesh.finger());
        if node == mesh.frame_node(finger.tip()) {
            return Location::Tip;
        }
        let mut ribs = (0..finger.rib_count()).map(|rung| (rung, finger.rib_nodes(rung).map(|id| mesh.frame_node(id))));
        if let Some((rung, [front, _])) = ribs.find(|(_, nodes)| nodes.contains(&node)) {
            return Location::Rung { rung, row: if node == front { 3 } else { 0 } };
        }
        let mut lines = mesh.lines().iter().enumerate();
        // Nodes inside a line follow each other.
        let found = lines.find_map(|(line, along)| {
            let inner = &along.nodes[1..along.nodes.len() - 1];
            inner.binary_search(&node).ok().map(|i| Location::Inside { line, element: i + 1 })
        });
        found.unwrap_or(Location::Clamped)
    }

    /// Where a load stands.
    fn place(&self, load: &FrameLoad) -> Location {
        if let FrameLoad::Interior { member, .. } = *load {
            let (line, element) = self.element_of(member);
            return Location::Inside { line, element };
        }
        self.location(load.at_end(self.mesh.frame()).0.node)
    }

    /// Gradient of the loads that stand on the key nodes at a position (a rung's row or the tip), and its derivative by the
    /// node's rotation: the end of an arm moves on a circle.
    fn loads_at(&self, location: Location, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> ([f64; 3], f64) {
        let frame = self.mesh.frame();
        let (mut gradient, mut curvature) = ([0.0; 3], 0.0);
        for (load, _) in loads.iter().zip(&self.places).filter(|(_, place)| **place == location) {
            let (end, force, moment_nmm) = load.at_end(frame);
            let potential = frame.end_load(motion, end, force * factor, moment_nmm * factor, self.linear());
            for (sum, part) in gradient.iter_mut().zip(&potential.gradient) {
                *sum += part;
            }
            curvature += potential.tangent[(2, 2)];
        }
        (gradient, curvature)
    }

    /// The undeformable rib of a rung, if it has one.
    fn rigid_rib(&self, level: usize, motion: &FrameMotion, front_load: &[f64; 3]) -> Option<RigidRib> {
        let frame = self.mesh.frame();
        let front = self.mesh.frame_node(self.mesh.finger().rib_nodes(level)[0]);
        let (slot, lever) = frame.link_of(front, motion, self.linear())?;
        let front_pull = if self.linear() {
            Vector::zeros()
        } else {
            let raw = self.own.rung_sum(level, |line| &self.forces[line].raw);
            Vector::new(raw[3] + front_load[0], raw[4] + front_load[1])
        };
        Some(RigidRib { lever, together: slot == frame.rotation_of(front), front_pull })
    }

    /// Factorises the tangent at a motion; `false` if it is not positive definite.
    fn factorise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        self.own.make_room(self.mesh);
        self.condense_lines(motion, loads, factor);
        let (_, curvature) = self.loads_at(Location::Tip, motion, loads, factor);
        self.own.eliminate_tip(curvature);
        for level in (0..self.rung_ys.len()).rev() {
            let [(_, back), (front_load, front)] =
                [0, 3].map(|row| self.loads_at(Location::Rung { rung: level, row }, motion, loads, factor));
            let rib = self.rigid_rib(level, motion, &front_load);
            self.own.eliminate_rung(level, rib, [back, front]);
        }
        self.own.positive
    }

    /// Eliminates the gradient from tip to base with the stiffness that is there.
    fn eliminate_gradient(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        let mut ys = std::mem::take(&mut self.rung_ys);
        let stiffness = self.factor();
        let (mut tip, _) = self.loads_at(Location::Tip, motion, loads, factor);
        for line in stiffness.plate_members(ys.len()) {
            for (sum, part) in tip.iter_mut().zip(&self.forces[line].gradient[3..]) {
                *sum += part;
            }
        }
        let tip_y = stiffness.tip.forward(&tip);
        let mut work = self.forces.iter().map(|forces| forces.work).sum::<f64>() + stiffness.tip.work(&tip_y);
        for level in (0..ys.len()).rev() {
            let mut gradient = stiffness.rung_sum(level, |line| &self.forces[line].gradient);
            match stiffness.rungs.get(level + 1) {
                Some(above) => above.reduce_gradient(&ys[level + 1], &mut gradient),
                None => stiffness.tip.reduce_gradient(&tip_y, &mut gradient),
            }
            for row in [0, 3] {
                let (load, _) = self.loads_at(Location::Rung { rung: level, row }, motion, loads, factor);
                for (sum, part) in gradient[row..].iter_mut().zip(&load) {
                    *sum += part;
                }
            }
            ys[level] = stiffness.rungs[level].forward(&gradient);
            work += stiffness.rungs[level].work(&ys[level]);
        }
        (self.rung_ys, self.tip_y, self.work) = (ys, tip_y, work);
    }

    /// Whether the tangent is that of small displacements. Co-rotationally it is at rest, if loads neither stand on arms
    /// or between nodes, where they turn, nor pull at an undeformable rib.
    fn has_rest_stiffness(&self, unmoved: bool, loads: &[FrameLoad]) -> bool {
        if self.linear() {
            return !self.forgotten;
        }
        let deforms = || self.mesh.finger().description().ribs.strip.is_some();
        unmoved && deforms() && loads.iter().all(|load| matches!(load, FrameLoad::Node { .. }))
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
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        places.extend(loads.iter().map(|load| self.place(load)));
        self.places = places;
        let unmoved = motion.is_at_rest();
        self.rests = self.has_rest_stiffness(unmoved, loads);
        if self.rests || self.factored {
            self.load_lines(motion, loads, factor, unmoved);
        } else {
            self.factorise(motion, loads, factor);
            self.factored = self.linear();
        }
        self.eliminate_gradient(motion, loads, factor);
        self.factor().positive
    }

    fn keeps_digits(&self) -> bool {
        self.factor().accurate
    }

    fn log_determinant(&mut self) -> Option<f64> {
        Some(self.factor().log_determinant(self.mesh)).filter(|sum| sum.is_finite())
    }

    fn forget_factor(&mut self) {
        (self.forgotten, self.factored) = (true, false);
    }

    fn elastic_energy(&self) -> f64 {
        self.energy
    }

    fn correct(&mut self, motion: &mut FrameMotion) -> f64 {
        let mut retraction = self.retraction.take();
        if let Some(retraction) = &mut retraction {
            retraction.remember(motion);
        }
        let mut corrections = std::mem::take(&mut self.corrections);
        let (mesh, frame, finger, linear) = (self.mesh, self.mesh.frame(), self.mesh.finger(), self.linear());
        let count = corrections.len();
        let stiffness = self.factor();
        let mut below = [0.0; 6];
        for (level, (rung, y)) in stiffness.rungs.iter().zip(&self.rung_ys).enumerate() {
            let (correction, link_rotation) = rung.motion(y, &below);
            corrections[level] = correction;
            let [front, back] = finger.rib_nodes(level).map(|node| mesh.frame_node(node));
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
        let tip = stiffness.tip.motion(&self.tip_y, &below);
        let tip_node = mesh.frame_node(finger.tip());
        let u = &mut motion.displacements[tip_node];
        u.x += tip[0];
        u.y += tip[1];
        motion.rotations[frame.rotation_of(tip_node)] += tip[2];
        frame.follow_links(motion, linear);

        // Back along the chains, from the corrections of their ends (back, front).
        let at = |level: usize| match level {
            0 => [[0.0; 3]; 2],
            level if level == count + 1 => [tip; 2],
            level => halves(&corrections[level - 1]),
        };
        let mut correct_line = |index: usize, first: &[f64; 3], second: &[f64; 3]| {
            let line = &mesh.lines()[index];
            let joints = joints_of(line);
            if joints.is_empty() && !stiffness.chains[index].is_pinned() {
                return;
            }
            let between = Between::of(frame, line);
            let inner = Solved { joints: &stiffness.joints[joints.clone()], ys: &self.ys[joints], between: &between };
            stiffness.chains[index].correct(inner, &self.forces[index], motion, [first, second]);
            if let Some(retraction) = &mut retraction {
                let key_nodes = [first, second].map(|correction| Vector::new(correction[0], correction[1]));
                retraction.mend(frame, line, motion, key_nodes);
            }
        };
        for level in 0..=count {
            let (lower, upper) = (at(level), at(level + 1));
            for (side, line) in stiffness.plate_members(level).into_iter().enumerate() {
                correct_line(line, &lower[side], &upper[side]);
            }
        }
        for rung in 0..count {
            if !mesh.lines()[stiffness.rib(rung)].members.is_empty() {
                let [back, front] = at(rung + 1);
                correct_line(stiffness.rib(rung), &back, &front);
            }
        }
        let squares = corrections.iter().flat_map(halves).chain([tip]).map(|[x, y, _]| x * x + y * y);
        self.largest_correction = squares.fold(0.0, f64::max).sqrt();
        (self.retraction, self.corrections) = (retraction, corrections);
        self.work
    }

    fn largest_correction(&self) -> f64 {
        self.largest_correction
    }
}

/// The structure at rest.
fn at_rest(mesh: &Mesh) -> FrameMotion {
    FrameMotion::at_rest(mesh.frame())
}
