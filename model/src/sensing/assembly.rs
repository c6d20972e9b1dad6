//! Errors of assembly, mounting and thickness: differences between the real finger and the finger of the scene.
//!
//! Assembly and mounting displace each joint by some tenths of a millimetre, leave a preload in the plates, and change the finger's distance from the
//! camera. Members are some per cent thicker or thinner than drawn. To first order, each error displaces the markers of a bent finger in a fixed
//! pattern, and the plate at each contact, which an object of known shape touches. [`UnloadedFinger`] computes both from the equilibrium of a finger
//! with this error. The nonlinear estimator estimates the amplitude of each error together with the forces. Each amplitude has a prior. Errors that
//! remain after a calibration are correlated; [`AssemblyErrors::further`] lists independent combinations of these errors.

use super::{ContactQuestion, PadForce, SensingError};
use crate::finger::{Finger, Plate, PlatePosition, StiffnessChange, ThicknessError};
use crate::measurement::{Measurement, PlateMotion, SharedError};
use crate::mesh::{Load, Mesh};
use crate::statics::Statics;
use crate::{Kinematics, NodeId, Vector};
use nalgebra::UnitComplex;

/// Uncertainty of the unloaded finger.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AssemblyErrors {
    /// Standard deviation of the position of each joint between a rib and a plate, in mm. It applies along the plate and, for joints on brackets,
    /// perpendicular to the plate.
    pub joint_sd_mm: f64,
    /// Moment that the plates exert on each other at the tip without load, in N mm. A positive moment turns the x axis towards the y axis. One moment
    /// at the tip represents the preload of uniformly curved plates, because the end moments of neighbouring elements cancel.
    pub preload_nmm: f64,
    /// Standard deviation of the preload, N mm.
    pub preload_sd_nmm: f64,
    /// Standard deviation of the markers' height towards the camera, in mm.
    pub height_sd_mm: f64,
    /// Errors that remain after a calibration. The errors in this list are independent of each other and of the errors in the other fields.
    pub further: Vec<UnloadedError>,
}

/// One error of the finger and its mounting, with the size of one standard deviation. All fields of one error are fully correlated: they
/// change together.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedError {
    /// Displacements of the joints of each rib, in mm: `[front, back]`. The displacement of each joint has two components: along the joint's plate
    /// from base to tip, and perpendicular to this plate into the finger.
    pub joints_mm: Vec<[[f64; 2]; 2]>,
    /// Additional length of the ribs' clips, in mm: first for clips on the front plate, then for clips on the back plate.
    pub clip_mm: [f64; 2],
    /// Additional preload at the tip, in N mm.
    pub preload_nmm: f64,
    /// Additional height of the markers towards the camera, in mm.
    pub height_mm: f64,
    /// Displacement of the base from its assumed position, in mm, finger frame.
    pub base: Vector,
    /// Rotation of the base from its assumed orientation, in rad, positive from x to y.
    pub base_turn_rad: f64,
    /// Changes of thicknesses and moduli. Rows of numbers do not contain them.
    pub stiffness: StiffnessChange,
}

/// Possible errors of the finger, as seen in one image.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedFinger {
    /// Uncertainty of the unloaded finger.
    pub assembly: AssemblyErrors,
    /// Uncertainty of the thicknesses.
    pub thickness: ThicknessError,
    /// The camera above the markers. `None` neglects the effect of the markers' height.
    pub camera: Option<CameraAbove>,
    /// Standard deviation, in rad, of the rotation of the frame in which displacements are measured. Applies to displacements from an image of the
    /// unloaded finger. Displacements from an image of the unloaded finger do not depend on the position of the base. `None` if displacements refer
    /// to the finger of the scene.
    pub measured_in_frame_sd_rad: Option<f64>,
}

/// A camera above the plane of the markers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraAbove {
    /// Foot of the perpendicular from the camera to the plane of the markers, finger frame, in mm.
    pub eye: Vector,
    /// Point whose image stays fixed when finger and base rise together towards the camera, finger frame, in mm.
    pub middle: Vector,
    /// Distance of the camera from the plane of the markers, in mm.
    pub distance_mm: f64,
}

/// Beam elements per member in the meshes of the fingers with and without errors.
const ELEMENTS: usize = 8;
/// An [`UnloadedError`] is written as a row of numbers; this many numbers of the row belong to each rib. `OF_REST` is the count of the numbers in a
/// row that do not belong to a rib.
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
            stiffness: StiffnessChange::default(),
        }
    }

    /// Reads an error from a row of numbers. Four numbers per rib come first, in mm: front joint along the plate, front joint into the finger, back
    /// joint along the plate, back joint into the finger. Seven numbers follow: front clip (mm), back clip (mm), preload (N mm), height (mm), base x
    /// (mm), base y (mm), rotation (degrees). `None` if the row has a wrong length.
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
            stiffness: StiffnessChange::default(),
        })
    }

    /// Length of a row for a finger with `ribs` ribs.
    pub fn row_length(ribs: usize) -> usize {
        OF_RIB * ribs + OF_REST
    }

    /// The row of numbers from which [`UnloadedError::from_row`] reads this error, in the same order and units.
    pub fn to_row(&self) -> Vec<f64> {
        let rest = [self.preload_nmm, self.height_mm, self.base.x, self.base.y, self.base_turn_rad.to_degrees()];
        self.joints_mm.iter().flatten().flatten().chain(&self.clip_mm).copied().chain(rest).collect()
    }

    /// Sum of this error and `times` times the error `other`.
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

    /// A copy of `finger` in which this error displaces the joints, lengthens the clips, and changes thicknesses and moduli. `None` if the changed
    /// finger is geometrically impossible.
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
        self.stiffness.apply(&mut description);
        Finger::new(description).ok()
    }

    /// Whether the error changes the shape of the bent finger.
    fn bends(&self) -> bool {
        self.joints_mm.iter().flatten().flatten().chain(&self.clip_mm).any(|mm| *mm != 0.0)
            || self.preload_nmm != 0.0
            || self.base_turn_rad != 0.0
    }
}

impl AssemblyErrors {
    /// Load that represents a preload of `moment_nmm`, N mm: a moment at the tip.
    pub(crate) fn load(finger: &Finger, moment_nmm: f64) -> Load {
        Load::Node { node: finger.tip(), force: Vector::zeros(), moment_nmm }
    }
}

/// Forces at contacts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pushed<'f> {
    /// For each contact, whether its position and its direction are known.
    pub questions: &'f [ContactQuestion],
    /// Force of each contact.
    pub forces: &'f [PadForce],
}

impl Pushed<'_> {
    /// The forces in a finger frame that is rotated by `by_rad`, rad. Only known and measured directions change, because they refer to the unrotated
    /// frame.
    fn turned_back(&self, by_rad: f64) -> Vec<PadForce> {
        let turned = |(force, question): (&PadForce, &ContactQuestion)| match question.direction.stated_deg() {
            Some(_) => force.turned(-force.contact.position.plate().turn_sign() * by_rad.to_degrees(), force.force_n),
            None => *force,
        };
        self.forces.iter().zip(self.questions).map(turned).collect()
    }
}

impl UnloadedFinger {
    /// Corrects a measurement for the expected preload, and adds the assembly errors as errors that all markers share. The effects of the errors are
    /// linearised at the amplitudes `found`, in standard deviations, from an earlier search. If `found` is empty, the effects are linearised at zero.
    ///
    /// # Errors
    /// [`SensingError`] if a finger with one of the errors is impossible or has no equilibrium under the forces.
    pub(super) fn allowed_for(
        &self,
        finger: &Finger,
        measurement: &Measurement,
        pushed: Pushed,
        found: &[f64],
    ) -> Result<Measurement, SensingError> {
        let errors = self.independent_errors(finger);
        let none = UnloadedError::none(finger.rib_count());
        let all = errors.iter().zip(found).fold(none.clone(), |all, (error, times)| all.and(*times, error));
        // If a finger with the amplitudes `found` is geometrically impossible, the effects of the errors are linearised at zero amplitude.
        let (here, found) = if all.finger(finger).is_some() { (all, found) } else { (none, &[][..]) };
        let bent = self.bent(finger, &here, pushed)?;
        let seen = self.seen(&here, &bent.markers_mm);
        let shared_error = |change: &dyn Fn(f64) -> UnloadedError, bends: bool, start: f64| {
            let moved = |times: f64| -> Result<SharedError, SensingError> {
                let there = change(times);
                let bent_there = if bends { self.bent(finger, &there, pushed)? } else { bent.clone() };
                let seen_there = self.seen(&there, &bent_there.markers_mm);
                let moved = |(there, here): (&Vector, &Vector)| (there - here) * times;
                let pattern_mm = seen_there.iter().zip(&seen).map(moved).collect();
                let plate = bent_there.moved_from(&bent).map(|moved| PlateMotion::default().and(times, moved));
                Ok(SharedError { pattern_mm, plate: plate.collect(), start })
            };
            // If a finger with the error is impossible or has no equilibrium, the effect follows from the error of opposite sign.
            moved(1.0).or_else(|_| moved(-1.0))
        };
        let starts = found.iter().copied().chain(std::iter::repeat(0.0));
        let mut shared = Vec::new();
        for (error, start) in errors.iter().zip(starts) {
            shared.push(shared_error(&|times| here.and(times, error), error.bends(), start)?);
        }
        let of_scene = self.bent_under(finger, 0.0, pushed)?;
        let mut offset: Vec<Vector> = of_scene.markers_mm.iter().zip(&seen).map(|(scene, seen)| scene - seen).collect();
        let mut plate_offsets: Vec<PlateMotion> = bent.moved_from(&of_scene).collect();
        for SharedError { pattern_mm, plate, start } in &shared {
            offset.iter_mut().zip(pattern_mm).for_each(|(offset, of_error)| *offset += of_error * *start);
            plate_offsets.iter_mut().zip(plate).for_each(|(offset, of_error)| *offset = offset.and(-start, *of_error));
        }
        // Thicknesses are linearised at zero amplitude: at their amplitudes, beside derivatives of the scene's finger by the force, the rounds would
        // diverge where markers hardly distinguish thicknesses from forces. Displacements are linear in them, so that they need no offset, as little
        // as errors that the measurement states.
        for stiffness in self.thickness.changes(finger) {
            let change = |times| UnloadedError { stiffness: stiffness.times(times), ..here.clone() };
            shared.push(shared_error(&change, true, 0.0)?);
        }
        shared.extend(measurement.shared_errors().iter().cloned());
        let allowed_for = |marker: &crate::measurement::Marker| marker.displacement + offset[marker.node.0 - 1];
        let measurement = measurement.clone().with_markers(|marker| marker.displacement = allowed_for(marker));
        Ok(measurement.with_shared_errors(shared).with_plate_offsets(plate_offsets))
    }

    /// Whether an error has a standard deviation, so that it is estimated together with the forces.
    pub(crate) fn is_uncertain(&self, finger: &Finger) -> bool {
        self.thickness.sd > 0.0 || self.is_assembled(finger)
    }

    /// Whether an error of assembly or mounting has a standard deviation.
    pub(crate) fn is_assembled(&self, finger: &Finger) -> bool {
        !self.independent_errors(finger).is_empty()
    }

    /// All independent errors of assembly and mounting, each with the size of one standard deviation. A joint without a bracket lies on its plate, so
    /// its error perpendicular to the plate is zero. Ribs with a common junction move together, and a joint in a corner of the base does not move.
    fn independent_errors(&self, finger: &Finger) -> Vec<UnloadedError> {
        let ribs = finger.rib_count();
        let AssemblyErrors { joint_sd_mm, preload_sd_nmm, height_sd_mm, further, .. } = &self.assembly;
        let mut errors = Vec::new();
        let mut add = |change: &dyn Fn(&mut UnloadedError)| {
            let mut error = UnloadedError::none(ribs);
            change(&mut error);
            errors.push(error);
        };
        if *joint_sd_mm > 0.0 {
            let positions_mm = [Plate::Front, Plate::Back].map(|plate| finger.plate_positions_mm(plate));
            for (rib, plate, way) in
                (0..ribs).flat_map(|rib| [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[p, w]| (rib, p, w)))
            {
                // The position of a plate's rib follows the position of the rib before it, or of the base.
                let at_mm = &positions_mm[plate];
                let joint_mm = at_mm[rib + 1];
                match way {
                    0 if joint_mm > at_mm[rib] => add(&|error| {
                        let together = (rib..ribs).filter(|other| at_mm[other + 1] == joint_mm);
                        together.for_each(|other| error.joints_mm[other][plate][way] = *joint_sd_mm);
                    }),
                    1 if finger.description().ribs.bracket_mm.of(rib)[plate] > 0.0 => {
                        add(&|error| error.joints_mm[rib][plate][way] = *joint_sd_mm)
                    }
                    _ => {}
                }
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

    /// `finger` with `error`, bent by the forces.
    fn bent(&self, finger: &Finger, error: &UnloadedError, pushed: Pushed) -> Result<BentFinger, SensingError> {
        let other = error.finger(finger).ok_or(SensingError::NoSuchFinger)?;
        let forces = pushed.turned_back(error.base_turn_rad);
        self.bent_under(&other, self.assembly.preload_nmm + error.preload_nmm, Pushed { forces: &forces, ..pushed })
    }

    /// Marker positions that the camera sees, in mm: the positions `bent`, displaced by the errors of base and height in `error`.
    fn seen(&self, error: &UnloadedError, bent: &[Vector]) -> Vec<Vector> {
        let turn = UnitComplex::new(error.base_turn_rad);
        // In displacements from an image of the unloaded finger, a common translation of all markers cancels.
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

    /// `finger` under forces and a moment at the tip.
    fn bent_under(&self, finger: &Finger, moment_nmm: f64, pushed: Pushed) -> Result<BentFinger, SensingError> {
        let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let preload = mesh.frame_load(&AssemblyErrors::load(finger, moment_nmm))?;
        let loads = pushed.forces.iter().flat_map(|force| force.loads(&mesh));
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
        let plate = |force: &PadForce| {
            let contact = force.contact;
            let s_mm = contact.position_mm(finger)?;
            let point = mesh.plate_point(&bent, PlatePosition { plate: contact.position.plate(), s_mm }).ok()?;
            Some((point, mesh.normal_turn(&bent, &contact.unit_load(finger), 0.0).ok()?))
        };
        let plate = pushed.forces.iter().map(|force| plate(force).unwrap_or_default()).collect();
        Ok(BentFinger { markers_mm: nodes.map(at).collect(), plate })
    }
}

/// A finger under forces, relative to its base.
#[derive(Debug, Clone)]
struct BentFinger {
    /// Positions of the markers of all key nodes, mm. If displacements refer to an image of the unloaded finger, displacements from the unloaded finger.
    markers_mm: Vec<Vector>,
    /// Position, mm, and rotation towards the tip, rad, of the plate at each contact.
    plate: Vec<(Vector, f64)>,
}

impl BentFinger {
    /// Motion of the plate at each contact from that of the finger `from`.
    fn moved_from(&self, from: &BentFinger) -> impl Iterator<Item = PlateMotion> {
        self.plate
            .iter()
            .zip(&from.plate)
            .map(|(to, from)| PlateMotion { displacement: to.0 - from.0, turn_rad: to.1 - from.1 })
    }
}
