//! Tests of `finray-report`: each file tests the source file of the same path.

mod claims;
mod dataset;
mod explore;
mod format;
mod lattice;
mod maps {
    mod drawings;
}
mod measured;
mod page;
mod speed_error;
mod table_two {
    mod words;
}
mod trainings;
mod twin {
    mod words;
}
