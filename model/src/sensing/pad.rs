//! Pad between an object and a plate.

/// A pad on a plate. The pad distributes a force evenly over a length of the plate. The force acts on the pad's surface, so the component of
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

impl Pad {
    /// Whether there is no pad. Without a pad, a force acts at a point of the plate.
    pub fn is_none(&self) -> bool {
        *self == Pad::default()
    }
}
