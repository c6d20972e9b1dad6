//! Error of the lattice against converged beams by its fineness ([`accuracy`]), and what it comes from ([`causes`]).

pub mod accuracy;
pub mod causes;
