//! Tests that run `finray` as its users do: a module for each command, and one each for the command line itself (`arguments`), for what is
//! written where (`output`), for scenes that are refused (`scene_errors`, `scene_geometry`), for damaged input (`garbage`) and for the warnings
//! where the beam model does not hold (`validity`). `kit` runs the command and takes apart what it answers. Tests of the library stand in
//! `tests/tests`.

mod kit;

mod arguments;
mod calibrate;
mod camera;
mod contradictions;
mod faults;
mod garbage;
mod grasp;
mod gripper;
mod guide;
mod map;
mod output;
mod photographs;
mod press;
mod reassembled;
mod rendered;
mod report;
mod scene_errors;
mod scene_geometry;
mod sense;
mod solve;
mod sweep;
mod train;
mod validity;
