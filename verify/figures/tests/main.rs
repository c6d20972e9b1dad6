//! Tests of `finray-figures`: each file tests the source file of the same path; `layout` tests all figures.

mod bars;
mod chart;
mod film;
mod layout;
mod map;
