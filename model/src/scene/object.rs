//! The object that a contact scene presses onto the finger, and the rods that it meets: `[object]` and `[contact]`.

use super::SceneError;
use super::reader::TableReader;
use crate::Vector;
use crate::finger::{Finger, Plate};

/// Radius of the rods, mm: the paper's have a diameter of 3 mm (Xu et al. 2021, sec. II).
pub const ROD_RADIUS_MM: f64 = 1.5;
/// Steps from first touch to the end where the scene does not say.
const STEPS: usize = 20;
/// Largest length, in mm, and force, in N, that an object may have or go.
const FARTHEST_MM: f64 = 1e4;
/// Largest coefficient of friction: rubber on rubber reaches 2.
pub(super) const LARGEST_FRICTION: f64 = 10.0;
/// Most steps that are of use.
const MOST_STEPS: usize = 10_000;

/// Outline of an object, about the point that is moved.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// A round object, by its axis.
    Disc {
        /// Radius, mm.
        radius_mm: f64,
    },
    /// A rectangle, by its centre.
    Box {
        /// Side along x before the object is turned, mm.
        width_mm: f64,
        /// Side along y before the object is turned, mm.
        height_mm: f64,
    },
    /// A polygon, by the origin of its points.
    Polygon {
        /// Name of the CSV file with its corners in order, as written in the scene.
        points_csv: String,
    },
}

/// How the object moves. Where a hand moves it, it never turns.
#[derive(Debug, Clone, PartialEq)]
pub enum ObjectMotion {
    /// It is free, for a gripper to grasp.
    Free {
        /// Its mass, g.
        mass_g: f64,
        /// Where its point is at first, mm, in the frame of the gripper where it starts. Its centre of mass is the centre of its area.
        centre_mm: Vector,
    },
    /// Along a straight line, from where it touches the undeformed finger.
    Press {
        /// Position on the front plate that the line meets, mm from its base.
        at_mm: f64,
        /// Direction of the line, degrees from the undeformed inward normal, positive towards the tip.
        direction_deg: f64,
        /// How far.
        until: Until,
    },
    /// Through points of the finger frame, mm.
    Path(Vec<Vector>),
}

/// What ends a press.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// A travel from first touch, mm.
    Travel(f64),
    /// A force along the line, N; across it the object is guided.
    Force(f64),
}

/// An object that is pressed onto the finger.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectDescription {
    /// Its outline.
    pub outline: Outline,
    /// How far the outline is turned, degrees from x to y.
    pub rotation_deg: f64,
    /// Coefficient of Coulomb friction against the finger.
    pub friction: f64,
    /// How it moves.
    pub motion: ObjectMotion,
    /// In how many equal steps.
    pub steps: usize,
}

const OUTLINE_KEYS: [&str; 4] = ["radius_mm", "width_mm", "height_mm", "points_csv"];
const PRESS_KEYS: [&str; 4] = ["at_mm", "direction_deg", "travel_mm", "force_n"];
/// What a hand has to say, which no free object has.
const HAND_KEYS: [&str; 6] = ["at_mm", "direction_deg", "travel_mm", "force_n", "path_mm", "steps"];

/// All keys of `[object]`.
pub(super) const KEYS: [&str; 15] = [
    "shape",
    "radius_mm",
    "width_mm",
    "height_mm",
    "points_csv",
    "rotation_deg",
    "friction",
    "at_mm",
    "direction_deg",
    "travel_mm",
    "force_n",
    "path_mm",
    "steps",
    "mass_g",
    "centre_mm",
];

pub(super) fn read_object(table: &TableReader, finger: &Finger) -> Result<ObjectDescription, SceneError> {
    let rotation_deg = table.optional_number("rotation_deg", "angle in degrees")?.unwrap_or(0.0);
    if !rotation_deg.is_finite() {
        return Err(table.wrong("rotation_deg", "a finite angle in degrees", &format!("{rotation_deg:?}")));
    }
    let friction = table.optional_number("friction", "coefficient of friction")?.unwrap_or(0.0);
    if !(0.0..=LARGEST_FRICTION).contains(&friction) {
        return Err(table.wrong(
            "friction",
            &format!("a coefficient of friction, 0 to {LARGEST_FRICTION}"),
            &format!("{friction:?}"),
        ));
    }
    let steps = table.optional_count("steps")?.unwrap_or(STEPS);
    if !(1..=MOST_STEPS).contains(&steps) {
        return Err(table.wrong("steps", &format!("a whole number, 1 to {MOST_STEPS}"), &steps.to_string()));
    }
    Ok(ObjectDescription {
        outline: read_outline(table)?,
        rotation_deg,
        friction,
        motion: read_motion(table, finger)?,
        steps,
    })
}

#[derive(Clone, Copy)]
enum Shape {
    Disc,
    Box,
    Polygon,
}

fn read_outline(table: &TableReader) -> Result<Outline, SceneError> {
    let shape = table.choice("shape", &[("disc", Shape::Disc), ("box", Shape::Box), ("polygon", Shape::Polygon)])?;
    let (name, keys): (_, &[&str]) = match shape {
        Shape::Disc => ("disc", &OUTLINE_KEYS[..1]),
        Shape::Box => ("box", &OUTLINE_KEYS[1..3]),
        Shape::Polygon => ("polygon", &OUTLINE_KEYS[3..]),
    };
    refuse_others(table, &OUTLINE_KEYS, keys, &format!("a {name}"))?;
    Ok(match shape {
        Shape::Disc => Outline::Disc { radius_mm: positive(table, "radius_mm", "length in mm")? },
        Shape::Box => Outline::Box {
            width_mm: positive(table, "width_mm", "length in mm")?,
            height_mm: positive(table, "height_mm", "length in mm")?,
        },
        Shape::Polygon => {
            let points_csv = table.text("points_csv")?;
            if points_csv == "-" {
                return Err(table.wrong("points_csv", "the name of a file beside the scene", "-"));
            }
            Outline::Polygon { points_csv }
        }
    })
}

fn read_motion(table: &TableReader, finger: &Finger) -> Result<ObjectMotion, SceneError> {
    if table.has("mass_g") || table.has("centre_mm") {
        refuse_others(table, &HAND_KEYS, &[], "an object with mass_g and centre_mm, which is free,")?;
        let mass_g = positive(table, "mass_g", "mass in g")?;
        let centre_mm: [f64; 2] = table.numbers("centre_mm", "[x, y] in mm in the gripper's frame")?;
        if centre_mm.iter().any(|x| x.abs() > FARTHEST_MM) {
            return Err(table.wrong("centre_mm", &format!("a point within {FARTHEST_MM} mm"), "one further away"));
        }
        return Ok(ObjectMotion::Free { mass_g, centre_mm: centre_mm.into() });
    }
    if let Some(points) = table.optional_pairs("path_mm", "[x, y], points of the finger frame in mm")? {
        refuse_others(table, &PRESS_KEYS, &[], "an object with path_mm")?;
        let points: Vec<Vector> = points.into_iter().map(Vector::from).collect();
        let near = points.iter().all(|point| point.norm() <= FARTHEST_MM);
        if !near || points.windows(2).all(|pair| pair[0] == pair[1]) {
            let expected = format!("two or more different points [x, y] within {FARTHEST_MM} mm of the base");
            return Err(table.wrong("path_mm", &expected, "others"));
        }
        return Ok(ObjectMotion::Path(points));
    }
    if !table.has("at_mm") {
        return Err(table.missing("at_mm", "the position on the front plate to press on, in mm (or path_mm)"));
    }
    let at_mm = table.number("at_mm", "position in mm")?;
    let length_mm = finger.plate_length_mm(Plate::Front);
    if !(0.0..=length_mm).contains(&at_mm) {
        return Err(table.wrong(
            "at_mm",
            &format!("a position on the front plate, 0 to {length_mm} mm"),
            &at_mm.to_string(),
        ));
    }
    let direction_deg = table.optional_number("direction_deg", "angle in degrees")?.unwrap_or(0.0);
    if direction_deg.is_nan() || direction_deg.abs() >= 90.0 {
        let expected = "an angle between -90 and 90 degrees, from the inward normal";
        return Err(table.wrong("direction_deg", expected, &format!("{direction_deg:?}")));
    }
    let until = match (table.has("travel_mm"), table.has("force_n")) {
        (true, false) => Until::Travel(positive(table, "travel_mm", "length in mm")?),
        (false, true) => Until::Force(positive(table, "force_n", "force in N")?),
        (true, true) => return Err(table.wrong("force_n", "either travel_mm or force_n", "both")),
        (false, false) => return Err(table.missing("travel_mm", "how far to press, in mm (or force_n)")),
    };
    Ok(ObjectMotion::Press { at_mm, direction_deg, until })
}

fn positive(table: &TableReader, key: &str, what: &str) -> Result<f64, SceneError> {
    let value = table.number(key, what)?;
    if value.is_normal() && 0.0 < value && value <= FARTHEST_MM {
        Ok(value)
    } else {
        Err(table.wrong(key, &format!("a {what} above zero, up to {FARTHEST_MM}"), &format!("{value:?}")))
    }
}

/// Refuses keys that belong to another shape or motion: what stands in a scene counts.
fn refuse_others(table: &TableReader, keys: &[&str], own: &[&str], whose: &str) -> Result<(), SceneError> {
    match keys.iter().find(|key| table.has(key) && !own.contains(key)) {
        Some(key) => Err(table.wrong(key, "nothing", &format!("a value that {whose} does not have"))),
        None => Ok(()),
    }
}
