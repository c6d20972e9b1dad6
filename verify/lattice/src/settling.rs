//! The lattice let loose in rapier until it comes to rest.
//!
//! Only the position where it rests has a meaning: masses, time and damping are chosen so that it is reached soon. Every step,
//! rapier solves the springs' forces at the end of the step by sweeps over them (projected Gauss-Seidel). The masses are
//! dt^2 times the stiffness at each body, divided by `SOFTNESS`, so a sweep leaves the same share of the error in every
//! lattice, whatever its units.
//!
//! Damping is kinetic: whenever the kinetic energy has passed a peak, all bodies are stopped. Springs carry none
//! of their own.
//!
//! Reference: Cundall, "Explicit finite-difference methods in geomechanics" (1976), for kinetic damping.

use super::LatticeError;
use super::bodies::{Assembly, BodyLoad};
use super::energy::{BodyMotion, Energy};
use super::springs::{Deformation, Spring};
use finray_model::Vector;
use rapier2d::prelude::{
    GenericJoint, GenericJointBuilder, IntegrationParameters, JointAxesMask, JointAxis, MassProperties, MotorModel,
    PhysicsWorld, Pose, RigidBodyBuilder, RigidBodyHandle, SpringJointBuilder, Vector as RapierVector,
};

/// Length of a step, s. Its size changes nothing but the scale of the masses. It must not be 1: rapier then takes a motor
/// without a limit of its force for a rigid constraint, which it subtracts from the other rows of the joint.
const STEP_S: f64 = 0.5;
/// Stiffness times dt^2 over mass. Larger values move farther in a step, and take more sweeps for the same error.
const SOFTNESS: f64 = 4.0;
/// Sweeps in a step. The residual of the springs' forces after them shifts the rest position, less the more there are.
/// Rapier's warm start of joints would not help: it hands
/// each its old impulse only when its turn comes, and a sweep forgets where it began.
pub const SWEEPS: usize = 32;

/// The lattice rests when no body has moved by more than this share of the largest displacement for as long as
/// the slowest motion takes: `PATIENCE` times the steps to the first peak of the kinetic energy.
pub const AT_REST: f64 = 2e-5;
/// See [`AT_REST`]. From rest to the first peak is a quarter of a period.
const PATIENCE: usize = 2;
/// Fewest steps between two looks at the positions.
const SHORTEST_WATCH: usize = 20;
/// Displacements below this share of the finger's size count as this large: rapier keeps positions, whose rounding they near.
const RESOLUTION: f64 = 1e-9;
/// Steps after which the lattice should long be at rest: the paper's finger takes 3000, one of spring steel 22000 (two segments a
/// stretch), and more in proportion as segments are shorter.
pub const MOST_STEPS: usize = 200_000;

/// How a lattice is let settle. The default is what it takes to rest where its energy is least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling {
    /// Sweeps over the springs in a step.
    pub sweeps: usize,
    /// Precision of the positions.
    pub positions: Precision,
    /// Steps after which it is given up.
    pub most_steps: usize,
}

impl Default for Settling {
    fn default() -> Settling {
        Settling { sweeps: SWEEPS, positions: Precision::Double, most_steps: MOST_STEPS }
    }
}

/// Precision of the bodies' positions and rotations from step to step. All else is in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    Double,
    /// Rounded to 32 bits after each step.
    Single,
}

impl Precision {
    /// A number as it is kept.
    pub fn round(self, x: f64) -> f64 {
        match self {
            Precision::Double => x,
            Precision::Single => f64::from(x as f32),
        }
    }
}

/// Result of settling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    /// Steps between two looks.
    pub watch: usize,
    /// Steps taken.
    pub steps: usize,
    /// Largest movement between the last two looks, as a share of the largest displacement.
    pub residual: f64,
}

/// Bodies and joints of a lattice in a rapier world.
pub(crate) struct Dynamics<'a> {
    assembly: &'a Assembly,
    pub(crate) world: PhysicsWorld,
    /// The lattice's bodies, in their order.
    pub(crate) handles: Vec<RigidBodyHandle>,
    /// All bodies that move, the lattice's and others.
    moving: Vec<Moving>,
    /// Precision of the positions.
    positions: Precision,
    /// Kinetic energy after the last step, N mm.
    energy: f64,
}

/// A body that moves, with where it began.
struct Moving {
    handle: RigidBodyHandle,
    start: RapierVector,
    mass: f64,
    moment: f64,
}

pub(crate) fn rapier(vector: Vector) -> RapierVector {
    RapierVector::new(vector.x, vector.y)
}

pub(crate) fn own(vector: RapierVector) -> Vector {
    Vector::new(vector.x, vector.y)
}

/// The mass with which a stiffness (N/mm) moves in step with the others.
pub(crate) fn mass_for(stiffness: f64) -> f64 {
    STEP_S * STEP_S * stiffness / SOFTNESS
}

/// A joint that moves like the spring: a motor that pulls back with a force (not an acceleration) in proportion.
fn joint(spring: &Spring) -> GenericJoint {
    let [first, second] = spring.ends.map(|end| rapier(end.arm));
    let motor = |axis: JointAxis, angle: f64| {
        let mut joint = GenericJointBuilder::new(JointAxesMask::empty())
            .motor_model(axis, MotorModel::ForceBased)
            .motor_position(axis, 0.0, spring.stiffness, 0.0)
            .build();
        joint.local_frame1 = Pose::new(first, angle);
        joint.local_frame2 = Pose::new(second, angle);
        joint
    };
    match spring.deformation {
        Deformation::Distance { rest } => SpringJointBuilder::new(rest.norm(), spring.stiffness, 0.0)
            .local_anchor1(first)
            .local_anchor2(second)
            .build()
            .into(),
        Deformation::Across { direction } => motor(JointAxis::LinY, direction.y.atan2(direction.x)),
        Deformation::Turn => motor(JointAxis::AngX, 0.0),
    }
}

impl<'a> Dynamics<'a> {
    /// Puts the lattice at rest into an empty world without gravity.
    pub(crate) fn new(assembly: &'a Assembly) -> Dynamics<'a> {
        let mut world = PhysicsWorld::new();
        world.gravity = RapierVector::ZERO;
        world.integration_parameters = IntegrationParameters {
            dt: STEP_S,
            num_solver_iterations: 1,
            num_internal_pgs_iterations: SWEEPS,
            num_internal_stabilization_iterations: 0,
            max_ccd_substeps: 0,
            contact_recycling: false,
            normalized_max_linear_velocity: f64::MAX,
            normalized_max_corrective_velocity: f64::MAX,
            ..IntegrationParameters::default()
        };
        let positions = Precision::Double;
        let mut dynamics =
            Dynamics { assembly, world, handles: Vec::new(), moving: Vec::new(), positions, energy: 0.0 };
        for (body, (mass, moment)) in assembly.bodies.iter().zip(inertia(assembly)) {
            let handle = if body.fixed {
                dynamics.world.bodies.insert(RigidBodyBuilder::fixed().translation(rapier(body.position)))
            } else {
                dynamics.insert_moving(body.position, mass, moment)
            };
            dynamics.handles.push(handle);
        }
        for spring in &assembly.springs {
            let [first, second] = spring.ends.map(|end| dynamics.handles[end.body]);
            dynamics.world.impulse_joints.insert(first, second, joint(spring), true);
        }
        dynamics
    }

    /// The same with other sweeps and another precision.
    pub(crate) fn settling_as(mut self, how: &Settling) -> Dynamics<'a> {
        self.world.integration_parameters.num_internal_pgs_iterations = how.sweeps;
        self.positions = how.positions;
        self
    }

    /// Puts a body that moves into the world.
    pub(crate) fn insert_moving(&mut self, position: Vector, mass: f64, moment: f64) -> RigidBodyHandle {
        let start = rapier(position);
        let properties = MassProperties::new(RapierVector::ZERO, mass, moment);
        let body = RigidBodyBuilder::dynamic().additional_mass_properties(properties).translation(start);
        let handle = self.world.bodies.insert(body.can_sleep(false));
        self.moving.push(Moving { handle, start, mass, moment });
        handle
    }

    /// One step under dead loads.
    fn step(&mut self, loads: &[BodyLoad]) {
        for load in loads {
            let body = &mut self.world.bodies[self.handles[load.body]];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        for load in loads {
            let body = &mut self.world.bodies[self.handles[load.body]];
            let lever =
                BodyMotion { displacement: Vector::zeros(), rotation: body.rotation().angle() }.carried(load.lever);
            body.add_force(rapier(load.force * load.share), true);
            body.add_torque(lever.perp(&load.force) + load.moment_nmm, true);
        }
        self.world.step();
        if self.positions == Precision::Single {
            self.round_positions();
        }
    }

    /// Positions and rotations as they are kept.
    fn round_positions(&mut self) {
        let positions = self.positions;
        let kept = |x: f64| positions.round(x);
        for moving in &self.moving {
            let body = &mut self.world.bodies[moving.handle];
            let mut position = *body.position();
            position.translation = RapierVector::new(kept(position.translation.x), kept(position.translation.y));
            position.rotation.re = kept(position.rotation.re);
            position.rotation.im = kept(position.rotation.im);
            body.set_position(position, true);
        }
    }

    fn kinetic_energy(&self) -> f64 {
        let energy = |moving: &Moving| {
            let body = &self.world.bodies[moving.handle];
            0.5 * (moving.mass * body.linvel().length_squared() + moving.moment * body.angvel() * body.angvel())
        };
        self.moving.iter().map(energy).sum()
    }

    fn stop(&mut self) {
        for moving in &self.moving {
            let body = &mut self.world.bodies[moving.handle];
            body.set_linvel(RapierVector::ZERO, true);
            body.set_angvel(0.0, true);
        }
    }

    /// Puts the lattice's bodies, at rest, where they have moved so.
    pub(crate) fn place(&mut self, motions: &[BodyMotion]) {
        for ((handle, rest), motion) in self.handles.iter().zip(&self.assembly.bodies).zip(motions) {
            if !rest.fixed {
                let pose = Pose::new(rapier(rest.position + motion.displacement), motion.rotation);
                self.world.bodies[*handle].set_position(pose, true);
            }
        }
        self.stop();
        self.energy = 0.0;
    }

    /// Displacement of every moving body, mm.
    fn displacements(&self) -> Vec<RapierVector> {
        self.moving.iter().map(|moving| self.world.bodies[moving.handle].translation() - moving.start).collect()
    }

    /// Motion of every body of the lattice from rest; rotations within half a turn.
    pub(crate) fn motions(&self) -> Vec<BodyMotion> {
        let motion = |(handle, rest): (&RigidBodyHandle, &super::bodies::Body)| {
            let body = &self.world.bodies[*handle];
            BodyMotion { displacement: own(body.translation()) - rest.position, rotation: body.rotation().angle() }
        };
        self.handles.iter().zip(&self.assembly.bodies).map(motion).collect()
    }

    /// One step; afterwards all bodies are stopped if the kinetic energy has passed its peak, and `true` is returned.
    pub(crate) fn damped_step(&mut self, loads: &[BodyLoad]) -> bool {
        self.step(loads);
        let energy = self.kinetic_energy();
        let peak_passed = energy <= self.energy;
        self.energy = if peak_passed { 0.0 } else { energy };
        if peak_passed {
            self.stop();
        }
        peak_passed
    }

    /// Steps until the lattice rests.
    ///
    /// # Errors
    /// [`LatticeError::NotSettled`] with the last residual if it does not within `most_steps`.
    pub(crate) fn settle(&mut self, loads: &[BodyLoad], most_steps: usize) -> Result<Rest, LatticeError> {
        let mut steps = 1;
        while !self.damped_step(loads) && steps < most_steps {
            steps += 1;
        }
        self.watch(loads, (PATIENCE * steps).max(SHORTEST_WATCH), steps, most_steps)
    }

    /// Goes on after `steps` until no moving body has moved for as long as a `watch` lasts, in steps.
    ///
    /// # Errors
    /// [`LatticeError::NotSettled`] with the last residual if they still move after `most_steps`.
    pub(crate) fn watch(
        &mut self,
        loads: &[BodyLoad],
        watch: usize,
        mut steps: usize,
        most_steps: usize,
    ) -> Result<Rest, LatticeError> {
        let resolution_mm =
            RESOLUTION * self.assembly.bodies.iter().map(|body| body.position.norm()).fold(0.0, f64::max);
        let mut residual = f64::INFINITY;
        while steps + watch <= most_steps {
            let before = self.displacements();
            for _ in 0..watch {
                self.damped_step(loads);
            }
            steps += watch;
            let now = self.displacements();
            let moved = before.iter().zip(&now).map(|(a, b)| (*b - *a).length()).fold(0.0, f64::max);
            let largest = now.iter().map(|displacement| displacement.length()).fold(0.0, f64::max);
            residual = moved / largest.max(resolution_mm);
            if residual <= AT_REST {
                return Ok(Rest { watch, steps, residual });
            }
        }
        Err(LatticeError::NotSettled { steps, residual })
    }
}

/// Mass and moment of inertia of every body: dt^2 k / softness, with the stiffness k that the lattice at rest sets against the
/// body's own motion.
fn inertia(assembly: &Assembly) -> Vec<(f64, f64)> {
    let energy = Energy::new(assembly);
    let at_rest = vec![BodyMotion::default(); assembly.bodies.len()];
    let mut stiffness = vec![0.0; energy.unknown_count()];
    for entry in energy.expand(&at_rest, &[], 0.0).curvature {
        if entry.row == entry.col {
            stiffness[entry.row] += entry.val;
        }
    }
    let scale = STEP_S * STEP_S / SOFTNESS;
    let inertia = |body: usize| match energy.first_unknown(body) {
        Some(i) => (scale * stiffness[i].max(stiffness[i + 1]), scale * stiffness[i + 2]),
        None => (0.0, 0.0),
    };
    (0..assembly.bodies.len()).map(inertia).collect()
}
