//! Tests of the finger that a page can push.

mod program;
mod pushed;
