//! Sentences on the lattice: its agreement with beams, and its differences.

use crate::prelude::*;
use finray_studies::experiments::lattice::LatticeStudy;
use finray_studies::lattice::accuracy::FinenessRow;

/// The difference from beams counts as converging to zero if its order of convergence in the segment length is above this.
const COARSENESS_ORDER: f64 = 2.0;

/// Sentence on the lattice's difference from beams, and on sensing on the lattice compared with the uniform finger.
pub fn verdict(lattice: &LatticeStudy) -> Result<Option<String>, ReportError> {
    let numbers = || {
        let finest = lattice.rows.last()?;
        let worst = worst(finest.errors.iter().copied());
        let difference = lattice.sensing.difference.largest;
        Some(context! { worst, force_n => *finest.forces_n.last()?, difference })
    };
    say("lattice.verdict", numbers())
}

/// Sentences on the order and size of the difference from beams, and on its effect on sensing.
pub fn findings(lattice: &LatticeStudy) -> Result<Vec<String>, ReportError> {
    let said = [
        say("lattice.agreement", agreement(&lattice.rows))?,
        say("lattice.linear", linear(lattice))?,
        say("lattice.sensing", Some(sensing(lattice)))?,
    ];
    Ok(said.into_iter().flatten().collect())
}

/// Errors of the coarsest and the finest lattice, and the order of convergence.
fn agreement(rows: &[FinenessRow]) -> Option<Value> {
    let (coarsest, finest) = (rows.first()?, rows.last().filter(|_| rows.len() > 1)?);
    let refined = (finest.fineness as f64 / coarsest.fineness as f64).ln();
    let orders = coarsest.errors.iter().zip(&finest.errors).map(|(coarse, fine)| (coarse / fine).ln() / refined);
    let Span { least: low, greatest: high, .. } = Span::of(orders)?;
    let of = |row: &FinenessRow| context! { fineness => row.fineness, worst => worst(row.errors.iter().copied()) };
    Some(context! { coarsest => of(coarsest), finest => of(finest), low, high, order => COARSENESS_ORDER })
}

/// Errors of linear theory under the smallest and the largest force.
fn linear(lattice: &LatticeStudy) -> Option<Value> {
    let (&(small_n, small), &(large_n, large)) = (lattice.linear.first()?, lattice.linear.last()?);
    Some(context! { small_n, small, large_n, large })
}

/// Results for the sentence on sensing: whether its checks pass, and the nonlinear estimator's error.
fn sensing(lattice: &LatticeStudy) -> Value {
    let sensing = &lattice.sensing;
    let agrees = sensing.checks().iter().all(Check::passes);
    context! { agrees, cells => sensing.difference.cells, nonlinear => sensing.nonlinear_error() }
}

/// Sentence on the effect of single precision.
pub fn precision(lattice: &LatticeStudy) -> Result<Option<String>, ReportError> {
    say("lattice.precision", Some(context! { out_of_balance => lattice.out_of_balance }))
}
