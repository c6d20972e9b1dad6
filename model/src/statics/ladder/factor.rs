//! The finger's stiffness, eliminated: what one motion's tangent needs, whatever the loads' gradients are.

use super::SMALL_PIVOT;
use super::block::Block;
use super::cantilever::Joint;
use super::chain::{Chain, Ends, EndsMatrix, joints_of};
use super::rung::{RigidRib, Rung};
use super::{Ladder, at_rest};
use crate::mesh::Mesh;

/// The elimination of a finger's stiffness from tip to base.
#[derive(Debug, Clone)]
pub(super) struct Factor {
    /// One for each line of the mesh.
    pub(super) chains: Vec<Chain>,
    /// One for each member of the frame: where it is put behind those before it. The first of a line has none.
    pub(super) joints: Vec<Joint>,
    /// From the base to the tip.
    pub(super) rungs: Vec<Rung>,
    /// The tip, with the back and front node of the last rung.
    pub(super) tip: Block<3, 6>,
    /// Whether it is positive definite.
    pub(super) positive: bool,
    /// Whether no pivot has lost more than three digits to cancellation.
    pub(super) accurate: bool,
}

impl Factor {
    /// Without room: for ladders that need no other stiffness than that at rest.
    pub(super) fn none() -> Factor {
        let (chains, joints, rungs) = (Vec::new(), Vec::new(), Vec::new());
        Factor { chains, joints, rungs, tip: Block::empty(), positive: false, accurate: false }
    }

    /// Room for a mesh, unless it is there already.
    pub(super) fn make_room(&mut self, mesh: &Mesh) {
        if self.chains.is_empty() {
            let frame = mesh.frame();
            self.chains = mesh.lines().iter().map(|line| Chain::new(frame, line)).collect();
            self.joints = vec![Joint::empty(); frame.members().len()];
            self.rungs = vec![Rung::empty(); mesh.finger().rib_count()];
        }
    }

    /// The stiffness of small displacements.
    fn at_rest(mesh: &Mesh) -> Factor {
        let mut ladder = Ladder::new(mesh, crate::Kinematics::Linear);
        ladder.factorise(&at_rest(mesh), &[], 0.0);
        ladder.own
    }

    /// That at rest, which the mesh keeps, or a ladder's own.
    pub(super) fn chosen<'a>(mesh: &'a Mesh, own: &'a Factor, rests: bool) -> &'a Factor {
        let at_rest = rests.then(|| mesh.prepared(Factor::at_rest)).flatten();
        at_rest.unwrap_or(own)
    }

    /// Lines of the two plate members above rung `level - 1` (level 0 is the base), back then front; the lines are
    /// numbered back plate, front plate, ribs, each from the base.
    pub(super) fn plate_members(&self, level: usize) -> [usize; 2] {
        [level, self.rungs.len() + 1 + level]
    }

    pub(super) fn rib(&self, rung: usize) -> usize {
        2 * (self.rungs.len() + 1) + rung
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
    pub(super) fn rung_sum<'a>(&self, level: usize, at_ends: impl Fn(usize) -> &'a Ends) -> Ends {
        let [below, above] = [self.plate_members(level), self.plate_members(level + 1)];
        let mut sum = *at_ends(self.rib(level));
        for i in 0..3 {
            sum[i] += at_ends(below[0])[3 + i] + at_ends(above[0])[i];
            sum[3 + i] += at_ends(below[1])[3 + i] + at_ends(above[1])[i];
        }
        sum
    }

    /// Logarithm of the stiffness's determinant; not a number if it is not positive definite.
    pub(super) fn log_determinant(&self, mesh: &Mesh) -> f64 {
        let joints = mesh.lines().iter().flat_map(|line| &self.joints[joints_of(line)]);
        let chains: f64 = self.chains.iter().map(Chain::log_determinant).sum();
        let rungs: f64 = self.rungs.iter().map(Rung::log_determinant).sum();
        joints.map(Joint::log_determinant).sum::<f64>() + chains + rungs + self.tip.log_determinant()
    }

    /// Eliminates the tip and begins with the sum of what the chains have; `curvature` is that of the loads on the tip's
    /// rotation.
    pub(super) fn eliminate_tip(&mut self, curvature: f64) {
        self.positive = self.chains.iter().all(|chain| chain.positive);
        self.accurate = self.chains.iter().all(|chain| chain.accurate);
        let members = self.plate_members(self.rungs.len());
        let [back, front] = members.map(|line| &self.chains[line].stiffness);
        let mut tip = [[0.0; 3]; 3];
        let mut coupling = [[0.0; 6]; 3];
        for i in 0..3 {
            for j in 0..3 {
                tip[i][j] = back[3 + i][3 + j] + front[3 + i][3 + j];
                coupling[i][j] = back[j][3 + i];
                coupling[i][3 + j] = front[j][3 + i];
            }
        }
        tip[2][2] += curvature;
        self.tip.factorise(&tip, &coupling);
        self.positive &= self.tip.positive();
        let [back, front] = members.map(|line| &self.chains[line].diagonal);
        self.accurate &= self.tip.pivots_exceed(&[3, 4, 5].map(|i| SMALL_PIVOT * (back[i] + front[i])));
    }

    /// Eliminates a rung; `curvatures` are those of the loads on the rotations of its back and front node.
    pub(super) fn eliminate_rung(&mut self, level: usize, rib: Option<RigidRib>, curvatures: [f64; 2]) {
        let mut stiffness = self.rung_stiffness(level);
        match self.rungs.get(level + 1) {
            Some(above) => above.reduce_stiffness(&mut stiffness),
            None => self.tip.reduce_stiffness(&mut stiffness),
        }
        stiffness[2][2] += curvatures[0];
        stiffness[5][5] += curvatures[1];
        let [back, front] = self.plate_members(level).map(|line| &self.chains[line].stiffness);
        self.rungs[level].eliminate(rib, &stiffness, back, front);
        self.positive &= self.rungs[level].positive();
        let limits = self.rung_sum(level, |line| &self.chains[line].diagonal).map(|sum| SMALL_PIVOT * sum);
        self.accurate &= self.rungs[level].pivots_exceed(&limits);
    }
}
