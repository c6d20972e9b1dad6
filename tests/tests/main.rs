//! Tests across crates: the report of a whole study (`whole_study`), and acyclic dependencies among files (`rooms`).

mod rooms;
mod whole_study;
