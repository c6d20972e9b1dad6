//! Markers on clamped nodes: what a camera sees of them is noise, and a large displacement is another node's.

use super::MarkerError;
use crate::Vector;
use crate::finger::Finger;
use crate::measurement::Marker;

/// A clamped marker may seem to move by this many standard deviations, and by this much, mm, before nodes must be mixed up.
const SIGMAS: f64 = 6.0;
const LEAST_MM: f64 = 0.05;
/// The same where no noise is stated, as a share of the largest displacement: of a finger that moves by 10 mm three times the noise of the paper's
/// camera. The paper's first free nodes move by more than that when a force at a node bends the finger.
const SHARE: f64 = 0.02;

/// Largest motion of a clamped marker that noise explains, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestClampedMotion(f64);

impl LargestClampedMotion {
    /// By the standard deviation of a coordinate, mm, or where none is known by the displacements of all markers.
    pub fn of(sd_mm: Option<f64>, displacements: impl IntoIterator<Item = Vector>) -> LargestClampedMotion {
        LargestClampedMotion(match sd_mm {
            Some(sd_mm) => LEAST_MM.max(SIGMAS * sd_mm),
            None => SHARE * displacements.into_iter().map(|moved| moved.norm()).fold(0.0, f64::max),
        })
    }

    /// Refuses a clamped marker that moved by more.
    ///
    /// # Errors
    /// [`MarkerError::ClampedMoves`].
    pub fn check(self, finger: &Finger, marker: &Marker) -> Result<(), MarkerError> {
        let (node, moved_mm, largest_mm) = (marker.node, marker.displacement.norm(), self.0);
        match finger.is_clamped(node) && moved_mm > largest_mm {
            true => Err(MarkerError::ClampedMoves { node, moved_mm, largest_mm }),
            false => Ok(()),
        }
    }
}
