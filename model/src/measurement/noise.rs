//! Noise of measured displacements, by where the undeformed positions come from.
//!
//! A displacement is a position in an image less the undeformed position. That one is measured too, in an image of the finger at
//! rest, or computed from the motor angle; either way its error is part of the displacement, and all frames that use it share it.

use super::Measurement;
use crate::Vector;
use nalgebra::allocator::Allocator;
use nalgebra::{Cholesky, DMatrix, DefaultAllocator, Dim, Dyn, OMatrix};

/// Noise of the displacements of one measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DisplacementNoise {
    /// Each coordinate has an error of its own, in every frame anew: the undeformed positions are exact.
    Independent {
        /// Standard deviation of one displacement coordinate, mm.
        sd_mm: f64,
    },
    /// The undeformed positions come from an image of the finger at rest.
    TwoImages {
        /// Standard deviation of one coordinate in one image, mm.
        image_sd_mm: f64,
    },
    /// The undeformed positions come from the motor angle, eqs (6)-(10) of Xu et al. (2021): with the error of the base's pose.
    Kinematic {
        /// Standard deviation of one coordinate in one image, mm.
        image_sd_mm: f64,
        /// Standard deviation of the base's position along each axis, mm.
        translation_sd_mm: f64,
        /// Standard deviation of the base's rotation, rad, about the origin of the finger frame.
        rotation_sd_rad: f64,
    },
}

/// A covariance that has no inverse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the noise of the displacements must be positive")]
pub struct NoNoise;

impl DisplacementNoise {
    /// Standard deviation of the error that one coordinate has in every frame anew, mm.
    pub fn frame_sd_mm(&self) -> f64 {
        match *self {
            DisplacementNoise::Independent { sd_mm } => sd_mm,
            DisplacementNoise::TwoImages { image_sd_mm } | DisplacementNoise::Kinematic { image_sd_mm, .. } => {
                image_sd_mm
            }
        }
    }

    /// Covariance of the mean of `frames` frames, mm^2: rows and columns are x and y of the node at each position.
    ///
    /// `positions_mm` are those of the nodes in the image (deformed), finger frame: the base's rotation moves every node across
    /// its radius. The undeformed positions' error does not average out.
    pub fn covariance_mm2(&self, positions_mm: &[Vector], frames: usize) -> DMatrix<f64> {
        let coordinates = 2 * positions_mm.len();
        let own = self.frame_sd_mm().powi(2) / frames as f64;
        let mut covariance = DMatrix::from_diagonal_element(coordinates, coordinates, own);
        match *self {
            DisplacementNoise::Independent { .. } => {}
            DisplacementNoise::TwoImages { image_sd_mm } => {
                for i in 0..coordinates {
                    covariance[(i, i)] += image_sd_mm.powi(2);
                }
            }
            DisplacementNoise::Kinematic { translation_sd_mm, rotation_sd_rad, .. } => {
                let motions = base_motions(positions_mm);
                let scaled = [translation_sd_mm, translation_sd_mm, rotation_sd_rad];
                for (motion, sd) in motions.column_iter().zip(scaled) {
                    covariance += motion * motion.transpose() * (sd * sd);
                }
            }
        }
        covariance
    }

    /// Errors that all frames share which use the same undeformed positions, mm, from standard normal numbers.
    pub fn shared_errors_mm(&self, positions_mm: &[Vector], mut standard_normal: impl FnMut() -> f64) -> Vec<Vector> {
        match *self {
            DisplacementNoise::Independent { .. } => vec![Vector::zeros(); positions_mm.len()],
            DisplacementNoise::TwoImages { image_sd_mm } => {
                let error = |_: &Vector| Vector::new(standard_normal(), standard_normal()) * -image_sd_mm;
                positions_mm.iter().map(error).collect()
            }
            DisplacementNoise::Kinematic { translation_sd_mm, rotation_sd_rad, .. } => {
                let translation = Vector::new(standard_normal(), standard_normal()) * translation_sd_mm;
                let rotation = standard_normal() * rotation_sd_rad;
                positions_mm.iter().map(|at| -translation - across(at) * rotation).collect()
            }
        }
    }

    /// Adds the shared errors and a frame's own to a measurement whose markers are those at the positions of `shared_mm`.
    pub fn add_to(
        &self,
        measurement: &mut Measurement,
        shared_mm: &[Vector],
        mut standard_normal: impl FnMut() -> f64,
    ) {
        for (marker, shared) in measurement.markers.iter_mut().zip(shared_mm) {
            marker.displacement += shared;
            marker.displacement += Vector::new(standard_normal(), standard_normal()) * self.frame_sd_mm();
        }
    }

    /// The covariance of the mean of several frames, factored: what turns errors into independent ones of standard deviation 1.
    ///
    /// # Errors
    /// [`NoNoise`] if it is not positive definite.
    pub fn whitening(&self, positions_mm: &[Vector], frames: usize) -> Result<Whitening, NoNoise> {
        let factor = Cholesky::new(self.covariance_mm2(positions_mm, frames)).ok_or(NoNoise)?;
        Ok(Whitening { factor })
    }
}

/// The covariance of displacements, factored as L L^T.
#[derive(Debug, Clone)]
pub struct Whitening {
    factor: Cholesky<f64, Dyn>,
}

impl Whitening {
    /// L^-1 of a residual or of derivatives: a row a coordinate (mm), a column an unknown.
    pub fn whitened<C: Dim>(&self, columns: &OMatrix<f64, Dyn, C>) -> OMatrix<f64, Dyn, C>
    where
        DefaultAllocator: Allocator<Dyn, C>,
    {
        let mut whitened = columns.clone();
        self.factor.l_dirty().solve_lower_triangular_mut(&mut whitened);
        whitened
    }
}

/// Motion of every coordinate per mm of the base along x, along y, and per rad about the origin: three columns.
pub fn base_motions(positions_mm: &[Vector]) -> DMatrix<f64> {
    DMatrix::from_fn(2 * positions_mm.len(), 3, |row, column| match column {
        2 => across(&positions_mm[row / 2])[row % 2],
        axis => f64::from(u8::from(row % 2 == axis)),
    })
}

/// Displacement of a node per rad about the origin, mm.
fn across(position_mm: &Vector) -> Vector {
    Vector::new(-position_mm.y, position_mm.x)
}
