//! Error of the lattice against converged beams by its fineness ([`accuracy`]), and the causes of that error ([`causes`]).

pub mod accuracy;
pub mod causes;
