//! Reader of a table with times and errors of other programs: `bench/peers` writes the table, and the command `report` uses it.

use crate::experiments::speed_error::peers::{Peer, Peers};
use crate::experiments::speed_error::{Asked, Task};
use csv::StringRecord;
use finray_files::FileError;
use finray_files::table::Table;
use std::path::Path;

const COLUMNS: [&str; 9] = ["task", "model", "setting", "seconds", "error", "program", "version", "nodes", "forces_n"];

/// Reads a table with the columns `task,model,setting,seconds,error,program,version,nodes,forces_n` in any order, and `machine` if present. `error`
/// may be empty.
///
/// # Errors
/// [`FileError`] with line and column of an invalid entry.
pub fn load(path: &Path) -> Result<Peers, FileError> {
    let table = Table::read(path, &COLUMNS)?;
    let peers = table.rows.iter().map(|row| peer(&table, row)).collect::<Result<_, _>>()?;
    let machine = table.rows.first().map_or("", |row| table.cell(row, "machine")).to_owned();
    Ok(Peers { peers, machine })
}

fn peer(table: &Table, row: &StringRecord) -> Result<Peer, FileError> {
    let text = |column: &str| match table.cell(row, column) {
        "" => Err(table.wrong(row, format!("{column}: expected text, found nothing"))),
        words => Ok(words.to_owned()),
    };
    let name = table.cell(row, "task");
    let task = Task::ALL.into_iter().find(|task| task.name() == name).ok_or_else(|| {
        let names = Task::ALL.map(Task::name).join(", ");
        table.wrong(row, format!("task: expected one of {names}, found {name:?}"))
    })?;
    let seconds = table.number(row, "seconds")?;
    if seconds <= 0.0 {
        return Err(table.wrong(row, format!("seconds: expected a number above 0, found {seconds}")));
    }
    let error = if table.cell(row, "error").is_empty() { None } else { Some(table.number(row, "error")?) };
    if let Some(error) = error.filter(|error| *error < 0.0) {
        return Err(table.wrong(row, format!("expected an error of at least 0, or an empty cell, found {error}")));
    }
    let (model, setting, program, version) = (text("model")?, text("setting")?, text("program")?, text("version")?);
    let asked = Asked { nodes: text("nodes")?, forces_n: text("forces_n")? };
    Ok(Peer { task, asked, model, setting, seconds, error, program, version })
}
