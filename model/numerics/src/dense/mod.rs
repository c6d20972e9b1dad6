//! Evaluation of dense layers of a neural network: products of a matrix with a vector, and the hyperbolic tangent.

mod products;
mod tanh;
mod vectors;

pub use products::{Finish, Linear, Weights, padded};
pub use tanh::Tanh;
pub use vectors::{Aligned, Number};
