//! Tests of `finray-studies`: each file tests the source file of the same path.

mod check;
mod estimators {
    mod all;
    mod networks;
    mod stated_intervals;
}
mod experiments {
    mod camera;
    mod contact_scene;
    mod continuum;
    mod coverage;
    mod explain;
    mod grasp {
        mod energy;
        mod loops;
        mod modules;
        mod obstacles;
        mod sensed;
        mod world;
    }
    mod networks;
    mod noise;
    mod situations;
}
mod exports {
    mod calculix;
    pub mod mujoco;
}
mod one_sensor;
mod paper;
mod problems {
    mod closed_forms;
    mod mujoco;
    mod opensees;
}
mod sampling {
    mod bound;
    mod map;
    pub mod scatter;
    mod shared_start;
    mod situation;
}
mod statistics;
mod truths {
    mod all;
    mod exported;
    mod lattice;
}
