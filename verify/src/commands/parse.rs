//! Parsers of command-line values: loads, contacts, numbers.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use finray_model::sensing::{Contact, ContactPosition, Direction, MeasuredContact};
use finray_model::sensor::AskedDirection;
use finray_model::{Kinematics, Load, NodeId, Vector};
use serde::Deserialize;
use serde::de::IntoDeserializer;

/// Load on the front plate, `S_MM:FORCE,ANGLE_DEG`: position in mm from the base, force in N, angle in degrees from the inward normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionLoad {
    /// Position along the front plate, mm from its base.
    pub s_mm: f64,
    /// Magnitude of the force, N.
    pub force_n: f64,
    /// Angle from the undeformed inward normal, degrees, positive towards the tip.
    pub angle_deg: f64,
}

/// Parses a finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite())
        .ok_or_else(|| format!("expected a finite number, found \"{text}\""))
}

/// Parses a finite number, zero or more.
pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if x >= 0.0 { Ok(x) } else { Err(format!("expected zero or more, found {x}")) })
}

/// Parses a finite number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if x > 0.0 { Ok(x) } else { Err(format!("expected more than zero, found {x}")) })
}

/// Parses a number from 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if (0.0..=1.0).contains(&x) { Ok(x) } else { Err(format!("expected 0 to 1, found {x}")) })
}

/// Parses the angle between neighbouring directions, degrees, at least 0.01.
pub fn degrees_between(text: &str) -> Result<f64, String> {
    const FINEST: f64 = 0.01;
    finite(text).and_then(|x| if x >= FINEST { Ok(x) } else { Err(format!("expected {FINEST} or more, found {x}")) })
}

fn node(text: &str) -> Result<NodeId, String> {
    text.trim().parse().map(NodeId).map_err(|_| format!("expected the number of a node, found \"{text}\""))
}

/// Parses `NODE:FX,FY[,M]`: force in N in the finger frame, moment in N mm.
pub fn node_load(text: &str) -> Result<Load, String> {
    let expected = || format!("expected NODE:FX,FY or NODE:FX,FY,M, for instance 19:-0.4,-2, found \"{text}\"");
    let (position, rest) = text.split_once(':').ok_or_else(expected)?;
    let numbers = rest.split(',').map(finite).collect::<Result<Vec<_>, _>>()?;
    let (fx, fy, moment_nmm) = match numbers[..] {
        [fx, fy] => (fx, fy, 0.0),
        [fx, fy, moment] => (fx, fy, moment),
        _ => return Err(expected()),
    };
    Ok(Load::Node { node: node(position)?, force: Vector::new(fx, fy), moment_nmm })
}

/// Parses `S_MM:FORCE,ANGLE_DEG`; a missing angle means 0 degrees.
pub fn position_load(text: &str) -> Result<PositionLoad, String> {
    let expected = || format!("expected S_MM:FORCE,ANGLE_DEG, for instance 80.5:2,-20, found \"{text}\"");
    let (position, rest) = text.split_once(':').ok_or_else(expected)?;
    let (force, angle) = rest.split_once(',').unwrap_or((rest, "0"));
    Ok(PositionLoad { s_mm: finite(position)?, force_n: finite(force)?, angle_deg: finite(angle)? })
}

/// Motor angles, degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorAngles(pub Vec<f64>);

/// Parses one motor angle `DEG` or a range `FROM:TO:STEP`, degrees.
pub fn motor_angles(text: &str) -> Result<MotorAngles, String> {
    const MOST: f64 = 1e6;
    // Rounding error, in steps, by which the last angle may exceed the end of the range.
    const ROUNDING: f64 = 1e-9;
    let numbers = text.split(':').map(finite).collect::<Result<Vec<_>, _>>()?;
    match numbers[..] {
        [angle_deg] => Ok(MotorAngles(vec![angle_deg])),
        [from_deg, to_deg, step_deg] => {
            let steps = ((to_deg - from_deg) / step_deg + ROUNDING).floor();
            if !(0.0..MOST).contains(&steps) {
                return Err(format!(
                    "expected a step that leads from {from_deg} to {to_deg} in fewer than {MOST} steps"
                ));
            }
            Ok(MotorAngles((0..=steps as usize).map(|step| from_deg + step as f64 * step_deg).collect()))
        }
        _ => Err(format!("expected DEG or FROM:TO:STEP, for instance 0:360:22.5, found \"{text}\"")),
    }
}

/// A contact as given on the command line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedContact {
    /// Position along the front plate; `None` if the position is unknown and to be estimated.
    pub position: Option<ContactPosition>,
    /// Standard deviation of a measured position, mm.
    pub position_sd_mm: Option<f64>,
    /// Direction of the force; along the undeformed normal if none is given.
    pub direction: AskedDirection,
    /// Whether a direction is given.
    pub is_direction_given: bool,
    /// Standard deviation of a measured direction, degrees.
    pub direction_sd_deg: Option<f64>,
}

impl AskedContact {
    /// Whether position or direction has a standard deviation.
    pub fn has_deviation(&self) -> bool {
        self.position_sd_mm.or(self.direction_sd_deg).is_some()
    }

    /// The measured contact, if position or direction has a standard deviation and both are numbers.
    pub fn measured(&self) -> Option<MeasuredContact> {
        match (self.position, self.direction) {
            (Some(position), AskedDirection::Itself(Direction::Angle(angle_deg))) if self.has_deviation() => {
                Some(MeasuredContact {
                    contact: Contact { position, angle_deg },
                    direction_sd_rad: self.direction_sd_deg.unwrap_or_default().to_radians(),
                    position_sd_mm: self.position_sd_mm.unwrap_or_default(),
                })
            }
            _ => None,
        }
    }
}

/// Parser of an option whose values are the names of an enum.
pub fn listed<T>(all: &'static [T], name: fn(T) -> &'static str) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    let values = all.iter().map(|value| PossibleValue::new(name(*value)));
    PossibleValuesParser::new(values).try_map(move |text: String| {
        all.iter().copied().find(|value| name(*value) == text).ok_or_else(|| format!("no such value: {text}"))
    })
}

/// Parser of `--kinematics` that accepts these names of [`Kinematics`].
pub fn kinematics<const N: usize>(names: [&'static str; N]) -> impl TypedValueParser<Value = Kinematics> {
    let of_name =
        |name: String| Kinematics::deserialize(IntoDeserializer::<serde::de::value::Error>::into_deserializer(name));
    PossibleValuesParser::new(names).try_map(of_name)
}

/// Parses a number with an optional standard deviation, `VALUE+-SD`.
fn with_deviation(text: &str) -> Result<(f64, Option<f64>), String> {
    match text.split_once("+-") {
        None => Ok((finite(text)?, None)),
        Some((value, sd)) => Ok((finite(value)?, Some(positive(sd)?))),
    }
}

/// Largest accepted angle, degrees. A larger one is probably not in degrees.
const FULL_TURN_DEG: f64 = 360.0;

/// Parses a direction after `@`: an angle in degrees with optional standard deviation, or a keyword. A missing direction means 0 degrees.
fn direction(text: Option<&str>) -> Result<(AskedDirection, Option<f64>), String> {
    let direction = match text.map(str::trim) {
        None => Direction::Angle(0.0),
        Some("normal") => Direction::NORMAL,
        Some("auto") => Direction::Auto,
        Some("friction") => return Ok((AskedDirection::Friction, None)),
        Some("object") => return Ok((AskedDirection::Object, None)),
        Some("measured") => return Ok((AskedDirection::Measured, None)),
        Some(number) => match with_deviation(number) {
            Ok((angle_deg, sd_deg)) if angle_deg.abs() <= FULL_TURN_DEG => {
                return Ok((AskedDirection::Itself(Direction::Angle(angle_deg)), sd_deg));
            }
            Ok((angle_deg, _)) => {
                return Err(format!(
                    "expected an angle from -{FULL_TURN_DEG} to {FULL_TURN_DEG} degrees, found {angle_deg}"
                ));
            }
            Err(_) => {
                let expected = "an angle in degrees, `normal`, `friction`, `object`, `measured` or `auto`";
                return Err(format!("expected {expected}, found \"{number}\""));
            }
        },
    };
    Ok((AskedDirection::Itself(direction), None))
}

/// Parses `NODE[@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]`.
pub fn contact_at_node(text: &str) -> Result<AskedContact, String> {
    let (position, towards) = split_at_sign(text);
    let (direction, direction_sd_deg) = direction(towards)?;
    let position = Some(ContactPosition::Node(node(position)?));
    Ok(AskedContact {
        position,
        position_sd_mm: None,
        direction,
        is_direction_given: towards.is_some(),
        direction_sd_deg,
    })
}

/// Parses `S_MM[+-SD][@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]`, or `auto` for the position.
pub fn contact_at_position(text: &str) -> Result<AskedContact, String> {
    let (position, towards) = split_at_sign(text);
    let (position, position_sd_mm) = match position.trim() {
        "auto" => (None, None),
        number => {
            let (s_mm, sd_mm) = with_deviation(number)?;
            (Some(ContactPosition::At(s_mm)), sd_mm)
        }
    };
    let (direction, direction_sd_deg) = direction(towards)?;
    Ok(AskedContact { position, position_sd_mm, direction, is_direction_given: towards.is_some(), direction_sd_deg })
}

fn split_at_sign(text: &str) -> (&str, Option<&str>) {
    text.split_once('@').map_or((text, None), |(position, direction)| (position, Some(direction)))
}
