//! Least-squares equations of an edge: sums over the pixels about the edge.

use super::{PARTS, UNKNOWNS};
use nalgebra::{SMatrix, SVector, Vector2};

/// Sums over the pixels of the band about an edge. Centre and radius are in the units of the plane map.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    /// Normal matrix of the least-squares problem.
    pub normal: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    /// Right-hand side of the normal equations.
    pub gradient: SVector<f64, UNKNOWNS>,
    /// Number of pixels, each weighted by the trust in its sector.
    pub count: f64,
    /// Number of channels that have a weight: one for brightness, two for colour.
    pub channels: f64,
    /// Sum of the weighted squared residuals, in squared grey levels.
    pub squares: f64,
    /// Sum of the weighted squared contrasts, in squared grey levels.
    pub weight: f64,
    /// Sums of the squared residuals of brightness and of colour, in squared grey levels. The sum for colour is halved, because colour has two channels.
    pub noise: [f64; PARTS],
    /// Sums over the pixels of each sector.
    pub by_sector: Vec<SectorSums>,
}

impl Sums {
    /// Variance of the weighted residuals, in squared grey levels.
    pub fn residual_variance(&self) -> f64 {
        self.squares / (self.channels * self.count - UNKNOWNS as f64).max(1.0)
    }
}

/// Sums over the pixels of one sector.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SectorSums {
    /// Number of pixels in the sector.
    pub count: f32,
    /// Sum of the weighted squared residuals, in squared grey levels.
    pub squares: f32,
    /// Sum of the weighted squared contrasts, in squared grey levels.
    pub contrast2: f32,
    /// Contribution of the sector to the gradient by the centre's coordinates.
    pub pull: Vector2<f32>,
    /// Contribution of the sector to the normal matrix of the centre: xx, xy, yy.
    pub stiffness: [f32; 3],
    /// Contributions to gradient and normal matrix of an edge that the sector's pixels alone move outwards, whatever the trust in the sector.
    pub outwards: [f32; 2],
}
