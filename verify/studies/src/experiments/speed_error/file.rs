//! Reader of times and errors of other programs: the output of `bench/peers`, which `report` reads.

use crate::experiments::speed_error::peers::{Peer, Peers};
use crate::experiments::speed_error::{Asked, Task};
use finray_files::FileError;
use finray_files::table::{Row, Table};
use std::path::Path;

const COLUMNS: [&str; 9] = ["task", "model", "setting", "seconds", "error", "program", "version", "nodes", "forces_n"];
/// Optional column with the machine of the time measurements.
const MACHINE: &str = "machine";

/// Reads a table with the columns `task,model,setting,seconds,error,program,version,nodes,forces_n` in any order, and `machine` if present. `error`
/// may be empty.
///
/// # Errors
/// [`FileError`] with line and column of an invalid entry.
pub fn load(path: &Path) -> Result<Peers, FileError> {
    let text = finray_files::read_text(path)?;
    let table = Table::of_text(path, &text, COLUMNS)?;
    let peers = table.rows().iter().map(|row| peer(&table, row)).collect::<Result<_, _>>()?;
    let machines = Table::of_text(path, &text, [MACHINE]).ok();
    let machine = machines.and_then(|machines| machines.rows().first().map(|row| row.cells[0].clone()));
    Ok(Peers { peers, machine: machine.unwrap_or_default() })
}

fn peer(table: &Table<9>, row: &Row<9>) -> Result<Peer, FileError> {
    let text = |column: usize| match row.cells[column].as_str() {
        "" => Err(table.wrong(row, format!("{}: expected text, found nothing", COLUMNS[column]))),
        words => Ok(words.to_owned()),
    };
    let task = Task::ALL.into_iter().find(|task| task.name() == row.cells[0]).ok_or_else(|| {
        let names = Task::ALL.map(Task::name).join(", ");
        table.wrong(row, format!("task: expected one of {names}, found {:?}", row.cells[0]))
    })?;
    let seconds = table.number(row, 3)?;
    if seconds <= 0.0 {
        return Err(table.wrong(row, format!("seconds: expected a number above 0, found {seconds}")));
    }
    let error = if row.cells[4].is_empty() { None } else { Some(table.number(row, 4)?) };
    if let Some(error) = error.filter(|error| *error < 0.0) {
        return Err(table.wrong(row, format!("expected an error of at least 0, or an empty cell, found {error}")));
    }
    let (model, setting, program, version) = (text(1)?, text(2)?, text(5)?, text(6)?);
    let asked = Asked { nodes: text(7)?, forces_n: text(8)? };
    Ok(Peer { task, asked, model, setting, seconds, error, program, version })
}
