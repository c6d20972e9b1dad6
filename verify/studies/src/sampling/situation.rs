//! Situations in which forces are sensed: what the sensor knows of the contact, and which markers it sees.

use crate::prelude::*;
use crate::settings::{DIRECTION_OFF_DEG, FRICTION_MAX, KNOWN_FRICTION, POSITION_OFF_MM};
use finray_model::registry;
use finray_model::sensing::Lean;

registry! {
    /// What a sensor knows of a contact. The names are those of the option `--contact-at` where a user can state the same.
    ContactKnowledge: KnowledgeRow {
        /// Position and direction are known.
        Known => KnowledgeRow { name: "known", label: "contact known", help: "Position and direction known", unknown: None },
        /// Position and direction are assumed, and wrong by as much as a user may misjudge them.
        #[serde(rename = "off")]
        Misjudged => KnowledgeRow {
            name: "off",
            label: "contact misjudged",
            help: "Position and direction assumed, and wrong",
            unknown: None,
        },
        /// Position and direction are unknown.
        #[serde(rename = "auto@auto")]
        Nothing => KnowledgeRow {
            name: "auto@auto",
            label: "contact unknown",
            help: "Position and direction unknown",
            unknown: Some(|_, _| Direction::Auto),
        },
        /// The position is unknown; the angle between the force and the plate's normal is known.
        #[serde(rename = "auto@known")]
        Direction => KnowledgeRow {
            name: "auto@known",
            label: "direction known",
            help: "Position unknown, direction from the plate's normal known",
            unknown: Some(|_, lean_deg| Direction::Leaning(Lean { angle_deg: lean_deg, ..Lean::NONE })),
        },
        /// The position is unknown; the force leans from the plate's normal within a known range of friction.
        #[serde(rename = "auto@friction")]
        Friction => KnowledgeRow {
            name: "auto@friction",
            label: "friction known",
            help: "Position unknown, friction in a known range",
            unknown: Some(|scene, _| Direction::Leaning(known_lean(scene))),
        },
        /// The position is unknown; the force acts along the plate's normal.
        #[serde(rename = "auto@normal")]
        Frictionless => KnowledgeRow {
            name: "auto@normal",
            label: "no friction",
            help: "Position unknown, no friction",
            unknown: Some(|_, _| Direction::NORMAL),
        },
        /// The position is known, the direction is unknown.
        #[serde(rename = "known@auto")]
        Position => KnowledgeRow {
            name: "known@auto",
            label: "position known",
            help: "Position known, direction unknown",
            unknown: Some(|_, _| Direction::Auto),
        },
    }
}

struct KnowledgeRow {
    name: &'static str,
    label: &'static str,
    help: &'static str,
    /// The direction of the question about a contact whose direction is not stated as an angle from the undeformed normal. Takes the angle of the true
    /// force from the deformed normal, degrees.
    unknown: Option<fn(&Scene, f64) -> Direction>,
}

registry! {
    /// Markers that a camera does not see.
    HiddenMarkers: HiddenRow {
        /// All markers are visible.
        None => HiddenRow { name: "none", label: "all markers visible", help: "All markers are visible" },
        /// The touching object hides the markers of the front plate about the contact: a third of the plate's length.
        Object => HiddenRow { name: "object", label: "markers at the object hidden", help: "The object hides a third of the front plate" },
        /// The markers of the third of the finger next to the tip are hidden.
        Tip => HiddenRow { name: "tip", label: "tip hidden", help: "The third of the finger next to the tip is hidden" },
    }
}

struct HiddenRow {
    name: &'static str,
    label: &'static str,
    help: &'static str,
}

/// Length that is hidden, as a share of the length of the plate or finger.
const HIDDEN_SHARE: f64 = 1.0 / 3.0;

/// What a sensor knows of the contact, and which markers it does not see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Situation {
    /// Knowledge of the contact.
    pub contact: ContactKnowledge,
    /// Hidden markers.
    pub hidden: HiddenMarkers,
}

impl Default for Situation {
    /// A known contact with all markers visible.
    fn default() -> Situation {
        Situation { contact: ContactKnowledge::Known, hidden: HiddenMarkers::None }
    }
}

impl std::fmt::Display for Situation {
    /// Writes the label of the contact, and the label of hidden markers if there are any.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.hidden {
            HiddenMarkers::None => f.write_str(self.contact.label()),
            hidden => write!(f, "{}, {}", self.contact.label(), hidden.label()),
        }
    }
}

impl ContactKnowledge {
    /// Whether true directions lean from the normal of the deformed plate, as friction turns them, instead of counting from the undeformed normal. A
    /// user who states an angle states it from the undeformed normal.
    pub fn is_leaning(self) -> bool {
        self.row().unknown.is_some()
    }

    /// Directions that friction allows, degrees from the normal: the known range, or the cone of the coefficient of friction [`FRICTION_MAX`].
    pub fn allowed_deg(self, scene: &Scene) -> [f64; 2] {
        match self {
            ContactKnowledge::Frictionless => [0.0; 2],
            ContactKnowledge::Friction => {
                let Lean { angle_deg, sd_deg, .. } = known_lean(scene);
                // All angles of the range are equally likely, so its half width is sqrt(3) standard deviations.
                [-1.0, 1.0].map(|side| angle_deg + side * 3.0_f64.sqrt() * sd_deg)
            }
            _ => ContactKnowledge::cone_deg(),
        }
    }

    /// The cone of the coefficient of friction [`FRICTION_MAX`], degrees from the normal.
    pub fn cone_deg() -> [f64; 2] {
        [-1.0, 1.0].map(|side: f64| side * FRICTION_MAX.atan().to_degrees())
    }

    /// The questions that users ask about a true contact, which successive samples take in turn. For a [leaning](Self::is_leaning) contact, its angle
    /// counts from the deformed normal.
    pub fn questions(self, scene: &Scene, contact: Contact) -> Vec<ContactQuestion> {
        match (self, self.row().unknown) {
            (ContactKnowledge::Misjudged, _) => misjudged(&scene.finger, contact).into_iter().map(Into::into).collect(),
            (_, None) => vec![contact.into()],
            (_, Some(direction)) => {
                let position = (self == ContactKnowledge::Position).then_some(contact.position);
                vec![ContactQuestion::new(position, direction(scene, contact.angle_deg))]
            }
        }
    }
}

impl HiddenMarkers {
    /// Nodes whose markers are hidden if the finger is touched at `s_mm`, mm from the base of the front plate.
    pub fn nodes(self, finger: &Finger, s_mm: f64) -> Vec<NodeId> {
        let covers_mm = HIDDEN_SHARE * finger.plate_length_mm(Plate::Front);
        let from_mm = (1.0 - HIDDEN_SHARE) * finger.marker_position(finger.tip()).x;
        let is_hidden = |node: &NodeId| match self {
            HiddenMarkers::None => false,
            HiddenMarkers::Object => {
                finger.front_position_mm(*node).is_some_and(|at_mm| (at_mm - s_mm).abs() <= 0.5 * covers_mm)
            }
            HiddenMarkers::Tip => finger.marker_position(*node).x >= from_mm,
        };
        finger.free_nodes().filter(is_hidden).collect()
    }
}

/// The lean of sensed forces that the scene states, or else friction within [`KNOWN_FRICTION`], from the normal of the deformed plate.
fn known_lean(scene: &Scene) -> Lean {
    let Lean { angle_deg, sd_deg, .. } = scene.contact.lean.unwrap_or(Lean::within(KNOWN_FRICTION));
    Lean { angle_deg, sd_deg, ..Lean::NONE }
}

/// Contacts with a wrong position (by [`POSITION_OFF_MM`]) and a wrong direction (by [`DIRECTION_OFF_DEG`]), for each combination of signs.
/// Positions off the plate are omitted, unless all are.
fn misjudged(finger: &Finger, contact: Contact) -> Vec<Contact> {
    let length_mm = finger.plate_length_mm(Plate::Front);
    let s_mm = contact.position_mm(finger).unwrap_or(f64::NAN);
    let off = |(by_mm, by_deg)| Contact {
        position: ContactPosition::at(s_mm + by_mm),
        angle_deg: contact.angle_deg + by_deg,
    };
    let signs =
        [-POSITION_OFF_MM, POSITION_OFF_MM].map(|mm| [-DIRECTION_OFF_DEG, DIRECTION_OFF_DEG].map(|deg| (mm, deg)));
    let all: Vec<Contact> = signs.concat().into_iter().map(off).collect();
    let on_plate = |contact: &&Contact| matches!(contact.position, ContactPosition::At(at) if at.s_mm > 0.0 && at.s_mm <= length_mm);
    let on: Vec<Contact> = all.iter().filter(on_plate).copied().collect();
    if on.is_empty() { all } else { on }
}
