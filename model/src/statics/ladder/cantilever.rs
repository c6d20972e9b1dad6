//! The elements from the first end of a chain to one of its nodes, as a cantilever that grows.
//!
//! Where the second end is, counted from the first end and turning with it, says how the elements between deform. By
//! that deflection an element's stiffness is all there is to it; by positions the same stiffness stands against the
//! motion of either end alone, and what the two ends do together is a small difference of large numbers: of a chain of n
//! elements, eliminated node by node, n^3 times the rounding error. So the next element's deflection is eliminated, not
//! the node before it. Elements in a row are springs in a row: the stiffness S of what is there and k of the next give
//! S - S (S + k)^-1 S, where little is subtracted since k is large.
//!
//! Everything may also turn as a whole, which deforms nothing but turns the forces that the elements carry: a fourth
//! unknown. And it may be displaced as a whole, which changes nothing.

use super::block::Block;
use super::chain::{Ends, EndsMatrix};
use crate::Vector;
use crate::element::{Response, quarter_turn};

/// Unknowns: deflection x, y (mm) and rotation (rad) of the second end as seen from the first; rotation of the whole.
pub(super) type Deflection = [f64; 4];
const TURN: usize = 3;

/// Forces on a cantilever: gradient of its energy by its deflection, and by a displacement as a whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forces {
    by_deflection: Deflection,
    by_displacement: [f64; 2],
    /// From the first to the second end, mm.
    lever: Vector,
}

impl Forces {
    /// Of a gradient on the two ends; `lever` reaches from the first to the second, mm.
    #[inline(always)]
    pub(super) fn on(gradient: &Ends, lever: Vector) -> Forces {
        let [x, y, moment, end_x, end_y, end_moment] = *gradient;
        let arm = quarter_turn(lever);
        Forces {
            by_deflection: [end_x, end_y, end_moment, moment + end_moment + arm.x * end_x + arm.y * end_y],
            by_displacement: [x + end_x, y + end_y],
            lever,
        }
    }

    /// On the two ends.
    pub(super) fn on_ends(&self) -> Ends {
        let [x, y, moment, turn] = self.by_deflection;
        let arm = quarter_turn(self.lever);
        let [all_x, all_y] = self.by_displacement;
        [all_x - x, all_y - y, turn - moment - arm.x * x - arm.y * y, x, y, moment]
    }

    /// Puts an element behind the second end and eliminates its deflection; returns its y.
    #[inline(always)]
    pub(super) fn extend(&mut self, joint: &Joint, next: &Forces) -> [f64; 3] {
        let (arm, next_arm) = (quarter_turn(self.lever), quarter_turn(joint.lever));
        self.lever += joint.lever;
        let g = &mut self.by_deflection;
        // The next element goes where the old second end goes.
        let [x, y] = next.by_displacement;
        self.by_displacement[0] += x;
        self.by_displacement[1] += y;
        g[0] += x;
        g[1] += y;
        g[TURN] += arm.x * x + arm.y * y + next.by_deflection[TURN];
        // Seen from the new second end, and the next element turns with the old one.
        g[2] += next.by_deflection[TURN] - next_arm.x * g[0] - next_arm.y * g[1];
        let y = joint.block.forward(&std::array::from_fn(|i| next.by_deflection[i] - g[i]));
        joint.block.reduce_gradient(&y, g);
        y
    }
}

/// Where an element was put behind a cantilever: the elimination of its deflection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joint {
    block: Block<3, 4>,
    /// From the element's first to its second node, mm.
    lever: Vector,
}

impl Joint {
    /// To be overwritten.
    pub(super) fn empty() -> Joint {
        Joint { block: Block::empty(), lever: Vector::zeros() }
    }

    /// Whether the node between, held on both sides, is stable.
    pub(super) fn positive(&self) -> bool {
        self.block.positive()
    }

    /// Work of a residual on the correction of the element's deflection, by its y, N mm.
    pub(super) fn work(&self, y: &[f64; 3]) -> f64 {
        self.block.work(y)
    }

    /// Logarithm of the determinant of what was eliminated here.
    pub(super) fn log_determinant(&self) -> f64 {
        self.block.log_determinant()
    }

    /// The deflection of the shorter cantilever, from that of the longer one and the y of the residual.
    #[inline(always)]
    pub(super) fn shortened(&self, y: &[f64; 3], longer: &Deflection) -> Deflection {
        let [x, y, rotation] = self.block.motion(y, longer);
        let rotation = longer[2] - rotation;
        let arm = quarter_turn(self.lever) * rotation;
        [longer[0] - x - arm.x, longer[1] - y - arm.y, rotation, longer[TURN]]
    }

    pub(super) fn lever(&self) -> Vector {
        self.lever
    }
}

/// Second derivatives of the energy of a chain's first elements by [`Deflection`], the nodes between eliminated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cantilever {
    /// Symmetric: only the upper triangle is kept up to date.
    stiffness: [[f64; 4]; 4],
    /// From the first to the second end, mm.
    lever: Vector,
}

impl Cantilever {
    /// Of one element without loads; `carried`: the force at its second end, N, if it turns with the element.
    ///
    /// The second end's own stiffness is that of the deflection. A turn of the whole by w turns the force f by
    /// w quarter_turn(f); the moments about the first end, which balance before, then lack w f . lever.
    #[inline(always)]
    pub(super) fn of_element(element: &Response, carried: Vector, lever: Vector) -> Cantilever {
        let mut stiffness = [[0.0; 4]; 4];
        // Symmetric: columns are rows.
        let columns = &element.tangent.data.0;
        for i in 0..3 {
            for j in i..3 {
                stiffness[i][j] = columns[3 + i][3 + j];
            }
        }
        let turned = quarter_turn(carried);
        (stiffness[0][TURN], stiffness[1][TURN]) = (turned.x, turned.y);
        stiffness[TURN][TURN] = carried.dot(&lever);
        Cantilever { stiffness, lever }
    }

    /// Adds what a load on the element has; it keeps its direction, so its own terms count.
    pub(super) fn add_load(&mut self, potential: &Response) {
        let tangent = &potential.tangent;
        let arm = quarter_turn(self.lever);
        let turn = nalgebra::Vector6::new(0.0, 0.0, 1.0, arm.x, arm.y, 1.0);
        let by_turn = tangent * turn;
        for i in 0..3 {
            for j in i..3 {
                self.stiffness[i][j] += tangent[(3 + i, 3 + j)];
            }
            self.stiffness[i][TURN] += by_turn[3 + i];
        }
        self.stiffness[TURN][TURN] += turn.dot(&by_turn);
    }

    /// Puts an element behind the second end and eliminates its deflection.
    #[inline(always)]
    pub(super) fn extend(&mut self, joint: &mut Joint, next: &Cantilever) {
        let arm = quarter_turn(next.lever);
        joint.lever = next.lever;
        self.lever += next.lever;
        let s = &mut self.stiffness;
        // Seen from the new second end: the old one is `arm` times its rotation behind.
        let lifted = [s[0][0] * arm.x + s[0][1] * arm.y, s[0][1] * arm.x + s[1][1] * arm.y];
        s[2][2] -= arm.x * s[0][2] + arm.y * s[1][2];
        s[0][2] -= lifted[0];
        s[1][2] -= lifted[1];
        s[2][2] -= arm.x * s[0][2] + arm.y * s[1][2];
        s[2][TURN] -= arm.x * s[0][TURN] + arm.y * s[1][TURN];
        // The next element turns with the old second end.
        let turning = next.stiffness[TURN][TURN];
        s[2][2] += turning;
        s[2][TURN] += turning;
        s[TURN][TURN] += turning;
        let with_turn: [f64; 3] = std::array::from_fn(|i| next.stiffness[i][TURN]);

        let mut own = [[0.0; 3]; 3];
        let mut coupling = [[0.0; 4]; 3];
        for i in 0..3 {
            for j in i..3 {
                own[i][j] = s[i][j] + next.stiffness[i][j];
            }
            for j in 0..3 {
                coupling[i][j] = -s[i.min(j)][i.max(j)];
            }
            own[i][2] -= with_turn[i];
            coupling[i][2] += with_turn[i];
            coupling[i][TURN] = with_turn[i] - s[i][TURN];
        }
        own[2][2] -= with_turn[2];
        joint.block.factorise(&own, &coupling);
        joint.block.reduce_stiffness(s);
    }

    /// Second derivatives by the two ends.
    pub(super) fn on_ends(&self) -> EndsMatrix {
        let s = &self.stiffness;
        let arm = quarter_turn(self.lever);
        let upper = |i: usize, j: usize| s[i.min(j)][i.max(j)];
        // By the first end's rotation: the second end deflects by minus this.
        let turn = [arm.x, arm.y, 1.0];
        let held: [f64; 3] =
            std::array::from_fn(|i| upper(i, 0) * turn[0] + upper(i, 1) * turn[1] + upper(i, 2) * turn[2] - s[i][TURN]);
        let mut ends = [[0.0; 6]; 6];
        for i in 0..3 {
            for j in i..3 {
                ends[3 + i][3 + j] = s[i][j];
            }
            ends[2][3 + i] = -held[i];
        }
        for i in 0..2 {
            for j in i..2 {
                ends[i][j] = s[i][j];
            }
            ends[i][2] = held[i];
            for j in 0..3 {
                ends[i][3 + j] = -upper(i, j);
            }
        }
        let with_turn: f64 = (0..3).map(|i| turn[i] * s[i][TURN]).sum();
        ends[2][2] = (0..3).map(|i| turn[i] * held[i]).sum::<f64>() - with_turn + s[TURN][TURN];
        ends
    }

    pub(super) fn lever(&self) -> Vector {
        self.lever
    }

    /// The stiffnesses against each part of the deflection alone.
    pub(super) fn diagonal(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.stiffness[i][i])
    }
}
