//! Factored stiffness of the finger: the part of the elimination that is independent of the gradient.

use super::Ladder;
use super::SMALL_PIVOT;
use super::block::Block;
use super::cantilever::Joint;
use super::chain::{Chain, joints_of};
use super::ends::{Ends, EndsMatrix};
use super::loads::OnNode;
use super::rung::{RigidRib, Rung};
use crate::frame::FrameMotion;
use crate::mesh::Mesh;
use crate::number::Number;

/// Block elimination of a finger's stiffness, from tip to base.
#[derive(Debug, Clone)]
pub(crate) struct Factor<R: Number = f64> {
    /// One chain per line of the mesh.
    pub(super) chains: Vec<Chain<R>>,
    /// One joint per member of the frame: the elimination of the member's deflection. The joint of a line's first member is unused.
    pub(super) joints: Vec<Joint<R>>,
    /// Rungs (pairs of key nodes joined by a rib) from base to tip.
    pub(super) rungs: Vec<Rung<R>>,
    /// The tip, coupled to the back and front node of the rib nearest to the tip.
    pub(super) tip: Block<R, 3, 6>,
    /// Lanes in which the stiffness is positive definite.
    pub(in crate::statics) positive: R::Mask,
    /// Lanes in which no pivot lost more than three digits to cancellation.
    pub(super) accurate: R::Mask,
}

impl<R: Number> Factor<R> {
    /// A factor without arrays, in the number type of `like`, for ladders that use only the stiffness at rest.
    pub(super) fn none(like: R) -> Factor<R> {
        let (chains, joints, rungs) = (Vec::new(), Vec::new(), Vec::new());
        let never = like.zero().exceeds(like.zero());
        Factor { chains, joints, rungs, tip: Block::empty(like), positive: never, accurate: never }
    }

    /// A factor with arrays for a mesh.
    pub(in crate::statics) fn with_room(mesh: &Mesh, like: R) -> Factor<R> {
        let mut factor = Factor::none(like);
        factor.make_room(mesh, like);
        factor
    }

    /// Allocates the arrays for a mesh, unless they already exist.
    pub(super) fn make_room(&mut self, mesh: &Mesh, like: R) {
        if self.chains.is_empty() {
            let frame = mesh.frame();
            self.chains = mesh.lines().iter().map(|line| Chain::new(frame, line, like)).collect();
            self.joints = vec![Joint::empty(like); frame.members().len()];
            let rungs = mesh.finger().rib_count();
            let is_tied = |line: usize| mesh.lines()[line].members.is_empty();
            let tied = |level: usize| {
                let [back, front] = [level, rungs + 1 + level].map(is_tied);
                back.then_some(0).or(front.then_some(3))
            };
            self.rungs = (0..rungs).map(|level| Rung::empty(like, tied(level))).collect();
        }
    }

    /// Indices of the lines of the back and front plate member on the base side of rung `level`. If `level` is the number of rungs, the two members
    /// that end at the tip. Lines are ordered back, front, ribs; each group starts at the base.
    pub(super) fn plate_members(&self, level: usize) -> [usize; 2] {
        [level, self.rungs.len() + 1 + level]
    }

    pub(super) fn rib(&self, rung: usize) -> usize {
        2 * (self.rungs.len() + 1) + rung
    }

    /// Stiffness of the two nodes of a rung (joined by one rib), before the tip and the rungs nearer to the tip are eliminated.
    #[inline(always)]
    fn rung_stiffness(&self, level: usize) -> EndsMatrix<R> {
        let stiffness = |line: usize| &self.chains[line].stiffness;
        let [below, above] = [self.plate_members(level), self.plate_members(level + 1)];
        // The rib joins the two nodes of its rung; an undeformable rib contributes zeros.
        let mut sum = *stiffness(self.rib(level));
        for i in 0..3 {
            for j in i..3 {
                sum[i][j] += stiffness(below[0])[3 + i][3 + j] + stiffness(above[0])[i][j];
                sum[3 + i][3 + j] += stiffness(below[1])[3 + i][3 + j] + stiffness(above[1])[i][j];
            }
        }
        sum
    }

    /// Sums a quantity at the ends of lines (plate members and ribs), over all lines that end at a rung.
    #[inline(always)]
    pub(super) fn rung_sum<'a>(&self, level: usize, at_ends: impl Fn(usize) -> &'a Ends<R>) -> Ends<R>
    where
        R: 'a,
    {
        let [below, above] = [self.plate_members(level), self.plate_members(level + 1)];
        let mut sum = *at_ends(self.rib(level));
        for i in 0..3 {
            sum[i] += at_ends(below[0])[3 + i] + at_ends(above[0])[i];
            sum[3 + i] += at_ends(below[1])[3 + i] + at_ends(above[1])[i];
        }
        sum
    }

    /// Natural logarithm of the determinant of the stiffness; NaN if the stiffness is not positive definite.
    pub(super) fn log_determinant(&self, mesh: &Mesh) -> R {
        let tip = self.tip.factor.log_determinant();
        let sum = |sum: R, part: R| sum + part;
        let joints = mesh.lines().iter().flat_map(|line| &self.joints[joints_of(line)]);
        let joints = joints.map(|joint| joint.block.factor.log_determinant()).fold(tip.zero(), sum);
        let chains = self.chains.iter().map(Chain::log_determinant).fold(tip.zero(), sum);
        let rungs = self.rungs.iter().map(|rung| rung.block.factor.log_determinant()).fold(tip.zero(), sum);
        joints + chains + rungs + tip
    }

    /// Eliminates the tip with the loads on it.
    #[inline(always)]
    pub(super) fn eliminate_tip(&mut self, loads: &OnNode<R>) {
        let zero = loads.curvature.zero();
        (self.positive, self.accurate) = (zero.always(), zero.always());
        for chain in &self.chains {
            self.positive = zero.both(self.positive, chain.positive);
            self.accurate = zero.both(self.accurate, chain.accurate);
        }
        let members = self.plate_members(self.rungs.len());
        let [back, front] = members.map(|line| &self.chains[line].stiffness);
        let mut tip = [[zero; 3]; 3];
        let mut coupling = [[zero; 6]; 3];
        for i in 0..3 {
            for j in 0..3 {
                tip[i][j] = back[3 + i][3 + j] + front[3 + i][3 + j];
                coupling[i][j] = back[j][3 + i];
                coupling[i][3 + j] = front[j][3 + i];
            }
        }
        tip[0][0] += loads.spring;
        tip[1][1] += loads.spring;
        tip[2][2] += loads.curvature;
        self.tip.factorise(&tip, &coupling);
        self.positive = zero.both(self.positive, self.tip.factor.positive);
        let [back, front] = members.map(|line| &self.chains[line].diagonal);
        let mut limits = [zero; 3];
        for i in 0..3 {
            limits[i] = (back[3 + i] + front[3 + i]) * SMALL_PIVOT;
        }
        self.accurate = zero.both(self.accurate, self.tip.factor.pivots_exceed(&limits));
    }

    /// Eliminates a rung (pair of key nodes joined by a rib) with the loads on its back and front node.
    #[inline(always)]
    pub(super) fn eliminate_rung(&mut self, level: usize, rib: Option<RigidRib<R>>, loads: [&OnNode<R>; 2]) {
        let zero = loads[0].curvature.zero();
        let mut stiffness = self.rung_stiffness(level);
        match self.rungs.get(level + 1) {
            Some(above) => above.reduce_stiffness(&mut stiffness),
            None => self.tip.reduce_stiffness(&mut stiffness),
        }
        for (row, load) in [0, 3].into_iter().zip(loads) {
            stiffness[row][row] += load.spring;
            stiffness[row + 1][row + 1] += load.spring;
            stiffness[row + 2][row + 2] += load.curvature;
        }
        let [back, front] = self.plate_members(level).map(|line| &self.chains[line].stiffness);
        self.rungs[level].eliminate(rib, &stiffness, back, front);
        self.positive = zero.both(self.positive, self.rungs[level].block.factor.positive);
        let mut limits = self.rung_sum(level, |line| &self.chains[line].diagonal);
        for limit in &mut limits {
            *limit *= zero.constant(SMALL_PIVOT);
        }
        if let Some(row) = self.rungs[level].tied_row() {
            limits[row..row + 3].fill(zero);
        }
        let exceed = self.rungs[level].pivots_exceed(&limits).unwrap_or(zero.exceeds(zero));
        self.accurate = zero.both(self.accurate, exceed);
    }
}

impl Factor {
    /// The factored linear stiffness of a mesh.
    fn at_rest(mesh: &Mesh) -> Factor {
        let mut ladder = Ladder::new(mesh, crate::Kinematics::Linear);
        ladder.factorise(&FrameMotion::at_rest(mesh.frame()));
        ladder.own
    }

    /// Returns the stiffness at rest, which the mesh stores, if `rests`; otherwise the ladder's own factor.
    pub(super) fn chosen<'a>(mesh: &'a Mesh, own: &'a Factor, rests: bool) -> &'a Factor {
        let at_rest = rests.then(|| mesh.prepared(Factor::at_rest)).flatten();
        at_rest.unwrap_or(own)
    }
}
