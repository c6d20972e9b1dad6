//! Reading of scene files: from TOML text to a checked [`Finger`], with camera, contacts, objects and gripper.

mod camera;
mod contact;
mod grasp;
mod gripper;
mod object;
mod reader;
mod touched;
mod warning;

pub use crate::keys::ROD_RADIUS_MM;
pub use camera::{Base, CameraDescription, MarkerLook, Markers, Reference, Rgb, Shade, marker_offset};
pub use contact::ContactDescription;
pub use grasp::{GraspDescription, Support};
pub use object::{ObjectDescription, ObjectMotion, Outline, Until};
pub use touched::{ObjectFrame, ObjectPlace, TouchedDescription};
pub use warning::SceneWarning;

use crate::finger::{
    Fillets, Finger, FingerDescription, Joints, MarkerPoints, ModelError, Part, Plate, RibDescription, RibPositions,
    RigidEnds, SideFaces, StiffnessError, Strip, ThicknessError, Zone,
};
use crate::gripper::Gripper;
use crate::keys::{
    ASSEMBLY, BACK, BASE, CAMERA, CONTACT, FINGER, FRONT, GRASP, GRIPPER, Key, MARKERS, Number, OBJECT, PlateKeys,
    RIBS, TOP, TOUCHED, ZONE,
};
use crate::measurement::MarkerErrors;
use crate::sensing::{AssemblyErrors, UnloadedError};
use crate::validity::{SHEAR_CORRECTION, StrainLimits};
use crate::{NodeId, Vector};
use nalgebra::Vector6;
use reader::{Document, TableReader};

/// Contents of a scene file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Name of the scene.
    pub name: String,
    /// The finger that the scene describes.
    pub finger: Finger,
    /// Largest fibre strain at which the material of each part is linear, dimensionless; `None` for parts without a stated limit.
    pub strain_limits: StrainLimits,
    /// Relative standard deviation of a sensed force due to the errors of beam theory and of the model of free side faces, with its origin.
    pub model_error: ModelError,
    /// Relative standard deviation that all sensed forces share, because the moduli and the depth are uncertain.
    pub stiffness_error: StiffnessError,
    /// Uncertainty of the thicknesses of front plate, back plate and ribs.
    pub thickness_error: ThicknessError,
    /// Standard deviation of one measured marker coordinate, mm; `None` if the scene does not state it.
    pub noise_mm: Option<f64>,
    /// Factor on the stated noise of the markers, and error of the finger model at a marker.
    pub marker_errors: MarkerErrors,
    /// The camera; `None` if the scene has none.
    pub camera: Option<CameraDescription>,
    /// Independent errors of the camera's pose, one standard deviation each, as motions of [`Pose::moved`](crate::camera::Pose::moved).
    pub pose_errors: Vec<Vector6<f64>>,
    /// Size, height and appearance of the markers in images; `None` if the scene does not state them.
    pub markers: Option<Markers>,
    /// Position of each key node's marker relative to the node, on the unloaded finger, mm, finger frame. Empty if markers are centred on their nodes.
    /// Images alone depend on these offsets: locators convert positions of markers to positions of nodes.
    pub marker_offsets: Vec<Vector>,
    /// Nodes whose markers have unknown offsets, because the image from which the others are does not show them. No measurement contains them.
    pub missing_markers: Vec<NodeId>,
    /// Reference marks on the base and the base's uncertainty, for a base that moves between images; `None` for a fixed base.
    pub base: Option<Base>,
    /// Possible deviations of the unloaded finger from its description; `None` if the scene states none.
    pub assembly: Option<AssemblyErrors>,
    /// Properties of contacts between objects and the finger.
    pub contact: ContactDescription,
    /// The object of known shape that touches the front plate while forces are sensed; `None` if the scene has none.
    pub touched: Option<TouchedDescription>,
    /// The object that is pressed onto the finger or grasped; `None` if the scene has none.
    pub object: Option<ObjectDescription>,
    /// The linkage that moves two copies of the finger; `None` if the scene has none.
    pub gripper: Option<Gripper>,
    /// Settings of a grasp by the gripper; `None` if the scene states none.
    pub grasp: Option<GraspDescription>,
}

/// Error in the text of a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct SceneError {
    /// Line in the text, counted from 1.
    pub line: usize,
    /// The key, the expected value and the found value, in words.
    pub message: String,
}

impl Scene {
    /// A scene of a finger alone: without camera, markers, objects and stated errors. Its moduli count as exact.
    pub fn of_finger(finger: Finger) -> Scene {
        Scene {
            name: String::new(),
            model_error: ModelError::of(&finger, None),
            stiffness_error: StiffnessError::default(),
            thickness_error: ThicknessError::default(),
            finger,
            strain_limits: StrainLimits::default(),
            noise_mm: None,
            marker_errors: MarkerErrors::default(),
            camera: None,
            pose_errors: Vec::new(),
            markers: None,
            marker_offsets: Vec::new(),
            missing_markers: Vec::new(),
            base: None,
            assembly: None,
            contact: ContactDescription::default(),
            touched: None,
            object: None,
            gripper: None,
            grasp: None,
        }
    }

    /// The scene under the assumptions of a simulation: forces act on the bare plate, the base is known, and no errors of markers, base or assembly are
    /// stated.
    pub fn as_simulated(&self) -> Scene {
        let Scene { name, camera, markers, object, gripper, grasp, .. } = self.clone();
        let contact = ContactDescription { rod_radius_mm: self.contact.rod_radius_mm, ..ContactDescription::default() };
        let finger = Scene { strain_limits: self.strain_limits, ..self.of_same_finger() };
        Scene { name, camera, markers, contact, object, gripper, grasp, ..finger }
    }

    /// A scene of this finger alone, with the stated errors of its model and of moduli and depth.
    pub fn of_same_finger(&self) -> Scene {
        let &Scene { model_error, stiffness_error, .. } = self;
        Scene { model_error, stiffness_error, ..Scene::of_finger(self.finger.clone()) }
    }

    /// Reads a scene from TOML. Rejects unknown and missing keys, wrong types, values out of range and impossible geometry.
    ///
    /// # Errors
    /// [`SceneError`] with the line, the key and the expected value.
    pub fn from_toml(text: &str) -> Result<Scene, SceneError> {
        let document = Document::parse(text)?;
        let top = document.top()?;
        let name = top.get(&TOP.name)?;
        let markers = top.optional_table(&MARKERS)?.as_ref().map(camera::read_markers).transpose()?.unwrap_or_default();
        let table = top.table(&FINGER)?;
        let description = read_finger(&table, markers.on)?;
        let strain_limits = read_strain_limits(&table)?;
        let model_error = table.optional(&FINGER.model_error)?;
        let modulus_error = table.optional(&FINGER.youngs_modulus_sigma)?;
        let depth_sd_mm = table.get(&FINGER.depth_sigma_mm)?;
        let thickness_error = ThicknessError {
            sd: table.get(&FINGER.thickness_sigma)?,
            modulus_slopes: table.optional(&FINGER.modulus_per_thickness)?.unwrap_or_default(),
        };
        let finger = Finger::new(description).map_err(|impossible| SceneError {
            line: document.line_of(&impossible.key),
            message: impossible.to_string(),
        })?;
        if !markers.offsets.is_empty() && markers.offsets.len() != finger.key_node_count() {
            let (offsets, expected) = (MARKERS.offsets_mm.path(), finger.key_node_count());
            let message =
                format!("{offsets}: expected {expected} pairs, one for each key node, found {}", markers.offsets.len());
            return Err(SceneError { line: document.line_of(&offsets), message });
        }
        let assembly = top.optional_table(&ASSEMBLY)?;
        let assembly = assembly.as_ref().map(|table| read_assembly(table, finger.rib_count())).transpose()?;
        let camera = top.optional_table(&CAMERA)?;
        let pose_errors = camera.as_ref().map(camera::read_pose_errors).transpose()?.unwrap_or_default();
        let camera = camera.as_ref().map(camera::read_camera).transpose()?;
        let (noise_mm, camera) = camera.unwrap_or_default();
        let base = top.optional_table(&BASE)?.as_ref().map(camera::read_base).transpose()?;
        let (contact, touched) = match top.optional_table(&CONTACT)? {
            None => (ContactDescription::default(), None),
            Some(table) => {
                let touched = table.optional_table(&TOUCHED)?;
                (contact::read_contact(&table, &finger)?, touched.as_ref().map(touched::read_touched).transpose()?)
            }
        };
        let object = top.optional_table(&OBJECT)?.map(|table| object::read_object(&table, &finger)).transpose()?;
        let gripper = top.optional_table(&GRIPPER)?.as_ref().map(gripper::read_gripper).transpose()?;
        let grasp = top.optional_table(&GRASP)?.map(|table| grasp::read_grasp(&table, gripper.as_ref())).transpose()?;
        if finger.tapers(Plate::Front) && (touched.is_some() || object.is_some() || grasp.is_some()) {
            let tip = FRONT.tip_thickness_mm.path();
            let message = format!("{tip}: expected a front plate of constant thickness where an object touches it");
            return Err(SceneError { line: document.line_of(&tip), message });
        }
        Ok(Scene {
            name,
            strain_limits,
            model_error: ModelError::of(&finger, model_error),
            stiffness_error: StiffnessError::of(&finger, modulus_error, depth_sd_mm),
            thickness_error,
            finger,
            noise_mm,
            marker_errors: markers.errors,
            camera,
            pose_errors,
            markers: markers.discs,
            marker_offsets: markers.offsets,
            missing_markers: markers.missing,
            base,
            assembly,
            contact,
            touched,
            object,
            gripper,
            grasp,
        })
    }
}

fn read_finger(table: &TableReader, markers_on: MarkerPoints) -> Result<FingerDescription, SceneError> {
    let front = read_plate(table, &FRONT)?;
    let back = read_plate(table, &BACK)?;
    let fillets = read_fillets(table)?;
    let shear_correction = table.optional(&FINGER.shear_correction)?;
    Ok(FingerDescription {
        base_width_mm: table.get(&FINGER.base_width_mm)?,
        front_length_mm: table.get(&FINGER.front_length_mm)?,
        back_length_mm: table.get(&FINGER.back_length_mm)?,
        depth_mm: table.get(&FINGER.depth_mm)?,
        rod_arm_mm: table.get(&FINGER.rod_arm_mm)?,
        rib_arm_mm: table.optional(&FINGER.rib_arm_mm)?,
        clamp_arm_mm: table.optional(&FINGER.clamp_arm_mm)?,
        poissons_ratio: table.get(&FINGER.poissons_ratio)?,
        side_faces: read_side_faces(table)?,
        fillets,
        shear_correction: shear_correction.unwrap_or(if fillets.is_some() { SHEAR_CORRECTION } else { 0.0 }),
        front: front.0,
        back: back.0,
        rigid_ends: [front.1, back.1],
        ribs: read_ribs(&table.table(&RIBS)?)?,
        zones: table.tables(&ZONE)?.iter().map(read_zone).collect::<Result<_, _>>()?,
        markers_on,
    })
}

fn read_side_faces(table: &TableReader) -> Result<Option<SideFaces>, SceneError> {
    let side_faces = table.optional(&FINGER.side_faces)?.map(|word| [SideFaces::Fixed, SideFaces::Free][word]);
    if side_faces == Some(SideFaces::Free) && !table.has(&FINGER.poissons_ratio) {
        let needed = FINGER.poissons_ratio.name;
        let message =
            format!("expected {needed} beside free side faces: without it, no section contracts along the depth");
        return Err(table.at(FINGER.side_faces.name, &message));
    }
    Ok(side_faces)
}

fn read_fillets(finger: &TableReader) -> Result<Option<Fillets>, SceneError> {
    let of_all = finger.optional(&FINGER.fillet_mm)?;
    let of = |table: &TableReader, key: &'static Key<Number>| match (table.optional(key)?, of_all) {
        (Some(_), None) => Err(table.wrong(key.name, "fillet_mm in [finger] beside it", "none")),
        (own_mm, _) => Ok(own_mm.or(of_all).unwrap_or_default()),
    };
    let plates_mm = [of(&finger.table(&FRONT)?, &FRONT.fillet_mm)?, of(&finger.table(&BACK)?, &BACK.fillet_mm)?];
    let base_mm = of(finger, &FINGER.base_fillet_mm)?;
    for keys in [&FRONT, &BACK] {
        let (ribs, plate) = (finger.table(&RIBS)?, finger.table(keys)?);
        if ribs.has(&RIBS.fillet_mm) && plate.has(&keys.fillet_mm) {
            return Err(plate.wrong(keys.fillet_mm.name, "either this key or fillet_mm of the ribs", "both"));
        }
    }
    Ok(of_all.map(|_| Fillets { plates_mm, base_mm }))
}

fn read_strain_limits(finger: &TableReader) -> Result<StrainLimits, SceneError> {
    Ok(StrainLimits {
        front: finger.table(&FRONT)?.optional(&FRONT.largest_strain)?,
        back: finger.table(&BACK)?.optional(&BACK.largest_strain)?,
        ribs: finger.table(&RIBS)?.optional(&RIBS.largest_strain)?,
    })
}

fn read_plate(finger: &TableReader, keys: &'static PlateKeys) -> Result<(Strip, RigidEnds), SceneError> {
    let table = finger.table(keys)?;
    let strip = Strip {
        thickness_mm: table.get(&keys.thickness_mm)?,
        tip_thickness_mm: table.optional(&keys.tip_thickness_mm)?,
        youngs_modulus_mpa: table.get(&keys.youngs_modulus_mpa)?,
    };
    Ok((strip, RigidEnds { base_mm: table.get(&keys.rigid_base_mm)?, tip_mm: table.get(&keys.rigid_tip_mm)? }))
}

fn read_ribs(table: &TableReader) -> Result<RibDescription, SceneError> {
    let positions = match (table.optional(&RIBS.count)?, table.optional(&RIBS.positions_mm)?) {
        (Some(count), None) => RibPositions::Count(count),
        (None, Some(positions)) => RibPositions::Positions(positions),
        (Some(_), Some(_)) => {
            return Err(table.wrong(RIBS.positions_mm.name, "either count or positions_mm", "both"));
        }
        (None, None) => return Err(table.missing(RIBS.count.name, "the number of ribs, or positions_mm")),
    };
    let rigid = table.is_true(&RIBS.rigid)?;
    let none = positions == RibPositions::Count(0) || positions == RibPositions::Positions(Vec::new());
    // Rigid ribs do not use the keys for the material, but the values of these keys are checked nevertheless.
    let thickness_mm = table.optional(&RIBS.thickness_mm)?;
    let (strip, thicknesses_mm) = match (&thickness_mm, table.optional(&RIBS.youngs_modulus_mpa)?) {
        _ if rigid => (None, None),
        (None, None) if none => (None, None),
        _ => {
            let thickness_mm = table.get(&RIBS.thickness_mm)?;
            let strip = Strip {
                thickness_mm: thickness_mm.all().iter().copied().fold(0.0, f64::max),
                tip_thickness_mm: None,
                youngs_modulus_mpa: table.get(&RIBS.youngs_modulus_mpa)?,
            };
            (Some(strip), thickness_mm.each())
        }
    };
    Ok(RibDescription {
        positions,
        joints: match none && !table.has(&RIBS.joints) {
            true => Joints::Rigid,
            false => table.word(&RIBS.joints, [Joints::Rigid, Joints::Hinged])?,
        },
        bracket_mm: table.get(&RIBS.bracket_mm)?,
        clip_mm: table.get(&RIBS.clip_mm)?,
        strip,
        thicknesses_mm,
        fillets_mm: table.optional(&RIBS.fillet_mm)?,
    })
}

fn read_assembly(table: &TableReader, ribs: usize) -> Result<AssemblyErrors, SceneError> {
    let rows = table.optional(&ASSEMBLY.errors)?.unwrap_or_default();
    let error = |row: &Vec<f64>| {
        UnloadedError::from_row(row, ribs).ok_or_else(|| {
            let expected = format!("rows of {} numbers for {ribs} ribs", UnloadedError::row_length(ribs));
            table.wrong(ASSEMBLY.errors.name, &expected, &format!("a row of {}", row.len()))
        })
    };
    Ok(AssemblyErrors {
        joint_sd_mm: table.get(&ASSEMBLY.joint_sigma_mm)?,
        preload_nmm: table.get(&ASSEMBLY.preload_nmm)?,
        preload_sd_nmm: table.get(&ASSEMBLY.preload_sigma_nmm)?,
        height_sd_mm: table.get(&ASSEMBLY.height_sigma_mm)?,
        further: rows.iter().map(error).collect::<Result<_, _>>()?,
    })
}

fn read_zone(table: &TableReader) -> Result<Zone, SceneError> {
    Ok(Zone {
        part: table.word(&ZONE.plate, [Part::Front, Part::Back, Part::Ribs])?,
        from_mm: table.get(&ZONE.from_mm)?,
        to_mm: table.get(&ZONE.to_mm)?,
        modulus_factor: table.get(&ZONE.modulus_factor)?,
    })
}
