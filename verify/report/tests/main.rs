//! Tests of `finray-report`: each file tests the source file of the same path.

mod dataset;
mod explore;
mod format;
mod maps {
    mod drawings;
}
mod measured;
mod page;
mod trainings;
