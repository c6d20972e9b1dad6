//! Balance of fingers, object and contacts, by Newton's method.
//!
//! Unknown are the motions of all bodies of the fingers, the pose of the object, and for every pair of parts that are near each other the
//! contact's normal and friction force. Signorini's and Coulomb's laws are equations without inequalities (Alart and Curnier 1991): with a
//! stiffness c, a contact is open where normal force minus c gap is negative; it sticks where friction minus c slip is within the cone, and slips
//! otherwise. Newton's method takes each pair for what it looks like and looks again.
//!
//! Reference: Alart, Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods" (Comput. Methods Appl.
//! Mech. Eng. 92, 1991).

use super::contact::{Pair, Stand, Touching};
use super::surface::{Feature, Front, Part, Shape};
use crate::lattice::Lattice;
use crate::lattice::bodies::Body;
use crate::lattice::energy::{BodyMotion, Energy};
use crate::lattice::skin::TouchedPart;
use faer::linalg::solvers::Solve;
use faer::mat::MatMut;
use faer::sparse::{SparseColMat, Triplet};
use finray_model::Vector;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// Newton's method is given up after so many steps; those that converge mostly take ten.
const MOST_STEPS: usize = 50;
/// From this step on friction lags behind the normal force by a step: where pairs stick and slip in turn, this mostly ends it.
const LAGGING: usize = 15;
/// Longest step of a body or the object, as a share of the object's size, and rad.
const LONGEST: [f64; 2] = [0.3, 0.2];
/// It has converged when a step moves nothing by more than this share of the object's size.
const CONVERGED: f64 = 1e-11;
/// A force is rounding up to this share of what bends a finger by the object's size.
const ROUNDING: f64 = 1e-11;
/// Overlap of a pair that was missed, as a share of the object's size.
const OVERLAP: f64 = 1e-6;
/// Yield of a contact, as a share of what the finger yields, so that parts of the rigid object that touch the rigid support at two
/// points share friction.
const YIELD: f64 = 1e-6;
/// Distance, as a share of the object's size, from which on a pair is looked at.
const NEAR: f64 = 0.2;

/// Which pair of parts: the finger by its number (the support comes after the last), its part, and the object's feature.
pub(super) type Key = (usize, usize, Feature);

/// A finger that stands somewhere.
#[derive(Debug, Clone)]
pub(super) struct Standing<'l> {
    pub lattice: &'l Lattice,
    pub energy: Energy<'l>,
    pub front: Front,
}

/// All that is there.
#[derive(Debug, Clone)]
pub(super) struct Scene<'l> {
    pub fingers: Vec<Standing<'l>>,
    pub shape: Shape,
    pub friction: f64,
    /// Centre of mass in the object's frame, mm.
    pub centre: Vector,
    /// A stiffness of the fingers, N/mm.
    pub stiffness: f64,
    /// Size of the object, mm.
    pub size_mm: f64,
}

/// Where all is, and the forces of contacts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    pub placements: Vec<Placement>,
    pub motions: Vec<Vec<BodyMotion>>,
    pub object: [f64; 3],
    /// Normal and friction force of each pair that is near, N.
    pub forces: BTreeMap<Key, [f64; 2]>,
}

/// What acts on the object beside the fingers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surroundings {
    /// Weight, N.
    pub weight: Vector,
    /// A point of the support and its upward unit normal.
    pub support: Option<(Vector, Vector)>,
    /// Resistance of the object against having moved since the step began, N/mm; against turning it is this times the square of its size.
    pub drag: f64,
    /// The same of each body of the fingers in their own frames, against moving alone: for snaps, which no equilibrium leads through.
    pub finger_drag: f64,
}

/// A pair that is near, at some state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near {
    pub key: Key,
    /// The part of the finger; none of the support.
    pub part: Option<Part>,
    pub touching: Touching,
}

/// What a pair looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Status {
    Open,
    Sticks,
    Slips { forwards: bool },
}

/// What a pair looks like, and whether its force pulled in the last step.
#[derive(Debug, Clone, Copy)]
struct Look {
    status: Status,
    is_pulled: bool,
}

impl Scene<'_> {
    /// Equilibrium with the fingers at `placements`, from a state of which slips are counted; `None` where Newton's method does not arrive.
    pub(super) fn equilibrium(&self, before: &State, placements: &[Placement], around: &Surroundings) -> Option<State> {
        let mut state = State { placements: placements.to_vec(), ..before.clone() };
        let mut looks: BTreeMap<Key, Look> = BTreeMap::new();
        let mut last = Vec::new();
        for step in 0..MOST_STEPS {
            let near = self.near(&state, before, around);
            state.forces = self.inherited(&state, &near);
            looks = near
                .iter()
                .map(|near| (near.key, self.look(near, state.forces[&near.key], looks.get(&near.key))))
                .collect();
            let statuses: Vec<Status> = near.iter().map(|near| looks[&near.key].status).collect();
            let correction = self.correction(&state, before, around, &near, &statuses, step >= LAGGING)?;
            let (share, largest) = self.share(&correction);
            self.apply(&mut state, &near, &correction, share);
            let is_same = statuses == last && looks.values().all(|look| !look.is_pulled);
            if share == 1.0 && largest <= CONVERGED * self.size_mm && is_same {
                state.forces.retain(|_, [normal_n, _]| normal_n.abs() > self.nothing_n());
                let given_mm = |near: &Near| self.yield_mm(state.forces.get(&near.key).map_or(0.0, |forces| forces[0]));
                let overlaps = |near: &Near| near.touching.gap_mm + given_mm(near) < -OVERLAP * self.size_mm;
                let pulls = state.forces.values().any(|[normal_n, _]| *normal_n < -self.nothing_n());
                return (!pulls && !self.near(&state, before, around).iter().any(overlaps)).then_some(state);
            }
            last = statuses;
        }
        None
    }

    /// All pairs that are near each other.
    pub(super) fn near(&self, state: &State, before: &State, around: &Surroundings) -> Vec<Near> {
        let mut pairs = Vec::new();
        let within_mm = NEAR * self.size_mm;
        for (finger, standing) in self.fingers.iter().enumerate() {
            let bodies = &standing.lattice.assembly().bodies;
            for (index, part) in standing.front.parts.iter().enumerate() {
                let stand = |state: &State| Stand {
                    finger: state.placements[finger],
                    body: state.motions[finger][part.body],
                    object: state.object,
                };
                let (body, now) = (&bodies[part.body], stand(state));
                for (feature, pair) in self.shape.near(part, body, &now, within_mm) {
                    let touching = pair.touching(body.position, &now, &stand(before));
                    pairs.push(Near { key: (finger, index, feature), part: Some(*part), touching });
                }
            }
        }
        let Some((point, upward)) = around.support else { return pairs };
        let fixed =
            |state: &State| Stand { finger: Placement::IDENTITY, body: BodyMotion::default(), object: state.object };
        let ground = Body { position: Vector::zeros(), fixed: true };
        let (corners, disc_mm) = self.shape.corners();
        for (i, corner) in corners.iter().enumerate() {
            let radii_mm = [0.0, disc_mm];
            let pair = Pair::PieceAndCorner { on_piece: point, outward: upward, corner: *corner, radii_mm };
            let touching = pair.touching(ground.position, &fixed(state), &fixed(before));
            if touching.gap_mm < within_mm {
                pairs.push(Near { key: (self.fingers.len(), 0, Feature::Corner(i)), part: None, touching });
            }
        }
        pairs
    }

    /// Forces of the pairs that are near now: their own, or for a new one those of a pair of the same part that is no longer near.
    fn inherited(&self, state: &State, near: &[Near]) -> BTreeMap<Key, [f64; 2]> {
        let mut gone: BTreeMap<Key, [f64; 2]> = state.forces.clone();
        near.iter().for_each(|near| {
            gone.remove(&near.key);
        });
        let mut force = |key: Key| {
            state.forces.get(&key).copied().unwrap_or_else(|| {
                let of_same = gone.keys().find(|(finger, part, feature)| {
                    *finger == key.0 && (*part == key.1 || matches!(feature, Feature::Corner(_)) && *feature == key.2)
                });
                let of_same = of_same.copied();
                of_same.and_then(|key| gone.remove(&key)).unwrap_or_default()
            })
        };
        near.iter().map(|near| (near.key, force(near.key))).collect()
    }

    /// What a pair looks like after a step in which it was taken for `before`. A closed one opens when its force pulls twice in a row: after a long
    /// step forces are not yet what they will be.
    fn look(&self, near: &Near, [normal_n, friction_n]: [f64; 2], before: Option<&Look>) -> Look {
        let Touching { gap_mm, slip_mm, .. } = near.touching;
        let sticks_or_slips = |held_n: f64, pressed_n: f64| match held_n.abs() < self.friction * pressed_n {
            true => Status::Sticks,
            false => Status::Slips { forwards: held_n < 0.0 },
        };
        let before = before.copied().unwrap_or(Look {
            status: if normal_n > self.nothing_n() { sticks_or_slips(friction_n, normal_n) } else { Status::Open },
            is_pulled: false,
        });
        let is_pulled = normal_n < -self.nothing_n() && before.status != Status::Open;
        let status = match before.status {
            Status::Open if gap_mm >= 0.0 => Status::Open,
            Status::Open => sticks_or_slips(-self.stiffness * slip_mm, -self.stiffness * gap_mm),
            _ if is_pulled && before.is_pulled => Status::Open,
            closed if is_pulled => closed,
            Status::Sticks => sticks_or_slips(friction_n, normal_n),
            Status::Slips { forwards } if self.friction == 0.0 || slip_mm == 0.0 || (slip_mm > 0.0) == forwards => {
                before.status
            }
            Status::Slips { .. } => Status::Sticks,
        };
        Look { status, is_pulled: is_pulled && status != Status::Open }
    }

    /// How far a contact gives way under a force, mm.
    fn yield_mm(&self, force_n: f64) -> f64 {
        YIELD / self.stiffness * force_n
    }

    /// A force that is rounding, N.
    fn nothing_n(&self) -> f64 {
        ROUNDING * self.stiffness * self.size_mm
    }

    /// Number of the first unknown of a finger; of the object for the number after the last.
    fn first(&self, finger: usize) -> usize {
        self.fingers[..finger].iter().map(|standing| standing.energy.unknown_count()).sum()
    }

    /// A step of Newton's method: motions of the fingers' bodies, of the object, then the two forces of each pair that is near. Where friction
    /// is lagging, its bound is that of the normal force before the step.
    fn correction(
        &self,
        state: &State,
        before: &State,
        around: &Surroundings,
        near: &[Near],
        statuses: &[Status],
        is_lagging: bool,
    ) -> Option<Vec<f64>> {
        let object = self.first(self.fingers.len());
        let count = object + 3 + 2 * near.len();
        let mut residual = vec![0.0; count];
        let mut tangent: Vec<Triplet<usize, usize, f64>> = Vec::new();
        for (finger, standing) in self.fingers.iter().enumerate() {
            let first = self.first(finger);
            let expansion = standing.energy.expand(&state.motions[finger], &[], 0.0);
            for (i, gradient) in expansion.gradient.iter().enumerate() {
                residual[first + i] += gradient;
            }
            for (body, (now, then)) in state.motions[finger].iter().zip(&before.motions[finger]).enumerate() {
                let Some(i) = standing.energy.first_unknown(body).map(|i| first + i) else { continue };
                let resistance = (now.displacement - then.displacement) * around.finger_drag;
                for axis in 0..2 {
                    residual[i + axis] += resistance[axis];
                    tangent.push(Triplet::new(i + axis, i + axis, around.finger_drag));
                }
            }
            for Triplet { row, col, val } in expansion.curvature {
                tangent.push(Triplet::new(first + row, first + col, val));
                if row != col {
                    tangent.push(Triplet::new(first + col, first + row, val));
                }
            }
        }
        let arm = nalgebra::Rotation2::new(state.object[2]) * self.centre;
        let drags = [around.drag, around.drag, around.drag * self.size_mm * self.size_mm];
        let loads = [around.weight.x, around.weight.y, arm.perp(&around.weight)];
        for i in 0..3 {
            residual[object + i] += drags[i] * (state.object[i] - before.object[i]) - loads[i];
            tangent.push(Triplet::new(object + i, object + i, drags[i]));
        }
        tangent.push(Triplet::new(object + 2, object + 2, arm.dot(&around.weight)));

        for (k, (near, status)) in near.iter().zip(statuses).enumerate() {
            let Near { key, part, touching } = near;
            let forces = state.forces[key];
            let of_body =
                part.and_then(|part| Some(self.first(key.0) + self.fingers[key.0].energy.first_unknown(part.body)?));
            let unknown = |i: usize| if i < 3 { of_body.map(|first| first + i) } else { Some(object + i - 3) };
            let rows = [object + 3 + 2 * k, object + 4 + 2 * k];
            for i in 0..6 {
                let Some(row) = unknown(i) else { continue };
                for axis in 0..2 {
                    residual[row] -= forces[axis] * touching.pull[axis][i];
                    tangent.push(Triplet::new(row, rows[axis], -touching.pull[axis][i]));
                }
                for j in 0..6 {
                    let Some(column) = unknown(j) else { continue };
                    let by = |axis: usize| forces[axis] * touching.pull_by[j][axis][i];
                    tangent.push(Triplet::new(row, column, -by(0) - by(1)));
                }
            }
            let given = self.yield_mm(1.0);
            let mut closed = |row: usize, value: f64, by: &[f64; 6], force_n: f64| {
                residual[row] = value + given * force_n;
                tangent.push(Triplet::new(row, row, given));
                for j in 0..6 {
                    if let Some(column) = unknown(j) {
                        tangent.push(Triplet::new(row, column, by[j]));
                    }
                }
            };
            match status {
                Status::Open => {}
                Status::Sticks => {
                    closed(rows[0], touching.gap_mm, &touching.pull[0], forces[0]);
                    closed(rows[1], touching.slip_mm, &touching.slip_by, forces[1]);
                }
                Status::Slips { .. } => closed(rows[0], touching.gap_mm, &touching.pull[0], forces[0]),
            }
            match status {
                Status::Open => {
                    for axis in 0..2 {
                        residual[rows[axis]] = forces[axis];
                        tangent.push(Triplet::new(rows[axis], rows[axis], 1.0));
                    }
                }
                Status::Sticks => {}
                Status::Slips { forwards } => {
                    let bound = if *forwards { -self.friction } else { self.friction };
                    residual[rows[1]] = forces[1] - bound * forces[0];
                    tangent.push(Triplet::new(rows[1], rows[1], 1.0));
                    if !is_lagging {
                        tangent.push(Triplet::new(rows[1], rows[0], -bound));
                    }
                }
            }
        }
        let matrix = SparseColMat::try_new_from_triplets(count, count, &tangent).ok()?;
        let factorised = matrix.sp_lu().ok()?;
        let mut correction: Vec<f64> = residual.iter().map(|r| -r).collect();
        factorised.solve_in_place(MatMut::from_column_major_slice_mut(&mut correction, count, 1));
        correction.iter().all(|c| c.is_finite()).then_some(correction)
    }

    /// The share of a correction that moves nothing too far, and its largest movement, mm (rotations at the object's size).
    fn share(&self, correction: &[f64]) -> (f64, f64) {
        let object = self.first(self.fingers.len());
        let (mut moved_mm, mut turned_rad) = (0.0_f64, 0.0_f64);
        for motion in correction[..object + 3].chunks(3) {
            moved_mm = moved_mm.max(motion[0].hypot(motion[1]));
            turned_rad = turned_rad.max(motion[2].abs());
        }
        let share = (LONGEST[0] * self.size_mm / moved_mm).min(LONGEST[1] / turned_rad).min(1.0);
        (share, moved_mm.max(turned_rad * self.size_mm))
    }

    fn apply(&self, state: &mut State, near: &[Near], correction: &[f64], share: f64) {
        for (finger, standing) in self.fingers.iter().enumerate() {
            let first = self.first(finger);
            for (body, motion) in state.motions[finger].iter_mut().enumerate() {
                if let Some(i) = standing.energy.first_unknown(body).map(|i| first + i) {
                    motion.displacement += Vector::new(correction[i], correction[i + 1]) * share;
                    motion.rotation += correction[i + 2] * share;
                }
            }
        }
        let object = self.first(self.fingers.len());
        for i in 0..3 {
            state.object[i] += share * correction[object + i];
        }
        for (k, near) in near.iter().enumerate() {
            if let Some(forces) = state.forces.get_mut(&near.key) {
                forces[0] += share * correction[object + 3 + 2 * k];
                forces[1] += share * correction[object + 4 + 2 * k];
            }
        }
    }
}

/// Where on the plate a part is touched: a piece where it is met, from its first end.
pub(super) fn touched(part: &Part, arm: Vector) -> TouchedPart {
    match (part.touched, part.to) {
        (TouchedPart::Plate(from_mm), Some(to)) => {
            TouchedPart::Plate(from_mm + (arm - part.from).dot(&(to - part.from).normalize()))
        }
        (touched, _) => touched,
    }
}
