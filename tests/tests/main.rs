//! Tests across crates: the report of a whole study (`claims`), acyclic dependencies among files (`rooms`), and sentences of page and claims
//! (`words`). Tests of one crate are in the `tests` folder of the crate, under the path of the source file. Tests that run the `finray` command are
//! in `verify/tests`.

mod claims;
mod rooms;
mod words;
