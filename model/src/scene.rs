//! The scene file: TOML text to a checked [`Finger`].

mod camera;
mod contact;
mod grasp;
mod gripper;
mod object;
mod reader;
mod touched;

pub use camera::{Base, CameraDescription, MarkerLook, Markers, Reference, Rgb, Shade};
pub use contact::ContactDescription;
pub use grasp::{GraspDescription, Support};
pub use object::{ObjectDescription, ObjectMotion, Outline, ROD_RADIUS_MM, Until};
pub use touched::{ObjectFrame, ObjectPlace, TouchedDescription};

use crate::finger::{
    BracketLengths, Finger, FingerDescription, Joints, MarkerPoints, Part, RibDescription, RibPositions, RigidEnds,
    Strip, Zone,
};
use crate::gripper::Gripper;
use crate::measurement::MarkerErrors;
use crate::validity::StrainLimits;
use reader::{Document, TableReader};

/// What a scene file describes.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// The finger.
    pub finger: Finger,
    /// Up to which strain the material of each part is what the model takes it for, where the scene says so.
    pub strain_limits: StrainLimits,
    /// Standard deviation of one measured coordinate, mm, where the scene says so.
    pub noise_mm: Option<f64>,
    /// Errors of markers beside what is stated of each.
    pub marker_errors: MarkerErrors,
    /// The camera, where the scene has one.
    pub camera: Option<CameraDescription>,
    /// The markers that it sees, where the scene has them.
    pub markers: Option<Markers>,
    /// How the base is found, where it moves from image to image.
    pub base: Option<Base>,
    /// How objects meet the finger.
    pub contact: ContactDescription,
    /// The object that touches the front plate where forces are sensed, where the scene has one.
    pub touched: Option<TouchedDescription>,
    /// The object that is pressed onto the finger, where the scene has one.
    pub object: Option<ObjectDescription>,
    /// The linkage that moves two such fingers, where the scene has one.
    pub gripper: Option<Gripper>,
    /// What the gripper does to the object, where the scene says so.
    pub grasp: Option<GraspDescription>,
}

/// A scene text that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct SceneError {
    /// Line of the text, from 1.
    pub line: usize,
    /// The key and what was expected.
    pub message: String,
}

impl Scene {
    /// Reads a scene from TOML text. Every key is checked: unknown keys, missing keys, values of another type and
    /// impossible geometry are refused.
    ///
    /// # Errors
    /// [`SceneError`] with the line, the key and what was expected.
    pub fn from_toml(text: &str) -> Result<Scene, SceneError> {
        let document = Document::parse(text)?;
        let top =
            document.top(&["name", "finger", "camera", "markers", "base", "contact", "object", "gripper", "grasp"])?;
        let name = top.text("name")?;
        let markers = match top.optional_table("markers", &camera::MARKER_KEYS)? {
            None => camera::MarkersRead::default(),
            Some(table) => camera::read_markers(&table)?,
        };
        let table = top.table("finger", &FINGER_KEYS)?;
        let description = read_finger(&table, markers.on)?;
        let strain_limits = read_strain_limits(&table)?;
        let finger = Finger::new(description).map_err(|impossible| SceneError {
            line: document.line_of(&impossible.key),
            message: impossible.to_string(),
        })?;
        let (noise_mm, camera) = match top.optional_table("camera", &camera::KEYS)? {
            None => (None, None),
            Some(table) => camera::read_camera(&table)?,
        };
        let base = match top.optional_table("base", &camera::BASE_KEYS)? {
            None => None,
            Some(table) => Some(camera::read_base(&table)?),
        };
        let (contact, touched) = match top.optional_table("contact", &contact::KEYS)? {
            None => (ContactDescription::default(), None),
            Some(table) => {
                let touched = table.optional_table("object", &touched::KEYS)?;
                (contact::read_contact(&table, &finger)?, touched.as_ref().map(touched::read_touched).transpose()?)
            }
        };
        let object = match top.optional_table("object", &object::KEYS)? {
            None => None,
            Some(table) => Some(object::read_object(&table, &finger)?),
        };
        let gripper = match top.optional_table("gripper", &gripper::KEYS)? {
            None => None,
            Some(table) => Some(gripper::read_gripper(&table)?),
        };
        let grasp = match top.optional_table("grasp", &grasp::KEYS)? {
            None => None,
            Some(table) => Some(grasp::read_grasp(&table, gripper.as_ref())?),
        };
        Ok(Scene {
            name,
            finger,
            strain_limits,
            noise_mm,
            marker_errors: markers.errors,
            camera,
            markers: markers.discs,
            base,
            contact,
            touched,
            object,
            gripper,
            grasp,
        })
    }
}

fn not_negative_mm(table: &TableReader, key: &str) -> Result<f64, SceneError> {
    let length_mm = table.number(key, "length in mm")?;
    if length_mm.is_finite() && length_mm >= 0.0 {
        Ok(length_mm)
    } else {
        Err(table.wrong(key, "a length in mm, zero or more", &format!("{length_mm:?}")))
    }
}

const FINGER_KEYS: [&str; 10] = [
    "base_width_mm",
    "front_length_mm",
    "back_length_mm",
    "depth_mm",
    "rod_arm_mm",
    "poissons_ratio",
    "front",
    "back",
    "ribs",
    "zone",
];

fn read_finger(table: &TableReader, markers_on: MarkerPoints) -> Result<FingerDescription, SceneError> {
    Ok(FingerDescription {
        base_width_mm: table.number("base_width_mm", "length in mm")?,
        front_length_mm: table.number("front_length_mm", "length in mm")?,
        back_length_mm: table.number("back_length_mm", "length in mm")?,
        depth_mm: table.number("depth_mm", "length in mm")?,
        rod_arm_mm: table.optional_number("rod_arm_mm", "length in mm")?.unwrap_or(0.0),
        poissons_ratio: table.optional_number("poissons_ratio", "ratio")?.unwrap_or(0.0),
        front: read_strip(&table.table("front", &PLATE_KEYS)?)?,
        back: read_strip(&table.table("back", &PLATE_KEYS)?)?,
        rigid_ends: [
            read_rigid_ends(&table.table("front", &PLATE_KEYS)?)?,
            read_rigid_ends(&table.table("back", &PLATE_KEYS)?)?,
        ],
        ribs: read_ribs(&table.table("ribs", &RIB_KEYS)?)?,
        zones: table
            .tables("zone", &["plate", "from_mm", "to_mm", "modulus_factor"])?
            .iter()
            .map(read_zone)
            .collect::<Result<_, _>>()?,
        markers_on,
    })
}

/// The material of a plate or rib.
const MATERIAL_KEYS: [&str; 2] = ["thickness_mm", "youngs_modulus_mpa"];
const LARGEST_STRAIN: &str = "largest_strain";
const PLATE_KEYS: [&str; 5] = ["thickness_mm", "youngs_modulus_mpa", LARGEST_STRAIN, "rigid_base_mm", "rigid_tip_mm"];
const RIB_KEYS: [&str; 9] = [
    "count",
    "positions_mm",
    "joints",
    "bracket_mm",
    "clip_mm",
    "rigid",
    "thickness_mm",
    "youngs_modulus_mpa",
    LARGEST_STRAIN,
];

fn read_strain_limits(finger: &TableReader) -> Result<StrainLimits, SceneError> {
    let limit = |table: TableReader| match table.optional_number(LARGEST_STRAIN, "strain")? {
        Some(strain) if !(strain > 0.0 && strain <= 1.0) => {
            Err(table.wrong(LARGEST_STRAIN, "a strain above 0 and up to 1", &format!("{strain:?}")))
        }
        strain => Ok(strain),
    };
    Ok(StrainLimits {
        front: limit(finger.table("front", &PLATE_KEYS)?)?,
        back: limit(finger.table("back", &PLATE_KEYS)?)?,
        ribs: limit(finger.table("ribs", &RIB_KEYS)?)?,
    })
}

fn read_rigid_ends(table: &TableReader) -> Result<RigidEnds, SceneError> {
    Ok(RigidEnds {
        base_mm: table.optional_number("rigid_base_mm", "length in mm")?.unwrap_or_default(),
        tip_mm: table.optional_number("rigid_tip_mm", "length in mm")?.unwrap_or_default(),
    })
}

fn read_strip(table: &TableReader) -> Result<Strip, SceneError> {
    Ok(Strip {
        thickness_mm: table.number("thickness_mm", "length in mm")?,
        youngs_modulus_mpa: table.number("youngs_modulus_mpa", "modulus in MPa")?,
    })
}

fn read_ribs(table: &TableReader) -> Result<RibDescription, SceneError> {
    let positions =
        match (table.optional_count("count")?, table.optional_pairs("positions_mm", "[front, back], positions in mm")?)
        {
            (Some(count), None) => RibPositions::Count(count),
            (None, Some(positions)) => RibPositions::Positions(positions),
            (Some(_), Some(_)) => return Err(table.wrong("positions_mm", "either count or positions_mm", "both")),
            (None, None) => return Err(table.missing("count", "the number of ribs, or positions_mm")),
        };
    let joints = table.choice("joints", &[("rigid", Joints::Rigid), ("hinged", Joints::Hinged)])?;
    let rigid = table.optional_switch("rigid")?.unwrap_or(false);
    let none = positions == RibPositions::Count(0) || positions == RibPositions::Positions(Vec::new());
    let given = MATERIAL_KEYS.iter().any(|key| table.has(key));
    let strip = if rigid || (none && !given) {
        // Ribs that do not deform have no use for a material, but one that stands there must make sense.
        for key in MATERIAL_KEYS {
            match table.optional_number(key, "number")? {
                Some(value) if !(value.is_normal() && value > 0.0) => {
                    return Err(table.wrong(key, "a positive number", &format!("{value:?}")));
                }
                _ => {}
            }
        }
        None
    } else {
        Some(read_strip(table)?)
    };
    let lengths = |key| table.optional_number_or_pair(key, "a length in mm, or [front, back]");
    let clip_mm = lengths("clip_mm")?.unwrap_or_default();
    let bracket_mm = match table.is_list_of_lists("bracket_mm") {
        true => {
            let each = table.optional_pairs("bracket_mm", "[front, back], lengths in mm")?;
            BracketLengths::Each(each.unwrap_or_default())
        }
        false => BracketLengths::Alike(lengths("bracket_mm")?.unwrap_or_default()),
    };
    Ok(RibDescription { positions, joints, bracket_mm, clip_mm, strip })
}

fn read_zone(table: &TableReader) -> Result<Zone, SceneError> {
    Ok(Zone {
        part: table.choice("plate", &[("front", Part::Front), ("back", Part::Back), ("ribs", Part::Ribs)])?,
        from_mm: table.number("from_mm", "position in mm")?,
        to_mm: table.number("to_mm", "position in mm")?,
        modulus_factor: table.number("modulus_factor", "factor")?,
    })
}
