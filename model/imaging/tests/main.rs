//! Tests of `finray-imaging`: each file tests the source file of its path. `chain` goes from rendered images through nodes to forces; `kit` has
//! cameras and images that several share.

mod boards;
mod chain;
mod grid;
mod kit;
mod locate;
mod plane_pose;
