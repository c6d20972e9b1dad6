//! Images of the finger: as the scene's camera takes them ([`render`]), and node positions from them ([`locate`]).
//!
//! Pixel (0, 0) has its centre at (0, 0), u to the right, v down, as in [`finray_model::camera`].

pub mod locate;
pub mod render;
