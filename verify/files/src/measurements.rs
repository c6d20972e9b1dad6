//! Measured displacements under known loads as CSV, as `calibrate` reads them.

use super::FileError;
use super::table::Table;
use finray_model::calibration::CalibrationCase;
use finray_model::measurement::{Marker, Measurement};
use finray_model::observation::LargestClampedMotion;
use finray_model::{Finger, Load, Mesh, Vector};
use std::path::Path;

/// Reads `case,load_node,fx_n,fy_n,node,ux_mm,uy_mm`; every row of a load case repeats the load. `noise_mm` is the standard deviation of the noise in
/// one coordinate, mm. Rows of clamped nodes are ignored if noise of this standard deviation explains their displacement.
///
/// # Errors
/// [`FileError`] with the line of a row that does not fit the finger, or whose load differs from the load in the first row of its case.
pub fn load(path: &Path, finger: &Finger, noise_mm: Option<f64>) -> Result<Vec<CalibrationCase>, FileError> {
    let mesh = Mesh::key_nodes(finger);
    let table = Table::read(path, &["case", "load_node", "fx_n", "fy_n", "node", "ux_mm", "uy_mm"])?;
    let mut names: Vec<&str> = Vec::new();
    let mut cases: Vec<CalibrationCase> = Vec::new();
    let all =
        table.rows.iter().map(|row| table.vector(row, ["ux_mm", "uy_mm"])).collect::<Result<Vec<_>, FileError>>()?;
    let clamped = LargestClampedMotion::of(noise_mm, all.iter().flatten().copied());
    for (row, displacement) in table.rows.iter().zip(all) {
        // Empty cells and missing rows both mean that the marker is hidden.
        let Some(displacement) = displacement else { continue };
        let force = Vector::new(table.number(row, "fx_n")?, table.number(row, "fy_n")?);
        let load = Load::at_node(table.node(row, "load_node")?, force);
        mesh.frame_load(&load).map_err(|error| table.wrong(row, error))?;
        let name = table.cell(row, "case");
        let index = names.iter().position(|known| *known == name).unwrap_or_else(|| {
            names.push(name);
            cases.push(CalibrationCase { load, measurement: Measurement::empty() });
            cases.len() - 1
        });
        let case = &mut cases[index];
        if case.load != load {
            return Err(
                table.wrong(row, format!("case {name}: expected the same load as in the first row of this case"))
            );
        }
        let node = table.node(row, "node")?;
        let marker = Marker { node, displacement, weight: 1.0 };
        clamped.check(finger, &marker).map_err(|error| table.wrong(row, error))?;
        if !finger.is_clamped(node) {
            case.measurement.add(finger, marker).map_err(|error| table.wrong(row, error))?;
        }
    }
    match cases.is_empty() {
        true => Err(FileError::content(path, "expected displacements, but all markers are hidden")),
        false => Ok(cases),
    }
}
