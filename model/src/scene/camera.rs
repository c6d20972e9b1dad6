//! Reading of the camera and the markers: the tables `[camera]`, `[markers]` and `[base]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::camera::{Distortion, Lens, Pose};
use crate::finger::{MarkerPoints, NodeId};
use crate::keys::{BASE, CAMERA, Key, Kind, MARKERS, Number, REFERENCE, SceneTable};
use crate::measurement::{BaseUncertainty, MarkerErrors};
use nalgebra::Vector6;

/// The camera of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDescription {
    /// Lens and image sensor.
    pub lens: Lens,
    /// Pose of the finger frame relative to the camera; `None` if the scene does not state it.
    pub pose: Option<Pose>,
}

/// A colour as red, green and blue, 0 to 255 each, as an image file stores it.
pub type Rgb = [u8; 3];

/// Markers on the finger: discs or rings centred on key nodes or joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Markers {
    /// Radius of the markers, mm; for rings, the outer radius.
    pub radius_mm: f64,
    /// Height of the markers above the plane of the beams, mm, measured along the z axis (x cross y) of the finger frame.
    pub height_mm: f64,
    /// Appearance that distinguishes the markers from the background.
    pub look: MarkerLook,
}

/// Position of a marker relative to its node by [`Scene::marker_offsets`](super::Scene::marker_offsets), mm: zero without offsets.
pub fn marker_offset(offsets: &[Vector], node: NodeId) -> Vector {
    node.0.checked_sub(1).and_then(|index| offsets.get(index)).copied().unwrap_or_default()
}

/// Appearance that distinguishes markers from the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MarkerLook {
    /// The markers have two colours that occur nowhere else in the image.
    Coloured {
        /// Colour of the markers on the front plate, including the tip and the clamped node.
        front_rgb: Rgb,
        /// Colour of the markers on the back plate.
        back_rgb: Rgb,
    },
    /// The markers have a visible rim: they are bright in dark surroundings, or dark in bright surroundings.
    Grey {
        /// Brightness of the marker relative to its surroundings.
        shade: Shade,
        /// Inner radius of a ring, mm; zero for discs. The area inside this radius may have any appearance.
        inner_radius_mm: f64,
    },
}

/// Brightness of a mark relative to its surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shade {
    /// Brighter than the surroundings.
    Bright,
    /// Darker than the surroundings.
    Dark,
}

/// Reads the standard deviation of a measured marker coordinate (mm) and the camera. Each of the two results is `None` if the scene does not state
/// it.
pub(super) fn read_camera(table: &TableReader) -> Result<(Option<f64>, Option<CameraDescription>), SceneError> {
    let noise_mm = table.optional(&CAMERA.noise_mm)?;
    let pose = [CAMERA.rotation_vector_rad.name, CAMERA.translation_mm.name];
    let lens = [CAMERA.size_px.name, CAMERA.focal_px.name, CAMERA.principal_point_px.name];
    let lens = [&lens[..], &[CAMERA.distortion.name, CAMERA.distortion_model.name]].concat();
    let has_pose = table.first_of(&pose).is_some();
    if !has_pose && table.first_of(&lens).is_none() {
        return match noise_mm {
            Some(_) => Ok((noise_mm, None)),
            None => Err(table.missing(CAMERA.noise_mm.name, "a length in mm, or size_px and further keys of a camera")),
        };
    }
    let coefficients = table.get(&CAMERA.distortion)?;
    let distortion = match table.get(&CAMERA.distortion_model)? {
        0 => Distortion::rational(&coefficients),
        _ => Distortion::fisheye(&coefficients),
    };
    let distortion = distortion.map_err(|error| table.at(CAMERA.distortion.name, &format!("expected {error}")))?;
    let lens = Lens::new(
        table.get(&CAMERA.size_px)?.map(|side| side as u32),
        table.get(&CAMERA.focal_px)?,
        table.get(&CAMERA.principal_point_px)?,
        distortion,
    )
    .map_err(|impossible| table.at(impossible.key, &format!("expected {}", impossible.expected)))?;
    let pose = match has_pose {
        false => None,
        true => Some(Pose::new(table.get(&CAMERA.rotation_vector_rad)?, table.get(&CAMERA.translation_mm)?)),
    };
    Ok((noise_mm, Some(CameraDescription { lens, pose })))
}

/// Reads the errors of the camera's pose.
pub(super) fn read_pose_errors(table: &TableReader) -> Result<Vec<Vector6<f64>>, SceneError> {
    let wrong =
        |row: &Vec<f64>| table.wrong(CAMERA.pose_errors.name, "rows of 6 numbers", &format!("a row of {}", row.len()));
    let motion = |row: &Vec<f64>| (row.len() == 6).then(|| Vector6::from_column_slice(row)).ok_or_else(|| wrong(row));
    table.get(&CAMERA.pose_errors)?.iter().map(motion).collect()
}

/// Contents of the table `[markers]`: the points of the finger that carry markers, the errors of the markers and, if described, their appearance in
/// images.
#[derive(Default)]
pub(super) struct MarkersRead {
    pub on: MarkerPoints,
    pub errors: MarkerErrors,
    pub offsets: Vec<Vector>,
    pub missing: Vec<NodeId>,
    pub discs: Option<Markers>,
}

pub(super) fn read_markers(table: &TableReader) -> Result<MarkersRead, SceneError> {
    let on = table.word(&MARKERS.on, [MarkerPoints::Junctions, MarkerPoints::Hinges])?;
    let errors = MarkerErrors {
        noise_factor: table.get(&MARKERS.noise_factor)?,
        noise_factor_of_mm: table.optional(&MARKERS.noise_factor_of_mm)?,
        calibration_error_mm: table.get(&MARKERS.model_error_mm)?,
    };
    // An empty table `[markers]` counts as a description of the markers' appearance. An empty table is therefore rejected, because the required keys
    // of the appearance are missing.
    let offsets = table.optional(&MARKERS.offsets_mm)?.unwrap_or_default().into_iter().map(Vector::from).collect();
    let lookless = [
        MARKERS.on.name,
        MARKERS.noise_factor.name,
        MARKERS.noise_factor_of_mm.name,
        MARKERS.model_error_mm.name,
        MARKERS.offsets_mm.name,
        MARKERS.missing_nodes.name,
    ];
    let of_look: Vec<_> =
        MARKERS.entries().iter().map(|entry| entry.name).filter(|name| !lookless.contains(name)).collect();
    let is_lookless = table.first_of(&lookless).is_some() && table.first_of(&of_look).is_none();
    let discs = if is_lookless { None } else { Some(read_discs(table)?) };
    let missing = table.get(&MARKERS.missing_nodes)?.into_iter().map(|node| NodeId(node as usize)).collect();
    Ok(MarkersRead { on, errors, offsets, missing, discs })
}

fn read_discs(table: &TableReader) -> Result<Markers, SceneError> {
    let radius_mm = table.get(&MARKERS.radius_mm)?;
    Ok(Markers { radius_mm, height_mm: table.get(&MARKERS.height_mm)?, look: read_look(table, radius_mm)? })
}

fn read_look(table: &TableReader, radius_mm: f64) -> Result<MarkerLook, SceneError> {
    if table.first_of(&[MARKERS.shade.name, MARKERS.inner_radius_mm.name]).is_none() {
        return Ok(MarkerLook::Coloured {
            front_rgb: table.get(&MARKERS.front_rgb)?.map(|part| part as u8),
            back_rgb: table.get(&MARKERS.back_rgb)?.map(|part| part as u8),
        });
    }
    if let Some(colour) = table.first_of(&[MARKERS.front_rgb.name, MARKERS.back_rgb.name]) {
        let found = format!("shade and {colour}");
        return Err(table.wrong(MARKERS.shade.name, "either shade or front_rgb and back_rgb", &found));
    }
    let inner_radius_mm = inner_radius_mm(table, &MARKERS.inner_radius_mm, radius_mm)?;
    Ok(MarkerLook::Grey { shade: table.word(&MARKERS.shade, SHADES)?, inner_radius_mm })
}

/// Shades in the order of the words that the key accepts.
const SHADES: [Shade; 2] = [Shade::Bright, Shade::Dark];

fn inner_radius_mm(table: &TableReader, key: &Key<Number>, radius_mm: f64) -> Result<f64, SceneError> {
    let inner_radius_mm = table.get(key)?;
    if (0.0..radius_mm).contains(&inner_radius_mm) {
        return Ok(inner_radius_mm);
    }
    let expected = format!("{} = {radius_mm:?}", key.kind.expected());
    Err(table.wrong(key.name, &expected, &format!("{inner_radius_mm:?}")))
}

/// A reference mark on the finger's base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Position of the mark's centre, mm, finger frame.
    pub at: Vector,
    /// Appearance, radius and height of the mark.
    pub markers: Markers,
}

/// A base that moves between images, so that the camera's pose alone does not determine the position of the base.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Base {
    /// Reference marks that move with the base. Two or more marks determine the pose of the base.
    pub references: Vec<Reference>,
    /// Uncertainty of the base's pose relative to the reference marks or, without marks, to the camera's pose; `None` if the scene does not state it.
    pub uncertainty: Option<BaseUncertainty>,
}

impl Base {
    /// Whether the base has an uncertainty but no reference marks. Without reference marks, the uncertainty of the base is relative to the camera's
    /// pose.
    pub fn is_of_pose(&self) -> bool {
        self.references.is_empty() && self.uncertainty.is_some()
    }
}

pub(super) fn read_base(table: &TableReader) -> Result<Base, SceneError> {
    let uncertain = [BASE.sigma_mm.name, BASE.sigma_deg.name, BASE.turn_deg_per_n.name, BASE.turn_sigma_deg_per_n.name];
    let uncertainty = match table.first_of(&uncertain) {
        None => None,
        Some(_) => Some(BaseUncertainty {
            sd_mm: table.get(&BASE.sigma_mm)?,
            sd_rad: table.get(&BASE.sigma_deg)?.to_radians(),
            turn_rad_per_n: table.get(&BASE.turn_deg_per_n)?.to_radians(),
            turn_sd_rad_per_n: table.get(&BASE.turn_sigma_deg_per_n)?.to_radians(),
        }),
    };
    let references = table.tables(&REFERENCE)?.iter().map(read_reference).collect::<Result<_, _>>()?;
    Ok(Base { references, uncertainty })
}

fn read_reference(table: &TableReader) -> Result<Reference, SceneError> {
    let radius_mm = table.get(&REFERENCE.radius_mm)?;
    let look = MarkerLook::Grey {
        shade: table.word(&REFERENCE.shade, SHADES)?,
        inner_radius_mm: inner_radius_mm(table, &REFERENCE.inner_radius_mm, radius_mm)?,
    };
    let markers = Markers { radius_mm, height_mm: table.get(&REFERENCE.height_mm)?, look };
    Ok(Reference { at: table.get(&REFERENCE.at_mm)?.into(), markers })
}
