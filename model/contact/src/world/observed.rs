//! Read access to fingers, object and contacts in equilibrium.

use super::motion::AT_REST;
use super::{Account, ObjectContact, TouchedBody, World};
use crate::Touch;
use crate::outline::ContactOutline;
use crate::pair::Touching;
use crate::status::{ContactPair, touched};
use finray_model::frame::FrameMotion;
use finray_model::gripper::Placement;
use finray_model::mesh::FingerShape;
use finray_model::statics::{elastic_energy, reaction};
use finray_model::{Kinematics, Vector};

impl World<'_> {
    /// Work and energy since the start of the grasp.
    pub fn account(&self) -> &Account {
        &self.now.account
    }

    /// Elastic energy of the fingers, N mm.
    pub fn elastic_nmm(&self) -> f64 {
        let fingers = self.scene.fingers.iter().zip(&self.now.state.motions);
        fingers.map(|(finger, motion)| elastic_energy(finger.mesh.frame(), motion, Kinematics::Corotational)).sum()
    }

    /// Position of the object, mm, and its angle, rad, world frame.
    pub fn object(&self) -> [f64; 3] {
        self.now.state.object
    }

    /// Outline of the object.
    pub fn shape(&self) -> &ContactOutline {
        &self.scene.shape
    }

    /// Placements of the fingers in the world.
    pub fn placements(&self) -> &[Placement] {
        &self.now.drive.placements
    }

    /// Stiffness of the softest undeformed finger at its middle, N/mm; the scale for tolerances and numerical resistance.
    pub fn stiffness(&self) -> f64 {
        self.scene.stiffness
    }

    /// Motion of a finger's mesh, in the finger's frame.
    pub fn motion(&self, finger: usize) -> &FrameMotion {
        &self.now.state.motions[finger]
    }

    /// Displacements and rotations of a finger's key nodes, in the finger's frame.
    pub fn finger_shape(&self, finger: usize) -> FingerShape {
        self.scene.fingers[finger].mesh.shape(&self.now.state.motions[finger])
    }

    /// Force (N) and moment about the origin (N mm) on a finger's base, in the finger's frame: from the plates, and from the contacts on clamped parts.
    pub fn on_base(&self, finger: usize) -> (Vector, f64) {
        self.on_base_with(finger, &self.near_pairs())
    }

    /// Same as [`on_base`](Self::on_base), with the contact pairs at the present state.
    pub(super) fn on_base_with(&self, finger: usize, pairs: &[ContactPair]) -> (Vector, f64) {
        let (mesh, motion) = (self.scene.fingers[finger].mesh, &self.now.state.motions[finger]);
        let (mut force, mut moment_nmm) = (Vector::zeros(), 0.0);
        let mut add = |at: Vector, on_node: Vector, moment_on_node: f64| {
            force += on_node;
            moment_nmm += at.perp(&on_node) + moment_on_node;
        };
        for node in mesh.finger().clamped_nodes() {
            let held = reaction(mesh.frame(), motion, Kinematics::Corotational, &[], mesh.frame_node(node));
            add(mesh.finger().position(node), -held.force, -held.moment_nmm);
        }
        for pair in pairs.iter().filter(|pair| pair.key.0 == finger) {
            let Some(&forces) = self.now.state.forces.get(&pair.key) else { continue };
            let mounts = pair.pair.carrier.mounts();
            if !mounts.iter().flatten().any(|mount| mount.clamped) {
                continue;
            }
            let pull = pair.tangent(&self.now.state, &self.now.before).pull;
            let on = |i: usize| forces[0] * pull[0][i] + forces[1] * pull[1][i];
            for (i, mount) in mounts.iter().enumerate() {
                if let Some(mount) = mount.filter(|mount| mount.clamped) {
                    add(mount.position, Vector::new(on(3 * i), on(3 * i + 1)), on(3 * i + 2));
                }
            }
        }
        (force, moment_nmm)
    }

    /// Contacts that carry a force, from base to tip on each finger. A contact is omitted if the numerical resistance at rest could cause its force.
    /// An object that rolls away freely is therefore listed without contact.
    pub fn contacts(&self) -> Vec<ObjectContact> {
        let normals_n = self.now.state.forces.values().map(|[normal_n, _]| *normal_n);
        let nothing_n = AT_REST * normals_n.fold(self.now.drive.weight.norm(), f64::max);
        let mut contacts: Vec<ObjectContact> = self
            .near_pairs()
            .iter()
            .filter_map(|pair| {
                let [normal_n, friction_n] = self.now.state.forces.get(&pair.key).copied()?;
                (normal_n > nothing_n).then(|| self.contact_of(pair, normal_n, friction_n))
            })
            .collect();
        let place = |contact: &ObjectContact| match (contact.partner, contact.touch) {
            (TouchedBody::Finger(finger), Some(touch)) => {
                (finger, Some(touch.part.place(self.scene.fingers[finger].mesh.finger())))
            }
            _ => (usize::MAX, None),
        };
        contacts.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(std::cmp::Ordering::Equal));
        contacts
    }

    fn contact_of(&self, pair: &ContactPair, normal_n: f64, friction_n: f64) -> ObjectContact {
        let Touching { normal, point, slip_mm, gap_mm, .. } = pair.touching;
        let on_finger = normal * normal_n + Vector::new(-normal.y, normal.x) * friction_n;
        let touch = pair.part.map(|part| {
            let placement = self.now.state.placements[pair.key.0];
            let inwards = |vector: Vector| placement.axes().transpose() * vector;
            Touch {
                part: touched(&part, &pair.pair),
                clamped: part.carrier.is_fixed(),
                point: placement.inwards(point),
                normal: inwards(normal),
                force: inwards(on_finger),
                overlap_mm: -gap_mm,
            }
        });
        ObjectContact { partner: self.partner(pair), point, force: -on_finger, slip_mm, touch }
    }
}
