//! Read access to fingers, object and contacts in equilibrium.

use super::motion::AT_REST;
use super::{Account, ObjectContact, TouchedBody, World};
use crate::energy::BodyMotion;
use crate::grasp::contact::Touching;
use crate::grasp::near::{ContactPair, touched};
use crate::grasp::surface::Shape;
use crate::skin::Touch;
use finray_model::Vector;
use finray_model::gripper::Placement;
use finray_model::mesh::FingerShape;
use nalgebra::Rotation2;

impl World<'_> {
    /// Work and energy since the start of the grasp.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// Elastic energy of the fingers, N mm.
    pub fn elastic_nmm(&self) -> f64 {
        let fingers = self.scene.fingers.iter().zip(&self.state.motions);
        fingers
            .map(|(standing, motions)| standing.energy.springs(motions).map(|spring| spring.energy).sum::<f64>())
            .sum()
    }

    /// Position of the object, mm, and its angle, rad, world frame.
    pub fn object(&self) -> [f64; 3] {
        self.state.object
    }

    /// Outline of the object.
    pub fn shape(&self) -> &Shape {
        &self.scene.shape
    }

    /// Placements of the fingers in the world.
    pub fn placements(&self) -> &[Placement] {
        &self.drive.placements
    }

    /// Stiffness of the softest undeformed finger at its middle, N/mm; the scale for tolerances and numerical resistance.
    pub fn stiffness(&self) -> f64 {
        self.scene.stiffness
    }

    /// Motions of a finger's bodies, in the finger's frame.
    pub fn motions(&self, finger: usize) -> &[BodyMotion] {
        &self.state.motions[finger]
    }

    /// Displacements and rotations of a finger's key nodes, in the finger's frame.
    pub fn finger_shape(&self, finger: usize) -> FingerShape {
        self.scene.fingers[finger].lattice.shape(&self.state.motions[finger])
    }

    /// Force (N) and moment about the origin (N mm) on a finger's base, in the finger's frame. Both include the springs and the contacts on clamped parts.
    pub fn on_base(&self, finger: usize) -> (Vector, f64) {
        let (mut force, mut moment) = self.scene.fingers[finger].energy.on_clamps(&self.state.motions[finger]);
        let contacts = self.contacts();
        let touches = contacts
            .iter()
            .filter(|contact| contact.partner == TouchedBody::Finger(finger))
            .filter_map(|contact| contact.touch);
        for touch in touches.filter(|touch| touch.clamped) {
            force += touch.force;
            moment += touch.point.perp(&touch.force);
        }
        (force, moment)
    }

    /// Contacts that carry a force, from base to tip on each finger. A contact is omitted if the numerical resistance at rest could cause its force.
    /// An object that rolls away freely is therefore listed without contact.
    pub fn contacts(&self) -> Vec<ObjectContact> {
        let normals_n = self.state.forces.values().map(|[normal_n, _]| *normal_n);
        let nothing_n = AT_REST * normals_n.fold(self.drive.weight.norm(), f64::max);
        let mut contacts: Vec<ObjectContact> = self
            .near_pairs()
            .iter()
            .filter_map(|pair| {
                let [normal_n, friction_n] = self.state.forces.get(&pair.key).copied()?;
                (normal_n > nothing_n).then(|| self.contact_of(pair, normal_n, friction_n))
            })
            .collect();
        let place = |contact: &ObjectContact| match (contact.partner, contact.touch) {
            (TouchedBody::Finger(finger), Some(touch)) => {
                (finger, touch.part.position_mm(self.scene.fingers[finger].lattice))
            }
            _ => (usize::MAX, 0.0),
        };
        contacts.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(std::cmp::Ordering::Equal));
        contacts
    }

    fn contact_of(&self, pair: &ContactPair, normal_n: f64, friction_n: f64) -> ObjectContact {
        let Touching { normal, point, slip_mm, gap_mm, .. } = pair.touching;
        let on_finger = normal * normal_n + Vector::new(-normal.y, normal.x) * friction_n;
        let touch = pair.part.map(|part| {
            let finger = pair.key.0;
            let placement = self.state.placements[finger];
            let inwards = |vector: Vector| placement.axes().transpose() * vector;
            let (body, motion) = (
                self.scene.fingers[finger].lattice.assembly().bodies[part.body],
                self.state.motions[finger][part.body],
            );
            let at = placement.inwards(point);
            let arm = Rotation2::new(-motion.rotation) * (at - body.position - motion.displacement);
            Touch {
                body: part.body,
                part: touched(&part, arm),
                clamped: body.fixed,
                point: at,
                arm,
                normal: inwards(normal),
                force: inwards(on_finger),
                overlap_mm: -gap_mm,
            }
        });
        ObjectContact { partner: self.partner(pair), point, force: -on_finger, slip_mm, touch }
    }
}
