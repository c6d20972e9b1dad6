//! Tests of `finray-imaging`: each test file tests the source file with the same path. `chain` computes nodes and then forces from rendered images.
//! `kit` contains the scene, the cameras and the disturbances that several tests share.

mod boards;
mod chain;
mod grid;
mod kit;
mod locate;
mod plane_pose;
