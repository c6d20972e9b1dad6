//! Grid of positions along the front plate, between which responses are interpolated.

use crate::finger::{Finger, Plate};

/// The grid starts at this share of the plate's length, where a force moves hardly any marker.
const FROM: f64 = 0.02;
/// Points between neighbouring nodes of the plate lie at most this share of the plate's length apart, for one or two contacts.
const FINE: f64 = 1.0 / 24.0;
/// For three contacts, the grid is coarser, because all combinations are computed.
const COARSE: f64 = 1.0 / 9.0;
/// Number of points of a piece, over which the response is a cubic. A cubic is exact between nodes of a straight uniform plate.
const POINTS: usize = 4;

/// Positions in ascending order, mm. Each piece has [`POINTS`] points, the last of which is the first of the next piece.
pub(super) struct Grid {
    pub at_mm: Vec<f64>,
    /// Largest distance between neighbouring points, mm.
    pub spacing_mm: f64,
}

/// A position as a weighted sum of points of the grid: the index of the first point, and the weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    first: usize,
    weights: [f64; POINTS],
    count: usize,
}

impl Place {
    /// A point of the grid.
    pub fn at_point(point: usize) -> Place {
        Place { first: point, weights: [1.0, 0.0, 0.0, 0.0], count: 1 }
    }

    /// Indices and weights of the points.
    pub fn weights(&self) -> impl Iterator<Item = (usize, f64)> + use<'_> {
        self.weights[..self.count].iter().enumerate().map(|(i, weight)| (self.first + i, *weight))
    }
}

impl Grid {
    /// A grid for a number of contacts at unknown positions.
    pub fn new(finger: &Finger, contacts: usize) -> Grid {
        let length_mm = finger.plate_length_mm(Plate::Front);
        let nodes = finger.contact_nodes().filter_map(|node| finger.front_position_mm(node));
        let mut ends: Vec<f64> = [FROM * length_mm, length_mm].into_iter().chain(nodes).collect();
        ends.retain(|s_mm| *s_mm >= FROM * length_mm);
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() < 1e-6 * length_mm);
        let widest_mm = (POINTS - 1) as f64 * length_mm * if contacts > 2 { COARSE } else { FINE };
        let (mut at_mm, mut spacing_mm) = (vec![ends[0]], 0.0_f64);
        for bay in ends.windows(2) {
            let intervals = (POINTS - 1) * ((bay[1] - bay[0]) / widest_mm).ceil().max(1.0) as usize;
            let step_mm = (bay[1] - bay[0]) / intervals as f64;
            at_mm.extend((1..=intervals).map(|i| bay[0] + i as f64 * step_mm));
            spacing_mm = spacing_mm.max(step_mm);
        }
        Grid { at_mm, spacing_mm }
    }

    /// A position, mm. `None` beyond the ends of the grid.
    pub fn place(&self, s_mm: f64) -> Option<Place> {
        let (from_mm, to_mm) = (*self.at_mm.first()?, *self.at_mm.last()?);
        (from_mm..=to_mm).contains(&s_mm).then_some(())?;
        let pieces = (self.at_mm.len() - 1) / (POINTS - 1);
        let after = self.at_mm.partition_point(|at_mm| *at_mm <= s_mm);
        let first = (POINTS - 1) * ((after - 1) / (POINTS - 1)).min(pieces - 1);
        let piece = &self.at_mm[first..first + POINTS];
        let mut weights = [1.0; POINTS];
        for (i, weight) in weights.iter_mut().enumerate() {
            let others = piece.iter().enumerate().filter(|(j, _)| *j != i);
            *weight = others.map(|(_, other_mm)| (s_mm - other_mm) / (piece[i] - other_mm)).product();
        }
        Some(Place { first, weights, count: POINTS })
    }
}
