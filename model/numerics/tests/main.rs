//! Tests of `finray-numerics`: each test file tests the source file with the same path.

mod dense;
mod linear {
    mod bordered;
    mod ldl;
}
mod number {
    mod arctangent;
    mod sine;
}
mod optimise;
