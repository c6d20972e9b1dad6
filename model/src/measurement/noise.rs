//! Noise of measured displacements. The noise of a displacement depends on the source of the undeformed position.
//!
//! A displacement is a position in an image minus the undeformed position. The undeformed position is measured in an image of the unloaded finger, or
//! computed from the motor angle. The error of the undeformed position is part of the displacement, and all frames that use this undeformed position
//! share the error.

use super::Measurement;
use crate::Vector;
use crate::element::quarter_turn;
use nalgebra::{Cholesky, DMatrix, Dyn};

/// Noise of the displacements of one measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DisplacementNoise {
    /// Each coordinate has an independent error in every frame. The undeformed positions are exact.
    Independent {
        /// Standard deviation of one displacement coordinate, mm.
        sd_mm: f64,
    },
    /// The undeformed positions come from an image of the unloaded finger.
    TwoImages {
        /// Standard deviation of one coordinate in one image, mm.
        image_sd_mm: f64,
    },
    /// The undeformed positions come from the motor angle, eqs (6)-(10) of Xu et al. (2021), and share the error of the base's pose.
    Kinematic {
        /// Standard deviation of one coordinate in one image, mm.
        image_sd_mm: f64,
        /// Standard deviation of the base's position along each axis, mm.
        translation_sd_mm: f64,
        /// Standard deviation of the base's rotation, rad, about the origin of the finger frame.
        rotation_sd_rad: f64,
    },
}

impl DisplacementNoise {
    /// Standard deviation of the part of a coordinate's error that is independent in every frame, mm.
    pub fn frame_sd_mm(&self) -> f64 {
        match *self {
            DisplacementNoise::Independent { sd_mm } => sd_mm,
            DisplacementNoise::TwoImages { image_sd_mm } | DisplacementNoise::Kinematic { image_sd_mm, .. } => {
                image_sd_mm
            }
        }
    }

    /// Covariance of the displacements averaged over `frames` frames, mm^2. Rows and columns are x and y of each node of `positions_mm`.
    ///
    /// `positions_mm` are the deformed positions of the nodes, finger frame. The positions are needed because a rotation of the base moves every node
    /// perpendicular to its radius. The error of the undeformed positions is the same in all frames, so it does not average out.
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

    /// Random errors of the displacements due to the undeformed positions, mm, one vector per node. All frames share these errors. `standard_normal` returns
    /// independent random numbers of the standard normal distribution.
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
                positions_mm.iter().map(|at| -translation - quarter_turn(*at) * rotation).collect()
            }
        }
    }

    /// Adds shared errors and the independent errors of one frame to a measurement. `shared_mm` has one entry per marker, in the same order.
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

    /// Covariance of the displacements averaged over several frames, factored as L L^T. L^-1 transforms errors into independent errors of standard
    /// deviation 1. `None` without noise.
    pub fn factored(&self, positions_mm: &[Vector], frames: usize) -> Option<Cholesky<f64, Dyn>> {
        Cholesky::new(self.covariance_mm2(positions_mm, frames))
    }
}

/// Derivatives of every coordinate with respect to the pose of the base. The three columns are translation along x and along y (dimensionless), and rotation
/// about the origin (mm/rad).
pub fn base_motions(positions_mm: &[Vector]) -> DMatrix<f64> {
    DMatrix::from_fn(2 * positions_mm.len(), 3, |row, column| match column {
        2 => quarter_turn(positions_mm[row / 2])[row % 2],
        axis => f64::from(u8::from(row % 2 == axis)),
    })
}
