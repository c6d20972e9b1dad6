//! Tests of `finray-lattice`: each file tests the source file of its path.

mod energy;
mod grasp {
    mod contact;
}
mod pressing;
mod settling;
