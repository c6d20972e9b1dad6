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

/// Reads the shape of a whole finger: `node,ux_mm,uy_mm,theta_rad`, found by name, a row a key node in any order.
///
/// # Errors
/// [`FileError`] naming the line for anything that is not a node of this finger, and for nodes that are missing.
pub fn load_shape(path: &Path, finger: &Finger) -> Result<FingerShape, FileError> {
    let table = Table::read(path, ["node", "ux_mm", "uy_mm", "theta_rad"])?;
    let mut motions: Vec<Option<(Vector, f64)>> = vec![None; finger.key_node_count()];
    for row in table.rows() {
        let node = table.node(row, 0)?;
        let numbers = [table.number(row, 1)?, table.number(row, 2)?, table.number(row, 3)?];
        let Some(motion) = node.0.checked_sub(1).and_then(|i| motions.get_mut(i)) else {
            let count = finger.key_node_count();
            return Err(
                table.wrong(row, format!("node {node} does not exist: the finger has the key nodes 1 to {count}"))
            );
        };
        if motion.replace((Vector::new(numbers[0], numbers[1]), numbers[2])).is_some() {
            return Err(table.wrong(row, format!("node {node} is listed twice")));
        }
    }
    if let Some(missing) = motions.iter().position(Option::is_none) {
        let message = format!(
            "expected a row for every key node, as solve and press write them; node {} is missing",
            missing + 1
        );
        return Err(FileError::content(path, message));
    }
    Ok(FingerShape::new(finger, |node| motions[node.0 - 1].unwrap_or_default()))
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
