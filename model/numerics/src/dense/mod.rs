//! Evaluation of dense layers of a neural network: products of a matrix with one or many vectors, and the hyperbolic tangent.

mod products;
mod tanh;
mod vectors;

pub use products::{Finish, Linear, Weights, padded, tile_frames, tiled};
pub use tanh::{Tanh, tanh_all};
pub use vectors::{Aligned, Number};
