//! The camera that sees the finger and the markers that it sees: `[camera]` and `[markers]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::camera::{Distortion, Lens, Pose};
use crate::finger::MarkerPoints;
use crate::keys::{BASE, CAMERA, Key, Kind, MARKERS, Number, REFERENCE, SceneTable};
use crate::measurement::{BaseUncertainty, MarkerErrors};

/// The camera as the scene has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDescription {
    /// Its lens and sensor.
    pub lens: Lens,
    /// Where the finger stands before it, where the scene says so.
    pub pose: Option<Pose>,
}

/// A colour: red, green and blue, 0 to 255 each, as an image file has them.
pub type Rgb = [u8; 3];

/// Discs or rings on the key nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Markers {
    /// Radius, mm; of rings the outer one.
    pub radius_mm: f64,
    /// Height above the plane of the beams, mm, along z = x cross y of the finger frame.
    pub height_mm: f64,
    /// How they are told from what is around them.
    pub look: MarkerLook,
}

/// What makes a marker one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MarkerLook {
    /// Colours that nothing else has.
    Coloured {
        /// On the front plate, the tip and its clamped node included.
        front_rgb: Rgb,
        /// On the back plate.
        back_rgb: Rgb,
    },
    /// A rim against which the surroundings are darker, or lighter.
    Grey {
        /// Brightness of the marker.
        shade: Shade,
        /// Radius of what is inside a ring, mm: it may look like anything; zero for discs.
        inner_radius_mm: f64,
    },
}

/// Brightness against the surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shade {
    /// Brighter.
    Bright,
    /// Darker.
    Dark,
}

/// The standard deviation of a measured coordinate, mm, and the camera.
pub(super) fn read_camera(table: &TableReader) -> Result<(Option<f64>, Option<CameraDescription>), SceneError> {
    let noise_mm = table.optional(&CAMERA.noise_mm)?;
    let pose = [CAMERA.rotation_vector_rad.name, CAMERA.translation_mm.name];
    let lens = [CAMERA.size_px.name, CAMERA.focal_px.name, CAMERA.principal_point_px.name, CAMERA.distortion.name];
    let has_pose = table.first_of(&pose).is_some();
    if !has_pose && table.first_of(&lens).is_none() {
        return match noise_mm {
            Some(_) => Ok((noise_mm, None)),
            None => Err(table.missing(CAMERA.noise_mm.name, "a length in mm, or size_px and further keys of a camera")),
        };
    }
    let lens = Lens::new(
        table.get(&CAMERA.size_px)?.map(|side| side as u32),
        table.get(&CAMERA.focal_px)?,
        table.get(&CAMERA.principal_point_px)?,
        Distortion::from_opencv(table.get(&CAMERA.distortion)?),
    )
    .map_err(|impossible| table.at(impossible.key, &format!("expected {}", impossible.expected)))?;
    let pose = match has_pose {
        false => None,
        true => Some(Pose::new(table.get(&CAMERA.rotation_vector_rad)?, table.get(&CAMERA.translation_mm)?)),
    };
    Ok((noise_mm, Some(CameraDescription { lens, pose })))
}

/// `[markers]`: what they are on and, unless displacements are given otherwise, how they look.
#[derive(Default)]
pub(super) struct MarkersRead {
    pub on: MarkerPoints,
    pub errors: MarkerErrors,
    pub discs: Option<Markers>,
}

pub(super) fn read_markers(table: &TableReader) -> Result<MarkersRead, SceneError> {
    let on = table.word(&MARKERS.on, [MarkerPoints::Junctions, MarkerPoints::Hinges])?;
    let errors =
        MarkerErrors { noise_factor: table.get(&MARKERS.noise_factor)?, model_mm: table.get(&MARKERS.model_error_mm)? };
    // A table that is there but empty lacks markers, too.
    let lookless = [MARKERS.on.name, MARKERS.noise_factor.name, MARKERS.model_error_mm.name];
    let of_look: Vec<_> =
        MARKERS.entries().iter().map(|entry| entry.name).filter(|name| !lookless.contains(name)).collect();
    let is_lookless = table.first_of(&lookless).is_some() && table.first_of(&of_look).is_none();
    let discs = if is_lookless { None } else { Some(read_discs(table)?) };
    Ok(MarkersRead { on, errors, discs })
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

/// As the keys' words name them.
const SHADES: [Shade; 2] = [Shade::Bright, Shade::Dark];

fn inner_radius_mm(table: &TableReader, key: &Key<Number>, radius_mm: f64) -> Result<f64, SceneError> {
    let inner_radius_mm = table.get(key)?;
    if (0.0..radius_mm).contains(&inner_radius_mm) {
        return Ok(inner_radius_mm);
    }
    let expected = format!("{} = {radius_mm:?}", key.kind.expected());
    Err(table.wrong(key.name, &expected, &format!("{inner_radius_mm:?}")))
}

/// A mark on the finger's base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Its place, mm, finger frame.
    pub at: Vector,
    /// How it looks, and its height above the plane of the beams.
    pub markers: Markers,
}

/// A base that is not where the camera's pose has it: it moves from image to image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Base {
    /// Marks that move with it; two or more show where it is.
    pub references: Vec<Reference>,
    /// How well the base is where the references have it, or without references where the scene has it, if the scene says so.
    pub uncertainty: Option<BaseUncertainty>,
}

impl Base {
    /// Whether it stands about where the camera's pose has it, no references showing where.
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
