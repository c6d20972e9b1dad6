//! What crosses crates: the report of a whole study (`claims`), no circles among rooms (`rooms`), and sentences of page and claims (`words`).
//! What one crate can test stands in its `tests` folder, below the path of the source file; tests that run the `finray` command stand in
//! `verify/tests`.

mod claims;
mod rooms;
mod words;
