//! The surface that an object touches: the outer face of a plate, or of a pad on the plate.

use crate::finger::{Finger, PlatePosition};

/// Surface on which an object's force acts: the outer face of a plate, or of a pad on this face. The component of the force along the plate exerts a
/// moment on the plate's middle line. A pad also distributes the force evenly over a length of the plate. The default is the bare plate.
///
/// # Reference
/// Forces at two Gauss points replace the pressure of the pad. The forces at the Gauss points have the same resultant, moment and second moment as a
/// uniform pressure with shear.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pad {
    /// Length of the plate over which a force is distributed, mm.
    pub length_mm: f64,
    /// Distance from the plate's outer face to the surface that touches the object, mm: the thickness of the pad.
    pub thickness_mm: f64,
}

impl Pad {
    /// Distance from the plate's middle line to the touched surface, mm: half the plate's thickness, and the pad.
    pub fn lever_mm(&self, finger: &Finger, at: PlatePosition) -> f64 {
        0.5 * finger.thickness_mm(at.plate, at.s_mm) + self.thickness_mm
    }
}
