//! How fine a mesh must be: table and figure.

use super::ReportError;
use super::page::{Block, Cell, Column, Figure, Row, Section, Table};
use super::sections::{self, text};
use crate::experiments::convergence::{Convergence, MeshSize};
use crate::figures::{Axis, Chart, FigureError, Frame, Series};
use crate::study::Study;

pub(super) const CSV: &str = "convergence.csv";
/// Errors worth comparing with.
const REFERENCES: [(f64, &str); 2] = [(1.0, "1 %"), (0.01, "0.01 %")];

pub(super) fn section(study: &Study) -> Result<Section, ReportError> {
    let convergence = &study.convergence;
    let mut blocks = vec![text(
        "Forces along the front plate's normal, one node after the other (tip left out), solved with large rotations on \
         ever finer meshes. The error is the largest difference of a key node's displacement from the converged solution, \
         as a share of the largest displacement; the worst loaded node counts. The converged solution is Richardson's \
         extrapolation from the two finest meshes of 1, 2, 4, ... elements a member; what may be left on the finest mesh \
         is Roache's grid convergence index. The linear solution needs no refinement: it is exact at the nodes.",
    )];
    let series = error_by_nodes(convergence);
    if !series.is_empty() {
        blocks.push(Block::Figure(Figure {
            svg: picture(series)?,
            caption: "Worst error by nodes of the mesh, for each force.".to_owned(),
            csv: Some(CSV.to_owned()),
            wide: true,
        }));
    }
    blocks.push(Block::Table(table(convergence)));
    Ok(sections::section("convergence", "How fine a mesh must be", blocks))
}

/// A series a force: nodes and error in %.
fn error_by_nodes(convergence: &Convergence) -> Vec<Series> {
    let series = |(n, force_n): (usize, f64)| {
        let points = convergence.meshes.iter().enumerate().filter_map(|(mesh, size)| {
            // An error of nothing has no place on a logarithmic axis.
            let error = convergence.error(mesh, force_n).filter(|error| *error > 0.0)?;
            Some([size.nodes as f64, 100.0 * error])
        });
        Series::nth(n, format!("{force_n} N"), points.collect())
    };
    convergence.forces_n().into_iter().enumerate().map(series).filter(|series| !series.points.is_empty()).collect()
}

fn picture(series: Vec<Series>) -> Result<String, FigureError> {
    let alt = "Worst error of the displacements by number of mesh nodes, a line a force, both axes logarithmic";
    let frame = Frame::full("", alt).with_plot_height(300.0);
    let axes = [Axis::log("nodes of the mesh"), Axis::log("error / largest displacement, %")];
    Chart::new(frame, axes, series).compared(REFERENCES.map(|(value, label)| (value, label.to_owned()))).svg()
}

fn mesh_name(mesh: &MeshSize) -> String {
    match mesh.elements_a_member {
        None => format!("{} nodes (elements of one length)", mesh.nodes),
        Some(1) => format!("{} nodes (one element a member)", mesh.nodes),
        Some(elements) => format!("{} nodes ({elements} elements a member)", mesh.nodes),
    }
}

/// In per cent with two digits, however small.
pub(super) fn percent(error: f64) -> String {
    match 100.0 * error {
        p if p < 1e-3 => format!("{p:.1e} %"),
        p => format!("{p:.*} %", (1.0 - p.log10().floor()).max(0.0) as usize),
    }
}

fn table(convergence: &Convergence) -> Table {
    let forces_n = convergence.forces_n();
    let row = |name: String, cell: &dyn Fn(f64) -> Option<String>| Row {
        cells: std::iter::once(Cell::plain(name))
            .chain(forces_n.iter().map(|&force_n| Cell::plain(cell(force_n).unwrap_or_else(|| "-".to_owned()))))
            .collect(),
    };
    let meshes = convergence.meshes.iter().enumerate();
    let mut rows: Vec<Row> = meshes
        .map(|(mesh, size)| row(mesh_name(size), &|force_n| convergence.error(mesh, force_n).map(percent)))
        .collect();
    rows.push(row("may be left on the finest mesh".to_owned(), &|force_n| convergence.left(force_n).map(percent)));
    rows.push(row("observed order".to_owned(), &|force_n| {
        convergence.orders(force_n).map(|[low, high]| format!("{low:.1} to {high:.1}"))
    }));
    if forces_n.iter().any(|&force_n| convergence.gaps(force_n) > 0) {
        let loads = |force_n| Some(convergence.gaps(force_n).to_string());
        rows.push(row("loads without equilibrium (in no figure above)".to_owned(), &loads));
    }
    Table {
        caption: "Worst error by mesh and force".to_owned(),
        columns: std::iter::once(Column::words("mesh"))
            .chain(forces_n.iter().map(|force_n| Column::numbers(format!("{force_n} N"))))
            .collect(),
        rows,
        csv: Some(CSV.to_owned()),
    }
}
