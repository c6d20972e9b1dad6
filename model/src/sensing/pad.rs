//! Pad between an object and the front plate.

use super::Contact;
use crate::finger::{Finger, Plate};
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::{Load, LoadError, Mesh};

/// A pad on the front plate. The pad distributes a force evenly over a length of the plate. The force acts on the pad's surface, so the component of
/// the force along the plate exerts a moment on the plate. The default is no pad.
///
/// # Reference
/// Forces at two Gauss points replace the pressure of the pad. The forces at the Gauss points have the same resultant, moment and second moment as a
/// uniform pressure with shear.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pad {
    /// Length of the plate over which a force is distributed, mm.
    pub length_mm: f64,
    /// Distance from the plate to the pad's surface, which touches the object, mm.
    pub thickness_mm: f64,
}

/// Distance of each of the two Gauss points from the contact, as a share of the pad's length: 1 / (2 sqrt(3)).
const GAUSS_POINT: f64 = 0.288_675_134_594_812_9;
/// Each of the two forces acts at least this far from the contact, in mm, because a couple needs a lever arm.
const SHORTEST_LEVER_MM: f64 = 0.5;

impl Pad {
    /// Whether there is no pad. Without a pad, a force acts at a point of the plate.
    pub fn is_none(&self) -> bool {
        *self == Pad::default()
    }

    /// Number of loads that represent one contact force.
    pub(super) fn load_count(&self) -> usize {
        if self.is_none() { 1 } else { 2 }
    }

    /// Rotation of the plate under the pad, rad, for the displacements `motion` of the mesh. Zero without a pad, because the rotation then has no effect.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off the front plate.
    pub(crate) fn plate_turn(&self, mesh: &Mesh, contact: &Contact, motion: &FrameMotion) -> Result<f64, LoadError> {
        match self.is_none() {
            true => Ok(0.0),
            false => mesh.normal_turn(motion, &contact.unit_load(mesh.finger()), self.length_mm),
        }
    }

    /// Loads of a contact force of `force_n`, N, on a plate that is rotated by `plate_turn_rad`. The loads are proportional to the force.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off the front plate.
    pub(crate) fn loads<'m>(
        &self,
        mesh: &'m Mesh,
        contact: &Contact,
        force_n: f64,
        plate_turn_rad: f64,
    ) -> impl Iterator<Item = Result<FrameLoad, LoadError>> + use<'m> {
        let finger = mesh.finger();
        let whole = contact.load(finger, force_n);
        let loads = match contact.position_mm(finger).filter(|_| !self.is_none()) {
            None => [Some(whole), None],
            Some(s_mm) => self.pair(finger, contact, s_mm, force_n, plate_turn_rad).map(Some),
        };
        loads.into_iter().flatten().map(|load| mesh.frame_load(&load))
    }

    /// Two forces whose sum is the contact force. The moment of the two forces about the contact equals the moment of the friction force on the pad's
    /// surface.
    fn pair(&self, finger: &Finger, contact: &Contact, s_mm: f64, force_n: f64, plate_turn_rad: f64) -> [Load; 2] {
        let length_mm = finger.plate_length_mm(Plate::Front);
        let reach_mm = (GAUSS_POINT * self.length_mm).max(SHORTEST_LEVER_MM);
        // The pad does not extend beyond the ends of the plate.
        let nearest_mm = f64::EPSILON * length_mm;
        let [from_mm, to_mm] = [s_mm - reach_mm, s_mm + reach_mm].map(|at_mm| at_mm.clamp(nearest_mm, length_mm));
        let apart_mm = to_mm - from_mm;
        let force = finger.direction(contact.angle_deg) * force_n;
        // Normal and tangent of the rotated plate.
        let [inward, tipward] = [0.0, 90.0].map(|deg| finger.direction(deg + plate_turn_rad.to_degrees()));
        // A force on the pad's surface that points towards the tip presses the plate inwards on the side of the tip.
        let turning = inward * (self.thickness_mm * force.dot(&tipward) / apart_mm);
        let to_share = (s_mm - from_mm) / apart_mm;
        [
            Load::at_position(from_mm, force * (1.0 - to_share) - turning),
            Load::at_position(to_mm, force * to_share + turning),
        ]
    }
}
