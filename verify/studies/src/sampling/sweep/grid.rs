//! The grid of positions, directions, forces and noise levels on which sensing is tested.

use crate::prelude::*;

/// Directions of a grid reach up to this angle from the normal, degrees. At larger angles a contact would slip.
const LARGEST_ANGLE_DEG: f64 = 80.0;

/// The grid of one request, shared by all true fingers and estimators.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Positions on the front plate, mm from the base.
    #[serde(rename = "places_mm")]
    pub positions_mm: Vec<f64>,
    /// Directions, degrees from the inward normal, positive towards the tip.
    pub angles_deg: Vec<f64>,
    /// Forces, N, ascending.
    pub forces_n: Vec<f64>,
    /// Standard deviations of a measured coordinate's noise, mm; 0 means no noise.
    pub noise_levels_mm: Vec<f64>,
    /// Number of noise samples per cell. All cells share the samples.
    #[serde(rename = "noise_pictures")]
    pub noise_samples: usize,
    /// Seed of the noise.
    pub seed: u64,
}

impl Grid {
    /// Positions (mm from the base) and directions (degrees) of a grid. There are about `positions` positions, evenly spaced in every member of the
    /// front plate, up to and including the tip. A plate with at least 2 * `positions` members is sampled at a subset of its nodes. Directions are
    /// multiples of `step_deg` from -80 to 80 degrees.
    pub fn grid(finger: &Finger, positions: usize, step_deg: f64) -> (Vec<f64>, Vec<f64>) {
        let mut nodes = finger.plate_positions_mm(Plate::Front);
        nodes.dedup();
        let members = nodes.len() - 1;
        let per_member = (positions / members).max(1);
        let every = (members / positions).max(1);
        let divided = nodes.windows(2).flat_map(|w| {
            (1..per_member).map(move |i| w[0] + (w[1] - w[0]) * i as f64 / per_member as f64).chain([w[1]])
        });
        // Selection starts from the tip, so that the tip is always included.
        let mut positions: Vec<f64> = divided.collect::<Vec<_>>().into_iter().rev().step_by(every).collect();
        positions.reverse();
        let steps = (LARGEST_ANGLE_DEG / step_deg).floor() as i32;
        (positions, (-steps..=steps).map(|i| f64::from(i) * step_deg).collect())
    }

    /// Number of contacts (pairs of position and direction).
    pub fn contact_count(&self) -> usize {
        self.positions_mm.len() * self.angles_deg.len()
    }

    /// Contact with index `number`, below [`contact_count`](Grid::contact_count). Contacts are ordered by position, then direction.
    pub fn contact(&self, number: usize) -> Contact {
        let (position, angle) = (number / self.angles_deg.len(), number % self.angles_deg.len());
        Contact { position: ContactPosition::at(self.positions_mm[position]), angle_deg: self.angles_deg[angle] }
    }
}
