//! Tests of `finray-lattice`: each file tests the source file of the same path.

mod energy;
mod engine_pressing;
mod settling;
