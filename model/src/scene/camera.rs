//! The camera that sees the finger and the markers that it sees: `[camera]` and `[markers]`.

use super::reader::TableReader;
use super::{SceneError, not_negative_mm};
use crate::Vector;
use crate::camera::{Distortion, Lens, Pose};
use crate::finger::MarkerPoints;
use crate::measurement::{BaseUncertainty, MarkerErrors};

/// Farthest distance of the finger from the camera, mm, and largest size of a marker.
const FARTHEST_MM: f64 = 1e5;
const LARGEST_MARKER_MM: f64 = 1e3;
/// Beyond it the turn of a base is anything.
const LARGEST_SIGMA_DEG: f64 = 90.0;
/// A base that turns by more under a newton is no base.
const LARGEST_TURN_DEG_PER_N: f64 = 10.0;
/// Keys that describe the camera's images.
const LENS_KEYS: [&str; 4] = ["size_px", "focal_px", "principal_point_px", "distortion"];
const POSE_KEYS: [&str; 2] = ["rotation_vector_rad", "translation_mm"];

/// All keys of `[camera]`.
pub(super) const KEYS: [&str; 7] =
    ["noise_mm", "size_px", "focal_px", "principal_point_px", "distortion", "rotation_vector_rad", "translation_mm"];

/// All keys of `[markers]`.
pub(super) const MARKER_KEYS: [&str; 9] =
    ["on", NOISE_FACTOR, MODEL_ERROR, "radius_mm", "height_mm", "front_rgb", "back_rgb", "shade", "inner_radius_mm"];
const MODEL_ERROR: &str = "model_error_mm";
const NOISE_FACTOR: &str = "noise_factor";
/// Those that do not say how markers look.
const LOOKLESS: [&str; 3] = ["on", NOISE_FACTOR, MODEL_ERROR];
const COLOUR_KEYS: [&str; 2] = ["front_rgb", "back_rgb"];
const SHADE_KEYS: [&str; 2] = ["shade", "inner_radius_mm"];

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
    let noise_mm = if table.has("noise_mm") { Some(not_negative_mm(table, "noise_mm")?) } else { None };
    if !LENS_KEYS.iter().chain(&POSE_KEYS).any(|key| table.has(key)) {
        return match noise_mm {
            Some(_) => Ok((noise_mm, None)),
            None => Err(table.missing("noise_mm", "a length in mm, or size_px and further keys of a camera")),
        };
    }
    let size_px: [f64; 2] = table.numbers("size_px", "width and height in px")?;
    let whole = |side: &f64| side.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(side);
    if !size_px.iter().all(whole) {
        return Err(table.wrong("size_px", "whole numbers, width and height in px", &format!("{size_px:?}")));
    }
    let distortion: [f64; 5] = table.optional_numbers("distortion", "k1, k2, p1, p2, k3")?.unwrap_or_default();
    let lens = Lens::new(
        size_px.map(|side| side as u32),
        table.numbers("focal_px", "focal lengths along u and v in px")?,
        table.numbers("principal_point_px", "u and v in px")?,
        Distortion::from_opencv(distortion),
    )
    .map_err(|impossible| table.at(impossible.key, &impossible.to_string()))?;
    let pose = match POSE_KEYS.iter().any(|key| table.has(key)) {
        false => None,
        true => Some(read_pose(table)?),
    };
    Ok((noise_mm, Some(CameraDescription { lens, pose })))
}

fn read_pose(table: &TableReader) -> Result<Pose, SceneError> {
    let rotation: [f64; 3] = table.numbers("rotation_vector_rad", "a rotation vector in rad")?;
    if rotation.iter().any(|angle| angle.abs() > 100.0) {
        return Err(table.wrong("rotation_vector_rad", "a rotation vector in rad", &format!("{rotation:?}")));
    }
    let translation: [f64; 3] = table.numbers("translation_mm", "a translation in mm")?;
    if translation.iter().any(|length| length.abs() > FARTHEST_MM) {
        let expected = format!("a translation of at most {FARTHEST_MM} mm");
        return Err(table.wrong("translation_mm", &expected, &format!("{translation:?}")));
    }
    Ok(Pose::new(rotation, translation))
}

/// `[markers]`: what they are on and, unless displacements are given otherwise, how they look.
#[derive(Default)]
pub(super) struct MarkersRead {
    pub on: MarkerPoints,
    pub errors: MarkerErrors,
    pub discs: Option<Markers>,
}

pub(super) fn read_markers(table: &TableReader) -> Result<MarkersRead, SceneError> {
    let points = [("junctions", MarkerPoints::Junctions), ("hinges", MarkerPoints::Hinges)];
    let on = if table.has("on") { table.choice("on", &points)? } else { MarkerPoints::default() };
    let noise_factor = table.optional_number(NOISE_FACTOR, "number")?.unwrap_or(1.0);
    if !(noise_factor > 0.0 && noise_factor <= 1.0) {
        return Err(table.wrong(NOISE_FACTOR, "a number above 0 and up to 1", &format!("{noise_factor:?}")));
    }
    let model_mm = if table.has(MODEL_ERROR) { not_negative_mm(table, MODEL_ERROR)? } else { 0.0 };
    let given = |lookless: bool| MARKER_KEYS.iter().any(|key| LOOKLESS.contains(key) == lookless && table.has(key));
    let discs = if given(true) && !given(false) { None } else { Some(read_discs(table)?) };
    Ok(MarkersRead { on, errors: MarkerErrors { noise_factor, model_mm }, discs })
}

fn read_discs(table: &TableReader) -> Result<Markers, SceneError> {
    let radius_mm = table.number("radius_mm", "length in mm")?;
    if !(radius_mm > 0.0 && radius_mm <= LARGEST_MARKER_MM) {
        let expected = format!("a length in mm, above 0 and up to {LARGEST_MARKER_MM}");
        return Err(table.wrong("radius_mm", &expected, &format!("{radius_mm:?}")));
    }
    let height_mm = table.number("height_mm", "length in mm")?;
    if height_mm.is_nan() || height_mm.abs() > LARGEST_MARKER_MM {
        let expected = format!("a length of at most {LARGEST_MARKER_MM} mm");
        return Err(table.wrong("height_mm", &expected, &format!("{height_mm:?}")));
    }
    Ok(Markers { radius_mm, height_mm, look: read_look(table, radius_mm)? })
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

/// All keys of `[base]`, and of each reference.
pub(super) const BASE_KEYS: [&str; 5] = ["reference", "sigma_mm", "sigma_deg", TURN_PER_N, TURN_SIGMA_PER_N];
const TURN_PER_N: &str = "turn_deg_per_n";
const TURN_SIGMA_PER_N: &str = "turn_sigma_deg_per_n";
const REFERENCE_KEYS: [&str; 5] = ["at_mm", "radius_mm", "height_mm", "shade", "inner_radius_mm"];

pub(super) fn read_base(table: &TableReader) -> Result<Base, SceneError> {
    let reference = |table: &TableReader| {
        let [x, y] = table.numbers("at_mm", "x and y in mm")?;
        if x.abs() > FARTHEST_MM || y.abs() > FARTHEST_MM {
            return Err(table.wrong(
                "at_mm",
                &format!("lengths of at most {FARTHEST_MM} mm"),
                &format!("{:?}", [x, y]),
            ));
        }
        if !table.has("shade") {
            return Err(table.missing("shade", "\"bright\" or \"dark\""));
        }
        Ok(Reference { at: Vector::new(x, y), markers: read_discs(table)? })
    };
    let references = table.tables("reference", &REFERENCE_KEYS)?;
    let uncertainty = match ["sigma_mm", "sigma_deg", TURN_PER_N, TURN_SIGMA_PER_N].iter().any(|key| table.has(key)) {
        false => None,
        true => Some(BaseUncertainty {
            sd_mm: not_negative_mm(table, "sigma_mm")?,
            sd_rad: read_sigma_deg(table)?.to_radians(),
            turn_rad_per_n: read_turn_per_n(table, TURN_PER_N, -LARGEST_TURN_DEG_PER_N)?.to_radians(),
            turn_sd_rad_per_n: read_turn_per_n(table, TURN_SIGMA_PER_N, 0.0)?.to_radians(),
        }),
    };
    Ok(Base { references: references.iter().map(reference).collect::<Result<_, _>>()?, uncertainty })
}

fn read_turn_per_n(table: &TableReader, key: &str, least: f64) -> Result<f64, SceneError> {
    let deg_per_n = table.optional_number(key, "angle in degrees a newton")?.unwrap_or(0.0);
    match (least..=LARGEST_TURN_DEG_PER_N).contains(&deg_per_n) {
        true => Ok(deg_per_n),
        false => {
            let expected = format!("an angle in degrees a newton, {least} to {LARGEST_TURN_DEG_PER_N}");
            Err(table.wrong(key, &expected, &format!("{deg_per_n:?}")))
        }
    }
}

fn read_sigma_deg(table: &TableReader) -> Result<f64, SceneError> {
    let sigma_deg = table.number("sigma_deg", "angle in degrees")?;
    match (0.0..=LARGEST_SIGMA_DEG).contains(&sigma_deg) {
        true => Ok(sigma_deg),
        false => {
            let expected = format!("an angle in degrees, 0 to {LARGEST_SIGMA_DEG}");
            Err(table.wrong("sigma_deg", &expected, &format!("{sigma_deg:?}")))
        }
    }
}

fn read_look(table: &TableReader, radius_mm: f64) -> Result<MarkerLook, SceneError> {
    if !SHADE_KEYS.iter().any(|key| table.has(key)) {
        return Ok(MarkerLook::Coloured {
            front_rgb: read_rgb(table, "front_rgb")?,
            back_rgb: read_rgb(table, "back_rgb")?,
        });
    }
    if let Some(colour) = COLOUR_KEYS.iter().find(|key| table.has(key)) {
        return Err(table.wrong("shade", "either shade or front_rgb and back_rgb", &format!("shade and {colour}")));
    }
    let shade = table.choice("shade", &[("bright", Shade::Bright), ("dark", Shade::Dark)])?;
    let inner_radius_mm = table.optional_number("inner_radius_mm", "length in mm")?.unwrap_or(0.0);
    if !(0.0..radius_mm).contains(&inner_radius_mm) {
        let expected = format!("a length in mm, zero or more and below radius_mm = {radius_mm:?}");
        return Err(table.wrong("inner_radius_mm", &expected, &format!("{inner_radius_mm:?}")));
    }
    Ok(MarkerLook::Grey { shade, inner_radius_mm })
}

fn read_rgb(table: &TableReader, key: &str) -> Result<Rgb, SceneError> {
    let colour: [f64; 3] = table.numbers(key, "red, green and blue from 0 to 255")?;
    if !colour.iter().all(|part| part.fract() == 0.0 && (0.0..=255.0).contains(part)) {
        return Err(table.wrong(key, "whole numbers from 0 to 255, red, green and blue", &format!("{colour:?}")));
    }
    Ok(colour.map(|part| part as u8))
}
