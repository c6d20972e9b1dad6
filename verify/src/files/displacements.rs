//! Displacements of the key nodes: what `solve` writes and `sense` reads.

use super::FileError;
use super::table::Table;
use finray_model::measurement::{Marker, Measurement};
use finray_model::mesh::FingerShape;
use finray_model::{Finger, Vector};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Row {
    node: usize,
    x_mm: f64,
    y_mm: f64,
    ux_mm: f64,
    uy_mm: f64,
    theta_rad: f64,
}

/// CSV of a shape: `node,x_mm,y_mm,ux_mm,uy_mm,theta_rad`, a row a key node, undeformed position and displacement.
///
/// # Errors
/// None in memory; the signature is the CSV writer's.
pub fn to_csv(shape: &FingerShape) -> Result<String, csv::Error> {
    super::csv_text(shape.motions().iter().map(|motion| Row {
        node: motion.node.0,
        x_mm: motion.position.x,
        y_mm: motion.position.y,
        ux_mm: motion.displacement.x,
        uy_mm: motion.displacement.y,
        theta_rad: motion.rotation,
    }))
}

/// Reads `node,ux_mm,uy_mm`, found by name, in any order; nodes may be missing.
///
/// # Errors
/// [`FileError`] naming the line for anything that is not a marker of this finger.
pub fn load(path: &Path, finger: &Finger) -> Result<Measurement, FileError> {
    let table = Table::read(path, ["node", "ux_mm", "uy_mm"])?;
    let mut measurement = Measurement::empty();
    for row in table.rows() {
        let displacement = Vector::new(table.number(row, 1)?, table.number(row, 2)?);
        let marker = Marker { node: table.node(row, 0)?, displacement, weight: 1.0 };
        measurement.add(finger, marker).map_err(|error| table.wrong(row, error))?;
    }
    Ok(measurement)
}
