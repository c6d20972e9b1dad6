//! Fingers on bases that move, an object and its support: from one settled step to the next.

mod observed;

use super::elimination::Elimination;
use super::equilibrium::{Scene, Standing, State, Surroundings};
use super::near::Near;
use super::surface::{Front, Shape};
use crate::lattice::energy::{BodyMotion, Energy};
use crate::lattice::skin::Touch;
use crate::lattice::{Lattice, LatticeError};
use finray_model::Vector;
use finray_model::gripper::Placement;
use finray_model::mesh::Load;

/// Least part of a step that is tried before a snap is passed.
const LEAST_PART: f64 = 1.0 / 16.0;
/// Resistance of an object against having moved, as a share of the fingers' stiffness: it holds one that nothing holds, and a millimetre costs
/// a millionth of a newton.
const DRAG: f64 = 1e-6;
/// The same while bases move.
const MOVING_DRAG: f64 = 1e-3;
/// The most that is tried.
const MOST_DRAG: f64 = 1e3;
/// The resistance grows by this factor where the object would go far, and falls again when it does not.
const DRAG_FACTOR: f64 = 10.0;
/// Steps that are to be solved after one that was not until a longer part, or less resistance, is tried.
const BOLDER: usize = 2;
/// Farthest that an object goes at once while it comes to rest, as a share of its size.
const FARTHEST: f64 = 0.1;
/// All rests when the resistance is this share of the forces.
const AT_REST: f64 = 1e-5;
/// Steps in which the object must have come to rest.
const MOST_STEPS: usize = 400;
/// A finger of which a part turns further than this, rad, folds: one that wraps an object turns half as far, one of which a plate buckles more.
const FOLDED_RAD: f64 = 1.0;

/// Why a grasp cannot begin.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The object is inside a finger or the support.
    #[error("the object overlaps {what} by {overlap_mm:.3} mm where it starts")]
    Overlap {
        /// What it overlaps.
        what: Partner,
        /// How deep, mm.
        overlap_mm: f64,
    },
    /// The lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

/// Why a grasp ends before its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Halt {
    /// The object falls or slides away and does not come to rest.
    #[error("the object gets away: the fingers do not hold it")]
    Dropped,
    /// Forces grow until nothing fits.
    #[error("jam: object and fingers find no equilibrium")]
    Jammed,
    /// A finger folds.
    #[error("a finger folds")]
    Folded,
}

/// What the object touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Partner {
    /// A finger, by its number: 0 is the left one.
    Finger(usize),
    /// The support.
    Support,
}

impl std::fmt::Display for Partner {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Partner::Finger(0) => "the left finger",
            Partner::Finger(_) => "the right finger",
            Partner::Support => "its support",
        })
    }
}

/// A contact that carries a force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Met {
    /// What the object touches.
    pub partner: Partner,
    /// Where, world, mm.
    pub point: Vector,
    /// Force on the object, world, N.
    pub force: Vector,
    /// How far it has slipped in the step, mm.
    pub slip_mm: f64,
    /// The same as the finger sees it; none of the support.
    pub touch: Option<Touch>,
}

/// Where the fingers stand and what acts on the object.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The fingers' frames in the world.
    pub placements: Vec<Placement>,
    /// Weight, N.
    pub weight: Vector,
    /// Where the gripper is, mm: an object that it holds goes along.
    pub gripper: Vector,
}

impl Drive {
    /// A share of the way to another drive; both have the same fingers.
    fn towards(&self, to: &Drive, share: f64) -> Drive {
        let between = |(from, to): (&Placement, &Placement)| Placement {
            origin: from.origin.lerp(&to.origin, share),
            angle_rad: from.angle_rad + (to.angle_rad - from.angle_rad) * share,
            mirrored: from.mirrored,
        };
        Drive {
            placements: self.placements.iter().zip(&to.placements).map(between).collect(),
            weight: self.weight.lerp(&to.weight, share),
            gripper: self.gripper.lerp(&to.gripper, share),
        }
    }
}

/// Fingers, object and support at rest.
#[derive(Debug, Clone)]
pub struct World<'l> {
    scene: Scene<'l>,
    state: State,
    /// The state before the last step that was solved: slips count from there.
    before: State,
    drive: Drive,
    support: Option<(Vector, Vector)>,
    elimination: Elimination,
    /// Work of friction on the way, N mm.
    dissipated_nmm: f64,
    /// Work of what moves the bases, N mm.
    driven_nmm: f64,
}

impl<'l> World<'l> {
    /// Puts an object, `[x, y, angle]` in mm and rad, between fingers at rest. The support is a point and its upward unit normal.
    ///
    /// # Errors
    /// [`WorldError`] for an object that overlaps a finger or the support.
    pub fn new(
        lattices: &[&'l Lattice],
        rod_radius_mm: f64,
        (shape, friction): (Shape, f64),
        object: [f64; 3],
        drive: Drive,
        support: Option<(Vector, Vector)>,
    ) -> Result<World<'l>, WorldError> {
        let mut stiffness = f64::INFINITY;
        let mut fingers = Vec::new();
        for &lattice in lattices {
            stiffness = stiffness.min(middle_stiffness(lattice)?);
            let (energy, front) = (Energy::new(lattice.assembly()), Front::new(lattice, rod_radius_mm));
            fingers.push(Standing { lattice, energy, front });
        }
        let motions = lattices.iter().map(|lattice| vec![BodyMotion::default(); lattice.assembly().bodies.len()]);
        let placements = drive.placements.clone();
        let state = State { placements, motions: motions.collect(), object, forces: Default::default() };
        let (centre, size_mm) = (shape.centroid(), shape.size_mm());
        let scene = Scene { fingers, shape, friction, centre, stiffness, size_mm };
        let world = World {
            scene,
            before: state.clone(),
            state,
            drive,
            support,
            elimination: Elimination::default(),
            dissipated_nmm: 0.0,
            driven_nmm: 0.0,
        };
        let overlaps = world.near().into_iter().map(|near| (-near.touching.gap_mm, near));
        match overlaps.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((overlap_mm, near)) if overlap_mm > AT_REST * size_mm => {
                Err(WorldError::Overlap { what: world.partner(&near), overlap_mm })
            }
            _ => Ok(world),
        }
    }

    /// Moves the fingers' bases and the weight, and lets all come to rest.
    ///
    /// # Errors
    /// [`Halt`]; fingers and object are then where they last were at rest.
    pub fn advance(&mut self, to: &Drive) -> Result<(), Halt> {
        let start = self.clone();
        let outcome = self.move_to(to).and_then(|()| self.come_to_rest());
        if outcome.is_err() {
            *self = start;
        }
        outcome
    }

    /// Moves the bases in parts that Newton's method takes. Where none is short enough, a snap is passed: a short part against resistance, after which
    /// all comes to rest before the bases move on.
    fn move_to(&mut self, to: &Drive) -> Result<(), Halt> {
        let from = self.drive.clone();
        let (mut at, mut part, mut solved) = (0.0, 1.0, 0);
        while at < 1.0 {
            let next = if at + part >= 1.0 { 1.0 } else { at + part };
            if self.step(&from.towards(to, next), MOVING_DRAG) {
                solved += 1;
                (at, part) = (next, if solved >= BOLDER { part * 2.0 } else { part });
            } else if part > LEAST_PART {
                (part, solved) = (part * 0.5, 0);
            } else {
                let there = from.towards(to, next);
                let mut drags = std::iter::successors(Some(MOVING_DRAG), |drag| Some(drag * DRAG_FACTOR));
                if !drags.by_ref().take_while(|drag| *drag <= MOST_DRAG).any(|drag| self.step(&there, drag)) {
                    return Err(self.halt());
                }
                self.come_to_rest()?;
                (at, part, solved) = (next, 4.0 * LEAST_PART, 0);
            }
        }
        Ok(())
    }

    /// Solves a step; whether it was.
    fn step(&mut self, to: &Drive, drag: f64) -> bool {
        let finger_drag = if drag > MOVING_DRAG { drag * self.scene.stiffness } else { 0.0 };
        let drag = drag * self.scene.stiffness;
        let carried = to.gripper - self.drive.gripper;
        let around = Surroundings { weight: to.weight, support: self.support, carried, drag, finger_drag };
        let farthest_mm = FARTHEST * self.scene.size_mm + self.base_way_mm(to);
        let (scene, placements, elimination) = (&self.scene, &to.placements, &mut self.elimination);
        let Some(next) = scene.equilibrium(&self.state, placements, &around, farthest_mm, elimination) else {
            return false;
        };
        let (bases, forces) = (self.drive.placements.clone(), self.on_bases());
        self.before = std::mem::replace(&mut self.state, next);
        self.drive = to.clone();
        // By the trapezoidal rule.
        for (finger, ((base, then), now)) in bases.iter().zip(forces).zip(self.on_bases()).enumerate() {
            let to = &self.drive.placements[finger];
            let (force, moment_nmm) = (0.5 * (then.0 + now.0), 0.5 * (then.1 + now.1));
            self.driven_nmm -= force.dot(&(to.origin - base.origin)) + moment_nmm * (to.angle_rad - base.angle_rad);
        }
        self.dissipated_nmm += self.friction_work_nmm();
        true
    }

    /// How far the bases move to another drive, mm, at the farthest tip.
    fn base_way_mm(&self, to: &Drive) -> f64 {
        let tip = |standing: &Standing, placement: &Placement| {
            let finger = standing.lattice.finger();
            placement.outwards(finger.position(finger.tip()))
        };
        let ways = self.scene.fingers.iter().zip(self.drive.placements.iter().zip(&to.placements));
        ways.map(|(finger, (a, b))| (tip(finger, b) - tip(finger, a)).norm()).fold(0.0, f64::max)
    }

    /// Lets the object move until the resistance against it is nothing beside the forces.
    fn come_to_rest(&mut self) -> Result<(), Halt> {
        let drive = self.drive.clone();
        let (mut drag, mut solved) = (MOVING_DRAG / DRAG_FACTOR, BOLDER);
        for _ in 0..MOST_STEPS {
            let held = self.state.clone();
            if !self.step(&drive, drag) {
                if drag > MOST_DRAG {
                    return Err(self.halt());
                }
                (drag, solved) = (drag * DRAG_FACTOR, 0);
                continue;
            }
            solved += 1;
            let moved_mm = self.scene.way_mm(&held, &self.state);
            let resistance_n = drag * self.scene.stiffness * moved_mm;
            let forces = self.near().into_iter().filter_map(|near| self.state.forces.get(&near.key).copied());
            let largest_n = forces.map(|[normal, _]| normal).fold(drive.weight.norm(), f64::max);
            if resistance_n <= AT_REST * largest_n && (drag <= DRAG || moved_mm <= AT_REST * self.scene.size_mm) {
                return Ok(());
            }
            if solved >= BOLDER {
                drag = (drag / DRAG_FACTOR.sqrt()).max(DRAG);
            }
        }
        Err(Halt::Dropped)
    }

    /// What keeps the last step from being solved.
    fn halt(&self) -> Halt {
        if self.is_folded() {
            Halt::Folded
        } else if self.met().iter().any(|met| matches!(met.partner, Partner::Finger(_))) {
            Halt::Jammed
        } else {
            Halt::Dropped
        }
    }

    /// Whether a finger has folded.
    pub fn is_folded(&self) -> bool {
        self.state.motions.iter().flatten().any(|motion| motion.rotation.abs() > FOLDED_RAD)
    }

    fn near(&self) -> Vec<Near> {
        let around = Surroundings {
            weight: self.drive.weight,
            support: self.support,
            carried: Vector::zeros(),
            drag: 0.0,
            finger_drag: 0.0,
        };
        self.scene.near(&self.state, &self.before, &around)
    }

    fn partner(&self, near: &Near) -> Partner {
        if near.part.is_some() { Partner::Finger(near.key.0) } else { Partner::Support }
    }

    /// Work of friction in the last step, N mm.
    fn friction_work_nmm(&self) -> f64 {
        let work = |near: &Near| {
            let [_, friction_n] = self.state.forces.get(&near.key).copied().unwrap_or_default();
            (friction_n * near.touching.slip_mm).abs()
        };
        self.near().iter().map(work).sum()
    }

    /// Force and moment about its frame's origin on the base of each finger, world, N and N mm.
    fn on_bases(&self) -> Vec<(Vector, f64)> {
        let on_base = |(finger, placement): (usize, &Placement)| {
            let (force, moment_nmm) = self.on_base(finger);
            (placement.axes() * force, if placement.mirrored { -moment_nmm } else { moment_nmm })
        };
        self.state.placements.iter().enumerate().map(on_base).collect()
    }
}

/// Stiffness of a finger's middle at rest, N/mm.
fn middle_stiffness(lattice: &Lattice) -> Result<f64, LatticeError> {
    // A force under which every finger is linear.
    const TINY_N: f64 = 1e-9;
    let finger = lattice.finger();
    let middle = finger.contact_nodes().nth(finger.contact_nodes().len() / 2).unwrap_or(finger.tip());
    let load = Load::at_node(middle, finger.direction(0.0) * TINY_N);
    let moved_mm = lattice.equilibrium(&[load])?.largest_displacement_mm();
    Ok(TINY_N / moved_mm)
}
