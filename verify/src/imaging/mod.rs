//! Images of the finger: as the scene's camera takes them ([`render`]), node positions from them ([`locate`]), and plane grids
//! that show the lens ([`grid`]).
//!
//! Pixel (0, 0) has its centre at (0, 0), u to the right, v down, as in [`finray_model::camera`].

pub mod grid;
pub mod locate;
pub mod render;
