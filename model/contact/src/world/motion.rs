//! Moves fingers and object from one placement of the bases to the next: increments solved by Newton's method, snaps, and coming to rest.

use super::{Drive, GraspFailure, Moment, World};
use crate::scene::{Key, PlacedFinger, State, Surroundings};
use finray_model::frame::FrameMotion;
use finray_model::gripper::Placement;

/// A snap (a jump to another equilibrium) is assumed if no increment of at least this share of a step is solved.
const LEAST_PART: f64 = 1.0 / 16.0;
/// Same limit as [`LEAST_PART`], for increments that are solved but violate the energy balance.
const LEAST_LEAP: f64 = 1.0 / 256.0;
/// An increment is rejected above this energy imbalance, relative to the energy that bends a finger by the object's size.
const MISSING: f64 = 1e-4;
/// Smallest numerical resistance to the object's motion, relative to the fingers' stiffness. This resistance keeps a loose object in position. If the
/// fingers' stiffness is 1 N/mm, the resistance to a displacement of 1 mm is a millionth of a newton.
const DRAG: f64 = 1e-6;
/// Numerical resistance to the object's motion while the bases move, relative to the fingers' stiffness. Only a snap raises this resistance.
const MOVING_DRAG: f64 = 1e-3;
/// Initial numerical resistance while fingers and object come to rest, relative to the fingers' stiffness.
const FIRST_DRAG: f64 = 1e-4;
/// Coming to rest fails if an increment needs more numerical resistance than this, relative to the fingers' stiffness.
const MOST_DRAG: f64 = 1e3;
/// Factor by which the numerical resistance grows after an increment without solution.
const DRAG_FACTOR: f64 = 10.0;
/// Factor by which the numerical resistance is divided after solved increments.
const LESS: f64 = 3.0;
/// Number of solved increments in a row before a larger increment, or less resistance, is tried.
const BOLDER: usize = 2;
/// An increment fails if the object or a node moves farther than the displacement of the fingers' bases plus this share of the object's size.
const FARTHEST: f64 = 0.1;
/// Fingers and object count as at rest if the force of the numerical resistance is at most this share of the largest contact force or of the weight,
/// whichever is larger. Unless the resistance is at its minimum, the last displacement must also be at most this share of the object's size.
pub(super) const AT_REST: f64 = 1e-5;
/// Number of increments with the smallest resistance in which fingers and object may come to rest before the resistance is raised.
const NEAR_STEPS: usize = 4;
/// Coming to rest fails after this number of increments.
const MOST_STEPS: usize = 400;

/// Outcome of one increment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StepOutcome {
    Solved,
    /// Newton's method found an equilibrium, but the path to it violates the energy balance. A shorter increment may succeed.
    Leaps,
    /// Newton's method found no equilibrium.
    Unsolved,
}

impl World<'_> {
    /// Moves the bases in increments that Newton's method solves and whose energy balances. If even the smallest increment fails, a snap is assumed: a
    /// small increment with numerical resistance follows. Everything then comes to rest before the bases move on.
    pub(super) fn move_to(&mut self, to: &Drive) -> Result<(), GraspFailure> {
        let from = self.now.drive.clone();
        let (mut at, mut part, mut solved) = (0.0, 1.0, 0);
        while at < 1.0 {
            let next = if at + part >= 1.0 { 1.0 } else { at + part };
            let there = from.towards(to, next);
            let least = match self.step(&there, MOVING_DRAG, self.most_missing_nmm()) {
                StepOutcome::Solved => {
                    solved += 1;
                    (at, part) = (next, if solved >= BOLDER { part * 2.0 } else { part });
                    continue;
                }
                StepOutcome::Leaps => LEAST_LEAP,
                StepOutcome::Unsolved => LEAST_PART,
            };
            if part > least {
                (part, solved) = (part * 0.5, 0);
                continue;
            }
            let mut drags = std::iter::successors(Some(MOVING_DRAG * DRAG_FACTOR), |drag| Some(drag * DRAG_FACTOR));
            let is_taken = |drag: &f64| self.step(&there, *drag, f64::INFINITY) == StepOutcome::Solved;
            let Some(held) = drags.by_ref().take_while(|drag| *drag <= MOST_DRAG).find(is_taken) else {
                return Err(self.failure());
            };
            self.come_to_rest(held, 0)?;
            (at, part, solved) = (next, 4.0 * LEAST_PART, 0);
        }
        Ok(())
    }

    /// Takes `there`, an equilibrium of the same fingers and object on meshes with half as many elements per member, as the present state.
    pub(crate) fn take_from(&mut self, coarse: &World, there: &Moment) {
        let fingers = || self.scene.fingers.iter().zip(&coarse.scene.fingers);
        let motion = |((fine, coarse), motion): ((&PlacedFinger, &PlacedFinger), &FrameMotion)| {
            fine.mesh.interpolate(coarse.mesh, motion)
        };
        let motions = fingers().zip(&there.state.motions).map(motion).collect();
        let part = |&(finger, part, feature): &Key| {
            let counterpart =
                |(fine, coarse): (&PlacedFinger, &PlacedFinger)| fine.surface.counterpart(&coarse.surface, part);
            (finger, fingers().nth(finger).map_or(part, counterpart), feature)
        };
        let forces = there.state.forces.iter().map(|(key, forces)| (part(key), *forces)).collect();
        let mut state = State { motions, forces, ..there.state.clone() };
        self.now.drive = there.drive.clone();
        self.now.account = there.account;
        state.forces = self.scene.inherited(&state, &self.scene.near_pairs(&state, &state, &self.surroundings()));
        (self.now.state, self.now.before) = (state.clone(), state);
        self.now.acting = self.acting(&self.surroundings(), &self.near_pairs());
    }

    /// Solves for an equilibrium near the present state, whatever the energy of the way there.
    pub(crate) fn meet(&mut self, to: &Drive) -> Result<(), GraspFailure> {
        match self.step(to, MOVING_DRAG, f64::INFINITY) {
            StepOutcome::Solved => Ok(()),
            StepOutcome::Leaps | StepOutcome::Unsolved => Err(self.failure()),
        }
    }

    /// Solves an increment, and accepts it if its energy imbalance is at most `most_missing_nmm`.
    fn step(&mut self, to: &Drive, drag: f64, most_missing_nmm: f64) -> StepOutcome {
        let finger_drag = if drag > MOVING_DRAG { drag * self.scene.stiffness } else { 0.0 };
        let drag = drag * self.scene.stiffness;
        let carried = to.gripper - self.now.drive.gripper;
        let around = Surroundings { weight: to.weight, support: self.support, carried, drag, finger_drag };
        let farthest_mm = FARTHEST * self.scene.size_mm + self.base_way_mm(to);
        let Some(next) = self.scene.equilibrium(&self.now.state, &to.placements, &around, farthest_mm) else {
            return StepOutcome::Unsolved;
        };
        let before = std::mem::replace(&mut self.now.state, next);
        let Moment { drive, acting, before: earlier, .. } = &mut self.now;
        let drive = std::mem::replace(drive, to.clone());
        let earlier = std::mem::replace(earlier, before);
        let then = std::mem::take(acting);
        let pairs = self.near_pairs();
        self.now.acting = self.acting(&around, &pairs);
        let step = self.booked(&drive, &then, &pairs);
        if step.missing_nmm().abs() > most_missing_nmm {
            self.now.state = std::mem::replace(&mut self.now.before, earlier);
            (self.now.drive, self.now.acting) = (drive, then);
            return StepOutcome::Leaps;
        }
        self.now.account.book(&step);
        StepOutcome::Solved
    }

    /// Largest energy imbalance at which an increment is accepted, N mm.
    fn most_missing_nmm(&self) -> f64 {
        MISSING * self.scene.stiffness * self.scene.size_mm * self.scene.size_mm
    }

    /// Largest displacement of a fingertip as its base moves to another placement, mm.
    fn base_way_mm(&self, to: &Drive) -> f64 {
        let tip = |standing: &PlacedFinger, placement: &Placement| {
            let finger = standing.mesh.finger();
            placement.outwards(finger.position(finger.tip()))
        };
        let ways = self.scene.fingers.iter().zip(self.now.drive.placements.iter().zip(&to.placements));
        ways.map(|(finger, (a, b))| (tip(finger, b) - tip(finger, a)).norm()).fold(0.0, f64::max)
    }

    /// Brings everything to rest: at once if the equilibrium is near, else by increments with decreasing numerical resistance.
    pub(crate) fn rest(&mut self) -> Result<(), GraspFailure> {
        let drive = self.now.drive.clone();
        for _ in 0..NEAR_STEPS {
            let held = self.now.state.clone();
            if self.step(&drive, DRAG, self.most_missing_nmm()) != StepOutcome::Solved {
                break;
            }
            let moved_mm = self.scene.moved_mm(&held, &self.now.state);
            if moved_mm <= AT_REST * self.scene.size_mm && self.is_at_rest(DRAG, moved_mm) {
                return Ok(());
            }
        }
        self.come_to_rest(FIRST_DRAG, BOLDER)
    }

    /// Whether the force of the numerical resistance in the last increment, in which fingers or object moved by `moved_mm`, is negligible.
    fn is_at_rest(&self, drag: f64, moved_mm: f64) -> bool {
        let resistance_n = drag * self.scene.stiffness * moved_mm;
        // Lower limit of the force to which the resistance is compared. A finger that has snapped off an object held by a hand rests without
        // contact force.
        let least_n = self.now.drive.weight.norm().max(self.scene.nothing_n());
        let largest_n = self.now.state.forces.values().map(|[normal_n, _]| *normal_n).fold(least_n, f64::max);
        resistance_n <= AT_REST * largest_n && (drag <= DRAG || moved_mm <= AT_REST * self.scene.size_mm)
    }

    /// Lets the object move until the numerical resistance is negligible compared with the contact forces. The first increment has the resistance
    /// `drag`, under which the last `solved` increments were solved.
    fn come_to_rest(&mut self, mut drag: f64, mut solved: usize) -> Result<(), GraspFailure> {
        let drive = self.now.drive.clone();
        // Number of solved increments before less resistance is tried; doubled each time that less resistance fails.
        let (mut patience, mut has_held) = (BOLDER, false);
        for _ in 0..MOST_STEPS {
            let held = self.now.state.clone();
            if self.step(&drive, drag, f64::INFINITY) != StepOutcome::Solved {
                if drag > MOST_DRAG {
                    return Err(self.failure());
                }
                if has_held {
                    (drag, patience) = (drag * LESS, patience * 2);
                } else {
                    drag *= DRAG_FACTOR;
                }
                (solved, has_held) = (0, false);
                continue;
            }
            (solved, has_held) = (solved + 1, true);
            let moved_mm = self.scene.moved_mm(&held, &self.now.state);
            if self.is_at_rest(drag, moved_mm) {
                return Ok(());
            }
            if solved >= patience {
                drag = (drag / LESS).max(DRAG);
            }
        }
        Err(GraspFailure::Dropped)
    }
}
