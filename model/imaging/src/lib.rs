//! From images to what sensing starts from: node positions of the finger ([`locate`]), and plane grids that show the lens ([`grid`]).
//!
//! Pure, as the model is: images in memory go in, positions come out. Pixel (0, 0) has its centre at (0, 0), u to the right, v down, as in
//! [`finray_model::camera`].
#![forbid(unsafe_code)]

pub mod grid;
pub mod locate;
