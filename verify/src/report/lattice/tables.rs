//! Tables of the lattice.

use super::super::convergence::percent;
use super::super::page::{Cell, Column, Row, Table};
use super::super::tables::error;
use super::rows::settling_rows;
use super::{AXIAL_CSV, CSV, SETTLING_CSV, loads_in_words};
use crate::experiments::lattice::LatticeStudy;
use crate::lattice::accuracy::{FinenessRow, LoadGrid};
use crate::problems::lattice::FINENESS;

/// How near each fineness is to beams.
pub(super) fn by_fineness(lattice: &LatticeStudy) -> Table {
    let forces_n = lattice.rows.first().map_or(&[][..], |row| &row.forces_n);
    let row = |row: &FinenessRow| {
        let errors = row.errors.iter().copied().map(percent);
        Row { cells: [row.fineness.to_string()].into_iter().chain(errors).map(Cell::plain).collect() }
    };
    let errors = forces_n.iter().map(|force_n| format!("{force_n} N"));
    Table {
        caption: format!(
            "The lattice's equilibrium against converged beams: largest difference of a key node's displacement, as a share of \
             the largest displacement ({})",
            loads_in_words(&lattice.loads[0])
        ),
        columns: ["segments a stretch".to_owned()].into_iter().chain(errors).map(Column::numbers).collect(),
        rows: lattice.rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}

/// What each fineness costs, and how near to its equilibrium it settles.
pub(super) fn costs(lattice: &LatticeStudy) -> Table {
    let settles = lattice.rows.iter().any(|row| row.settling.is_some());
    let row = |row: &FinenessRow| {
        let counts = [row.fineness, row.bodies, row.springs].map(|count| count.to_string());
        let settling = match row.settling {
            Some(cost) => [milliseconds(cost.ms), cost.steps.to_string(), percent(cost.error)],
            None => ["-"; 3].map(str::to_owned),
        };
        let cells = counts.into_iter().chain([milliseconds(row.newton_ms)]);
        Row { cells: cells.chain(settling.into_iter().filter(|_| settles)).map(Cell::plain).collect() }
    };
    let columns = ["segments a stretch", "bodies", "springs", "Newton, ms"].into_iter();
    let settling = ["settling, ms", "steps", "settled against equilibrium"];
    let settled = match settles {
        true => format!(
            ", and to settle under one load ({}, {} N; finer lattices take ever longer)",
            loads_in_words(&lattice.loads[1]),
            forces_in_words(&lattice.loads[1])
        ),
        false => String::new(),
    };
    Table {
        caption: format!(
            "What it costs on one core: Newton's method from rest through all the forces, mean over the loads{settled}"
        ),
        columns: columns.chain(settling.into_iter().filter(|_| settles)).map(Column::numbers).collect(),
        rows: lattice.rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}

fn forces_in_words(grid: &LoadGrid) -> String {
    grid.forces_n.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

fn milliseconds(ms: f64) -> String {
    if ms < 10.0 { format!("{ms:.1}") } else { format!("{ms:.0}") }
}

/// What the axial springs matter.
pub(super) fn axial(lattice: &LatticeStudy) -> Table {
    let rows = lattice.axial.iter().map(|row| {
        let errors = (0..lattice.axial_forces_n.len()).map(|force| match &row.errors {
            Some(errors) => Cell { text: percent(errors[force]), ..error(errors[force]) },
            None => Cell::plain("no equilibrium"),
        });
        let numbers = [format!("{:.3}", row.axial.inset), row.axial.stiffness.to_string()].map(Cell::plain);
        Row { cells: [Cell::plain(row.name)].into_iter().chain(numbers).chain(errors).collect() }
    });
    let forces = lattice.axial_forces_n.iter().map(|force_n| Column::numbers(format!("{force_n} N")));
    Table {
        caption: format!(
            "What the axial springs matter: the lattice of {FINENESS} segments a stretch against converged beams, by where \
             their points lie and how stiff they are"
        ),
        columns: [Column::words("axial springs")]
            .into_iter()
            .chain(["inset / length", "stiffness / (EA / l)"].map(Column::numbers))
            .chain(forces)
            .collect(),
        rows: rows.collect(),
        csv: Some(AXIAL_CSV.to_owned()),
    }
}

/// What sweeps and precision matter.
pub(super) fn settling(lattice: &LatticeStudy) -> Table {
    let rows = settling_rows(lattice).map(|row| Row {
        cells: [
            row.sweeps.to_string(),
            row.positions.to_owned(),
            row.error.map_or_else(|| "does not settle".to_owned(), percent),
            row.steps.map_or_else(|| "-".to_owned(), |steps| steps.to_string()),
        ]
        .map(Cell::plain)
        .into(),
    });
    Table {
        caption: format!(
            "What settling matters: the settled lattice of {FINENESS} segments a stretch against its own equilibrium ({}, {} N)",
            loads_in_words(&lattice.settled),
            forces_in_words(&lattice.settled)
        ),
        columns: vec![
            Column::numbers("sweeps a step"),
            Column::words("positions kept in precision"),
            Column::numbers("largest difference"),
            Column::numbers("most steps"),
        ],
        rows: rows.collect(),
        csv: Some(SETTLING_CSV.to_owned()),
    }
}
