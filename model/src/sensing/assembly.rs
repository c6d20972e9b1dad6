//! Differences between the unloaded finger and the scene's after assembly or mounting.
//!
//! Each joint is off by some tenths of a millimetre, the plates carry a preload, and the finger is at another height before the camera. To first order,
//! each of these errors displaces the markers of a bent finger in a fixed pattern. [`UnloadedFinger`] computes these patterns from equilibria of fingers
//! with errors. The nonlinear estimator estimates the amplitudes with their priors. A calibration leaves such errors, too; they are correlated and stated as
//! independent combinations.

use super::{Contact, ContactQuestion, Direction, Pad, SensingError};
use crate::finger::{Finger, Plate};
use crate::measurement::{Measurement, SharedError};
use crate::mesh::{Load, Mesh};
use crate::statics::Statics;
use crate::{Kinematics, NodeId, Vector};
use nalgebra::UnitComplex;

/// Uncertainty of the unloaded finger.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AssemblyErrors {
    /// Standard deviation of each joint's position, along its plate and perpendicular to it, mm.
    pub joint_sd_mm: f64,
    /// Moment that the plates exert on each other at the tip without load, N mm, from x to y. Uniformly curved plates leave only this moment when they are
    /// joined, because the end moments of neighbouring elements cancel.
    pub preload_nmm: f64,
    /// Standard deviation of the preload, N mm.
    pub preload_sd_nmm: f64,
    /// Standard deviation of the height of the markers, mm.
    pub height_sd_mm: f64,
    /// Further errors that a calibration leaves, independent of each other and of the errors above.
    pub further: Vec<UnloadedError>,
}

/// One error of the unloaded finger and its rig, of one standard deviation. All its parts occur together.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedError {
    /// Displacements of the joints of each rib, mm: `[front, back]`, each along the plate from base to tip and into the finger.
    pub joints_mm: Vec<[[f64; 2]; 2]>,
    /// Additional length of the clips on the front and the back plate, mm.
    pub clip_mm: [f64; 2],
    /// Additional preload, N mm.
    pub preload_nmm: f64,
    /// Additional height of the markers, mm.
    pub height_mm: f64,
    /// Displacement of the base from its assumed position, mm, finger frame.
    pub base: Vector,
    /// Turn of the base from its assumed orientation, rad.
    pub base_turn_rad: f64,
}

/// Possible errors of the unloaded finger in one image.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedFinger {
    /// Uncertainty of the unloaded finger.
    pub assembly: AssemblyErrors,
    /// The camera. `None` if the height of the markers has no effect.
    pub camera: Option<CameraAbove>,
    /// Standard deviation of the turn of the measurement's frame, rad, if displacements refer to an image of the unloaded finger. The position of the base
    /// then has no effect. `None` if displacements refer to the scene's finger.
    pub measured_in_frame_sd_rad: Option<f64>,
}

/// A camera above the plane of the markers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraAbove {
    /// Point of the plane below the camera, in the finger frame, mm.
    pub eye: Vector,
    /// Point of the finger whose image stays fixed when finger and base rise together, mm.
    pub middle: Vector,
    /// Distance of the camera from the plane, mm.
    pub distance_mm: f64,
}

/// Beam elements per member of the compared fingers.
const ELEMENTS: usize = 8;
/// Numbers in a row of [`UnloadedError`]: of each rib, and of all other parts.
const OF_RIB: usize = 4;
const OF_REST: usize = 7;

impl UnloadedError {
    /// No error, for a finger with `ribs` ribs.
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

    /// Reads an error from a row of numbers, mm and N mm. First, of each rib: front along the plate, front into the finger, back along, back into. Then: clip
    /// front, clip back, preload, height, base x, base y, turn in degrees. `None` for a row of another length.
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

    /// Length of a row for a finger with `ribs` ribs.
    pub fn row_length(ribs: usize) -> usize {
        OF_RIB * ribs + OF_REST
    }

    /// The row of numbers from which [`UnloadedError::from_row`] reads this error, in its order and units.
    pub fn to_row(&self) -> Vec<f64> {
        let rest = [self.preload_nmm, self.height_mm, self.base.x, self.base.y, self.base_turn_rad.to_degrees()];
        self.joints_mm.iter().flatten().flatten().chain(&self.clip_mm).copied().chain(rest).collect()
    }

    /// This error plus `times` another.
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

    /// A finger with this error. `None` if it is impossible.
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

    /// Whether the error changes the bending of the finger.
    fn bends(&self) -> bool {
        self.joints_mm.iter().flatten().flatten().chain(&self.clip_mm).any(|mm| *mm != 0.0)
            || self.preload_nmm != 0.0
            || self.base_turn_rad != 0.0
    }
}

impl AssemblyErrors {
    /// Load of a preload at the tip, N mm.
    pub(crate) fn load(finger: &Finger, moment_nmm: f64) -> Load {
        Load::Node { node: finger.tip(), force: Vector::zeros(), moment_nmm }
    }
}

/// Forces at contacts, with the pad between object and plate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pushed<'f> {
    pub questions: &'f [ContactQuestion],
    pub contacts: &'f [Contact],
    pub forces_n: &'f [f64],
    pub pad: Pad,
}

impl Pushed<'_> {
    /// The contacts in a finger frame turned by `by_rad`. Known directions are fixed outside this frame.
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
    /// Standard deviation of a coordinate, mm, due to shared errors before any force is known. Zero for displacements from the scene's finger, because most
    /// errors then do not depend on forces.
    pub(crate) fn unknown_without_forces_mm(&self) -> f64 {
        if self.measured_in_frame_sd_rad.is_some() { self.assembly.joint_sd_mm } else { 0.0 }
    }

    /// Corrects a measurement for the expected preload, and adds the errors that its markers share. They are linearised at `found`, the errors of an earlier
    /// search in standard deviations, or at zero if it is empty.
    ///
    /// # Errors
    /// [`SensingError`] if a finger with an error is impossible or has no equilibrium under the forces.
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
        // The errors are linearised at zero if the finger with the found errors is impossible.
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
            // The opposite sign serves where a finger with the error is impossible.
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

    /// All errors, of one standard deviation each.
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

    /// Marker positions of a finger with an error under the forces, mm, in its own frame.
    fn bent(&self, finger: &Finger, error: &UnloadedError, pushed: Pushed) -> Result<Vec<Vector>, SensingError> {
        let other = error.finger(finger).ok_or(SensingError::NoSuchFinger)?;
        let contacts = pushed.turned_back(error.base_turn_rad);
        self.markers(&other, self.assembly.preload_nmm + error.preload_nmm, Pushed { contacts: &contacts, ..pushed })
    }

    /// Marker positions of a finger with an error as the camera sees them, mm.
    fn seen(&self, error: &UnloadedError, bent: &[Vector]) -> Vec<Vector> {
        let turn = UnitComplex::new(error.base_turn_rad);
        // A common translation of all markers is not in a displacement from an image of the unloaded finger.
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

    /// Marker positions of all key nodes under forces and a moment at the tip, mm. Displacements instead, if an image shows the unloaded finger.
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
