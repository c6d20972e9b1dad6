//! An object pressed onto the lattice in the physics engine rapier, to verify presses that were computed on beams.
//!
//! The object is a rigid body that does not rotate. The object touches only the [`skin`](crate::skin) of the plates; the finger does not touch
//! itself. A "hand" moves the object to a prescribed position, or pulls the object with a force. A stiff spring keeps a pulled object on the line
//! along which it is pulled.
//!
//! In every step the bodies come to rest as in [`settling`], starting from the previous step or from an equilibrium to be verified. Without friction,
//! rapier and Newton's method on beams reach the same equilibrium, up to the discretisation of the lattice. With friction the rest state is not unique: within the friction cone, the rest state
//! depends on the simulated motion. An equilibrium with friction is therefore used as the initial state: rapier, with its own contacts, must stay
//! there.

use crate::energy::{BodyMotion, Energy};
use crate::settling::{self, Dynamics, Settling, mass_for, own, rapier};
use crate::skin::{Skin, add_skin, groups_of_object, require_one_thickness};
use crate::springs::BodyIndex;
use crate::{Lattice, LatticeError};
use finray_contact::outline::ContactOutline;
use finray_contact::path::PreparedObject;
use finray_contact::pressing::{Pressed, Push};
use finray_contact::{ContactError, Touch, TouchedPart, Wall};
use finray_model::Vector;
use finray_model::finger::{Part, Plate, PlatePosition};
use finray_model::mesh::Load;
use rapier2d::parry::transformation::hertel_mehlhorn;
use rapier2d::prelude::{
    CoefficientCombineRule, ColliderBuilder, ColliderHandle, GenericJointBuilder, JointAxesMask, JointAxis, MotorModel,
    Pose, RigidBodyBuilder, RigidBodyHandle, RigidBodyType, SharedShape, SolverContact, Vector as RapierVector,
};

/// A lattice with an object in front of its front plate, in the physics engine.
pub struct EnginePressing<'l> {
    lattice: &'l Lattice,
    dynamics: Dynamics<'l>,
    object: RigidBodyHandle,
    collider: ColliderHandle,
    hand: RigidBodyHandle,
    /// Body and part of the finger that each collider represents, indexed by the collider's user data.
    parts: Vec<(BodyIndex, Skin)>,
    /// Stiffness with which the hand guides a pulled object, N/mm.
    stiffness: f64,
    /// Unit vector along which the object is pressed.
    along: Vector,
    /// Number of steps between two position checks.
    watch: usize,
    /// Largest displacement of the hand (mm) and largest change of its pull (N) during `watch` steps.
    pace: (f64, f64),
    /// Last position or pull of the hand.
    last: Push,
    /// Last pull under which the object touched the finger, N; `None` before the first contact.
    touched_n: Option<f64>,
}

/// Distance within which the engine predicts contacts, as a share of the front plate's length. Per step, no body moves by more than half of the
/// prediction distance, so no body passes through another undetected.
const FORESIGHT: f64 = 1.0 / 150.0;
/// The object counts as merely touching the finger at the start if the overlap is at most this share of the front plate's length.
const OVERLAP: f64 = 1e-5;
/// Displacement of the hand during one period of the finger's slowest motion, as a share of the front plate's length. At this speed the finger
/// follows the hand: the object does not pass through the finger, and the finger does not swing back over the object.
const WAY: f64 = 1.0 / 75.0;
/// Same as [`WAY`], with friction. The displacement is smaller than without friction, because with friction the rest state depends on every slip on
/// the path.
const WAY_WITH_FRICTION: f64 = 1.0 / 300.0;
/// Settling fails if the bodies do not rest within this number of steps after the hand has stopped. The finger of Xu et al. (2021) needs 2000 steps
/// with two segments per member.
const MOST_STEPS: usize = 50_000;
/// Number of position checks between two tests of whether the object still touches the finger.
const LOOKS: usize = 8;
/// Displacement of the finger's middle in the test that measures the slowest motion, as a share of the front plate's length. The displacement is
/// small enough for the finger to respond linearly.
const PROBE: f64 = 1e-3;
/// A force under which every finger responds linearly, N.
const TINY_N: f64 = 1e-9;

impl<'l> EnginePressing<'l> {
    /// Places the object at its start, clear of the finger.
    ///
    /// # Errors
    /// [`ContactError::Overlap`] if the object overlaps the finger at the start, [`ContactError::Tapered`] if the front plate tapers,
    /// [`LatticeError::NotSettled`] if the finger does not come to rest even without the object.
    pub fn new(
        lattice: &'l Lattice,
        rod_radius_mm: f64,
        object: &PreparedObject,
    ) -> Result<EnginePressing<'l>, LatticeError> {
        let &PreparedObject { start, along, .. } = object;
        let assembly = lattice.assembly();
        require_one_thickness(lattice)?;
        let length_mm = lattice.finger().plate_length_mm(Plate::Front);
        let (watch, middle_stiffness) = slowest_motion(lattice)?;
        let mut dynamics = Dynamics::new(assembly, &Settling::default());
        let parameters = &mut dynamics.world.integration_parameters;
        parameters.normalized_prediction_distance = FORESIGHT * length_mm;
        parameters.normalized_max_linear_velocity = 0.5 * FORESIGHT * length_mm / parameters.dt;
        let parts = add_skin(lattice, rod_radius_mm, object.friction, &mut dynamics);

        let finger = lattice.finger();
        let member_mm = finger.plate_length_mm(Plate::Front) / (finger.rib_count() + 1) as f64;
        let stiffness = finger.section(Part::Front).map_or(1.0, |section| section.axial_rigidity_n / member_mm);
        let hand = dynamics.world.bodies.insert(RigidBodyBuilder::fixed().translation(rapier(start)));
        // The object cannot rotate, so its moment of inertia has no effect.
        let body = dynamics.insert_moving(start, mass_for(stiffness), 1.0);
        dynamics.world.bodies[body].lock_rotations(true, true);
        let collider = ColliderBuilder::new(engine_shape(&object.outline))
            .density(0.0)
            .friction(object.friction)
            .friction_combine_rule(CoefficientCombineRule::Min)
            .collision_groups(groups_of_object());
        let world = &mut dynamics.world;
        let collider = world.colliders.insert_with_parent(collider, body, &mut world.bodies);
        let mut joint = GenericJointBuilder::new(JointAxesMask::empty());
        let across = JointAxis::LinY;
        joint = joint.motor_model(across, MotorModel::ForceBased).motor_position(across, 0.0, stiffness, 0.0);
        let mut joint = joint.build();
        let turn = along.y.atan2(along.x);
        joint.local_frame1 = Pose::new(rapier(Vector::zeros()), turn);
        joint.local_frame2 = joint.local_frame1;
        world.impulse_joints.insert(hand, body, joint, true);
        world.detect_collisions(&(), &());
        let overlap_mm = world
            .narrow_phase
            .contact_pairs_with(collider)
            .flat_map(|pair| pair.manifolds())
            .flat_map(|manifold| &manifold.points)
            .fold(0.0, |most: f64, point| most.max(-point.dist));
        if overlap_mm > OVERLAP * length_mm {
            return Err(ContactError::Overlap { part: None, overlap_mm }.into());
        }
        let way_mm = length_mm * if object.friction > 0.0 { WAY_WITH_FRICTION } else { WAY };
        let pace = (way_mm, way_mm * middle_stiffness);
        let last = Push::To(start);
        Ok(EnginePressing {
            lattice,
            dynamics,
            object: body,
            collider,
            hand,
            parts,
            stiffness,
            along,
            watch,
            pace,
            last,
            touched_n: None,
        })
    }

    /// Moves the hand slowly to a new position, or slowly changes its pull, without waiting for rest. Returns the number of steps.
    ///
    /// # Errors
    /// [`ContactError::LetGo`] if a pulled object loses contact with the finger.
    pub fn pass(&mut self, push: Push) -> Result<usize, LatticeError> {
        let from = self.last;
        let steps = self.steps_on_the_way(from, push);
        // Steps since a pulled object lost contact; `None` before its first contact.
        let mut untouched = None;
        for step in 1..=steps {
            let at = from.towards(push, step as f64 / steps as f64);
            self.drive(at);
            self.dynamics.damped_step(&[]);
            let Push::With(force_n) = at else { continue };
            untouched = match self.touches_anything() {
                true => {
                    self.touched_n = Some(force_n);
                    Some(0)
                }
                false => untouched.map(|steps| steps + 1),
            };
            if untouched.is_some_and(|steps| steps >= LOOKS * self.watch) {
                return Err(self.lets_go());
            }
        }
        self.last = push;
        Ok(steps)
    }

    /// Moves the hand slowly to a new position, or slowly changes its pull, and simulates until all bodies rest.
    ///
    /// # Errors
    /// [`ContactError::LetGo`] if a pulled object loses contact with the finger, [`LatticeError::NotSettled`] if the bodies do not come to rest.
    pub fn push(&mut self, push: Push) -> Result<Pressed, LatticeError> {
        let steps = self.pass(push)?;
        self.rest(push, steps)
    }

    /// Sets the lattice's bodies to `motions` and the object's reference point to `object` (mm, finger frame), which are close to an equilibrium under
    /// `push`, and simulates until all bodies rest.
    ///
    /// # Errors
    /// As for [`push`](Self::push).
    pub fn hold(&mut self, motions: &[BodyMotion], object: Vector, push: Push) -> Result<Pressed, LatticeError> {
        self.dynamics.place(motions);
        self.dynamics.world.bodies[self.object].set_translation(rapier(object), true);
        self.last = push;
        self.rest(push, 0)
    }

    /// Simulates until all bodies rest; `steps` is the number of steps already taken.
    fn rest(&mut self, push: Push, steps: usize) -> Result<Pressed, LatticeError> {
        self.drive(push);
        self.settle(push, steps)?;
        let motions = self.dynamics.motions();
        let touched = self.touches(&motions);
        let touches: Vec<Touch> = touched.iter().map(|(_, touch)| *touch).collect();
        let object = own(self.dynamics.world.bodies[self.object].translation());
        let hand_force = match push {
            Push::To(_) => touches.iter().map(|touch| touch.force).sum(),
            Push::With(force_n) => {
                let off = own(self.dynamics.world.bodies[self.hand].translation()) - object;
                (off - self.along * off.dot(&self.along)) * self.stiffness + self.along * force_n
            }
        };
        let energy = Energy::new(self.lattice.assembly());
        let base = energy.stiff_base();
        let (mut base_force, mut base_moment_nmm) = energy.on_bodies(&motions, &base);
        for (_, touch) in touched.iter().filter(|(body, _)| base[*body]) {
            base_force += touch.force;
            base_moment_nmm += touch.point.perp(&touch.force);
        }
        let shape = self.lattice.shape(&motions);
        Ok(Pressed { shape, object, touches, hand_force, base_force, base_moment_nmm })
    }

    fn lets_go(&self) -> LatticeError {
        ContactError::LetGo { touched_n: self.touched_n }.into()
    }

    /// Simulates until all bodies rest. Returns the total number of steps, including the `steps` taken before.
    fn settle(&mut self, push: Push, mut steps: usize) -> Result<usize, LatticeError> {
        let most_steps = steps + MOST_STEPS;
        loop {
            let until = (steps + LOOKS * self.watch).min(most_steps);
            match self.dynamics.watch(&[], self.watch, steps, until) {
                Ok(rest) => return Ok(rest.steps),
                // A pulled object without contact never comes to rest.
                Err(_) if matches!(push, Push::With(_)) && !self.touches_anything() => return Err(self.lets_go()),
                Err(error) if until + self.watch > most_steps => return Err(error),
                Err(_) => {
                    if let Push::With(force_n) = push {
                        self.touched_n = Some(force_n);
                    }
                    steps = until;
                }
            }
        }
    }

    /// Number of steps in which the hand moves to another position or changes its pull.
    fn steps_on_the_way(&self, from: Push, to: Push) -> usize {
        let (way_mm, change_n) = self.pace;
        let way = match (from, to) {
            (Push::To(from), Push::To(to)) => (to - from).norm() / way_mm,
            (Push::With(from), Push::With(to)) => (to - from).abs() / change_n,
            (Push::To(_), Push::With(to)) => to.abs() / change_n,
            (Push::With(_), Push::To(_)) => 1.0,
        };
        (way * self.watch as f64).ceil() as usize
    }

    /// Moves the object to the hand's position, or applies the pull to the object.
    fn drive(&mut self, push: Push) {
        let object = &mut self.dynamics.world.bodies[self.object];
        object.reset_forces(true);
        match push {
            Push::To(position) => {
                object.set_body_type(RigidBodyType::KinematicPositionBased, true);
                object.set_next_kinematic_translation(rapier(position));
            }
            Push::With(force_n) => {
                object.set_body_type(RigidBodyType::Dynamic, true);
                object.add_force(rapier(self.along * force_n), true);
            }
        }
    }

    /// Whether the object presses on the finger.
    fn touches_anything(&self) -> bool {
        let pairs = self.dynamics.world.narrow_phase.contact_pairs_with(self.collider);
        pairs.flat_map(|pair| pair.manifolds()).any(|manifold| {
            let of = |contact: &SolverContact| &manifold.points[point_of(contact)].data;
            manifold.data.solver_contacts.iter().any(|contact| of(contact).impulse > 0.0)
        })
    }

    /// Contacts with the forces that the engine computed, each with the body that carries the force.
    fn touches(&self, motions: &[BodyMotion]) -> Vec<(BodyIndex, Touch)> {
        let world = &self.dynamics.world;
        let dt = world.integration_parameters.dt;
        let mut touches = Vec::new();
        for pair in world.narrow_phase.contact_pairs_with(self.collider) {
            let object_first = pair.collider1 == self.collider;
            let skin = if object_first { pair.collider2 } else { pair.collider1 };
            let index = world.colliders[skin].user_data as usize;
            let (body, part) = self.parts[index];
            for manifold in pair.manifolds() {
                // The engine's normal points from the first body of the contact to the second.
                let normal = own(manifold.data.normal) * if object_first { 1.0 } else { -1.0 };
                for contact in &manifold.data.solver_contacts {
                    let data = &manifold.points[point_of(contact)];
                    let (first, second) = manifold.data.solver_contact_world_points(contact, &world.bodies);
                    let (on_object, on_finger) = if object_first { (first, second) } else { (second, first) };
                    let (on_object, on_finger) = (own(on_object), own(on_finger));
                    let tangent = Vector::new(-normal.y, normal.x);
                    let force = (normal * data.data.impulse + tangent * data.data.tangent_impulse[0]) / dt;
                    if data.data.impulse <= 0.0 {
                        continue;
                    }
                    let rest = &self.lattice.assembly().bodies[body];
                    let motion = &motions[body];
                    let turned_back = BodyMotion { displacement: Vector::zeros(), rotation: -motion.rotation };
                    let arm = turned_back.carried(on_finger - rest.position - motion.displacement);
                    let touch = Touch {
                        part: match part {
                            Skin::Rod(node) => TouchedPart::Rod(node),
                            Skin::Plate { from: PlatePosition { plate, s_mm }, from_arm } => TouchedPart::On(
                                if plate == Plate::Front { Wall::Front } else { Wall::Back },
                                s_mm + (arm - from_arm).dot(&self.lattice.finger().tangent(plate)),
                            ),
                        },
                        clamped: rest.fixed,
                        point: on_finger,
                        normal,
                        force,
                        overlap_mm: (on_object - on_finger).dot(&normal),
                    };
                    touches.push((body, touch));
                }
            }
        }
        let place = |(_, touch): &(BodyIndex, Touch)| touch.part.place(self.lattice.finger());
        touches.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(std::cmp::Ordering::Equal));
        touches
    }
}

/// The outline of an object for the physics engine; a non-convex outline is divided into convex pieces.
fn engine_shape(outline: &ContactOutline) -> SharedShape {
    let (corners, disc_mm) = outline.corners();
    if disc_mm > 0.0 {
        return SharedShape::ball(disc_mm);
    }
    let vertices: Vec<RapierVector> = corners.iter().map(|corner| rapier(*corner)).collect();
    let pieces = hertel_mehlhorn(&vertices, &outline.triangles()).into_iter().filter_map(SharedShape::convex_polyline);
    let mut pieces: Vec<(Pose, SharedShape)> = pieces.map(|piece| (Pose::IDENTITY, piece)).collect();
    if pieces.len() == 1 { pieces.swap_remove(0).1 } else { SharedShape::compound(pieces) }
}

/// Index of a solver contact within the points of its contact manifold.
fn point_of(contact: &SolverContact) -> usize {
    (contact.contact_id[0] & 0x7fff_ffff) as usize
}

/// Duration (in steps) of the finger's slowest motion, as measured by [`Dynamics::settle`], and stiffness (N/mm) of the finger at its middle.
fn slowest_motion(lattice: &Lattice) -> Result<(usize, f64), LatticeError> {
    let finger = lattice.finger();
    let middle = finger.contact_nodes().nth(finger.contact_nodes().len() / 2).unwrap_or(finger.tip());
    let push = |force_n: f64| Load::at_node(middle, finger.direction(0.0) * force_n);
    let stiffness = TINY_N / lattice.equilibrium(&[push(TINY_N)])?.largest_displacement_mm();
    let probe_n = PROBE * finger.plate_length_mm(Plate::Front) * stiffness;
    let loads = lattice.body_loads(&[push(probe_n)])?;
    Ok((Dynamics::new(lattice.assembly(), &Settling::default()).settle(&loads, settling::MOST_STEPS)?.watch, stiffness))
}
