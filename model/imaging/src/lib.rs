//! Images of the finger: as a camera takes them ([`render`]), node positions from them ([`locate`]), and plane grids that show the lens
//! ([`grid`]).
//!
//! Pure, as the model is: images are in memory, and chance comes from a seed. Pixel (0, 0) has its centre at (0, 0), u to the right, v down, as in
//! [`finray_model::camera`].
#![forbid(unsafe_code)]

pub mod grid;
pub mod locate;
pub mod render;
