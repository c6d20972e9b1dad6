//! Markers on clamped nodes: what a camera sees of them is noise, and a large displacement is a row of another node.

use super::FileError;
use super::table::{Row, Table};
use finray_model::{Finger, NodeId, Vector};

/// A clamped node may seem to have moved by so many standard deviations, and by as much, mm, before rows and nodes must be mixed up.
const SIGMAS: f64 = 6.0;
const LEAST_MM: f64 = 0.05;
/// The same where no noise is stated, as a share of the largest displacement: of a finger that moves by 10 mm three times the noise of the paper's
/// camera. The paper's first free nodes move by more than that when a force at a node bends the finger.
const SHARE: f64 = 0.02;

/// What a clamped marker's displacement is held against.
pub(super) struct Clamped<'f> {
    finger: &'f Finger,
    /// Largest displacement that noise explains, mm.
    largest_mm: f64,
}

impl<'f> Clamped<'f> {
    /// By the standard deviation of a coordinate, mm, or where none is known by the displacements of all markers.
    pub(super) fn new(
        finger: &'f Finger,
        sigma_mm: Option<f64>,
        displacements: impl IntoIterator<Item = Vector>,
    ) -> Clamped<'f> {
        let largest_mm = match sigma_mm {
            Some(sigma_mm) => LEAST_MM.max(SIGMAS * sigma_mm),
            None => SHARE * displacements.into_iter().map(|moved| moved.norm()).fold(0.0, f64::max),
        };
        Clamped { finger, largest_mm }
    }

    /// Whether a row is a clamped marker's and is to be ignored.
    ///
    /// # Errors
    /// [`FileError`] naming the line of one that moved by more than noise explains.
    pub(super) fn holds<const N: usize>(
        &self,
        node: NodeId,
        moved: Vector,
        table: &Table<N>,
        row: &Row<N>,
    ) -> Result<bool, FileError> {
        if !self.finger.clamped_nodes().contains(&node) {
            return Ok(false);
        }
        let (moved_mm, largest_mm) = (moved.norm(), self.largest_mm);
        if moved_mm <= largest_mm {
            return Ok(true);
        }
        let message = format!(
            "node {node} is clamped, so its displacement must be zero but for noise: found {moved_mm:.3} mm, more than {largest_mm:.3} mm; are the \
             nodes numbered as in the scene, from the back base over the tip to the front base?"
        );
        Err(table.wrong(row, message))
    }
}
