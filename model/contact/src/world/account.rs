//! Energy balance of a grasp: work of the moving bases, compared with elastic energy, weight, friction and numerical resistance.

use super::{Drive, Moment, World};
use crate::scene::{State, Surroundings};
use crate::status::ContactPair;
use finray_model::Vector;
use finray_model::frame::FrameMotion;
use nalgebra::Rotation2;
use serde::Serialize;

/// Work and energy since the start of a grasp, N mm.
///
/// Each work term is an integral of forces over displacements, by the trapezoidal rule over the increments of the bases. The elastic energy is the
/// energy of the springs. No value is computed from the others, so an imbalance shows an error of the integration or of the forces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Account {
    /// Work done by the bases and by the numerical resistance that carries an object along with the gripper, N mm.
    pub driven_nmm: f64,
    /// Elastic energy of the fingers, N mm.
    pub elastic_nmm: f64,
    /// Work against the weight, N mm.
    pub lifted_nmm: f64,
    /// Work dissipated by friction, N mm.
    pub friction_nmm: f64,
    /// Work against the numerical resistance during snaps and while the object comes to rest, N mm.
    pub resistance_nmm: f64,
    /// Largest decrease of [`lost_nmm`](Self::lost_nmm) below its maximum so far, N mm: energy created by numerical errors.
    pub created_nmm: f64,
    /// Sum of the absolute imbalances of all increments, N mm: an estimate of the error of all work integrals.
    pub error_nmm: f64,
    #[serde(skip)]
    most_lost_nmm: f64,
}

impl Account {
    /// Driven work minus elastic energy and work against the weight, N mm.
    pub fn lost_nmm(&self) -> f64 {
        self.driven_nmm - self.elastic_nmm - self.lifted_nmm
    }

    /// Driven work that no other entry accounts for, N mm.
    pub fn missing_nmm(&self) -> f64 {
        self.lost_nmm() - self.friction_nmm - self.resistance_nmm
    }

    /// Adds the work and energy of one increment.
    pub(super) fn book(&mut self, part: &Account) {
        self.driven_nmm += part.driven_nmm;
        self.elastic_nmm += part.elastic_nmm;
        self.lifted_nmm += part.lifted_nmm;
        self.friction_nmm += part.friction_nmm;
        self.resistance_nmm += part.resistance_nmm;
        self.error_nmm += part.missing_nmm().abs();
        self.most_lost_nmm = self.most_lost_nmm.max(self.lost_nmm());
        self.created_nmm = self.created_nmm.max(self.most_lost_nmm - self.lost_nmm());
    }
}

/// Forces at one state, without the contact forces, and the elastic energy at this state.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Acting {
    elastic_nmm: f64,
    /// Force (N) on the base of each finger, and moment (N mm) about the origin of the finger's frame; both in the world frame.
    on_bases: Vec<(Vector, f64)>,
    weight: Vector,
    /// Numerical resistance to the motion of the object in x (N), in y (N) and in rotation (N mm), and of each key node in its finger's frame (N;
    /// empty without resistance).
    on_object: [f64; 3],
    on_nodes: Vec<Vec<Vector>>,
}

impl World<'_> {
    /// Forces at the current state, including the numerical resistance of the step that led to it.
    pub(super) fn acting(&self, around: &Surroundings, pairs: &[ContactPair]) -> Acting {
        let (Moment { state, before, .. }, drags) = (&self.now, self.scene.drags(around));
        let from = around.carried_from(before.object);
        let resisting = |finger: usize| {
            let key_nodes = self.scene.fingers[finger].mesh.finger().key_node_count();
            let [now, then] = [state, before].map(|state: &State| &state.motions[finger].displacements[..key_nodes]);
            let is_acting = around.finger_drag > 0.0;
            let nodes = now.iter().zip(then).filter(|_| is_acting);
            nodes.map(|(now, then)| (now - then) * around.finger_drag).collect()
        };
        Acting {
            elastic_nmm: self.elastic_nmm(),
            on_bases: self.on_bases(pairs),
            weight: around.weight,
            on_object: [0, 1, 2].map(|i| drags[i] * (state.object[i] - from[i])),
            on_nodes: (0..self.scene.fingers.len()).map(resisting).collect(),
        }
    }

    /// Energy balance of the last solved increment. The increment begins with the placements `drive` and the forces `start`.
    pub(super) fn booked(&self, drive: &Drive, start: &Acting, pairs: &[ContactPair]) -> Account {
        let Moment { acting: end, before: from, state: to, drive: there, .. } = &self.now;
        let mean = |of: &dyn Fn(&Acting) -> f64| 0.5 * (of(start) + of(end));
        let of_bases = |acting: &Acting| -> f64 {
            let of_base = |(finger, (force, moment_nmm)): (usize, &(Vector, f64))| {
                let [a, b] = [drive, there].map(|drive| drive.placements[finger]);
                -force.dot(&(b.origin - a.origin)) - moment_nmm * (b.angle_rad - a.angle_rad)
            };
            acting.on_bases.iter().enumerate().map(of_base).sum()
        };
        let carried = there.gripper - drive.gripper;
        let of_medium = |acting: &Acting| -Vector::new(acting.on_object[0], acting.on_object[1]).dot(&carried);
        let raised = self.centre_mm(to) - self.centre_mm(from);
        let against_weight = |acting: &Acting| -acting.weight.dot(&raised);
        let [x, y, angle] = [0, 1, 2].map(|i| to.object[i] - from.object[i]);
        let way = [x - carried.x, y - carried.y, angle];
        let against_resistance = |acting: &Acting| -> f64 {
            let of_object: f64 = acting.on_object.iter().zip(way).map(|(force, way)| force * way).sum();
            let moved = |(a, b): (&FrameMotion, &FrameMotion), forces: &Vec<Vector>| -> f64 {
                let nodes = a.displacements.iter().zip(&b.displacements);
                forces.iter().zip(nodes).map(|(force, (a, b))| force.dot(&(b - a))).sum()
            };
            let fingers = from.motions.iter().zip(&to.motions).zip(&acting.on_nodes);
            of_object + fingers.map(|(motions, forces)| moved(motions, forces)).sum::<f64>()
        };
        let of_friction = |pair: &ContactPair| {
            let [then, now] = [from, to].map(|state| state.forces.get(&pair.key).map_or(0.0, |forces| forces[1]));
            -0.5 * (then + now) * pair.touching.slip_mm
        };
        Account {
            driven_nmm: mean(&|acting| of_bases(acting) + of_medium(acting)),
            elastic_nmm: end.elastic_nmm - start.elastic_nmm,
            lifted_nmm: mean(&against_weight),
            friction_nmm: pairs.iter().map(of_friction).sum(),
            resistance_nmm: mean(&against_resistance),
            ..Account::default()
        }
    }

    fn centre_mm(&self, state: &State) -> Vector {
        let [x, y, angle] = state.object;
        Vector::new(x, y) + Rotation2::new(angle) * self.scene.centre
    }
}
