//! Check of markers on clamped nodes. A marker on a clamped node shows only noise, so a large displacement of this marker indicates a wrong node
//! number.

use super::MarkerError;
use crate::Vector;
use crate::finger::Finger;
use crate::measurement::Marker;

/// A clamped marker is refused if it moves by more than this many standard deviations and by more than `LEAST_MM`. A large motion of a clamped marker
/// indicates wrong node numbers.
const SIGMAS: f64 = 6.0;
const LEAST_MM: f64 = 0.05;
/// Without a stated noise, a clamped marker is refused if it moves by more than this share of the largest displacement. If the largest displacement
/// is 10 mm, this share of it (0.2 mm) is three times the noise of the paper's camera. On the paper's finger, the free nodes nearest to the base move
/// by more than this share under any force at a node.
const SHARE: f64 = 0.02;

/// Largest motion of a clamped marker that noise explains, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestClampedMotion(f64);

impl LargestClampedMotion {
    /// Computes the limit from the standard deviation of a coordinate, mm. If `sd_mm` is `None`, computes the limit from the displacements of all
    /// markers, mm.
    pub fn of(sd_mm: Option<f64>, displacements: impl IntoIterator<Item = Vector>) -> LargestClampedMotion {
        LargestClampedMotion(match sd_mm {
            Some(sd_mm) => LEAST_MM.max(SIGMAS * sd_mm),
            None => SHARE * displacements.into_iter().map(|moved| moved.norm()).fold(0.0, f64::max),
        })
    }

    /// Refuses a clamped marker that moved farther than this limit.
    ///
    /// # Errors
    /// [`MarkerError::ClampedMoves`] if the marker moved farther.
    pub fn check(self, finger: &Finger, marker: &Marker) -> Result<(), MarkerError> {
        let (node, moved_mm, largest_mm) = (marker.node, marker.displacement.norm(), self.0);
        match finger.is_clamped(node) && moved_mm > largest_mm {
            true => Err(MarkerError::ClampedMoves { node, moved_mm, largest_mm }),
            false => Ok(()),
        }
    }
}
