//! Tests of `finray-figures`: each file tests the source file of its path; `layout` all figures at once.

mod bars;
mod chart;
mod film;
mod layout;
mod map;
