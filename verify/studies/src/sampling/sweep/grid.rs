//! The grid of positions, directions, forces and noise levels on which sensing is tested.

use crate::prelude::*;
use crate::sampling::situation::ContactKnowledge;
use crate::truths::{Truth, leaning};

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
    /// Whether the directions count from the normal of the deformed plate at the contact, instead of the undeformed normal.
    #[serde(default)]
    pub is_leaning: bool,
    /// Forces, N, ascending.
    pub forces_n: Vec<f64>,
    /// Standard deviations of a measured coordinate's noise, mm; 0 means no noise.
    pub noise_levels_mm: Vec<f64>,
    /// Number of noise samples per cell. All cells share the samples, unless directions lean.
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

    /// Positions and directions of a [`grid`](Grid::grid) for what a sensor knows of the contact. Directions that lean from the deformed normal cover
    /// the range that friction allows in equal steps of about `step_deg` (degrees).
    pub fn of_knowledge(
        scene: &Scene,
        contact: ContactKnowledge,
        positions: usize,
        step_deg: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let (positions_mm, angles_deg) = Grid::grid(&scene.finger, positions, step_deg);
        if !contact.is_leaning() {
            return (positions_mm, angles_deg);
        }
        let [least, most] = contact.allowed_deg(scene);
        // An even number of steps includes the middle of the range.
        let steps = 2 * (0.5 * (most - least) / step_deg).round().max(1.0) as usize;
        let leans = (0..=steps).map(|i| least + (most - least) * i as f64 / steps as f64);
        (positions_mm, if least == most { vec![least] } else { leans.collect() })
    }

    /// Part of the plate (mm) that each position stands for: up to the middle between neighbours, and to the ends of the plate.
    pub fn lengths_mm(&self, finger: &Finger) -> Vec<f64> {
        parts(&self.positions_mm, [0.0, finger.plate_length_mm(Plate::Front)])
    }

    /// Part of the directions that friction allows (degrees) that each direction stands for. Directions outside the range have zero. With a single
    /// direction, its part is 1.
    pub fn sectors_deg(&self) -> Vec<f64> {
        match &self.angles_deg[..] {
            [_] => vec![1.0],
            [first, .., last] if self.is_leaning => parts(&self.angles_deg, [*first, *last]),
            angles_deg => parts(angles_deg, ContactKnowledge::cone_deg()),
        }
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

    /// The true contact and the shape of the finger for each force, for a contact of the grid. The list ends before the first force that the finger
    /// cannot carry.
    pub fn bent(&self, truth: &dyn Truth, finger: &Finger, contact: Contact) -> Vec<(Contact, FingerShape)> {
        if self.is_leaning {
            let s_mm = contact.position_mm(finger).unwrap_or(f64::NAN);
            let bent = |force_n: &f64| leaning(truth, finger, s_mm, contact.angle_deg, *force_n);
            return self.forces_n.iter().map_while(bent).collect();
        }
        truth.shapes(&contact, &self.forces_n).into_iter().map(|shape| (contact, shape)).collect()
    }
}

/// Length of the part of a range that is nearest to each of some ascending values.
fn parts(values: &[f64], [from, to]: [f64; 2]) -> Vec<f64> {
    let middles = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let edges: Vec<f64> = std::iter::once(from).chain(middles).chain([to]).map(|edge| edge.clamp(from, to)).collect();
    edges.windows(2).map(|ends| ends[1] - ends[0]).collect()
}
