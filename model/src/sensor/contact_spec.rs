//! Contacts as users state them, in the notation of the options `--contact` and `--contact-at`.

use super::SensorContacts;
use crate::finger::{Plate, PlatePosition};
use crate::scene::Scene;
use crate::sensing::{Contact, ContactPosition, ContactQuestion, Direction, Lean, MeasuredContact, Normal};
use crate::text::{finite, node, positive};

/// Largest accepted angle, degrees. An angle larger than a full turn is probably not in degrees.
const FULL_TURN_DEG: f64 = 360.0;

/// A contact as a user states it.
///
/// ```
/// use finray_model::Scene;
/// use finray_model::sensor::{ContactSpec, SensorContacts};
///
/// let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
/// // 80 mm from the base, 20 degrees towards the base; and node 16, in an unknown direction.
/// let specs = [ContactSpec::at_position("80@-20")?, ContactSpec::at_node("16@auto")?];
/// let contacts = SensorContacts::from_specs(&specs, &scene, 0.0, None)?;
/// assert!(matches!(contacts, SensorContacts::Asked(questions) if questions.len() == 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSpec {
    /// Position along a plate; `None` if the position is unknown and to be estimated.
    pub position: Option<ContactPosition>,
    /// Standard deviation of a measured position, mm.
    pub position_sd_mm: Option<f64>,
    /// Direction of the force; along the undeformed normal if none is given.
    pub direction: DirectionSpec,
    /// Whether a direction is given.
    pub is_direction_given: bool,
    /// Standard deviation of a measured direction, degrees.
    pub direction_sd_deg: Option<f64>,
}

/// The text of a contact is wrong: what was expected, and what was found.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ContactTextError(String);

/// Contacts that contradict each other, the scene, or the friction coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ContactSpecError {
    /// A contact has a standard deviation, but its position or direction is not a number.
    #[error("a contact with standard deviations (+-): expected numbers for its position and its direction")]
    NoNumbers,
    /// Only some contacts have standard deviations.
    #[error("expected standard deviations (+-) for all contacts or for no contact")]
    Mixed,
    /// A friction coefficient is given, but no contact has standard deviations.
    #[error("a coefficient of friction: expected contacts with standard deviations (+-)")]
    Friction,
    /// The scene or the image lacks a value that a direction needs.
    #[error(transparent)]
    Missing(#[from] MissingInScene),
}

impl ContactSpec {
    /// Parses `NODE[@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]`.
    ///
    /// # Errors
    /// [`ContactTextError`] states the expected text.
    pub fn at_node(text: &str) -> Result<ContactSpec, ContactTextError> {
        let (position, towards) = split_at_sign(text);
        let (direction, direction_sd_deg) = direction(towards)?;
        let position = Some(ContactPosition::Node(node(position).map_err(ContactTextError)?));
        Ok(ContactSpec {
            position,
            position_sd_mm: None,
            direction,
            is_direction_given: towards.is_some(),
            direction_sd_deg,
        })
    }

    /// Parses `[back:]S_MM[+-SD][@ANGLE_DEG[+-SD]|normal|friction|object|measured|auto]`, or `auto` for the position.
    ///
    /// # Errors
    /// [`ContactTextError`] states the expected text.
    pub fn at_position(text: &str) -> Result<ContactSpec, ContactTextError> {
        let (position, towards) = split_at_sign(text);
        let (position, position_sd_mm) = match position.trim().split_once(':') {
            None if position.trim() == "auto" => (None, None),
            Some(("back", place)) if place.trim() == "auto" => {
                let expected = "expected a position in mm after `back:`: unknown positions lie on the front plate";
                return Err(ContactTextError(format!("{expected}, found \"{place}\"")));
            }
            Some((plate, _)) if plate != "back" => {
                let expected = "expected a position in mm, after `back:` if it lies on the back plate";
                return Err(ContactTextError(format!("{expected}, found \"{position}\"")));
            }
            on_back => {
                let (plate, number) = on_back.map_or((Plate::Front, position), |(_, number)| (Plate::Back, number));
                let (s_mm, sd_mm) = with_deviation(number)?;
                (Some(ContactPosition::At(PlatePosition { plate, s_mm })), sd_mm)
            }
        };
        let (direction, direction_sd_deg) = direction(towards)?;
        Ok(ContactSpec { position, position_sd_mm, direction, is_direction_given: towards.is_some(), direction_sd_deg })
    }

    /// Whether position or direction has a standard deviation.
    pub fn has_deviation(&self) -> bool {
        self.position_sd_mm.or(self.direction_sd_deg).is_some()
    }

    /// The measured contact, if position or direction has a standard deviation and both are numbers.
    pub fn measured(&self) -> Option<MeasuredContact> {
        match (self.position, self.direction) {
            (Some(position), DirectionSpec::Itself(Direction::Angle(angle_deg))) if self.has_deviation() => {
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

impl SensorContacts {
    /// Combines contacts with the friction and the object of a scene. `friction` is the coefficient of friction for contacts with a standard deviation
    /// of position or direction; it confines their forces to a friction cone. `measured_deg` is the direction of the image's measured force, degrees.
    ///
    /// # Errors
    /// [`ContactSpecError`] if the scene lacks the friction or object that a direction needs, or if only some contacts have standard deviations.
    pub fn from_specs(
        specs: &[ContactSpec],
        scene: &Scene,
        friction: f64,
        measured_deg: Option<f64>,
    ) -> Result<SensorContacts, ContactSpecError> {
        if specs.iter().any(|spec| spec.has_deviation() && spec.measured().is_none()) {
            return Err(ContactSpecError::NoNumbers);
        }
        let measured: Vec<MeasuredContact> = specs.iter().filter_map(ContactSpec::measured).collect();
        if !measured.is_empty() {
            return match measured.len() == specs.len() {
                true => Ok(SensorContacts::Measured { contacts: measured, friction }),
                false => Err(ContactSpecError::Mixed),
            };
        }
        if friction > 0.0 {
            return Err(ContactSpecError::Friction);
        }
        let question = |spec: &ContactSpec| {
            // Angles of measured forces count from the normal of the front plate.
            let on_plate = |front_deg: f64| match spec.position.map_or(Plate::Front, ContactPosition::plate) {
                Plate::Front => front_deg,
                Plate::Back => scene.finger.angle_on_deg(Plate::Back, scene.finger.direction(front_deg)),
            };
            let direction = spec.direction.of_scene(scene, measured_deg.map(on_plate))?;
            Ok(ContactQuestion::new(spec.position, direction))
        };
        specs.iter().map(question).collect::<Result<_, _>>().map(SensorContacts::Asked)
    }
}

/// Direction of a force as a user states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DirectionSpec {
    /// An explicit direction, independent of the scene.
    Itself(Direction),
    /// The plate's normal, rotated by the angle of friction from the scene's table `contact`.
    Friction,
    /// The normal of the object's outline from the scene's table `contact.object`, rotated by the angle of friction.
    Object,
    /// Direction of the measured force that belongs to the image.
    Measured,
}

/// A direction needs a value that the scene or the image lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MissingInScene {
    /// The scene states no friction.
    #[error(
        "the direction `friction` needs a coefficient: expected friction or friction_range in the scene's table \
            [contact], such as friction_range = [-0.6, 0.6]; the direction `auto` needs none"
    )]
    Friction,
    /// The scene states no object.
    #[error("the direction `object` needs an outline: expected a table [contact.object] in the scene")]
    Object,
    /// The image has no measured force.
    #[error("the direction `measured` needs a force: expected the measured force of the image")]
    Measured,
}

impl DirectionSpec {
    /// Resolves the direction with the friction and the object of a scene. `measured_deg` is the direction of the measured force, degrees from the
    /// undeformed normal.
    ///
    /// # Errors
    /// [`MissingInScene`] if the direction needs a friction, an object or a measured force that is missing.
    pub fn of_scene(self, scene: &Scene, measured_deg: Option<f64>) -> Result<Direction, MissingInScene> {
        let friction = scene.contact.lean;
        match self {
            DirectionSpec::Itself(direction) => Ok(direction),
            DirectionSpec::Measured => measured_deg.map(Direction::Angle).ok_or(MissingInScene::Measured),
            DirectionSpec::Friction => friction.map(Direction::Leaning).ok_or(MissingInScene::Friction),
            DirectionSpec::Object => {
                let object = scene.touched.as_ref().ok_or(MissingInScene::Object)?;
                // Without a pose of the object, only tangency of plate and outline is known.
                let from = match object.place {
                    Some(_) => Normal::Object,
                    None => Normal::Deformed { over_mm: 0.0 },
                };
                Ok(Direction::Leaning(Lean { from, ..friction.unwrap_or(Lean::NONE) }))
            }
        }
    }
}

/// Parses a number with an optional standard deviation, `VALUE+-SD`.
fn with_deviation(text: &str) -> Result<(f64, Option<f64>), ContactTextError> {
    match text.split_once("+-") {
        None => Ok((finite(text).map_err(ContactTextError)?, None)),
        Some((value, sd)) => {
            let value = finite(value).map_err(ContactTextError)?;
            Ok((value, Some(positive(sd).map_err(ContactTextError)?)))
        }
    }
}

/// Parses a direction after `@`: an angle in degrees with optional standard deviation, or a keyword. A missing direction means 0 degrees.
fn direction(text: Option<&str>) -> Result<(DirectionSpec, Option<f64>), ContactTextError> {
    let direction = match text.map(str::trim) {
        None => Direction::Angle(0.0),
        Some("normal") => Direction::NORMAL,
        Some("auto") => Direction::Auto,
        Some("friction") => return Ok((DirectionSpec::Friction, None)),
        Some("object") => return Ok((DirectionSpec::Object, None)),
        Some("measured") => return Ok((DirectionSpec::Measured, None)),
        Some(number) => match with_deviation(number) {
            Ok((angle_deg, sd_deg)) if angle_deg.abs() <= FULL_TURN_DEG => {
                return Ok((DirectionSpec::Itself(Direction::Angle(angle_deg)), sd_deg));
            }
            Ok((angle_deg, _)) => {
                return Err(ContactTextError(format!(
                    "expected an angle from -{FULL_TURN_DEG} to {FULL_TURN_DEG} degrees, found {angle_deg}"
                )));
            }
            Err(_) => {
                let expected = "an angle in degrees, `normal`, `friction`, `object`, `measured` or `auto`";
                return Err(ContactTextError(format!("expected {expected}, found \"{number}\"")));
            }
        },
    };
    Ok((DirectionSpec::Itself(direction), None))
}

fn split_at_sign(text: &str) -> (&str, Option<&str>) {
    text.split_once('@').map_or((text, None), |(position, direction)| (position, Some(direction)))
}
