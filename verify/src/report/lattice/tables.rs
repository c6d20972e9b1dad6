//! Tables and files of the lattice.

use super::{AXIAL_CSV, CSV, SETTLING_CSV, loads_in_words};
use crate::experiments::lattice::LatticeStudy;
use crate::lattice::accuracy::{FinenessRow, LoadGrid, SettlingCost};
use crate::lattice::causes::{AxialRow, SettlingRow};
use crate::lattice::settling::Precision;
use crate::problems::lattice::FINENESS;
use crate::report::dataset::{Columns, Dataset, Format};
use crate::report::format::{error_as, list, percent_two_digits};
use crate::report::page::{Cell, Column, Table};

/// Errors and costs by fineness and force; the lattice with other axial springs; ways of settling.
pub(super) fn datasets(lattice: Option<&LatticeStudy>) -> Vec<Dataset<'_>> {
    // Errors are shares of the largest displacement: from converged beams, and of the settled lattice from its equilibrium.
    let fineness = Columns::<(&FinenessRow, usize)>::new()
        .file("segments_a_stretch", |(row, _)| row.fineness)
        .file("bodies", |(row, _)| row.bodies)
        .file("springs", |(row, _)| row.springs)
        .file("force_n", |(row, force)| row.forces_n[*force])
        .file("error", |(row, force)| row.errors[*force])
        .file("newton_ms", |(row, _)| row.newton_ms)
        .file("settling_error", |(row, _)| Some(row.settling?.error))
        .file("settling_steps", |(row, _)| Some(row.settling?.steps))
        .file("settling_ms", |(row, _)| Some(row.settling?.ms));
    let axial = Columns::<(&AxialRow, usize, f64)>::new()
        .file("axial_springs", |(row, ..)| row.name)
        .file("inset", |(row, ..)| row.axial.inset)
        .file("stiffness", |(row, ..)| row.axial.stiffness)
        .file("force_n", |(.., force_n)| *force_n)
        .file("error", |(row, force, _)| row.errors.as_ref().map(|errors| errors[*force]));
    let lattices = || lattice.into_iter();
    let by_force = lattices().flat_map(|lattice| &lattice.rows);
    let by_force = by_force.flat_map(|row| (0..row.forces_n.len()).map(move |force| (row, force)));
    let axial_by_force = lattices().flat_map(|lattice| {
        let forces = move |row| lattice.axial_forces_n.iter().enumerate().map(move |(i, force_n)| (row, i, *force_n));
        lattice.axial.iter().flat_map(forces)
    });
    vec![
        Dataset::new(CSV, &fineness, by_force),
        Dataset::new(AXIAL_CSV, &axial, axial_by_force),
        settled(lattices().flat_map(|lattice| &lattice.settling)),
    ]
}

/// Sweeps and precision of settling; no error where it does not settle.
fn settled<'s>(rows: impl Iterator<Item = &'s SettlingRow>) -> Dataset<'s> {
    let columns = Columns::<&SettlingRow>::new()
        .file("sweeps", |row| row.sweeps)
        .shown("sweeps a step", Format::Plain)
        .file("positions", |row| match row.positions {
            Precision::Double => "double",
            Precision::Single => "single",
        })
        .shown("positions kept in precision", Format::Words)
        .file("error", |row| row.error)
        .page("largest difference", Format::Plain, |row| {
            row.error.map_or_else(|| "does not settle".to_owned(), percent_two_digits)
        })
        .file("steps", |row| row.steps)
        .shown("most steps", Format::Plain);
    Dataset::new(SETTLING_CSV, &columns, rows)
}

/// How near each fineness is to beams.
pub(super) fn by_fineness(lattice: &LatticeStudy) -> Table {
    let forces_n = lattice.rows.first().map_or(&[][..], |row| &row.forces_n);
    Columns::<&FinenessRow>::new()
        .page("segments a plate member", Format::Plain, |row| row.fineness)
        .each(forces_n.iter().enumerate(), |columns, (i, force_n)| {
            columns.page(format!("{force_n} N"), Format::PercentTwoDigits, move |row| row.errors[i])
        })
        .table(
            format!(
                "The lattice's equilibrium against converged beams: largest difference of a key node's displacement, as a share of \
                 the largest displacement ({})",
                loads_in_words(&lattice.loads[0])
            ),
            CSV,
            &lattice.rows,
        )
}

/// What each fineness costs, and how near to its equilibrium it settles.
pub(super) fn costs(lattice: &LatticeStudy) -> Table {
    let mut columns = Columns::<&FinenessRow>::new()
        .page("segments a plate member", Format::Plain, |row| row.fineness)
        .page("bodies", Format::Plain, |row| row.bodies)
        .page("springs", Format::Plain, |row| row.springs)
        .page("Newton, ms", Format::Plain, |row| milliseconds(row.newton_ms));
    let mut settled = String::new();
    if lattice.rows.iter().any(|row| row.settling.is_some()) {
        let cost = |row: &&FinenessRow| -> Option<SettlingCost> { row.settling };
        columns = columns
            .page("settling, ms", Format::Plain, move |row| Some(milliseconds(cost(row)?.ms)))
            .page("steps", Format::Plain, move |row| Some(cost(row)?.steps))
            .page("settled against equilibrium", Format::PercentTwoDigits, move |row| Some(cost(row)?.error));
        settled = format!(
            ", and to settle under one load ({}, {} N; finer lattices take ever longer)",
            loads_in_words(&lattice.loads[1]),
            forces_in_words(&lattice.loads[1])
        );
    }
    let caption = format!(
        "What it costs on one core: Newton's method from rest through all the forces, mean over the loads{settled}"
    );
    columns.table(caption, CSV, &lattice.rows)
}

fn forces_in_words(grid: &LoadGrid) -> String {
    list(&grid.forces_n, ", ")
}

fn milliseconds(ms: f64) -> String {
    if ms < 10.0 { format!("{ms:.1}") } else { format!("{ms:.0}") }
}

/// What the axial springs matter.
pub(super) fn axial(lattice: &LatticeStudy) -> Table {
    let cell = |row: &&AxialRow, force: usize| match &row.errors {
        Some(errors) => error_as(percent_two_digits(errors[force]), errors[force]),
        None => Cell::plain("no equilibrium"),
    };
    Columns::<&AxialRow>::new()
        .page("axial springs", Format::Words, |row| row.name)
        .page("inset / length", Format::Fixed(3), |row| row.axial.inset)
        .page("stiffness / (EA / l)", Format::Plain, |row| row.axial.stiffness)
        .each(lattice.axial_forces_n.iter().enumerate(), |columns, (i, force_n)| {
            columns.cells(Column::numbers(format!("{force_n} N")), move |row| cell(row, i))
        })
        .table(
            format!(
                "What the axial springs matter: the lattice of {FINENESS} segments a plate member against converged beams, by where \
                 their points lie and how stiff they are"
            ),
            AXIAL_CSV,
            &lattice.axial,
        )
}

/// What sweeps and precision matter.
pub(super) fn settling(lattice: &LatticeStudy) -> Table {
    settled(lattice.settling.iter()).table(format!(
        "What settling matters: the settled lattice of {FINENESS} segments a plate member against its own equilibrium ({}, {} N)",
        loads_in_words(&lattice.settled),
        forces_in_words(&lattice.settled)
    ))
}
