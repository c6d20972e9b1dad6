//! The equations of an edge: sums over the pixels about it.

use super::{PARTS, UNKNOWNS};
use nalgebra::{SMatrix, SVector, Vector2};

/// Sums over the pixels of the band. Centre and radius are in the map's units.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    pub normal: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    pub gradient: SVector<f64, UNKNOWNS>,
    pub count: f64,
    /// How much of its light counts: brightness is one channel, colour two.
    pub channels: f64,
    /// Of the weighted squared residuals, grey levels^2.
    pub squares: f64,
    /// Of the weighted squared contrasts.
    pub weight: f64,
    /// Of the squared residuals of brightness and, halved, of colour.
    pub noise: [f64; PARTS],
    pub by_sector: Vec<SectorSums>,
}

impl Sums {
    /// Of the weighted residuals, grey levels^2.
    pub fn residual_variance(&self) -> f64 {
        self.squares / (self.channels * self.count - UNKNOWNS as f64).max(1.0)
    }
}

/// Sums over the pixels of a sector.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SectorSums {
    pub count: f32,
    /// Of the weighted squared residuals and contrasts.
    pub squares: f32,
    pub contrast2: f32,
    /// The centre's part of the gradient.
    pub pull: Vector2<f32>,
}
