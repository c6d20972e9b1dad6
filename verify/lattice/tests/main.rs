//! Tests of `finray-lattice`: each file tests the source file of the same path.

mod energy;
mod grasp {
    mod contact;
}
mod pressing;
mod settling;
