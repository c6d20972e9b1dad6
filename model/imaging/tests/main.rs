//! Tests of `finray-imaging`: each file tests the source file of its path. `chain` computes nodes and then forces from rendered images. `kit`
//! contains the scene, the cameras and the disturbances that several tests share.

mod boards;
mod chain;
mod grid;
mod kit;
mod locate;
mod plane_pose;
