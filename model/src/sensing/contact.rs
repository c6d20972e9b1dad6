//! Contacts: positions and directions of forces, known or unknown.

use super::{Lean, SensingError};
use crate::Vector;
use crate::finger::{Finger, NodeId, Plate};
use crate::mesh::{Load, LoadError};
use serde::{Deserialize, Serialize};

/// Position of a force on the front plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ContactPosition {
    /// At a node of the front plate, from the tip to the last node before the front base.
    #[serde(rename = "node")]
    Node(NodeId),
    /// At this distance from the front base along the plate, mm.
    #[serde(rename = "s_mm")]
    At(f64),
}

/// A contact of known position and direction whose force is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Position of the force.
    #[serde(flatten)]
    pub position: ContactPosition,
    /// Direction of the force, in degrees from the undeformed inward normal, positive towards the tip.
    pub angle_deg: f64,
}

/// Writes the position, an `@` and the angle in degrees: `19@0` means node 19 at 0 degrees, `80 mm@-20` means 80 mm from the base at -20 degrees.
impl std::fmt::Display for Contact {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.position {
            ContactPosition::Node(node) => write!(f, "{node}@{}", self.angle_deg),
            ContactPosition::At(s_mm) => write!(f, "{s_mm} mm@{}", self.angle_deg),
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
        let force: Vector = finger.direction(self.angle_deg) * force_n;
        match self.position {
            ContactPosition::Node(node) => Load::at_node(node, force),
            ContactPosition::At(s_mm) => Load::at_position(s_mm, force),
        }
    }

    /// Position along the front plate, in mm from the base. `None` for a node that is not on the front plate.
    pub fn position_mm(&self, finger: &Finger) -> Option<f64> {
        match self.position {
            ContactPosition::Node(node) => finger.front_position_mm(node),
            ContactPosition::At(s_mm) => Some(s_mm),
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
    /// An unknown direction, estimated together with the force.
    Auto,
}

impl Direction {
    /// Direction along the inward normal of the deformed plate.
    pub const NORMAL: Direction = Direction::Leaning(Lean::NONE);
}

/// A contact whose force is estimated. An unknown position or direction is estimated together with the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactQuestion {
    /// Position of the force. `None` if unknown.
    pub position: Option<ContactPosition>,
    /// Direction of the force.
    pub direction: Direction,
}

impl ContactQuestion {
    /// The contact, if both position and direction are known.
    pub fn known(&self) -> Option<Contact> {
        match (self.position, self.direction) {
            (Some(position), Direction::Angle(angle_deg)) => Some(Contact { position, angle_deg }),
            _ => None,
        }
    }
}

impl From<Contact> for ContactQuestion {
    fn from(contact: Contact) -> ContactQuestion {
        ContactQuestion { position: Some(contact.position), direction: Direction::Angle(contact.angle_deg) }
    }
}

/// Checks the known part of each contact, and contacts of which everything is known, as [`check_contacts`] does.
///
/// # Errors
/// [`SensingError`] for the first contact that fails a check, or if `questions` is empty.
pub fn check_questions(finger: &Finger, questions: &[ContactQuestion]) -> Result<(), SensingError> {
    // A valid value replaces an unknown direction or position.
    for question in questions {
        let angle_deg = if let Direction::Angle(angle) = question.direction { angle } else { 0.0 };
        let position = question.position.unwrap_or(ContactPosition::Node(finger.tip()));
        check_contacts(finger, &[Contact { position, angle_deg }])?;
    }
    let known: Option<Vec<Contact>> = questions.iter().map(ContactQuestion::known).collect();
    known.map_or(Ok(()), |contacts| check_contacts(finger, &contacts))
}

/// Checks that contacts lie on the free front plate, have finite angles and differ from each other.
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
            ContactPosition::At(s_mm) => {
                let length_mm = finger.plate_length_mm(Plate::Front);
                if !(s_mm > 0.0 && s_mm <= length_mm) {
                    return Err(LoadError::PositionOffPlate { at: s_mm.into(), length_mm }.into());
                }
            }
        }
        if !contact.angle_deg.is_finite() {
            return Err(SensingError::AngleNotFinite { contact: i + 1 });
        }
        let same = |other: &Contact| {
            other.angle_deg == contact.angle_deg && other.position_mm(finger) == contact.position_mm(finger)
        };
        if let Some(j) = contacts[..i].iter().position(same) {
            return Err(SensingError::SameContact { first: j + 1, second: i + 1 });
        }
    }
    Ok(())
}
