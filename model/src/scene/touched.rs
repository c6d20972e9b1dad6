//! An object of known shape that touches the plate where forces are sensed: `[contact.object]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::sensing::{ObjectShape, TouchedObject};
use nalgebra::Isometry2;

/// All keys of `[contact.object]`.
pub(super) const KEYS: [&str; 9] =
    ["shape", "radius_mm", "semi_axes_mm", "corners_mm", POSE, POSE_SIGMA, ROTATION, ROTATION_SIGMA, "frame"];
const POSE: &str = "pose_mm";
const POSE_SIGMA: &str = "pose_sigma_mm";
const ROTATION: &str = "rotation_deg";
const ROTATION_SIGMA: &str = "rotation_sigma_deg";
const OUTLINE_KEYS: [&str; 3] = ["radius_mm", "semi_axes_mm", "corners_mm"];
/// Keys that say nothing without a pose.
const OF_POSE: [&str; 4] = [POSE_SIGMA, ROTATION, ROTATION_SIGMA, "frame"];
/// Largest length, mm.
const FARTHEST_MM: f64 = 1e4;

/// An object that touches the plate, as a scene has it.
#[derive(Debug, Clone, PartialEq)]
pub struct TouchedDescription {
    /// Its outline.
    pub shape: ObjectShape,
    /// Where it is, if that is known.
    pub place: Option<ObjectPlace>,
}

/// Where an object is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectPlace {
    /// Origin of its outline, mm, and its turn.
    pub pose: Isometry2<f64>,
    /// Standard deviation of each coordinate of the origin, mm.
    pub sd_mm: f64,
    /// Standard deviation of the turn, rad.
    pub sd_rad: f64,
    /// In which frame.
    pub frame: ObjectFrame,
}

/// The frame of an object's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObjectFrame {
    /// That of the finger, where the image has its base.
    Base,
    /// That of the camera's pose, in which bases move from image to image.
    Plane,
}

impl TouchedDescription {
    /// The object as a measurement has it whose base is at `base` in the frame of the camera's pose; `None` where its pose is not known.
    pub fn seen_from(&self, base: &Isometry2<f64>) -> Option<TouchedObject> {
        let ObjectPlace { pose, sd_mm, sd_rad, frame } = self.place?;
        let pose = match frame {
            ObjectFrame::Base => pose,
            ObjectFrame::Plane => base.inverse() * pose,
        };
        Some(TouchedObject { shape: self.shape.clone(), pose, sd_mm, sd_rad })
    }
}

pub(super) fn read_touched(table: &TableReader) -> Result<TouchedDescription, SceneError> {
    let shape = read_shape(table)?;
    let place = match table.optional_numbers::<2>(POSE, "x and y of the origin of its outline in mm")? {
        Some(pose_mm) => Some(read_place(table, &shape, pose_mm)?),
        None => match OF_POSE.iter().find(|key| table.has(key)) {
            Some(key) => return Err(table.missing(POSE, &format!("[x, y] in mm, as `{key}` is there"))),
            None => None,
        },
    };
    Ok(TouchedDescription { shape, place })
}

#[derive(Clone, Copy)]
enum Shape {
    Disc,
    Ellipse,
    Polygon,
}

fn read_shape(table: &TableReader) -> Result<ObjectShape, SceneError> {
    let choices = [("disc", Shape::Disc), ("ellipse", Shape::Ellipse), ("polygon", Shape::Polygon)];
    let shape = table.choice("shape", &choices)?;
    let (name, own) = match shape {
        Shape::Disc => ("a disc", OUTLINE_KEYS[0]),
        Shape::Ellipse => ("an ellipse", OUTLINE_KEYS[1]),
        Shape::Polygon => ("a polygon", OUTLINE_KEYS[2]),
    };
    if let Some(key) = OUTLINE_KEYS.iter().find(|key| **key != own && table.has(key)) {
        return Err(table.wrong(key, "nothing", &format!("a value that {name} does not have")));
    }
    match shape {
        Shape::Disc => Ok(ObjectShape::Disc { radius_mm: positive(table, own, table.number(own, "length in mm")?)? }),
        Shape::Ellipse => {
            let [a_mm, b_mm] = table.numbers(own, "half of each axis in mm")?;
            Ok(ObjectShape::Ellipse { semi_axes_mm: [positive(table, own, a_mm)?, positive(table, own, b_mm)?] })
        }
        Shape::Polygon => {
            let corners = table.optional_pairs(own, "[x, y], corners in mm")?;
            let corners: Vec<Vector> = match corners {
                Some(corners) => corners.into_iter().map(Vector::from).collect(),
                None => return Err(table.missing(own, "a list of pairs [x, y], corners in mm")),
            };
            // Not a number is far off, too.
            let is_far = |corner: &Vector| !corner.iter().all(|x| x.abs() <= FARTHEST_MM);
            if corners.iter().any(is_far) {
                return Err(table.wrong(own, &format!("corners within {FARTHEST_MM} mm of the origin"), "others"));
            }
            ObjectShape::polygon(corners).map_err(|error| table.wrong(own, &error.to_string(), "others"))
        }
    }
}

fn read_place(table: &TableReader, shape: &ObjectShape, pose_mm: [f64; 2]) -> Result<ObjectPlace, SceneError> {
    if pose_mm.iter().any(|x| x.abs() > FARTHEST_MM) {
        let expected = format!("[x, y], no further than {FARTHEST_MM} mm");
        return Err(table.wrong(POSE, &expected, &format!("{pose_mm:?}")));
    }
    if let Some(key) = [ROTATION, ROTATION_SIGMA].iter().find(|key| shape.is_round() && table.has(key)) {
        return Err(table.wrong(key, "nothing", "a value that a disc does not have"));
    }
    let rotation_deg = table.optional_number(ROTATION, "angle in degrees")?.unwrap_or(0.0);
    if !rotation_deg.is_finite() {
        return Err(table.wrong(ROTATION, "a finite angle in degrees", &format!("{rotation_deg:?}")));
    }
    let sd_mm = sd(table, POSE_SIGMA, table.number(POSE_SIGMA, "standard deviation in mm")?)?;
    let sd_deg = table.optional_number(ROTATION_SIGMA, "standard deviation in degrees")?.unwrap_or(0.0);
    let frame = match table.has("frame") {
        false => ObjectFrame::Base,
        true => table.choice("frame", &[("base", ObjectFrame::Base), ("plane", ObjectFrame::Plane)])?,
    };
    let sd_rad = sd(table, ROTATION_SIGMA, sd_deg)?.to_radians();
    Ok(ObjectPlace { pose: Isometry2::new(Vector::from(pose_mm), rotation_deg.to_radians()), sd_mm, sd_rad, frame })
}

fn positive(table: &TableReader, key: &str, length_mm: f64) -> Result<f64, SceneError> {
    match length_mm.is_normal() && 0.0 < length_mm && length_mm <= FARTHEST_MM {
        true => Ok(length_mm),
        false => {
            let expected = format!("a length in mm above zero, up to {FARTHEST_MM}");
            Err(table.wrong(key, &expected, &format!("{length_mm:?}")))
        }
    }
}

/// A standard deviation: zero where something is known exactly.
fn sd(table: &TableReader, key: &str, value: f64) -> Result<f64, SceneError> {
    match (0.0..=FARTHEST_MM).contains(&value) && (value == 0.0 || value.is_normal()) {
        true => Ok(value),
        false => Err(table.wrong(key, &format!("a standard deviation, 0 to {FARTHEST_MM}"), &format!("{value:?}"))),
    }
}
