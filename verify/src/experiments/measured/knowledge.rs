//! The finger, the rig and friction as they are known, and but for one thing each.

use finray_model::finger::{BracketLengths, Finger, RigidEnds};
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

fn as_it_is(finger: &Finger) -> Option<Finger> {
    Some(finger.clone())
}

fn without_clips(finger: &Finger) -> Option<Finger> {
    let mut description = finger.description().clone();
    description.ribs.clip_mm = [0.0; 2];
    Finger::new(description).ok().filter(|other| other != finger)
}

fn without_rigid_ends(finger: &Finger) -> Option<Finger> {
    let mut description = finger.description().clone();
    description.rigid_ends = [RigidEnds::default(); 2];
    Finger::new(description).ok().filter(|other| other != finger)
}

fn without_brackets(finger: &Finger) -> Option<Finger> {
    let mut description = finger.description().clone();
    description.ribs.bracket_mm = BracketLengths::NONE;
    Finger::new(description).ok().filter(|other| other != finger)
}

fn as_measured(measured: Direction, _: Option<Lean>) -> Option<Direction> {
    Some(measured)
}

/// From the most that is known to less.
pub(super) const KNOWLEDGE: [Knowledge; 8] = [
    Knowledge {
        name: "direction measured",
        finger: as_it_is,
        direction: as_measured,
        base_is_sought: true,
        lens_is_known: true,
    },
    Knowledge {
        name: "friction of the scene",
        finger: as_it_is,
        direction: |_, lean| lean.map(Direction::Leaning),
        base_is_sought: true,
        lens_is_known: true,
    },
    Knowledge {
        name: "no friction",
        finger: as_it_is,
        direction: |_, _| Some(Direction::NORMAL),
        base_is_sought: true,
        lens_is_known: true,
    },
    Knowledge {
        name: "direction measured, base taken for exact",
        finger: as_it_is,
        direction: as_measured,
        base_is_sought: false,
        lens_is_known: true,
    },
    Knowledge {
        name: "direction measured, no distortion of the lens",
        finger: as_it_is,
        direction: as_measured,
        base_is_sought: true,
        lens_is_known: false,
    },
    Knowledge {
        name: "direction measured, no clips",
        finger: without_clips,
        direction: as_measured,
        base_is_sought: true,
        lens_is_known: true,
    },
    Knowledge {
        name: "direction measured, no rigid ends",
        finger: without_rigid_ends,
        direction: as_measured,
        base_is_sought: true,
        lens_is_known: true,
    },
    Knowledge {
        name: "direction measured, no brackets",
        finger: without_brackets,
        direction: as_measured,
        base_is_sought: true,
        lens_is_known: true,
    },
];
