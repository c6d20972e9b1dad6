//! Forces on a pad, as loads on the plate under it.

use super::{Contact, Pad};
use crate::Vector;
use crate::finger::{Finger, PlatePosition};
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::{Load, LoadError, Mesh};

/// Distance of each of the two Gauss points from the contact, as a share of the pad's length: 1 / (2 sqrt(3)).
const GAUSS_POINT: f64 = 0.288_675_134_594_812_9;
/// Each of the two forces acts at least this far from the contact, in mm, because a couple needs a lever arm.
const SHORTEST_LEVER_MM: f64 = 0.5;

/// Rotation of the plate under a touched surface, rad, for the displacements `motion` of the mesh. Zero for a force on the middle line, because the
/// rotation then has no effect.
///
/// # Errors
/// [`LoadError`] for a contact off its plate.
pub(crate) fn plate_turn(
    pad: Option<Pad>,
    mesh: &Mesh,
    contact: &Contact,
    motion: &FrameMotion,
) -> Result<f64, LoadError> {
    pad.map_or(Ok(0.0), |pad| mesh.normal_turn(motion, &contact.unit_load(mesh.finger()), pad.length_mm))
}

/// A contact force on the surface of a plate or pad, or on the plate's middle line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PadForce {
    /// Position and direction of the force.
    pub contact: Contact,
    /// Force along the direction, N.
    pub force_n: f64,
    /// The touched surface; `None` for a force on the plate's middle line.
    pub pad: Option<Pad>,
    /// Rotation of the plate under the pad towards the tip, rad.
    pub plate_turn_rad: f64,
}

impl PadForce {
    /// A force of `force_n`, N, whose direction is rotated by `by_deg`, degrees, on the same plate.
    pub fn turned(&self, by_deg: f64, force_n: f64) -> PadForce {
        PadForce { contact: Contact { angle_deg: self.contact.angle_deg + by_deg, ..self.contact }, force_n, ..*self }
    }

    /// Loads whose sum is the force, and whose moment about the contact is that of the friction force on the touched surface. The loads are proportional
    /// to the force. Without a length, a pad does not spread the force.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off its plate.
    pub fn loads<'m>(&self, mesh: &'m Mesh) -> impl Iterator<Item = Result<FrameLoad, LoadError>> + use<'m> {
        let finger = mesh.finger();
        let whole = self.contact.load(finger, self.force_n);
        let loads = match (whole, self.pad.zip(self.contact.position_mm(finger))) {
            (whole, None) => [Some(whole), None, None],
            (Load::Node { node, force, .. }, Some((pad, s_mm))) if pad.length_mm == 0.0 => {
                let [_, tipward] = self.plate_axes(finger);
                let moment_nmm = -pad.lever_mm(finger, s_mm.into()) * force.dot(&tipward);
                [Some(Load::Node { node, force, moment_nmm }), None, None]
            }
            (whole, Some((pad, s_mm))) => {
                let [from, to] = self.pair(finger, pad, s_mm);
                [Some(whole).filter(|_| pad.length_mm == 0.0), Some(from), Some(to)]
            }
        };
        loads.into_iter().flatten().map(|load| mesh.frame_load(&load))
    }

    /// Two forces whose moment about the contact equals the moment of the friction force on the touched surface. Their sum is the contact force if the
    /// pad spreads it, and zero otherwise.
    fn pair(&self, finger: &Finger, pad: Pad, s_mm: f64) -> [Load; 2] {
        let plate = self.contact.position.plate();
        let length_mm = finger.plate_length_mm(plate);
        let reach_mm = (GAUSS_POINT * pad.length_mm).max(SHORTEST_LEVER_MM);
        // The pad does not extend beyond the ends of the plate.
        let nearest_mm = f64::EPSILON * length_mm;
        let [from_mm, to_mm] = [s_mm - reach_mm, s_mm + reach_mm].map(|at_mm| at_mm.clamp(nearest_mm, length_mm));
        let apart_mm = to_mm - from_mm;
        let force = self.contact.direction(finger) * self.force_n;
        let [inward, tipward] = self.plate_axes(finger);
        // A force on the surface that points towards the tip presses the plate inwards on the side of the tip.
        let lever_mm = pad.lever_mm(finger, PlatePosition { plate, s_mm });
        let turning = inward * (lever_mm * force.dot(&tipward) / apart_mm);
        let to_share = (s_mm - from_mm) / apart_mm;
        let [of_from, of_to] =
            if pad.length_mm > 0.0 { [force * (1.0 - to_share), force * to_share] } else { [Vector::zeros(); 2] };
        let at = |s_mm, force| Load::at_position(PlatePosition { plate, s_mm }, force);
        [at(from_mm, of_from - turning), at(to_mm, of_to + turning)]
    }

    /// Inward normal and tangent towards the tip of the plate.
    fn plate_axes(&self, finger: &Finger) -> [Vector; 2] {
        let plate = self.contact.position.plate();
        [0.0, 90.0].map(|deg| finger.direction_on(plate, deg + self.plate_turn_rad.to_degrees()))
    }
}
