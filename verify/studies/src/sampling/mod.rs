//! Tests of sensing over many positions, directions, forces and noise samples.

pub mod bound;
pub mod intervals;
pub mod map;
pub mod noise;
pub mod sampled;
pub mod scatter;
pub mod situation;
pub mod sweep;
pub mod trust;
