//! Equilibrium of fingers, object and contacts by Newton's method.
//!
//! The unknowns are the motions of the fingers' nodes, the object's pose, and the normal and friction force of every contact pair. Signorini's and
//! Coulomb's laws become equations without inequalities (Alart and Curnier 1991). With a stiffness c, a contact is open if normal force minus c times
//! gap is negative. A contact sticks if friction minus c times slip lies within the friction cone; otherwise a closed contact slips. Each Newton step
//! fixes the contact status of every pair, then re-evaluates it (semi-smooth Newton).
//!
//! Reference: Alart, Curnier, "A mixed formulation for frictional contact problems prone to Newton like solution methods" (Comput. Methods Appl.
//! Mech. Eng. 92, 1991).

use crate::scene::{Key, Scene, State, Surroundings, largest_mm};
use crate::status::{ContactPair, ContactStatus, Grip};
use finray_model::frame::FrameMotion;
use finray_model::gripper::Placement;
use std::collections::BTreeMap;

/// A solve is abandoned after this number of Newton steps; 99 % of the solves that converge take fewer.
const MOST_STEPS: usize = 30;
/// A solve is abandoned if the object or a node moves by more than this multiple of the allowed distance. 99 % of the solves that converge stay
/// within this multiple.
const ASTRAY: f64 = 2.5;
/// From this Newton step on, friction uses the normal force of the previous step. Using the earlier normal force mostly ends alternation between
/// sticking and slipping.
const LAGGING: usize = 15;
/// The iteration counts as cycling if a step has the same contact statuses as an earlier step (from step `LAGGING` on), and their lengths differ by
/// at most this share.
const ROUND: f64 = 1e-3;
/// A step shorter than this share of the object's size never counts as cycling, because the iteration may still converge.
const ROUND_MM: f64 = 1e-6;
/// Largest Newton step of a node or the object: translation as a share of the object's size, and rotation, rad. A longer step is scaled down.
const LONGEST: [f64; 2] = [0.3, 0.2];
/// The iteration counts as converged only if a Newton step moves every node and the object by at most this share of the object's size. The error after
/// a step is proportional to the square of the step, and is thus of the order of rounding.
const CONVERGED: f64 = 1e-7;
/// Limit in place of [`CONVERGED`] from the Newton step `LAGGING` on, where convergence is linear.
const CONVERGED_LAGGING: f64 = 1e-11;
/// A solution with an overlap above this share of the object's size is rejected, because a contact pair was overlooked.
const OVERLAP: f64 = 1e-6;

impl Scene<'_> {
    /// Equilibrium with the fingers at `placements`; slips count from the state `before`. `None` if Newton's method does not converge, or if
    /// the object or a node moves by more than `farthest_mm`, mm.
    pub(crate) fn equilibrium(
        &mut self,
        before: &State,
        placements: &[Placement],
        around: &Surroundings,
        farthest_mm: f64,
    ) -> Option<State> {
        let mut state =
            State { placements: placements.to_vec(), object: around.carried_from(before.object), ..before.clone() };
        let mut statuses: BTreeMap<Key, ContactStatus> = BTreeMap::new();
        let mut passed: Vec<(Vec<Option<Grip>>, f64)> = Vec::new();
        for step in 0..MOST_STEPS {
            // If a hand holds the object, the first Newton step considers only contacts that carried a force, because overlaps before that step have no
            // meaning.
            let pairs = match step == 0 && self.held == [true; 3] {
                true => self.loaded_pairs(&state, before, around),
                false => self.near_pairs(&state, before, around),
            };
            state.forces = self.inherited(&state, &pairs);
            statuses = self.statuses(&pairs, &state.forces, &statuses);
            let grips: Vec<Option<Grip>> = pairs.iter().map(|pair| statuses[&pair.key].grip).collect();
            let mut closed = Vec::new();
            for (pair, grip) in pairs.into_iter().zip(&grips) {
                match grip {
                    Some(grip) => closed.push((pair, *grip)),
                    None => drop(state.forces.insert(pair.key, [0.0; 2])),
                }
            }
            let correction = self.correction(&state, before, around, &closed, step >= LAGGING)?;
            let (share, largest_mm) = self.share(&state, &correction);
            correction.apply(&mut state, &closed, share);
            let moved_mm = self.moved_mm(before, &state);
            if moved_mm > ASTRAY * farthest_mm {
                return None;
            }
            let is_same = passed.last().is_some_and(|(last, _)| *last == grips);
            let is_settled = is_same && statuses.values().all(|status| !status.is_pulled);
            let converged = if step < LAGGING { CONVERGED } else { CONVERGED_LAGGING };
            if share == 1.0 && largest_mm <= converged * self.size_mm && is_settled {
                return (moved_mm <= farthest_mm && self.is_equilibrium(&mut state, before, around)).then_some(state);
            }
            let goes_round = |(grips_then, then_mm): &(Vec<Option<Grip>>, f64)| {
                *grips_then == grips && (largest_mm - then_mm).abs() <= ROUND * largest_mm
            };
            if largest_mm > ROUND_MM * self.size_mm && passed.iter().skip(LAGGING).any(goes_round) {
                return None;
            }
            passed.push((grips, largest_mm));
        }
        None
    }

    /// Removes negligible forces, and returns whether no pair overlaps and no normal force is tensile.
    fn is_equilibrium(&self, state: &mut State, before: &State, around: &Surroundings) -> bool {
        state.forces.retain(|_, [normal_n, _]| normal_n.abs() > self.nothing_n());
        let given_mm = |pair: &ContactPair| self.yield_mm(state.forces.get(&pair.key).map_or(0.0, |forces| forces[0]));
        let overlaps = |pair: &ContactPair| pair.touching.gap_mm + given_mm(pair) < -OVERLAP * self.size_mm;
        let pulls = state.forces.values().any(|[normal_n, _]| *normal_n < -self.nothing_n());
        !pulls && !self.near_pairs(state, before, around).iter().any(overlaps)
    }

    /// Returns the largest share of a correction that respects `LONGEST`, and the correction's largest motion, mm; a rotation is multiplied by the
    /// object's size.
    fn share(&self, state: &State, correction: &Correction) -> (f64, f64) {
        let [x, y, angle] = correction.object;
        let (mut moved_mm, mut turned_rad) = (x.hypot(y), angle.abs());
        for (from, to) in state.motions.iter().zip(&correction.motions) {
            let nodes = from.displacements.iter().zip(&to.displacements);
            moved_mm = moved_mm.max(largest_mm(nodes.map(|(from, to)| to - from)));
            let turns = from.rotations.iter().zip(&to.rotations);
            turned_rad = turns.fold(turned_rad, |largest, (from, to)| largest.max((to - from).abs()));
        }
        let share = (LONGEST[0] * self.size_mm / moved_mm).min(LONGEST[1] / turned_rad).min(1.0);
        (share, moved_mm.max(turned_rad * self.size_mm))
    }
}

/// Correction of one Newton step.
pub(crate) struct Correction {
    /// Corrected motion of each finger's mesh.
    pub motions: Vec<FrameMotion>,
    /// Change of the object's pose, mm and rad.
    pub object: [f64; 3],
    /// Changes of the forces of the closed pairs, N.
    pub forces: Vec<[f64; 2]>,
}

impl Correction {
    /// Applies a share of the correction.
    fn apply(self, state: &mut State, closed: &[(ContactPair, Grip)], share: f64) {
        for (motion, to) in state.motions.iter_mut().zip(self.motions) {
            if share == 1.0 {
                *motion = to;
                continue;
            }
            motion.displacements.iter_mut().zip(&to.displacements).for_each(|(u, to)| *u += (to - *u) * share);
            motion.rotations.iter_mut().zip(&to.rotations).for_each(|(turn, to)| *turn += (to - *turn) * share);
        }
        for i in 0..3 {
            state.object[i] += share * self.object[i];
        }
        for ((pair, _), change) in closed.iter().zip(&self.forces) {
            if let Some(forces) = state.forces.get_mut(&pair.key) {
                (0..2).for_each(|axis| forces[axis] += share * change[axis]);
            }
        }
    }
}
