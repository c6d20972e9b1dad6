//! Displacements of the finger's key nodes as CSV, as `solve` and `press` write them.

use super::FileError;
use super::table::Table;
use finray_model::mesh::{FingerShape, NodeMotion};
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

/// Undeformed position and displacement, mm, of the joint between a rib and its bracket.
#[derive(Serialize)]
struct Hinge {
    hinge_x_mm: f64,
    hinge_y_mm: f64,
    hinge_ux_mm: f64,
    hinge_uy_mm: f64,
}

/// Displacements as CSV: `node,x_mm,y_mm,ux_mm,uy_mm,theta_rad`, one row per key node, with its undeformed position. If the ribs have brackets, each
/// row also has `hinge_x_mm,hinge_y_mm,hinge_ux_mm,hinge_uy_mm` of the joint between bracket and rib.
///
/// # Errors
/// A `csv::Error` from the CSV writer; none is expected, because the text is written to memory.
pub fn to_csv(shape: &FingerShape, finger: &Finger) -> Result<String, csv::Error> {
    let row = |motion: &NodeMotion| Row {
        node: motion.node.0,
        x_mm: motion.position.x,
        y_mm: motion.position.y,
        ux_mm: motion.displacement.x,
        uy_mm: motion.displacement.y,
        theta_rad: motion.rotation,
    };
    if !finger.has_brackets() {
        return super::csv_text(shape.motions().iter().map(row));
    }
    let hinge = |motion: &NodeMotion| Hinge {
        hinge_x_mm: motion.hinge_position.x,
        hinge_y_mm: motion.hinge_position.y,
        hinge_ux_mm: motion.hinge_displacement.x,
        hinge_uy_mm: motion.hinge_displacement.y,
    };
    super::csv_text(shape.motions().iter().map(|motion| (row(motion), hinge(motion))))
}

/// Reads the displacements of all key nodes from the columns `node,ux_mm,uy_mm,theta_rad`. The file has one row per key node, in any order.
///
/// # Errors
/// [`FileError`] if a node is missing; also, with the line, if a node is listed twice or does not exist in this finger.
pub fn load_shape(path: &Path, finger: &Finger) -> Result<FingerShape, FileError> {
    let table = Table::read(path, &["node", "ux_mm", "uy_mm", "theta_rad"])?;
    let mut motions: Vec<Option<(Vector, f64)>> = vec![None; finger.key_node_count()];
    for row in &table.rows {
        let node = table.node(row, "node")?;
        let displacement = Vector::new(table.number(row, "ux_mm")?, table.number(row, "uy_mm")?);
        let rotation = table.number(row, "theta_rad")?;
        let Some(motion) = node.0.checked_sub(1).and_then(|i| motions.get_mut(i)) else {
            let count = finger.key_node_count();
            return Err(table.wrong(row, format!("node {node} does not exist: the finger has nodes 1 to {count}")));
        };
        if motion.replace((displacement, rotation)).is_some() {
            return Err(table.wrong(row, format!("node {node} is listed twice")));
        }
    }
    if let Some(missing) = motions.iter().position(Option::is_none) {
        let message = format!(
            "expected one row for each node of the finger, as in a file of `finray solve` or `finray press`; node \
                {} is missing",
            missing + 1
        );
        return Err(FileError::content(path, message));
    }
    Ok(FingerShape::new(finger, false, |node| motions[node.0 - 1].unwrap_or_default()))
}
