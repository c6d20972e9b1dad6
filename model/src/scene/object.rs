//! Reading of the object that is pressed onto the finger or grasped: the table `[object]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::finger::{Finger, Plate};
use crate::keys::{Kind, OBJECT};

/// Outline of a pressed or grasped object, relative to the object's reference point. Motions of the object refer to its reference point. The crate
/// `finray-contact` turns it into corners with a radius about each (`outline::ContactOutline`).
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// A disc; its reference point is its centre.
    Disc {
        /// Radius, mm.
        radius_mm: f64,
    },
    /// A rectangle; its reference point is its centre.
    Box {
        /// Side along x before rotation, mm.
        width_mm: f64,
        /// Side along y before rotation, mm.
        height_mm: f64,
    },
    /// A polygon; its reference point is the origin of its coordinates. Only this outline needs a file, which `outline_corners` of `verify/files` reads.
    Polygon {
        /// Name of the CSV file that lists the corners in order; the scene states this name.
        points_csv: String,
    },
}

/// Motion of an object. A prescribed motion does not rotate the object.
#[derive(Debug, Clone, PartialEq)]
pub enum ObjectMotion {
    /// Free motion, for an object that a gripper grasps.
    Free {
        /// Mass, g.
        mass_g: f64,
        /// Initial position of the object's reference point, mm, in the gripper's frame at the start. The centre of mass is the centroid of the outline's
        /// area.
        centre_mm: Vector,
    },
    /// Motion along a straight line. The motion starts when the object touches the undeformed finger.
    Press {
        /// Position on the front plate at which the line of motion meets the plate, mm from the base.
        at_mm: f64,
        /// Direction of the line of motion, degrees from the undeformed inward normal, positive towards the tip.
        direction_deg: f64,
        /// Condition that ends the motion.
        until: Until,
    },
    /// Motion of the object's reference point through these points, mm, finger frame.
    Path(Vec<Vector>),
}

/// Condition that ends a press.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// The object has moved by this distance since first touch, mm.
    Travel(f64),
    /// The force along the line of motion has reached this value, N. A guide keeps the object on the line of motion.
    Force(f64),
}

/// An object that is pressed onto the finger or grasped.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectDescription {
    /// Outline of the object.
    pub outline: Outline,
    /// Rotation of the outline, degrees, positive from x to y.
    pub rotation_deg: f64,
    /// Coefficient of Coulomb friction of the object on the fingers and on the support, dimensionless.
    pub friction: f64,
    /// Motion of the object.
    pub motion: ObjectMotion,
    /// Number of equal steps into which a press is divided.
    pub steps: usize,
}

pub(super) fn read_object(table: &TableReader, finger: &Finger) -> Result<ObjectDescription, SceneError> {
    Ok(ObjectDescription {
        outline: read_outline(table)?,
        rotation_deg: table.get(&OBJECT.rotation_deg)?,
        friction: table.get(&OBJECT.friction)?,
        motion: read_motion(table, finger)?,
        steps: table.get(&OBJECT.steps)?,
    })
}

/// Function that reads the keys of one type of outline.
type OutlineReader = fn(&TableReader) -> Result<Outline, SceneError>;

fn read_outline(table: &TableReader) -> Result<Outline, SceneError> {
    let disc: OutlineReader = |table| Ok(Outline::Disc { radius_mm: table.get(&OBJECT.radius_mm)? });
    let rectangle: OutlineReader =
        |table| Ok(Outline::Box { width_mm: table.get(&OBJECT.width_mm)?, height_mm: table.get(&OBJECT.height_mm)? });
    let polygon: OutlineReader = |table| match table.get(&OBJECT.points_csv)? {
        points_csv if points_csv == "-" => {
            Err(table.wrong(OBJECT.points_csv.name, "the name of a file beside the scene", "-"))
        }
        points_csv => Ok(Outline::Polygon { points_csv }),
    };
    table.shape(&OBJECT, &OBJECT.shape, [disc, rectangle, polygon])?(table)
}

fn read_motion(table: &TableReader, finger: &Finger) -> Result<ObjectMotion, SceneError> {
    let press = [OBJECT.at_mm.name, OBJECT.direction_deg.name, OBJECT.travel_mm.name, OBJECT.force_n.name];
    if table.has(&OBJECT.mass_g) || table.has(&OBJECT.centre_mm) {
        let hand = [&press[..], &[OBJECT.path_mm.name, OBJECT.steps.name]].concat();
        if let Some(name) = table.first_of(&hand) {
            return Err(table.not_of(name, "a free object (mass_g, centre_mm)"));
        }
        let centre_mm = table.get(&OBJECT.centre_mm)?.into();
        return Ok(ObjectMotion::Free { mass_g: table.get(&OBJECT.mass_g)?, centre_mm });
    }
    if let Some(points) = table.optional(&OBJECT.path_mm)? {
        if let Some(name) = table.first_of(&press) {
            return Err(table.not_of(name, "an object with path_mm"));
        }
        if points.windows(2).all(|pair| pair[0] == pair[1]) {
            return Err(table.wrong(OBJECT.path_mm.name, &OBJECT.path_mm.kind.expected(), "others"));
        }
        return Ok(ObjectMotion::Path(points.into_iter().map(Vector::from).collect()));
    }
    let Some(at_mm) = table.optional(&OBJECT.at_mm)? else {
        return Err(table.missing(OBJECT.at_mm.name, "the position on the front plate to press at, in mm (or path_mm)"));
    };
    let length_mm = finger.plate_length_mm(Plate::Front);
    if !(0.0..=length_mm).contains(&at_mm) {
        let expected = format!("a position on the front plate, 0 to {length_mm} mm");
        return Err(table.wrong(OBJECT.at_mm.name, &expected, &at_mm.to_string()));
    }
    let until = match (table.optional(&OBJECT.travel_mm)?, table.optional(&OBJECT.force_n)?) {
        (Some(travel_mm), None) => Until::Travel(travel_mm),
        (None, Some(force_n)) => Until::Force(force_n),
        (Some(_), Some(_)) => return Err(table.wrong(OBJECT.force_n.name, "either travel_mm or force_n", "both")),
        (None, None) => return Err(table.missing(OBJECT.travel_mm.name, "the travel of the object in mm (or force_n)")),
    };
    Ok(ObjectMotion::Press { at_mm, direction_deg: table.get(&OBJECT.direction_deg)?, until })
}
