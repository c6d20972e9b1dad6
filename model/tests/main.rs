//! Tests of `finray-model`. Each file tests the source file of the same path; files in `units` test private items and are compiled into the crate.
//! Most properties are tested on random fingers, which `finray_tests` draws. `finray_tests` also contains helpers that several modules share.

mod calibration;
mod camera;
mod finger;
mod gripper;
mod hard_cases;
mod observation;
mod scene {
    mod cameras;
    mod errors;
    mod geometry;
    mod refused;
    mod warnings;
}
mod scene_keys;
mod shared_junctions;
mod side_faces;
mod sensing {
    mod assembly;
    mod back_plate;
    mod beam_theory;
    mod linear;
    mod measured;
    mod misfit;
    mod near;
    mod network;
    mod nonlinear;
    mod object;
    mod pad;
    mod random_fingers;
    mod residual_test;
    mod stated_sigma;
    mod stiffness;
    mod surface;
    mod thickness;
    mod uncertain_friction;
    mod valleys;
}
mod sensor {
    mod estimated_noise;
    mod rest;
}
mod statics {
    mod arc_length;
    mod arms;
    mod batch;
    mod examples;
    mod fine_meshes;
    mod invariance;
    mod ladder;
    mod properties;
    mod shear;
}
mod tapers;
mod validity;
