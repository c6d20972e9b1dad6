//! Tests of `model` alone, by family of properties: equilibria (`statics`, and `invariance` of the way a finger is written down), the
//! inverse (`sensing`, `networks` and their `training` on `samples`, `calibration`), the `camera`, what signs and angles mean (`conventions`), and where the
//! beam model holds (`validity`), and the `gripper`'s linkage. Most hold for random fingers; `finray_tests` draws them and has what several modules share.

mod calibration {
    mod modulus;
    mod views;
    mod zones;
}
mod camera;
mod conventions;
mod gripper;
mod invariance;
mod networks;
mod samples;
mod sensing {
    mod hard_measurements;
    mod linear;
    mod nonlinear;
    mod object;
    mod pad;
    mod priors;
    mod stated_sigma;
}
mod statics {
    mod arc_length;
    mod batch;
    mod examples;
    mod fine_meshes;
    mod ladder;
    mod properties;
}
mod training;
mod validity;
