//! Sentences on the lattice: its agreement with beams, and its differences.

use crate::format::percent_two_digits;
use crate::prelude::*;
use finray_studies::experiments::lattice::LatticeStudy;
use finray_studies::lattice::accuracy::FinenessRow;

/// The difference from beams counts as converging to zero if its order of convergence in the segment length is at least this.
const COARSENESS_ORDER: f64 = 2.0;

/// Text on how the lattice is built, and on what the comparison with beams verifies.
pub(super) const ABOUT: &str = "The lattice models the finger as rigid bodies connected by springs of EA / l, 12 EI / l^3 and EI / l. It shares no \
                                element or solver with the beams, and no parameter is fitted. The comparison verifies solver and kinematics, not \
                                beam theory. rapier2d lets the bodies come to rest; Newton's method minimises the energy and separates the lattice's \
                                errors from the errors of settling.";
/// Reason for the choice of the axial springs.
pub(super) const SPRINGS: &str = "The ends of a segment come closer when it bends. Points at a sixth of its length from the ends keep their \
                                  distance, so the axial springs join these points; axial springs between the ends would also resist bending. \
                                  Members must be extensible, because a V-shaped finger carries a force like a truss, by axial forces.";

/// Sentence on the lattice's difference from beams, and on sensing on the lattice compared with the uniform finger.
pub fn verdict(lattice: &LatticeStudy) -> Option<String> {
    let finest = lattice.rows.last()?;
    let force_n = finest.forces_n.last()?;
    let [worst, difference] = [largest(finest), lattice.sensing.difference.largest].map(percent_two_digits);
    Some(format!(
        "A lattice of rigid bodies and springs with the same EA and EI agrees with the beams within {worst} of the largest displacement up to {force_n} N. \
         Least-squares forces on the lattice and on the uniform finger agree within {difference} of the force."
    ))
}

/// Sentences on the order and size of the difference from beams, and on its effect on sensing.
pub fn findings(lattice: &LatticeStudy) -> Vec<String> {
    [agreement(&lattice.rows), linear(lattice), Some(sensing(lattice))].into_iter().flatten().collect()
}

/// Largest difference from beams over all forces, relative to the largest displacement.
fn largest(row: &FinenessRow) -> f64 {
    worst(row.errors.iter().copied())
}

/// Sentence on the errors of the coarsest and the finest lattice, and the order of convergence.
fn agreement(rows: &[FinenessRow]) -> Option<String> {
    let (coarsest, finest) = (rows.first()?, rows.last().filter(|_| rows.len() > 1)?);
    let [coarse, fine] = [coarsest, finest].map(|row| row.fineness);
    let refined = (fine as f64 / coarse as f64).ln();
    let orders = coarsest.errors.iter().zip(&finest.errors).map(|(coarse, fine)| (coarse / fine).ln() / refined);
    let [low, high] = Span::of(orders)?.ends();
    let [from, to] = [coarsest, finest].map(|row| percent_two_digits(largest(row)));
    let converges = match low >= COARSENESS_ORDER {
        true => "at least second order, as expected of a discretisation error.",
        false => "lower than the order of a discretisation error alone, so another difference remains.",
    };
    Some(format!(
        "From {coarse} to {fine} segments per plate member, the difference from beams falls from {from} to {to}. \
            The order of convergence in the segment length is {low:.1} to {high:.1}: {converges}"
    ))
}

/// Sentence on the errors of linear theory under the smallest and the largest force.
fn linear(lattice: &LatticeStudy) -> Option<String> {
    let (&(small_n, small), &(large_n, large)) = (lattice.linear.first()?, lattice.linear.last()?);
    let [small, large] = [small, large].map(percent_two_digits);
    Some(format!(
        "Linear theory, which neglects rotations, differs from the lattice by {small} at {small_n} N and by {large} at {large_n} N."
    ))
}

/// Sentence on sensing: whether its checks pass, and the nonlinear estimator's error.
fn sensing(lattice: &LatticeStudy) -> String {
    let sensing = &lattice.sensing;
    let agrees = if sensing.checks().iter().all(Check::passes) { "agrees" } else { "DOES NOT AGREE" };
    let (cells, nonlinear) = (sensing.difference.cells, percent_two_digits(sensing.nonlinear_error()));
    format!(
        "Sensing on the lattice {agrees} with the uniform finger over {cells} forces of the maps. The nonlinear \
            estimator, whose model is the uniform finger, senses forces on the lattice within {nonlinear}, so the \
            errors of least squares come from linear theory."
    )
}

/// Sentence on the effect of single precision.
pub fn precision(lattice: &LatticeStudy) -> String {
    format!(
        "If the equilibrium is rounded to single precision, the forces on a body are out of balance by up to {} of the load.",
        percent_two_digits(lattice.out_of_balance)
    )
}
