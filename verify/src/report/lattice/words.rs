//! What agrees and what does not, in sentences made from the numbers.

use crate::check::{Check, worst};
use crate::experiments::lattice::LatticeStudy;
use crate::lattice::accuracy::FinenessRow;
use crate::report::format::{Span, percent_two_digits as percent};

/// A difference that falls at least with this power of the segments' length goes to nothing with it; one that does not would stay.
const COARSENESS_ORDER: f64 = 2.0;

/// Why axial springs are as they are.
pub(super) const SPRINGS: &str = "A segment's ends come nearer when it bends: points a sixth of its length inside keep their distance, and \
                                  springs fixed at the ends would resist bending too. Members must stretch: a V carries a force like a truss.";

/// How near the lattice is to beams, and sensing on it to sensing on the uniform finger.
pub fn verdict(lattice: &LatticeStudy) -> Option<String> {
    let finest = lattice.rows.last()?;
    Some(format!(
        "A lattice of rigid bodies and springs of the same EA and EI bends as the beams do within {} of the largest displacement up to {} N; \
         least squares errs on it as on the uniform finger, within {} of the force.",
        percent(worst(finest.errors.iter().copied())),
        finest.forces_n.last()?,
        percent(lattice.sensing.difference.largest)
    ))
}

/// Order, size and reach of the difference from beams, as a list.
pub fn findings(lattice: &LatticeStudy) -> Vec<String> {
    [agreement(&lattice.rows), linear(lattice), Some(sensing(lattice))].into_iter().flatten().collect()
}

/// Errors of the coarsest and the finest lattice, and the order that they fall by.
fn agreement(rows: &[FinenessRow]) -> Option<String> {
    let (coarsest, finest) = (rows.first()?, rows.last().filter(|_| rows.len() > 1)?);
    let largest = |row: &FinenessRow| percent(worst(row.errors.iter().copied()));
    let refined = (finest.fineness as f64 / coarsest.fineness as f64).ln();
    let orders = coarsest.errors.iter().zip(&finest.errors).map(|(coarse, fine)| (coarse / fine).ln() / refined);
    let Span { least: low, greatest: high, .. } = Span::of(orders)?;
    Some(format!(
        "From {} to {} segments a plate member the difference from beams falls from {} to {}: on the whole with the power {low:.1} to {high:.1} of \
         their length, {}",
        coarsest.fineness,
        finest.fineness,
        largest(coarsest),
        largest(finest),
        match low >= COARSENESS_ORDER {
            true => "at least with their square, as expected of coarseness.",
            false => "too little for coarseness alone: something else remains.",
        }
    ))
}

/// How linear theory does where both co-rotational solutions agree.
fn linear(lattice: &LatticeStudy) -> Option<String> {
    let ((small_n, small), (large_n, large)) = (lattice.linear.first()?, lattice.linear.last()?);
    Some(format!(
        "Linear theory, which leaves out rotations, differs from the lattice by {} at {small_n} N and by {} at {large_n} N.",
        percent(*small),
        percent(*large)
    ))
}

/// Whether the checks of sensing pass, and the nonlinear estimator.
fn sensing(lattice: &LatticeStudy) -> String {
    format!(
        "Sensing{} over {} forces of the maps. The nonlinear estimator, whose model is the uniform finger, senses the lattice within {}: the errors of \
         least squares are those of linear theory.",
        if lattice.sensing.checks().iter().all(Check::passes) { " agrees" } else { " DOES NOT AGREE" },
        lattice.sensing.difference.cells,
        percent(lattice.sensing.nonlinear_error())
    )
}

/// What single precision would cost.
pub fn precision(lattice: &LatticeStudy) -> String {
    format!(
        "Rounding the equilibrium to single precision leaves up to {} of the load out of balance on a body.",
        percent(lattice.out_of_balance)
    )
}
