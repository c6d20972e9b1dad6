//! Simulates the lattice in the physics engine rapier until all bodies rest.
//!
//! Only the position at rest is meaningful: masses, time step and damping are chosen for fast convergence. In every step, rapier solves for the
//! spring forces at the end of the step, by sweeps over the springs (projected Gauss-Seidel). The mass of a body is dt^2 times its stiffness, divided
//! by `SOFTNESS`. With these masses, the error decreases by the same factor per sweep in every lattice.
//!
//! Damping is kinetic: all bodies are stopped after each peak of the kinetic energy. The springs have no damping.
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

/// Time step, s. It only scales the masses. The time step must not be 1: rapier then treats a motor without force limit as a rigid constraint, which
/// it subtracts from the joint's other rows.
const STEP_S: f64 = 0.5;
/// Stiffness times dt^2 over mass, dimensionless. With a larger value, bodies move farther per step but need more sweeps for the same error.
const SOFTNESS: f64 = 4.0;
/// Sweeps over the springs per step. The remaining force residual shifts the position at rest; more sweeps reduce the shift. Rapier's warm start of
/// joints would not help. Rapier applies a joint's old impulse only when the sweep reaches the joint, and the result of a sweep does not depend on
/// its initial values.
pub const SWEEPS: usize = 32;

/// The lattice counts as at rest if, within the duration of its slowest motion, no body moves by more than this share of the largest displacement.
/// The slowest motion is assumed to last `PATIENCE` times the number of steps to the first peak of the kinetic energy.
pub const AT_REST: f64 = 2e-5;
/// Duration of the slowest motion, in units of the time to the first peak of the kinetic energy. The first peak comes a quarter of a period after the
/// start.
const PATIENCE: usize = 2;
/// Position checks are at least this number of steps apart.
const SHORTEST_WATCH: usize = 20;
/// The displacement scale in the test of rest is at least this share of the finger's size. Rounding of rapier's positions dominates smaller displacements.
const RESOLUTION: f64 = 1e-9;
/// Settling fails after this number of steps. With two segments per member the finger of Xu et al. (2021) needs 3000 steps, a spring-steel finger 22000.
/// Shorter segments need proportionally more.
pub const MOST_STEPS: usize = 200_000;

/// Numerical settings of settling. With the default settings, the lattice reaches the minimum of its energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling {
    /// Number of solver sweeps over the springs per time step.
    pub sweeps: usize,
    /// Precision of the stored positions.
    pub positions: Precision,
    /// Number of steps after which settling fails.
    pub most_steps: usize,
}

impl Default for Settling {
    fn default() -> Settling {
        Settling { sweeps: SWEEPS, positions: Precision::Double, most_steps: MOST_STEPS }
    }
}

/// Precision of the bodies' positions and rotations between steps. All other numbers are in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Stored in 64 bits.
    Double,
    /// Rounded to 32 bits after each step.
    Single,
}

impl Precision {
    /// Rounds a number to this precision.
    pub fn round(self, x: f64) -> f64 {
        match self {
            Precision::Double => x,
            Precision::Single => f64::from(x as f32),
        }
    }
}

/// Result of settling: number of steps until rest, and the last movement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    /// Number of steps between two position checks.
    pub watch: usize,
    /// Number of time steps taken.
    pub steps: usize,
    /// Largest movement between the last two position checks, relative to the largest displacement.
    pub residual: f64,
}

/// Bodies and joints of a lattice in a rapier world.
pub(crate) struct Dynamics<'a> {
    assembly: &'a Assembly,
    /// The rapier world.
    pub(crate) world: PhysicsWorld,
    /// Handles of the lattice's bodies, in the order of the bodies.
    pub(crate) handles: Vec<RigidBodyHandle>,
    /// All moving bodies: the bodies of the lattice, then other bodies, such as a pressed object.
    moving: Vec<Moving>,
    /// Precision of the stored positions.
    positions: Precision,
    /// Kinetic energy after the last step, N mm.
    energy: f64,
}

/// A moving body, with its initial position (mm), mass and moment of inertia.
struct Moving {
    handle: RigidBodyHandle,
    start: RapierVector,
    mass: f64,
    moment: f64,
}

/// Converts a vector to rapier's type.
pub(crate) fn rapier(vector: Vector) -> RapierVector {
    RapierVector::new(vector.x, vector.y)
}

/// Converts a vector from rapier's type.
pub(crate) fn own(vector: RapierVector) -> Vector {
    Vector::new(vector.x, vector.y)
}

/// Mass with which a body of the given stiffness (N/mm) converges as fast as the lattice's bodies.
pub(crate) fn mass_for(stiffness: f64) -> f64 {
    STEP_S * STEP_S * stiffness / SOFTNESS
}

/// A rapier joint that acts like the spring. The joint's motor applies a force, not an acceleration, proportional to the deformation.
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
    /// Puts the lattice, at rest and undeformed, into an empty rapier world without gravity; `how` specifies the number of sweeps and the precision.
    pub(crate) fn new(assembly: &'a Assembly, how: &Settling) -> Dynamics<'a> {
        let mut world = PhysicsWorld::new();
        world.gravity = RapierVector::ZERO;
        world.integration_parameters = IntegrationParameters {
            dt: STEP_S,
            num_solver_iterations: 1,
            num_internal_pgs_iterations: how.sweeps,
            num_internal_stabilization_iterations: 0,
            max_ccd_substeps: 0,
            contact_recycling: false,
            normalized_max_linear_velocity: f64::MAX,
            normalized_max_corrective_velocity: f64::MAX,
            ..IntegrationParameters::default()
        };
        let positions = how.positions;
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

    /// Adds a moving body at `position` (mm), with its mass and moment of inertia.
    pub(crate) fn insert_moving(&mut self, position: Vector, mass: f64, moment: f64) -> RigidBodyHandle {
        let start = rapier(position);
        let properties = MassProperties::new(RapierVector::ZERO, mass, moment);
        let body = RigidBodyBuilder::dynamic().additional_mass_properties(properties).translation(start);
        let handle = self.world.bodies.insert(body.can_sleep(false));
        self.moving.push(Moving { handle, start, mass, moment });
        handle
    }

    /// Advances one step under dead loads.
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

    /// Rounds positions and rotations to the stored precision.
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

    /// Moves the lattice's bodies to the poses of the given motions, and sets their velocities to zero.
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

    /// Displacement of every moving body from its initial position, mm.
    fn displacements(&self) -> Vec<RapierVector> {
        self.moving.iter().map(|moving| self.world.bodies[moving.handle].translation() - moving.start).collect()
    }

    /// Motion of every body of the lattice from its undeformed pose. Rotations are between -pi and pi, rad.
    pub(crate) fn motions(&self) -> Vec<BodyMotion> {
        let motion = |(handle, rest): (&RigidBodyHandle, &super::bodies::Body)| {
            let body = &self.world.bodies[*handle];
            BodyMotion { displacement: own(body.translation()) - rest.position, rotation: body.rotation().angle() }
        };
        self.handles.iter().zip(&self.assembly.bodies).map(motion).collect()
    }

    /// Advances one step, then stops all bodies if the kinetic energy has passed its peak. Returns whether the energy has passed its peak.
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

    /// Simulates until the lattice rests.
    ///
    /// # Errors
    /// [`LatticeError::NotSettled`] with the last residual if the lattice still moves after `most_steps`.
    pub(crate) fn settle(&mut self, loads: &[BodyLoad], most_steps: usize) -> Result<Rest, LatticeError> {
        let mut steps = 1;
        while !self.damped_step(loads) && steps < most_steps {
            steps += 1;
        }
        self.watch(loads, (PATIENCE * steps).max(SHORTEST_WATCH), steps, most_steps)
    }

    /// Simulates from step `steps` on, until no body moves by more than the share [`AT_REST`] of the largest displacement during `watch` steps.
    ///
    /// # Errors
    /// [`LatticeError::NotSettled`] with the last residual if bodies still move after `most_steps`.
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

/// Mass and moment of inertia of every body: dt^2 k / softness. The stiffness k is a diagonal entry of the undeformed lattice's stiffness matrix. For
/// the mass, k is the larger translational entry; for the moment of inertia, k is the rotational entry.
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
