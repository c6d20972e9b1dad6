//! Least-squares equations of an edge: sums over the pixels about it.

use super::{PARTS, UNKNOWNS};
use nalgebra::{SMatrix, SVector, Vector2};

/// Sums over the pixels of the band; centre and radius are in the map's units.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    /// Normal matrix of the least squares.
    pub normal: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    /// Right-hand side of the normal equations.
    pub gradient: SVector<f64, UNKNOWNS>,
    /// Number of pixels, weighted by trust.
    pub count: f64,
    /// Number of weighted channels: one for brightness, two for colour.
    pub channels: f64,
    /// Sum of the weighted squared residuals, squared grey levels.
    pub squares: f64,
    /// Sum of the weighted squared contrasts, squared grey levels.
    pub weight: f64,
    /// Sums of the squared residuals of brightness and, halved, of colour, squared grey levels.
    pub noise: [f64; PARTS],
    pub by_sector: Vec<SectorSums>,
}

impl Sums {
    /// Variance of the weighted residuals, squared grey levels.
    pub fn residual_variance(&self) -> f64 {
        self.squares / (self.channels * self.count - UNKNOWNS as f64).max(1.0)
    }
}

/// Sums over the pixels of a sector.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SectorSums {
    /// Number of pixels.
    pub count: f32,
    /// Sums of the weighted squared residuals and contrasts, squared grey levels.
    pub squares: f32,
    pub contrast2: f32,
    /// The centre's part of the gradient.
    pub pull: Vector2<f32>,
}
