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
pub(super) fn verdict(lattice: &LatticeStudy) -> Option<String> {
    let finest = lattice.rows.last()?;
    Some(format!(
        "A lattice of rigid bodies and springs of the same EA and EI bends as the beams do within {} of the largest displacement up to {} N; \
         least squares errs on it as on the uniform finger, within {} of the force.",
        percent(worst(finest.errors.iter().copied())),
        finest.forces_n.last()?,
        percent(lattice.sensing.difference.largest)
    ))
}

pub(super) fn findings(lattice: &LatticeStudy) -> Vec<String> {
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
pub(super) fn precision(lattice: &LatticeStudy) -> String {
    format!(
        "Rounding the equilibrium to single precision leaves up to {} of the load out of balance on a body.",
        percent(lattice.out_of_balance)
    )
}

#[cfg(test)]
mod tests {
    use super::super::samples::sample;
    use super::*;

    #[test]
    fn findings_are_made_from_the_numbers() {
        let mut study = sample();
        study.sensing.difference.largest = 1e-5;
        let said = findings(&study).join("\n");
        for words in [
            "From 2 to 4 segments a plate member the difference from beams falls from 0.16 % to 0.010 %: on the whole with the power \
             3.0 to 4.0 of their length, at least with their square",
            "by 10 % at 1 N and by 50 % at 5 N",
            "Sensing agrees over 1 forces of the maps",
            "senses the lattice within 0.040 %",
        ] {
            assert!(said.contains(words), "{words} is not in {said}");
        }
        let head = verdict(&study).expect("a sentence");
        assert!(
            head.contains("within 0.010 % of the largest displacement up to 5 N")
                && head.contains("within 0.0010 % of the force"),
            "{head}"
        );
        assert!(precision(&study).contains("up to 0.060 % of the load"));
        study.rows[1].errors = vec![4e-4, 1e-4];
        study.sensing.difference.largest = 0.1;
        let said = findings(&study).join("\n");
        assert!(said.contains("something else remains") && said.contains("Sensing DOES NOT AGREE"), "{said}");
    }
}
