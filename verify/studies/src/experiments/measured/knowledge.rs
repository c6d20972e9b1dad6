//! The finger, the rig and friction as they are known, and but for one thing each.

use finray_model::finger::{BracketLengths, Finger, FingerDescription, RigidEnds};
use finray_model::sensing::{Direction, Lean};

/// What is known when a force is sensed: the scene, or the scene but for one thing.
pub(super) struct Knowledge {
    pub name: &'static str,
    /// The finger, where there is one that differs.
    pub finger: fn(&Finger) -> Option<Finger>,
    /// The direction of the force, which as measured is given; `None` where the scene does not say it.
    pub direction: fn(measured: Direction, Option<Lean>) -> Option<Direction>,
    /// Whether the base is sought.
    pub base_is_sought: bool,
    /// Whether the distortion of the camera's lens is known.
    pub lens_is_known: bool,
}

/// The finger with something of its description left out, where it has that.
fn without(finger: &Finger, leave_out: fn(&mut FingerDescription)) -> Option<Finger> {
    let mut description = finger.description().clone();
    leave_out(&mut description);
    Finger::new(description).ok().filter(|other| other != finger)
}

/// All that the scene has, and the measured direction of the force.
const DIRECTION_MEASURED: Knowledge = Knowledge {
    name: "direction measured",
    finger: |finger| Some(finger.clone()),
    direction: |measured, _| Some(measured),
    base_is_sought: true,
    lens_is_known: true,
};

/// From the most that is known to less.
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
