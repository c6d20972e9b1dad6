//! The elements from the first end of a chain to one of its nodes, as a cantilever that grows element by element.
//!
//! The motion of the second end relative to the rotating first end (the *deflection*) determines how the elements deform. With the deflection as
//! unknown, the stiffness matrix contains only the elements' stiffness. With nodal positions as unknowns, the stiffness matrix also contains the
//! resistance to a motion of one end alone. With nodal positions as unknowns, the resistance to a common motion of both ends would be a small
//! difference of large numbers. Eliminating n elements node by node would amplify rounding errors by n^3. The deflection of the next element is
//! therefore eliminated instead of the node before that element. Consecutive elements act as springs in series. The stiffness S of the preceding
//! elements and the stiffness k of the next element combine to S - S (S + k)^-1 S. The subtracted term S (S + k)^-1 S is small, because the stiffness
//! k of one element is large compared with S.
//!
//! A fourth unknown is the rotation of the whole cantilever, which rotates the elements' forces. A translation of the whole cantilever changes no forces.

use super::block::Block;
use super::ends::{Ends, EndsMatrix};
use crate::element::{Response, quarter_turn};
use crate::number::Number;
use nalgebra::Vector2;

/// Unknowns of a cantilever: deflection x, y (mm) and rotation (rad) of the second end relative to the first; then the rotation of the whole
/// cantilever (rad).
pub(super) type Deflection<R = f64> = [R; 4];
const TURN: usize = 3;

/// Forces on a cantilever: gradient of the energy with respect to the deflection (N, N mm), and to a translation of the whole cantilever (N).
#[derive(Debug, Clone, Copy)]
pub(super) struct Forces<R: Number> {
    /// Gradient of the energy with respect to the deflection, N and N mm.
    by_deflection: Deflection<R>,
    /// Gradient of the energy with respect to a translation of the whole cantilever, N.
    by_displacement: [R; 2],
    /// Vector from the first to the second end, mm.
    lever: Vector2<R>,
}

impl<R: Number> Forces<R> {
    /// Computes the forces on a cantilever from a gradient with respect to the motions of the two ends. `lever` is the vector from the first to the
    /// second end, mm.
    #[inline(always)]
    pub(super) fn on(gradient: &Ends<R>, lever: Vector2<R>) -> Forces<R> {
        let [x, y, moment, end_x, end_y, end_moment] = *gradient;
        let arm = quarter_turn(lever);
        Forces {
            by_deflection: [end_x, end_y, end_moment, moment + end_moment + arm.x * end_x + arm.y * end_y],
            by_displacement: [x + end_x, y + end_y],
            lever,
        }
    }

    /// The gradient with respect to the motions of the two ends.
    #[inline(always)]
    pub(super) fn on_ends(&self) -> Ends<R> {
        let [x, y, moment, turn] = self.by_deflection;
        let arm = quarter_turn(self.lever);
        let [all_x, all_y] = self.by_displacement;
        [all_x - x, all_y - y, turn - moment - arm.x * x - arm.y * y, x, y, moment]
    }

    /// Appends an element at the second end and eliminates the element's deflection. Returns y = L^-1 g of this elimination.
    #[inline(always)]
    pub(super) fn extend(&mut self, joint: &Joint<R>, next: &Forces<R>) -> [R; 3] {
        let (arm, next_arm) = (quarter_turn(self.lever), quarter_turn(joint.lever));
        self.lever = sum(self.lever, joint.lever);
        let g = &mut self.by_deflection;
        // The next element translates with the present second end.
        let [x, y] = next.by_displacement;
        self.by_displacement[0] += x;
        self.by_displacement[1] += y;
        g[0] += x;
        g[1] += y;
        g[TURN] += arm.x * x + arm.y * y + next.by_deflection[TURN];
        // Transforms the gradient to the new second end; `next.by_deflection[TURN]` appears because the next element rotates with the old second end.
        g[2] += next.by_deflection[TURN] - next_arm.x * g[0] - next_arm.y * g[1];
        let by_next = &next.by_deflection;
        let y = joint.block.forward(&[by_next[0] - g[0], by_next[1] - g[1], by_next[2] - g[2]]);
        joint.block.reduce_gradient(&y, g);
        y
    }
}

/// Elimination of the deflection of one element that was appended to a cantilever.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joint<R: Number = f64> {
    pub(super) block: Block<R, 3, 4>,
    /// Vector from the element's first to its second node, mm.
    pub(super) lever: Vector2<R>,
}

impl<R: Number> Joint<R> {
    /// An element's joint before its elimination, in the number type of `like`.
    #[inline(always)]
    pub(super) fn empty(like: R) -> Joint<R> {
        Joint { block: Block::empty(like), lever: Vector2::new(like.zero(), like.zero()) }
    }

    /// Copies one SIMD lane to `one`.
    #[inline(always)]
    pub(super) fn copy_lane(&self, lane: usize, one: &mut Joint) {
        self.block.copy_lane(lane, &mut one.block);
        (one.lever.x, one.lever.y) = (self.lever.x.lane(lane), self.lever.y.lane(lane));
    }

    /// Deflection of the cantilever without this element, computed from its deflection `longer` with this element and from y = L^-1 g of the residual
    /// g.
    #[inline(always)]
    pub(super) fn shortened(&self, y: &[R; 3], longer: &Deflection<R>) -> Deflection<R> {
        let [x, y, rotation] = self.block.motion(y, longer);
        let rotation = longer[2] - rotation;
        let arm = quarter_turn(self.lever);
        [longer[0] - x - arm.x * rotation, longer[1] - y - arm.y * rotation, rotation, longer[TURN]]
    }
}

/// Stiffness of the first elements of a chain with respect to the [`Deflection`]. The nodes between these elements are eliminated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cantilever<R: Number> {
    /// Stiffness with respect to the deflection: a symmetric matrix of which only the upper triangle is valid.
    stiffness: [[R; 4]; 4],
    /// Vector from the first to the second end, mm.
    pub(super) lever: Vector2<R>,
}

impl<R: Number> Cantilever<R> {
    /// The cantilever of one element without loads. `carried` is the force at the element's second end, N, which rotates with the element.
    ///
    /// The stiffness with respect to the deflection is the stiffness with respect to the motion of the element's second end. A rotation of the whole
    /// cantilever by w changes the force f by w quarter_turn(f). A change of the force f by w quarter_turn(f) has the moment w f . lever about the
    /// first end.
    #[inline(always)]
    pub(super) fn of_element(element: &Response<R>, carried: Vector2<R>, lever: Vector2<R>) -> Cantilever<R> {
        let mut stiffness = [[lever.x.zero(); 4]; 4];
        // The matrix is symmetric, so its columns serve as rows.
        let columns = &element.tangent.data.0;
        for i in 0..3 {
            for j in i..3 {
                stiffness[i][j] = columns[3 + i][3 + j];
            }
        }
        let turned = quarter_turn(carried);
        (stiffness[0][TURN], stiffness[1][TURN]) = (turned.x, turned.y);
        stiffness[TURN][TURN] = carried.x * lever.x + carried.y * lever.y;
        Cantilever { stiffness, lever }
    }

    /// Adds the second derivatives of the potential of a dead load on the element. A dead load does not rotate with the cantilever, so the full
    /// tangent of the load's potential is transformed.
    #[inline(always)]
    pub(super) fn add_load(&mut self, potential: &Response<R>) {
        let tangent = &potential.tangent;
        let arm = quarter_turn(self.lever);
        let mut by_turn = [arm.x; 6];
        for i in 0..6 {
            by_turn[i] = tangent[(i, 2)] + tangent[(i, 3)] * arm.x + tangent[(i, 4)] * arm.y + tangent[(i, 5)];
        }
        for i in 0..3 {
            for j in i..3 {
                self.stiffness[i][j] += tangent[(3 + i, 3 + j)];
            }
            self.stiffness[i][TURN] += by_turn[3 + i];
        }
        self.stiffness[TURN][TURN] += by_turn[2] + arm.x * by_turn[3] + arm.y * by_turn[4] + by_turn[5];
    }

    /// Appends an element at the second end and eliminates the element's deflection.
    #[inline(always)]
    pub(super) fn extend(&mut self, joint: &mut Joint<R>, next: &Cantilever<R>) {
        let arm = quarter_turn(next.lever);
        joint.lever = next.lever;
        self.lever = sum(self.lever, next.lever);
        let s = &mut self.stiffness;
        // Moves the stiffness to the new second end. The old second end moves like the new second end, minus `arm` times the rotation.
        let lifted = [s[0][0] * arm.x + s[0][1] * arm.y, s[0][1] * arm.x + s[1][1] * arm.y];
        s[2][2] -= arm.x * s[0][2] + arm.y * s[1][2];
        s[0][2] -= lifted[0];
        s[1][2] -= lifted[1];
        s[2][2] -= arm.x * s[0][2] + arm.y * s[1][2];
        s[2][TURN] -= arm.x * s[0][TURN] + arm.y * s[1][TURN];
        // The next element rotates with the old second end.
        let turning = next.stiffness[TURN][TURN];
        s[2][2] += turning;
        s[2][TURN] += turning;
        s[TURN][TURN] += turning;
        let with_turn = [next.stiffness[0][TURN], next.stiffness[1][TURN], next.stiffness[2][TURN]];

        let mut own = [[turning.zero(); 3]; 3];
        let mut coupling = [[turning.zero(); 4]; 3];
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

    /// Stiffness with respect to the motions of the two ends.
    #[inline(always)]
    pub(super) fn on_ends(&self) -> EndsMatrix<R> {
        let s = &self.stiffness;
        let arm = quarter_turn(self.lever);
        let upper = |i: usize, j: usize| s[i.min(j)][i.max(j)];
        // Column of the first end's rotation. A unit rotation of the first end changes the deflection in x and y by minus `arm`.
        let mut held = [arm.x; 3];
        for i in 0..3 {
            held[i] = upper(i, 0) * arm.x + upper(i, 1) * arm.y + upper(i, 2) - s[i][TURN];
        }
        let mut ends = [[arm.x.zero(); 6]; 6];
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
        let turning = arm.x * s[0][TURN] + arm.y * s[1][TURN] + s[2][TURN];
        ends[2][2] = arm.x * held[0] + arm.y * held[1] + held[2] - turning + s[TURN][TURN];
        ends
    }

    /// Diagonal entries of the stiffness with respect to x, y and rotation of the deflection.
    #[inline(always)]
    pub(super) fn diagonal(&self) -> [R; 3] {
        [self.stiffness[0][0], self.stiffness[1][1], self.stiffness[2][2]]
    }
}

#[inline(always)]
fn sum<R: Number>(a: Vector2<R>, b: Vector2<R>) -> Vector2<R> {
    Vector2::new(a.x + b.x, a.y + b.y)
}
