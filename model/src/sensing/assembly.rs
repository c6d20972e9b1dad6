//! How the unloaded finger may differ from the scene's: it was assembled or mounted anew.
//!
//! Each joint then sits elsewhere by some tenths of a millimetre, the plates carry a preload, and the finger stands at another height before the
//! camera. To first order each of these moves the markers of a bent finger in a fixed way: [`UnloadedFinger`] finds these ways from equilibria of
//! fingers that differ, and the nonlinear estimator seeks how far they went, with their priors. A calibration leaves such errors, too: they are correlated,
//! and are stated as independent combinations.

use super::{Contact, ContactQuestion, Direction, Pad, SensingError};
use crate::finger::{Finger, Plate};
use crate::measurement::{Measurement, SharedError};
use crate::mesh::{Load, Mesh};
use crate::statics::Statics;
use crate::{Kinematics, NodeId, Vector};
use nalgebra::UnitComplex;

/// What is known of the unloaded finger beside its drawing.
#[derive(Debug, Clone, PartialEq, Default)]
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
    /// Further errors that a calibration leaves, independent of each other and of those above.
    pub further: Vec<UnloadedError>,
}

/// One error of the unloaded finger and its rig, of one standard deviation: all its parts together.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedError {
    /// How far the joints of each rib are off, mm: `[front, back]`, each along the plate from base to tip and into the finger.
    pub joints_mm: Vec<[[f64; 2]; 2]>,
    /// By how much the clips on the front and the back plate are longer, mm.
    pub clip_mm: [f64; 2],
    /// How much larger the preload is, N mm.
    pub preload_nmm: f64,
    /// How much higher the markers stand, mm.
    pub height_mm: f64,
    /// How far the base is from where it is taken to be, mm in the finger frame, and by how much it is turned, rad.
    pub base: Vector,
    /// See `base`.
    pub base_turn_rad: f64,
}

/// An unloaded finger as one image may have it.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedFinger {
    /// What is known of it.
    pub assembly: AssemblyErrors,
    /// The camera; `None` where the markers' height does not matter.
    pub camera: Option<CameraAbove>,
    /// For displacements that count from an image of the unloaded finger: standard deviation, rad, of the turn of the frame that they are measured in.
    /// Where the scene has the base does not matter otherwise.
    pub measured_in_frame_sd_rad: Option<f64>,
}

/// A camera above the plane of the markers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraAbove {
    /// Point of the plane below it, in the finger frame, mm.
    pub eye: Vector,
    /// Point of the finger that stays where it is seen when finger and base stand higher together, mm.
    pub middle: Vector,
    /// Distance from the plane, mm.
    pub distance_mm: f64,
}

/// Elements a member of the fingers that are compared.
const ELEMENTS: usize = 8;
/// Numbers of a row of [`UnloadedError`]: of each rib, and of all else.
const OF_RIB: usize = 4;
const OF_REST: usize = 7;

impl UnloadedError {
    /// No error of a finger with so many ribs.
    pub fn none(ribs: usize) -> UnloadedError {
        UnloadedError {
            joints_mm: vec![[[0.0; 2]; 2]; ribs],
            clip_mm: [0.0; 2],
            preload_nmm: 0.0,
            height_mm: 0.0,
            base: Vector::zeros(),
            base_turn_rad: 0.0,
        }
    }

    /// From a row of numbers: of each rib, front along the plate, front into the finger, back along, back into; then clip front, clip back, preload, height,
    /// base x, base y, turn in degrees. `None` for a row of another length.
    pub fn from_row(row: &[f64], ribs: usize) -> Option<UnloadedError> {
        let (joints, rest) = row.split_at_checked(OF_RIB * ribs)?;
        let &[front_clip, back_clip, preload_nmm, height_mm, x, y, turn_deg] = rest else { return None };
        Some(UnloadedError {
            joints_mm: joints.chunks_exact(OF_RIB).map(|of| [[of[0], of[1]], [of[2], of[3]]]).collect(),
            clip_mm: [front_clip, back_clip],
            preload_nmm,
            height_mm,
            base: Vector::new(x, y),
            base_turn_rad: turn_deg.to_radians(),
        })
    }

    /// Length of a row for so many ribs.
    pub fn row_length(ribs: usize) -> usize {
        OF_RIB * ribs + OF_REST
    }

    /// The row that leads to it.
    pub fn to_row(&self) -> Vec<f64> {
        let rest = [self.preload_nmm, self.height_mm, self.base.x, self.base.y, self.base_turn_rad.to_degrees()];
        self.joints_mm.iter().flatten().flatten().chain(&self.clip_mm).copied().chain(rest).collect()
    }

    /// Itself and so many times another.
    pub(crate) fn and(&self, times: f64, other: &UnloadedError) -> UnloadedError {
        let mut sum = self.clone();
        let joints_mm = sum.joints_mm.iter_mut().flatten().flatten().zip(other.joints_mm.iter().flatten().flatten());
        joints_mm.chain(sum.clip_mm.iter_mut().zip(&other.clip_mm)).for_each(|(sum, mm)| *sum += times * mm);
        sum.preload_nmm += times * other.preload_nmm;
        sum.height_mm += times * other.height_mm;
        sum.base += times * other.base;
        sum.base_turn_rad += times * other.base_turn_rad;
        sum
    }

    /// A finger with this error, if there can be one.
    pub(crate) fn finger(&self, finger: &Finger) -> Option<Finger> {
        let mut description = finger.description().clone();
        for (rib, joints_mm) in self.joints_mm.iter().enumerate() {
            for (plate, [along_mm, off_mm]) in [Plate::Front, Plate::Back].into_iter().zip(*joints_mm) {
                if along_mm != 0.0 {
                    description.move_rib(finger, plate, rib, along_mm);
                }
                if off_mm != 0.0 {
                    description.lengthen_bracket(finger.rib_count(), plate, rib, off_mm);
                }
            }
        }
        for (clip_mm, more_mm) in description.ribs.clip_mm.iter_mut().zip(self.clip_mm) {
            *clip_mm += more_mm;
        }
        Finger::new(description).ok()
    }

    /// Whether it changes how the finger bends.
    fn bends(&self) -> bool {
        self.joints_mm.iter().flatten().flatten().chain(&self.clip_mm).any(|mm| *mm != 0.0)
            || self.preload_nmm != 0.0
            || self.base_turn_rad != 0.0
    }
}

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

    /// A measurement without what is expected of the preload, and with the errors that its markers share: linearised where they are, in standard
    /// deviations, as a search before has found them, which may have found none.
    ///
    /// # Errors
    /// [`SensingError`] where a finger that differs has no equilibrium under the forces.
    pub(crate) fn allowed_for(
        &self,
        finger: &Finger,
        measurement: &Measurement,
        pushed: Pushed,
        found: &[f64],
    ) -> Result<Measurement, SensingError> {
        let errors = self.independent_errors(finger.rib_count());
        let none = UnloadedError::none(finger.rib_count());
        let all = errors.iter().zip(found).fold(none.clone(), |all, (error, times)| all.and(*times, error));
        // As the scene has it where the finger has no room for them.
        let (here, found) = if all.finger(finger).is_some() { (all, found) } else { (none, &[][..]) };
        let bent = self.bent(finger, &here, pushed)?;
        let seen = self.seen(&here, &bent);
        let mut shared: Vec<SharedError> = Vec::new();
        for error in &errors {
            let moved = |times: f64| -> Result<SharedError, SensingError> {
                let there = here.and(times, error);
                let bent = if error.bends() { self.bent(finger, &there, pushed)? } else { bent.clone() };
                Ok(self.seen(&there, &bent).iter().zip(&seen).map(|(there, here)| (there - here) * times).collect())
            };
            // To the other side where the finger has no room.
            shared.push(moved(1.0).or_else(|_| moved(-1.0))?);
        }
        let mut offset = self.markers(finger, 0.0, pushed)?;
        for (offset, seen) in offset.iter_mut().zip(&seen) {
            *offset -= seen;
        }
        for (shared, times) in shared.iter().zip(found) {
            offset.iter_mut().zip(shared).for_each(|(offset, shared)| *offset += shared * *times);
        }
        let allowed_for = |marker: &crate::measurement::Marker| marker.displacement + offset[marker.node.0 - 1];
        Ok(measurement.clone().displaced(allowed_for).with_shared_errors(shared))
    }

    /// All errors, each of one standard deviation.
    pub(crate) fn independent_errors(&self, ribs: usize) -> Vec<UnloadedError> {
        let AssemblyErrors { joint_sd_mm, preload_sd_nmm, height_sd_mm, further, .. } = &self.assembly;
        let mut errors = Vec::new();
        let mut add = |change: &dyn Fn(&mut UnloadedError)| {
            let mut error = UnloadedError::none(ribs);
            change(&mut error);
            errors.push(error);
        };
        if *joint_sd_mm > 0.0 {
            for (rib, plate, way) in
                (0..ribs).flat_map(|rib| [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[p, w]| (rib, p, w)))
            {
                add(&|error| error.joints_mm[rib][plate][way] = *joint_sd_mm);
            }
        }
        if *preload_sd_nmm > 0.0 {
            add(&|error| error.preload_nmm = *preload_sd_nmm);
        }
        if let Some(camera) = self.camera.filter(|_| *height_sd_mm > 0.0) {
            add(&|error| {
                error.height_mm = *height_sd_mm;
                error.base = (camera.eye - camera.middle) * (height_sd_mm / camera.distance_mm);
            });
        }
        if let Some(sd_rad) = self.measured_in_frame_sd_rad.filter(|sd_rad| *sd_rad > 0.0) {
            add(&|error| error.base_turn_rad = sd_rad);
        }
        errors.extend(further.iter().cloned());
        errors
    }

    /// Where forces bring the markers of a finger with an error, mm in its own frame.
    fn bent(&self, finger: &Finger, error: &UnloadedError, pushed: Pushed) -> Result<Vec<Vector>, SensingError> {
        let other = error.finger(finger).ok_or(SensingError::NoSuchFinger)?;
        let contacts = pushed.turned_back(error.base_turn_rad);
        self.markers(&other, self.assembly.preload_nmm + error.preload_nmm, Pushed { contacts: &contacts, ..pushed })
    }

    /// Where markers of a finger with an error are seen, mm.
    fn seen(&self, error: &UnloadedError, bent: &[Vector]) -> Vec<Vector> {
        let turn = UnitComplex::new(error.base_turn_rad);
        // What moves all markers alike is not in a displacement from an image at rest.
        let (base, eye) = match self.measured_in_frame_sd_rad {
            Some(_) => (Vector::zeros(), Vector::zeros()),
            None => (error.base, self.camera.map_or(Vector::zeros(), |camera| camera.eye)),
        };
        let larger = self.camera.map_or(0.0, |camera| error.height_mm / camera.distance_mm);
        let seen = |at: &Vector| {
            let at = turn * at;
            at + base + (at - eye) * larger
        };
        bent.iter().map(seen).collect()
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
