//! Tests of `finray-contact`: each file tests the source file of the same path.

mod pair;
mod press;
mod pressing;
mod walls;
