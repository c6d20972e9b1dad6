//! Variants of prior knowledge about finger, rig and friction: all items, or all except one item.

use finray_model::finger::{BracketLengths, Finger, FingerDescription, RigidEnds};
use finray_model::sensing::{Direction, Lean};

/// Prior knowledge for sensing: all that the scene states, or all except one item.
pub(super) struct Knowledge {
    pub name: &'static str,
    /// The finger that sensing assumes; `None` if the scene's finger lacks the item that this variant leaves out.
    pub finger: fn(&Finger) -> Option<Finger>,
    /// Direction of the force for sensing, given the measured direction; `None` if the scene does not define it.
    pub direction: fn(measured: Direction, Option<Lean>) -> Option<Direction>,
    /// Whether the position of the base is estimated.
    pub base_is_sought: bool,
    /// Whether the distortion of the camera's lens is known.
    pub lens_is_known: bool,
}

/// The finger without some part of its description; `None` if the finger lacks that part.
fn without(finger: &Finger, leave_out: fn(&mut FingerDescription)) -> Option<Finger> {
    let mut description = finger.description().clone();
    leave_out(&mut description);
    Finger::new(description).ok().filter(|other| other != finger)
}

/// All prior knowledge, and the measured direction of the force.
const DIRECTION_MEASURED: Knowledge = Knowledge {
    name: "direction measured",
    finger: |finger| Some(finger.clone()),
    direction: |measured, _| Some(measured),
    base_is_sought: true,
    lens_is_known: true,
};

/// All variants of prior knowledge; the first variant includes every item.
pub(super) const KNOWLEDGE: [Knowledge; 8] = [
    DIRECTION_MEASURED,
    Knowledge {
        name: "friction of the scene",
        direction: |_, lean| lean.map(Direction::Leaning),
        ..DIRECTION_MEASURED
    },
    Knowledge { name: "no friction", direction: |_, _| Some(Direction::NORMAL), ..DIRECTION_MEASURED },
    Knowledge { name: "direction measured, base taken for exact", base_is_sought: false, ..DIRECTION_MEASURED },
    Knowledge { name: "direction measured, no distortion of the lens", lens_is_known: false, ..DIRECTION_MEASURED },
    Knowledge {
        name: "direction measured, no clips",
        finger: |finger| without(finger, |description| description.ribs.clip_mm = [0.0; 2]),
        ..DIRECTION_MEASURED
    },
    Knowledge {
        name: "direction measured, no rigid ends",
        finger: |finger| without(finger, |description| description.rigid_ends = [RigidEnds::default(); 2]),
        ..DIRECTION_MEASURED
    },
    Knowledge {
        name: "direction measured, no brackets",
        finger: |finger| without(finger, |description| description.ribs.bracket_mm = BracketLengths::NONE),
        ..DIRECTION_MEASURED
    },
];
