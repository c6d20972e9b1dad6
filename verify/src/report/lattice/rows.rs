//! The lattice's figures as they stand in the CSV files and the summary.

use crate::experiments::lattice::LatticeStudy;
use crate::lattice::settling::Precision;
use serde::Serialize;

/// Error and cost of one fineness at one force, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticeRow {
    /// Segments in a stretch of plate between two key nodes.
    pub segments_a_stretch: usize,
    /// Rigid bodies.
    pub bodies: usize,
    /// Springs.
    pub springs: usize,
    /// Force, N.
    pub force_n: f64,
    /// Largest difference of the lattice's equilibrium from converged beams / largest displacement.
    pub error: f64,
    /// Newton's method through all the forces under one load, ms.
    pub newton_ms: f64,
    /// Largest difference of the settled lattice from its equilibrium / largest displacement.
    pub settling_error: Option<f64>,
    /// Steps to rest.
    pub settling_steps: Option<usize>,
    /// Settling under one load, ms.
    pub settling_ms: Option<f64>,
}

/// Error of the lattice with some axial springs at one force, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxialSpringsRow {
    /// The springs, in words.
    pub axial_springs: &'static str,
    /// Share of a segment's length by which their points lie inside it.
    pub inset: f64,
    /// Stiffness in units of EA / l.
    pub stiffness: f64,
    /// Force, N.
    pub force_n: f64,
    /// Largest difference from converged beams / largest displacement; none where the lattice has no stable equilibrium.
    pub error: Option<f64>,
}

/// One way of settling, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettlingRow {
    /// Sweeps over the springs in a step.
    pub sweeps: usize,
    /// Precision that positions are kept in: `double` or `single`.
    pub positions: &'static str,
    /// Largest difference from the lattice's equilibrium / largest displacement; none if it does not settle.
    pub error: Option<f64>,
    /// Steps to rest.
    pub steps: Option<usize>,
}

pub(in crate::report) fn rows(lattice: &LatticeStudy) -> impl Iterator<Item = LatticeRow> {
    lattice.rows.iter().flat_map(|row| {
        row.forces_n.iter().zip(&row.errors).map(|(&force_n, &error)| LatticeRow {
            segments_a_stretch: row.fineness,
            bodies: row.bodies,
            springs: row.springs,
            force_n,
            error,
            newton_ms: row.newton_ms,
            settling_error: row.settling.map(|cost| cost.error),
            settling_steps: row.settling.map(|cost| cost.steps),
            settling_ms: row.settling.map(|cost| cost.ms),
        })
    })
}

pub(in crate::report) fn axial_rows(lattice: &LatticeStudy) -> impl Iterator<Item = AxialSpringsRow> {
    lattice.axial.iter().flat_map(|row| {
        lattice.axial_forces_n.iter().enumerate().map(|(force, &force_n)| AxialSpringsRow {
            axial_springs: row.name,
            inset: row.axial.inset,
            stiffness: row.axial.stiffness,
            force_n,
            error: row.errors.as_ref().map(|errors| errors[force]),
        })
    })
}

pub(in crate::report) fn settling_rows(lattice: &LatticeStudy) -> impl Iterator<Item = SettlingRow> {
    lattice.settling.iter().map(|row| SettlingRow {
        sweeps: row.sweeps,
        positions: precision(row.positions),
        error: row.error,
        steps: row.steps,
    })
}

fn precision(positions: Precision) -> &'static str {
    match positions {
        Precision::Double => "double",
        Precision::Single => "single",
    }
}
