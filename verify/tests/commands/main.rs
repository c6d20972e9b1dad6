//! Tests that run `finray` as users do. Each command has one module. Further modules test the command line (`arguments`), output files (`output`),
//! refused scenes (`scene_errors`), damaged input (`garbage`), and warnings of the beam model (`validity`). `kit` runs the command
//! and parses its output. Tests of the library are in `tests/tests`.

mod kit;

mod arguments;
mod calibrate;
mod camera;
mod contradictions;
mod faults;
mod garbage;
mod grasp;
mod grasp_stream;
mod gripper;
mod guide;
mod live;
mod located;
mod map;
mod output;
mod photographs;
mod press;
mod reassembled;
mod rendered;
mod report;
mod scene_errors;
mod sense;
mod setup;
mod solve;
mod sweep;
mod train;
mod validity;
