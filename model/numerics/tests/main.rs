//! Tests of `finray-numerics`: each file tests the source file of its path.

mod dense {
    mod tanh;
}
mod linear {
    mod bordered;
    mod ldl;
}
mod number {
    mod arctangent;
    mod sine;
}
mod optimise;
