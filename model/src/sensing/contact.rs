//! Contacts: positions and directions of forces, known or unknown.

use super::{Lean, MeasuredNormal, Pad, SensingError};
use crate::Vector;
use crate::finger::{Finger, NodeId, Plate, PlatePosition};
use crate::mesh::{Load, LoadError};
use serde::{Deserialize, Serialize};

/// Position of a force on the outer face of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ContactPosition {
    /// At a node of the front plate, from the tip to the last node before the front base.
    #[serde(rename = "node")]
    Node(NodeId),
    /// At this distance from the base along a plate, mm.
    #[serde(rename = "s_mm")]
    At(PlatePosition),
}

impl ContactPosition {
    /// The position `s_mm` along the front plate, mm from its base.
    pub fn at(s_mm: f64) -> ContactPosition {
        ContactPosition::At(s_mm.into())
    }

    /// The touched plate.
    pub fn plate(self) -> Plate {
        match self {
            ContactPosition::Node(_) => Plate::Front,
            ContactPosition::At(at) => at.plate,
        }
    }

    /// Name in tables: the node, `at` for a position on the front plate, or for instance `back:60` for a position in mm on the back plate.
    pub fn name(self) -> String {
        match self {
            ContactPosition::Node(node) => node.to_string(),
            ContactPosition::At(PlatePosition { plate: Plate::Front, .. }) => "at".to_owned(),
            ContactPosition::At(at) => PlatePosition { s_mm: (10.0 * at.s_mm).round() / 10.0, ..at }.to_string(),
        }
    }
}

/// A contact of known position and direction whose force is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Position of the force.
    #[serde(flatten)]
    pub position: ContactPosition,
    /// Direction of the force, in degrees from the undeformed inward normal of the touched plate, positive towards the tip.
    pub angle_deg: f64,
}

/// Writes the position, an `@` and the angle in degrees: `19@0` means node 19 at 0 degrees, `80 mm@-20` means 80 mm from the base at -20 degrees.
impl std::fmt::Display for Contact {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.position {
            ContactPosition::Node(node) => write!(f, "{node}@{}", self.angle_deg),
            ContactPosition::At(at) => write!(f, "{at} mm@{}", self.angle_deg),
        }
    }
}

impl Contact {
    /// A contact at a node, along the undeformed normal.
    pub fn at_node(node: NodeId) -> Contact {
        Contact { position: ContactPosition::Node(node), angle_deg: 0.0 }
    }

    /// Load of 1 N at the contact, along its direction.
    pub fn unit_load(&self, finger: &Finger) -> Load {
        self.load(finger, 1.0)
    }

    /// Load of `force_n`, N, at the contact, along its direction.
    pub fn load(&self, finger: &Finger, force_n: f64) -> Load {
        let force = self.direction(finger) * force_n;
        match self.position {
            ContactPosition::Node(node) => Load::at_node(node, force),
            ContactPosition::At(at) => Load::at_position(at, force),
        }
    }

    /// Unit vector along the force, in the finger frame.
    pub fn direction(&self, finger: &Finger) -> Vector {
        finger.direction_on(self.position.plate(), self.angle_deg)
    }

    /// Position along the touched plate, in mm from its base. `None` for a node that is not on the front plate.
    pub fn position_mm(&self, finger: &Finger) -> Option<f64> {
        match self.position {
            ContactPosition::Node(node) => finger.front_position_mm(node),
            ContactPosition::At(at) => Some(at.s_mm),
        }
    }
}

/// Direction of a force, known or unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// A known angle, in degrees from the undeformed inward normal, positive towards the tip. The normal rotates with the measured pose of the base.
    Angle(f64),
    /// An inward normal, rotated by the lean (angle between force and normal due to friction).
    Leaning(Lean),
    /// A measured normal, from which friction and the error of the measurement turn the force. The estimated force is the component along the
    /// measured normal.
    Measured(MeasuredNormal),
    /// An unknown direction, estimated together with the force.
    Auto,
}

impl Direction {
    /// Direction along the inward normal of the deformed plate.
    pub const NORMAL: Direction = Direction::Leaning(Lean::NONE);

    /// The known or measured angle, in degrees from the undeformed inward normal; `None` if the direction follows the plate or is unknown.
    pub(super) fn stated_deg(self) -> Option<f64> {
        match self {
            Direction::Angle(angle_deg) => Some(angle_deg),
            Direction::Measured(normal) => Some(normal.angle_deg),
            Direction::Leaning(_) | Direction::Auto => None,
        }
    }
}

/// A contact whose force is estimated. An unknown position or direction is estimated together with the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactQuestion {
    /// Position of the force. `None` if unknown.
    pub position: Option<ContactPosition>,
    /// Standard deviation of the position along the plate, mm. Zero for an exact position. A contact at a node is at the node exactly.
    pub position_sd_mm: f64,
    /// Direction of the force.
    pub direction: Direction,
    /// Pad between the object and the plate.
    pub pad: Pad,
}

/// A contact with measured position and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredContact {
    /// Measured position of the contact, and measured direction of the surface's normal.
    pub contact: Contact,
    /// Standard deviation of the direction, rad.
    pub direction_sd_rad: f64,
    /// Standard deviation of the position along the plate, mm. Zero for a contact at a rod.
    pub position_sd_mm: f64,
}

impl MeasuredContact {
    /// The question for the force at the contact. `friction` is the upper bound of the coefficient of friction, dimensionless. Friction acts on the
    /// surface of `pad`.
    pub fn question(&self, friction: f64, pad: Pad) -> ContactQuestion {
        let &MeasuredContact { contact: Contact { position, angle_deg }, direction_sd_rad, position_sd_mm } = self;
        let direction = Direction::Measured(MeasuredNormal { angle_deg, sd_rad: direction_sd_rad, friction });
        ContactQuestion { position: Some(position), position_sd_mm, direction, pad }
    }
}

impl ContactQuestion {
    /// A contact without a pad. The position is exact, or unknown if it is `None`.
    pub fn new(position: Option<ContactPosition>, direction: Direction) -> ContactQuestion {
        ContactQuestion { position, position_sd_mm: 0.0, direction, pad: Pad::default() }
    }

    /// The contact, if both position and direction are known exactly.
    pub fn known(&self) -> Option<Contact> {
        self.stated().filter(|_| matches!(self.direction, Direction::Angle(_)) && !self.is_position_measured())
    }

    /// The contact, if both position and direction are known or measured.
    pub(super) fn stated(&self) -> Option<Contact> {
        Some(Contact { position: self.position?, angle_deg: self.direction.stated_deg()? })
    }

    /// Whether the position is measured with an error.
    pub(super) fn is_position_measured(&self) -> bool {
        self.position_sd_mm > 0.0 && matches!(self.position, Some(ContactPosition::At(_)))
    }

    /// Whether the normal is measured.
    pub(super) fn is_normal_measured(&self) -> bool {
        matches!(self.direction, Direction::Measured(_))
    }
}

impl From<Contact> for ContactQuestion {
    fn from(contact: Contact) -> ContactQuestion {
        ContactQuestion::new(Some(contact.position), Direction::Angle(contact.angle_deg))
    }
}

/// Checks the known or measured part of each contact, and contacts without an unknown part, as [`check_contacts`] does.
///
/// # Errors
/// [`SensingError`] for the first contact that fails a check, or if `questions` is empty.
pub fn check_questions(finger: &Finger, questions: &[ContactQuestion]) -> Result<(), SensingError> {
    // A valid value replaces an unknown direction or position.
    for question in questions {
        let angle_deg = question.direction.stated_deg().unwrap_or(0.0);
        let position = question.position.unwrap_or(ContactPosition::Node(finger.tip()));
        check_contacts(finger, &[Contact { position, angle_deg }])?;
    }
    let known: Option<Vec<Contact>> = questions.iter().map(ContactQuestion::stated).collect();
    known.map_or(Ok(()), |contacts| check_contacts(finger, &contacts))
}

/// Checks that contacts lie on the free front plate or at positions on the back plate, have finite angles and differ from each other.
///
/// # Errors
/// [`SensingError`] for the first contact that fails a check, or if `contacts` is empty.
pub fn check_contacts(finger: &Finger, contacts: &[Contact]) -> Result<(), SensingError> {
    if contacts.is_empty() {
        return Err(SensingError::NoContact);
    }
    let [_, front_base] = finger.clamped_nodes();
    let (first, last) = (finger.tip(), NodeId(front_base.0 - 1));
    for (i, contact) in contacts.iter().enumerate() {
        match contact.position {
            ContactPosition::Node(node) => {
                if !(1..=front_base.0).contains(&node.0) {
                    return Err(LoadError::NodeMissing { node, key_nodes: front_base.0 }.into());
                }
                if finger.is_clamped(node) {
                    return Err(LoadError::NodeClamped { node }.into());
                }
                if !(first..=last).contains(&node) {
                    return Err(SensingError::NotAContactNode { node, first, last });
                }
            }
            ContactPosition::At(at) => {
                let length_mm = finger.plate_length_mm(at.plate);
                if !(at.s_mm > 0.0 && at.s_mm <= length_mm) {
                    return Err(LoadError::PositionOffPlate { at, length_mm }.into());
                }
            }
        }
        if !contact.angle_deg.is_finite() {
            return Err(SensingError::AngleNotFinite { contact: i + 1 });
        }
        let same = |other: &Contact| {
            let place = |contact: &Contact| (contact.position.plate(), contact.position_mm(finger), contact.angle_deg);
            place(other) == place(contact)
        };
        if let Some(j) = contacts[..i].iter().position(same) {
            return Err(SensingError::SameContact { first: j + 1, second: i + 1 });
        }
    }
    Ok(())
}
