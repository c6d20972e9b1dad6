//! List of the unknowns: forces, positions, directions, the base, the object, and errors that all markers share.

use crate::sensing::{ContactQuestion, Direction, TouchedObject};

/// One unknown. A number in a variant is the index of the contact or of the shared error, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unknown {
    /// Force along the contact's direction, N.
    Force(usize),
    /// Position along the contact's plate, mm.
    Position(usize),
    /// Component of a force across the force's current direction or, for a measured direction, across the measured normal, N. This component changes
    /// the direction.
    Across(usize),
    /// Motion of the base from its measured pose.
    Base(BaseMotion),
    /// Motion of the object from its stated pose. The object rotates about the origin of its outline.
    Object(BaseMotion),
    /// Error that all markers share, in units of its standard deviation.
    Shared(usize),
}

/// A motion of a base or an object in the finger frame. A base rotates about its own origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum BaseMotion {
    /// Translation along x, mm.
    X,
    /// Translation along y, mm.
    Y,
    /// Rotation, rad.
    Turn,
}

impl Unknown {
    /// All unknowns: those of the contacts in `questions`, of an uncertain base and of an object, and `shared_errors` errors that all markers share.
    pub(super) fn of(
        questions: &[ContactQuestion],
        is_base_sought: bool,
        object: Option<&TouchedObject>,
        shared_errors: usize,
    ) -> Vec<Unknown> {
        let is_sought = |question: &ContactQuestion| match question.direction {
            Direction::Auto => true,
            Direction::Leaning(lean) => lean.sd_deg > 0.0,
            Direction::Measured(normal) => normal.tangent_sd(questions.len()) > 0.0,
            Direction::Angle(_) => false,
        };
        let forces = (0..questions.len()).map(Unknown::Force);
        let positions = questions.iter().enumerate().filter(|(_, q)| q.position.is_none() || q.is_position_measured());
        let angles = questions.iter().enumerate().filter(|(_, q)| is_sought(q));
        let base = [BaseMotion::X, BaseMotion::Y, BaseMotion::Turn].into_iter().filter(|_| is_base_sought);
        let object = [BaseMotion::X, BaseMotion::Y, BaseMotion::Turn].into_iter().filter(|way| {
            object.is_some_and(|object| if *way == BaseMotion::Turn { object.may_turn() } else { object.sd_mm > 0.0 })
        });
        forces
            .chain(positions.map(|(i, _)| Unknown::Position(i)))
            .chain(angles.map(|(i, _)| Unknown::Across(i)))
            .chain(base.map(Unknown::Base))
            .chain(object.map(Unknown::Object))
            .chain((0..shared_errors).map(Unknown::Shared))
            .collect()
    }

    /// Index of the contact to which the unknown belongs, if any.
    pub(super) fn contact(self) -> Option<usize> {
        match self {
            Unknown::Force(i) | Unknown::Position(i) | Unknown::Across(i) => Some(i),
            Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => None,
        }
    }
}
