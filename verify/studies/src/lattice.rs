//! Error of the lattice against converged beams as a function of the lattice's fineness ([`accuracy`]), and the causes of that error ([`causes`]).

pub mod accuracy;
pub mod causes;
