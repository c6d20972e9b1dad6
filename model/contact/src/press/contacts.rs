//! Groups touches (points at which object and finger meet) into contacts, and determines each contact's position and direction from the surfaces
//! alone.

use crate::{Touch, TouchedPart, Wall};
use finray_model::finger::{Plate, PlatePosition};
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::{Finger, NodeId, Vector};

/// Touches closer together than this share of the plate segment between two rods form one contact for the camera. Touches on two different rods never
/// form one contact.
const TOGETHER: f64 = 0.25;

/// A contact seen by the camera, with the true force that it carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenContact {
    /// The touched wall; `contact` is a position on this wall.
    pub wall: Wall,
    /// Position of the contact, and its direction from the object into the finger, without noise. Position and direction come from the surfaces
    /// alone, not from the forces. For several touches, the position is the middle of their interval, and the direction is the middle of their
    /// directions.
    pub contact: Contact,
    /// Half the range of the touches' positions (mm) and directions (rad); the distribution of the force within this range is unknown.
    pub half_span: HalfSpan,
    /// Distance of the two outline points from which the camera reads the direction, mm.
    pub baseline_mm: f64,
    /// Whether the contact is on a clamped part, where a force does not deform the finger.
    pub clamped: bool,
    /// Deformed position of the contact in the finger frame, mm.
    pub point: Vector,
    /// True force on the finger in the finger frame, N.
    pub force: Vector,
    /// Component of the force along the direction of the contact, N.
    pub normal_n: f64,
    /// Component of the force across the direction of the contact, positive towards the tip, N. This component consists of friction, and of parts of
    /// the normal forces of touches in other directions.
    pub friction_n: f64,
}

/// Half the range of the positions and directions of the touches that form one contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HalfSpan {
    /// Half the interval along the plate, mm.
    pub along_mm: f64,
    /// Largest angle between a touch's direction and the contact's direction, rad.
    pub turn_rad: f64,
}

impl SeenContact {
    /// Name in tables: the contact's node, `at` for a position between nodes of the front plate, or `clamp`; elsewhere the wall and the position in mm,
    /// for instance `back:60` and `rib3:12.5`.
    pub fn name(&self) -> String {
        match (self.contact.position, self.wall) {
            _ if self.clamped => "clamp".to_owned(),
            (ContactPosition::At(at), Wall::Rib(rib)) => format!("rib{}:{}", rib + 1, (10.0 * at.s_mm).round() / 10.0),
            (position, _) => position.name(),
        }
    }
}

/// Groups touches into contacts, from base to tip. `baseline_mm` returns the distance (mm) between the two outline points that show a touch's
/// direction.
pub fn seen_contacts(finger: &Finger, touches: &[Touch], baseline_mm: impl Fn(&Touch) -> f64) -> Vec<SeenContact> {
    let mut groups: Vec<&[Touch]> = Vec::new();
    let mut rest = touches;
    while let [first, ..] = rest {
        let (wall, first_mm) = first.part.place(finger);
        let within_mm = TOGETHER * member_mm(finger, (wall, first_mm));
        let mut rods = 0;
        let together = rest.iter().take_while(|touch| {
            rods += usize::from(matches!(touch.part, TouchedPart::Rod(node) if !is_rod(first, node)));
            let other_rod = if matches!(first.part, TouchedPart::Rod(_)) { rods > 0 } else { rods > 1 };
            let (other, at_mm) = touch.part.place(finger);
            other == wall && touch.clamped == first.clamped && at_mm - first_mm <= within_mm && !other_rod
        });
        let (group, others) = rest.split_at(together.count());
        groups.push(group);
        rest = others;
    }
    groups.into_iter().map(|group| seen(finger, group, &baseline_mm)).collect()
}

fn is_rod(touch: &Touch, node: NodeId) -> bool {
    touch.part == TouchedPart::Rod(node)
}

/// Length of the plate's segment between two ribs that contains a position, mm; length of a rib or of the base.
pub(super) fn member_mm(finger: &Finger, (wall, position_mm): (Wall, f64)) -> f64 {
    let plate = match wall {
        Wall::Rib(rib) => return finger.rib_length_mm(rib),
        Wall::Base => return finger.description().base_width_mm,
        Wall::Back => Plate::Back,
        Wall::Front => Plate::Front,
    };
    let positions = finger.plate_positions_mm(plate);
    let member =
        positions.windows(2).find(|member| position_mm <= member[1]).unwrap_or(&positions[positions.len() - 2..]);
    member[1] - member[0]
}

fn seen(finger: &Finger, group: &[Touch], baseline_mm: &dyn Fn(&Touch) -> f64) -> SeenContact {
    let (first, last) = (&group[0], &group[group.len() - 1]);
    let rod = group.iter().find(|touch| matches!(touch.part, TouchedPart::Rod(_)));
    let [(wall, from_mm), (_, to_mm)] = [first, last].map(|touch| touch.part.place(finger));
    let position = match (first.part, group.len()) {
        (TouchedPart::Rod(node), 1) => ContactPosition::Node(node),
        _ => ContactPosition::At(PlatePosition { plate: plate_of(wall), s_mm: 0.5 * (from_mm + to_mm) }),
    };
    let normal = (first.normal + last.normal).normalize();
    let turn = |touch: &Touch| normal.perp(&touch.normal).asin().abs();
    let half_span =
        HalfSpan { along_mm: 0.5 * (to_mm - from_mm), turn_rad: group.iter().map(turn).fold(0.0, f64::max) };
    let force: Vector = group.iter().map(|touch| touch.force).sum();
    let tipward = match plate_of(wall) {
        Plate::Front => Vector::new(-normal.y, normal.x),
        Plate::Back => Vector::new(normal.y, -normal.x),
    };
    SeenContact {
        wall,
        contact: Contact { position, angle_deg: finger.angle_on_deg(plate_of(wall), normal) },
        half_span,
        baseline_mm: baseline_mm(rod.unwrap_or(first)),
        clamped: first.clamped,
        point: 0.5 * (first.point + last.point),
        force,
        normal_n: force.dot(&normal),
        friction_n: force.dot(&tipward),
    }
}

/// The plate from whose inward normal directions on a wall count: the touched plate, or the front plate for ribs and base.
fn plate_of(wall: Wall) -> Plate {
    wall.plate().unwrap_or(Plate::Front)
}
