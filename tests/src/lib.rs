//! Code that the tests of `model` and `verify` share: the paper's finger and random fingers, contacts and loads, simulated measurements
//! and cameras, and the comparison of results.

mod cameras;
mod chance;
mod comparison;
mod figures;
mod fingers;
mod loads;
mod measurements;
mod results;
mod strategies;
mod study;

pub use cameras::camera;
pub use chance::{
    CAMERA_NOISE_MM, STANDARD_ERRORS, TWO_SIDED_95, case_count, cases, is_full_study, random_stream, repetitions,
    share_error,
};
pub use comparison::{KINEMATICS, largest, motions_apart, shapes_apart};
pub use figures::{Figure, record_figures, recorded_figures, state_of_code, today};
pub use fingers::{ELEMENTS, finger_of, mirrored, paper, paper_scene_with};
pub use loads::{at_node, at_nodes, at_position, contact_node, force_for_deflection, under_pad};
pub use measurements::{noisy, seen};
pub use results::{assert_recorded, assert_said, recorded, results_file};
pub use strategies::{built_finger, built_finger_with_zones, finger, finger_with_zones};
pub use study::{assert_standardised, record_row};
