//! How the unloaded finger may differ from the scene's: it was assembled or mounted anew.
//!
//! Each joint then sits elsewhere by some tenths of a millimetre, the plates carry a preload, and the finger stands at another height before the
//! camera. To first order each of these moves the markers of a bent finger in a fixed way: [`UnloadedFinger`] finds these ways from equilibria of
//! fingers that differ, and the nonlinear estimator seeks how far they went, with their priors.

use super::{Contact, ContactQuestion, Direction, Pad, SensingError};
use crate::finger::{Finger, FingerDescription, Plate};
use crate::measurement::{Measurement, SharedError};
use crate::mesh::{Load, Mesh};
use crate::statics::Statics;
use crate::{Kinematics, NodeId, Vector};
use nalgebra::UnitComplex;

/// What is known of the unloaded finger beside its drawing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AssemblyErrors {
    /// Standard deviation of where each joint is, along its plate and off it, mm.
    pub joint_sd_mm: f64,
    /// Moment at the tip that the plates exert on each other without load, N mm, from x to y. Plates that are evenly curved before they are joined
    /// leave such a moment and nothing else: the end moments of neighbouring elements cancel.
    pub preload_nmm: f64,
    /// Standard deviation of it, N mm.
    pub preload_sd_nmm: f64,
    /// Standard deviation of the markers' height before the camera, mm.
    pub height_sd_mm: f64,
}

/// An unloaded finger as one image may have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnloadedFinger {
    /// What is known of it.
    pub assembly: AssemblyErrors,
    /// Point of the finger frame that stays where it is when the markers' height changes, and the distance of the camera from their plane, mm;
    /// `None` where the height does not matter.
    pub camera: Option<(Vector, f64)>,
    /// For displacements that count from an image of the unloaded finger: standard deviation, rad, of the turn of the frame that they are measured in.
    /// Where the scene has the base does not matter otherwise.
    pub measured_in_frame_sd_rad: Option<f64>,
}

/// Elements a member of the fingers that are compared.
const ELEMENTS: usize = 4;

impl AssemblyErrors {
    /// The load that a preload is.
    pub(crate) fn load(finger: &Finger, moment_nmm: f64) -> Load {
        Load::Node { node: finger.tip(), force: Vector::zeros(), moment_nmm }
    }
}

/// Forces at contacts, with the pad that is between.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pushed<'f> {
    pub questions: &'f [ContactQuestion],
    pub contacts: &'f [Contact],
    pub forces_n: &'f [f64],
    pub pad: Pad,
}

impl Pushed<'_> {
    /// The contacts as a finger has them whose frame is turned: directions that are known are known outside it.
    fn turned_back(&self, by_rad: f64) -> Vec<Contact> {
        let is_known = |question: &ContactQuestion| matches!(question.direction, Direction::Angle(_));
        let turned = |(contact, question): (&Contact, &ContactQuestion)| match is_known(question) {
            true => Contact { angle_deg: contact.angle_deg - by_rad.to_degrees(), ..*contact },
            false => *contact,
        };
        self.contacts.iter().zip(self.questions).map(turned).collect()
    }
}

impl UnloadedFinger {
    /// Standard deviation of a coordinate, mm, that errors shared by markers leave as long as no forces are known: none of displacements from the
    /// scene's unloaded finger, as most of these errors do not depend on forces.
    pub(crate) fn unknown_without_forces_mm(&self) -> f64 {
        if self.measured_in_frame_sd_rad.is_some() { self.assembly.joint_sd_mm } else { 0.0 }
    }

    /// A measurement without what is expected of the preload, and with the errors that its markers share.
    ///
    /// # Errors
    /// [`SensingError`] where a finger that differs has no equilibrium under the forces.
    pub(crate) fn allowed_for(
        &self,
        finger: &Finger,
        measurement: &Measurement,
        pushed: Pushed,
    ) -> Result<Measurement, SensingError> {
        let AssemblyErrors { joint_sd_mm, preload_nmm, preload_sd_nmm, height_sd_mm } = self.assembly;
        let expected = self.markers(finger, preload_nmm, pushed)?;
        let further = |other: Vec<Vector>| -> SharedError { other.iter().zip(&expected).map(|(a, b)| a - b).collect() };
        let mut errors: Vec<SharedError> = Vec::new();
        if joint_sd_mm > 0.0 {
            for moved in joints_moved(finger, joint_sd_mm) {
                errors.push(further(self.markers(&moved, preload_nmm, pushed)?));
            }
        }
        if preload_sd_nmm > 0.0 {
            errors.push(further(self.markers(finger, preload_nmm + preload_sd_nmm, pushed)?));
        }
        if let Some((middle, distance_mm)) = self.camera.filter(|_| height_sd_mm > 0.0) {
            let middle = if self.measured_in_frame_sd_rad.is_some() { Vector::zeros() } else { middle };
            errors.push(expected.iter().map(|at| (at - middle) * (height_sd_mm / distance_mm)).collect());
        }
        if let Some(sd_rad) = self.measured_in_frame_sd_rad.filter(|sd_rad| *sd_rad > 0.0) {
            let contacts = pushed.turned_back(sd_rad);
            let turned = self.markers(finger, preload_nmm, Pushed { contacts: &contacts, ..pushed })?;
            errors.push(further(turned.iter().map(|moved| UnitComplex::new(sd_rad) * moved).collect()));
        }
        let offset = match preload_nmm == 0.0 {
            true => vec![Vector::zeros(); expected.len()],
            false => further(self.markers(finger, 0.0, pushed)?),
        };
        let allowed_for = |marker: &crate::measurement::Marker| marker.displacement + offset[marker.node.0 - 1];
        Ok(measurement.clone().displaced(allowed_for).with_shared_errors(errors))
    }

    /// Where forces and a moment at the tip bring the markers of all key nodes, mm; from where the unloaded finger has them, if an image shows that.
    fn markers(&self, finger: &Finger, moment_nmm: f64, pushed: Pushed) -> Result<Vec<Vector>, SensingError> {
        let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let preload = mesh.frame_load(&AssemblyErrors::load(finger, moment_nmm))?;
        let forces = pushed.contacts.iter().zip(pushed.forces_n);
        let loads = forces.flat_map(|(contact, force_n)| pushed.pad.loads(&mesh, contact, *force_n, 0.0));
        let loads: Vec<_> = loads.chain([Ok(preload)]).collect::<Result<_, _>>()?;
        let bent = statics.equilibrium(&loads)?.motion;
        let at_rest = self.measured_in_frame_sd_rad.map(|_| statics.equilibrium(&[preload])).transpose()?;
        let nodes = (1..=finger.key_node_count()).map(NodeId);
        let at = |node: NodeId| match &at_rest {
            None => finger.marker_position(node) + bent.displacements[mesh.marker_node(node)],
            Some(rest) => {
                bent.displacements[mesh.marker_node(node)] - rest.motion.displacements[mesh.marker_node(node)]
            }
        };
        Ok(nodes.map(at).collect())
    }
}

/// Fingers of which one joint each sits elsewhere along its plate, then off it: to the other side where the finger has no room.
fn joints_moved(finger: &Finger, by_mm: f64) -> impl Iterator<Item = Finger> {
    let joints =
        [Plate::Front, Plate::Back].into_iter().flat_map(|plate| (0..finger.rib_count()).map(move |rib| (plate, rib)));
    joints.flat_map(move |(plate, rib)| {
        let along = move |by_mm: f64| {
            let mut description = finger.description().clone();
            description.move_rib(finger, plate, rib, by_mm);
            description
        };
        let off = move |by_mm: f64| {
            let mut description = finger.description().clone();
            description.lengthen_bracket(finger.rib_count(), plate, rib, by_mm);
            description
        };
        let possible = |moved: &dyn Fn(f64) -> FingerDescription| {
            [1.0, -1.0].into_iter().find_map(|sign| Finger::new(moved(sign * by_mm)).ok())
        };
        [possible(&along), possible(&off)].into_iter().flatten()
    })
}
