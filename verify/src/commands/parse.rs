//! Parsers of command-line values: loads, numbers, names.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use finray_model::text::{finite, node};
use finray_model::{Kinematics, Load, Vector};
use serde::Deserialize;
use serde::de::IntoDeserializer;

pub use finray_model::text::{not_negative, positive};

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

/// Parses a number from 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| if (0.0..=1.0).contains(&x) { Ok(x) } else { Err(format!("expected 0 to 1, found {x}")) })
}

/// Parses the angle between neighbouring directions, degrees, at least 0.01.
pub fn degrees_between(text: &str) -> Result<f64, String> {
    const FINEST: f64 = 0.01;
    finite(text).and_then(|x| if x >= FINEST { Ok(x) } else { Err(format!("expected {FINEST} or more, found {x}")) })
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

/// Parser of `--kinematics` that accepts only the given names of [`Kinematics`].
pub fn kinematics<const N: usize>(names: [&'static str; N]) -> impl TypedValueParser<Value = Kinematics> {
    let of_name =
        |name: String| Kinematics::deserialize(IntoDeserializer::<serde::de::value::Error>::into_deserializer(name));
    PossibleValuesParser::new(names).try_map(of_name)
}
