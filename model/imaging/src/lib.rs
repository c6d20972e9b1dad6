//! Images of the finger: rendering ([`render`]), positions of markers in images ([`locate`]), and plane grids for lens calibration ([`grid`]).
//!
//! The crate is pure, like the model: images are in memory, and random numbers come from a given seed. Pixel coordinates are u to the right and v down; the
//! centre of the first pixel is (0, 0), as in [`finray_model::camera`].
#![forbid(unsafe_code)]

pub mod grid;
pub mod lens_fit;
pub mod locate;
pub mod plane_pose;
pub mod render;
