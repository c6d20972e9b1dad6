//! Displacement of each marker as a function of the unknowns, beside the derivatives of this displacement.
//!
//! A marker moves with its point of the deformed finger, with the base, and by the errors that all markers share: [`MarkerPoint::displacement`].
//! [`MarkerRates`] differentiates the same sum: forces, positions and directions act through the tangent of the finger; base and shared errors
//! displace the markers directly.

use super::unknowns::{PosePart, Unknown};
use super::values::Nuisances;
use crate::Vector;
use crate::element::quarter_turn;
use crate::finger::NodeId;
use crate::frame::{FrameLoad, FrameMotion, NodeIndex};
use crate::measurement::SharedError;
use crate::mesh::{LoadError, Mesh};
use crate::sensing::{Contact, ContactQuestion, Direction, PadForce};
use crate::statics::Ladder;

/// A shape of the finger: its deformation, its forces, and the pose of its base.
#[derive(Clone, Copy)]
pub(super) struct Posed<'s> {
    /// Displacements and rotations of the mesh.
    pub motion: &'s FrameMotion,
    /// Position and direction of each contact.
    pub contacts: &'s [Contact],
    /// Force of each contact, N.
    pub forces_n: &'s [f64],
    /// Base pose, leans (angles between force and normal), object pose and shared errors.
    pub nuisances: &'s Nuisances,
}

/// Point of the mesh to which a marker belongs.
#[derive(Debug, Clone, Copy)]
pub(super) struct MarkerPoint {
    node: NodeIndex,
    /// Index of the marker's key node, from 0.
    key_node: usize,
    /// Undeformed position, finger frame, mm.
    rest: Vector,
}

impl MarkerPoint {
    /// The points of all key nodes.
    pub fn of_key_nodes(mesh: &Mesh) -> Vec<MarkerPoint> {
        let finger = mesh.finger();
        let point = |node: NodeId| MarkerPoint {
            node: mesh.marker_node(node),
            key_node: node.0 - 1,
            rest: finger.marker_position(node),
        };
        (1..=finger.key_node_count()).map(|node| point(NodeId(node))).collect()
    }

    /// Displacement of the marker, mm, relative to the expected pose of the base.
    pub fn displacement(&self, shape: Posed) -> Vector {
        let base = &shape.nuisances.base;
        let displaced = shape.motion.displacements[self.node];
        // If the base is at its expected pose, the part of the displacement due to the motion of the base is exactly zero.
        let by_base = base.translation.vector + (base.rotation * (self.rest + displaced) - (self.rest + displaced));
        displaced + by_base + shape.nuisances.shared_mm(self.key_node)
    }
}

/// Displacement of a marker for a small displacement `by` of its point of the finger, both mm. What turns or enlarges all displacements belongs here and
/// in [`MarkerPoint::displacement`], nowhere else.
pub(super) fn marker_displacement(nuisances: &Nuisances, by: Vector) -> Vector {
    nuisances.base.rotation * by
}

/// Derivative of every marker's displacement with respect to an unknown that displaces the markers by the same pattern in every shape, mm per unit
/// of the unknown. `None` if the displacement depends on the shape.
pub(super) fn fixed_pattern(unknown: Unknown, shared_errors: &[SharedError], key_node: usize) -> Option<Vector> {
    match unknown {
        Unknown::Shared(k) => Some(shared_errors[k].pattern_mm[key_node]),
        Unknown::Base(PosePart::X) => Some(Vector::x()),
        Unknown::Base(PosePart::Y) => Some(Vector::y()),
        Unknown::Force(_)
        | Unknown::Position(_)
        | Unknown::Across(_)
        | Unknown::Base(PosePart::Turn)
        | Unknown::Object(_) => None,
    }
}

/// Derivatives of the markers' displacements at an equilibrium without an object, whose tangent is factored.
pub(super) struct MarkerRates<'r, 'm> {
    pub mesh: &'m Mesh,
    pub questions: &'r [ContactQuestion],
    pub shared_errors: &'r [SharedError],
    /// The finger's equations with the factored tangent.
    pub ladder: &'r mut Ladder<'m>,
    pub motion: &'r FrameMotion,
    pub nuisances: &'r Nuisances,
    /// Force of each contact.
    pub forces: &'r [PadForce],
    /// Buffer for displacements of all key nodes.
    pub room: &'r mut [Vector],
}

impl MarkerRates<'_, '_> {
    /// Writes the derivative of each marker's displacement with respect to `unknown` to `rates`, mm per unit of the unknown. `points` and `rates` are
    /// in the order of the key nodes.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off its plate.
    pub fn differentiate(
        &mut self,
        unknown: Unknown,
        points: &[MarkerPoint],
        rates: &mut [Vector],
    ) -> Result<(), LoadError> {
        match unknown {
            Unknown::Shared(_) | Unknown::Base(PosePart::X | PosePart::Y) => {
                for (rate, point) in rates.iter_mut().zip(points) {
                    *rate = fixed_pattern(unknown, self.shared_errors, point.key_node).unwrap_or_default();
                }
                Ok(())
            }
            Unknown::Base(PosePart::Turn) => self.by_turn_of_base(points, rates),
            Unknown::Position(i) => {
                let force = self.forces[i];
                let plate = force.contact.position.plate();
                self.add_up(force, rates, |ladder, motion, load, out| ladder.moved_load(motion, load, plate, out))
            }
            Unknown::Force(i) | Unknown::Across(i) => {
                let (force, lean_deg) = (self.forces[i], self.nuisances.further_leans_deg[i]);
                let unit = match (unknown, self.questions[i].direction) {
                    (Unknown::Force(_), Direction::Measured(_)) => {
                        PadForce { force_n: 1.0_f64.hypot(self.nuisances.tangent(i)), ..force }
                    }
                    (Unknown::Force(_), _) => PadForce { force_n: 1.0, ..force },
                    (_, Direction::Measured(_)) => force.turned(90.0 - lean_deg, 1.0),
                    _ => force.turned(90.0, 1.0),
                };
                self.add_up(unit, rates, |ladder, motion, load, out| ladder.added_load(motion, load, out))
            }
            // The pose of an object is unknown only if there is an object, and then derivatives are differences of states.
            Unknown::Object(_) => Ok(()),
        }
    }

    fn by_turn_of_base(&mut self, points: &[MarkerPoint], rates: &mut [Vector]) -> Result<(), LoadError> {
        for (rate, point) in rates.iter_mut().zip(points) {
            let at = point.rest + self.motion.displacements[point.node];
            *rate = marker_displacement(self.nuisances, quarter_turn(at));
        }
        // In the frame of the rotated base, a force of known direction rotates opposite to the base.
        for (force, _) in self.forces.iter().zip(self.questions).filter(|(_, q)| q.direction.stated_deg().is_some()) {
            let back_deg = 90.0 * force.contact.position.plate().turn_sign();
            for load in force.turned(back_deg, force.force_n).loads(self.mesh) {
                self.ladder.added_load(self.motion, &load?, self.room);
                for (rate, across) in rates.iter_mut().zip(&*self.room) {
                    *rate -= marker_displacement(self.nuisances, *across);
                }
            }
        }
        Ok(())
    }

    /// Sums the effects `of` the loads of a force on each key node, and writes the sums, as displacements of the markers, to `rates`.
    fn add_up(
        &mut self,
        force: PadForce,
        rates: &mut [Vector],
        mut of: impl FnMut(&mut Ladder, &FrameMotion, &FrameLoad, &mut [Vector]),
    ) -> Result<(), LoadError> {
        for (i, load) in force.loads(self.mesh).enumerate() {
            match i {
                0 => of(self.ladder, self.motion, &load?, rates),
                _ => {
                    of(self.ladder, self.motion, &load?, self.room);
                    rates.iter_mut().zip(&*self.room).for_each(|(rate, further)| *rate += further);
                }
            }
        }
        rates.iter_mut().for_each(|rate| *rate = marker_displacement(self.nuisances, *rate));
        Ok(())
    }
}
