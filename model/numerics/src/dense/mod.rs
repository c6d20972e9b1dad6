//! What dense layers of a network are evaluated with: products of a matrix with one vector or many, and the hyperbolic tangent.

mod products;
mod tanh;
mod vectors;

pub use products::{Finish, Linear, Weights, padded, tile_frames, tiled};
pub use tanh::{Tanh, tanh_all};
pub use vectors::{Aligned, Number};
