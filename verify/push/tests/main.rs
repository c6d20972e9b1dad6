//! Tests of the finger that users push on a page.

mod program;
mod pushed;
