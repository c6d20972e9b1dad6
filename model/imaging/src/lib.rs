//! Images of the finger: rendering ([`render`]), marker positions from images ([`locate`]), and plane grids for lens calibration ([`grid`]).
//!
//! The crate is pure, like the model: images are in memory, and random numbers come from a given seed. Pixel (0, 0) has its centre at (0, 0), u to the right,
//! v down, as in [`finray_model::camera`].
#![forbid(unsafe_code)]

pub mod grid;
pub mod lens_fit;
pub mod locate;
pub mod plane_pose;
pub mod render;
