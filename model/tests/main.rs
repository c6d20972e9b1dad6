//! Tests of `finray-model`: each file tests the source file of its path; those in `units` test what is private to it, and are part of it. Most properties hold for random fingers; `finray_tests` draws them and
//! has what several modules share.

mod calibration;
mod camera;
mod finger;
mod gripper;
mod measurement {
    mod noise;
}
mod samples;
mod scene_keys;
mod shared_junctions;
mod sensing {
    mod assembly;
    mod linear;
    mod network;
    mod nonlinear;
    mod object;
    mod pad;
    mod random_fingers;
    mod residual_test;
    mod stated_sigma;
}
mod statics {
    mod arc_length;
    mod batch;
    mod examples;
    mod fine_meshes;
    mod invariance;
    mod ladder;
    mod properties;
}
mod tapers;
mod train;
mod validity;
