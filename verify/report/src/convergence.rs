//! Error of the deformed shape by number of mesh nodes: table and figure.

use super::format::{or_nothing, percent_two_digits};
use crate::prelude::*;
use finray_studies::experiments::convergence::{Convergence, MeshSize};

const CSV: &str = "convergence.csv";
/// Text on the loads, and on the definition of a mesh's error.
const ABOUT: &str = "A force along the normal acts at each node except the tip, in turn. The error is the largest difference between a key node's \
                     displacement and its Richardson extrapolation, divided by the largest displacement; the worst loaded node counts. Linear theory is \
                     exact at the nodes.";
/// Reference errors that the figure shows as horizontal lines, with their labels.
const REFERENCES: [(f64, &str); 2] = [(0.01, "1 %"), (1e-4, "0.01 %")];

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, study.convergence.rows()).csv_alone()]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let convergence = &study.convergence;
    let mut blocks = vec![text(ABOUT)];
    let series = error_by_nodes(convergence);
    if !series.is_empty() {
        let caption = "Worst error by number of mesh nodes, for each force.";
        blocks.push(Block::Figure(Figure::wide(drawing(series)?, caption, CSV)));
    }
    blocks.push(details("By mesh and force", vec![Block::Table(table(convergence))]));
    Ok(Some(Section::new("convergence", "How fine a mesh must be", blocks)))
}

/// Series of the shape's error over the number of mesh nodes, one series per force.
fn error_by_nodes(convergence: &Convergence) -> Vec<Series> {
    let series = |(n, force_n): (usize, f64)| {
        let points = convergence.meshes.iter().enumerate().filter_map(|(mesh, size)| {
            // An error of 0 cannot be drawn on a logarithmic axis.
            let error = convergence.error(mesh, force_n).filter(|error| *error > 0.0)?;
            Some([size.nodes as f64, error])
        });
        Series::nth(n, format!("{force_n} N"), points.collect())
    };
    convergence.forces_n().into_iter().enumerate().map(series).filter(|series| !series.points.is_empty()).collect()
}

fn drawing(series: Vec<Series>) -> Result<String, FigureError> {
    let alt = "Worst error of the displacements by number of mesh nodes, one line per force, both axes logarithmic";
    let frame = Frame::full("Error of the shape by mesh", alt).with_plot_height(300.0);
    let axes = [Axis::log("nodes of the mesh"), Axis::log("error / largest displacement").within(1e-9, 0.03)];
    Chart::new(frame, axes, series).compared(REFERENCES.map(|(value, label)| (value, label.to_owned()))).svg()
}

fn mesh_name(mesh: &MeshSize) -> String {
    match mesh.elements_a_member {
        None => format!("{} nodes, equal elements", mesh.nodes),
        Some(1) => format!("{} nodes, one element per member", mesh.nodes),
        Some(elements) => format!("{} nodes, {elements} elements per member", mesh.nodes),
    }
}

fn table(convergence: &Convergence) -> Table {
    type Line<'c> = (String, Box<dyn Fn(f64) -> Option<String> + 'c>);
    let percent = |share: Option<f64>| share.map(percent_two_digits);
    let mut lines: Vec<Line> = Vec::new();
    for (mesh, size) in convergence.meshes.iter().enumerate() {
        lines.push((mesh_name(size), Box::new(move |force_n| percent(convergence.error(mesh, force_n)))));
    }
    let left = "remaining error".to_owned();
    lines.push((left, Box::new(move |force_n| percent(convergence.left(force_n)))));
    let orders = |force_n| convergence.orders(force_n).map(|[low, high]| format!("{low:.1} to {high:.1}"));
    lines.push(("observed order".to_owned(), Box::new(orders)));
    let forces_n = convergence.forces_n();
    if forces_n.iter().any(|&force_n| convergence.gaps(force_n) > 0) {
        let gaps = |force_n| Some(convergence.gaps(force_n).to_string());
        lines.push(("loads without equilibrium".to_owned(), Box::new(gaps)));
    }
    Columns::<Line>::new()
        .page("mesh", Format::Words, |(name, _)| name.clone())
        .each(forces_n, |columns, force_n| {
            columns.page(format!("{force_n} N"), Format::Plain, move |(_, of)| or_nothing(of(force_n)))
        })
        .table("Worst error; remaining error by Roache's grid convergence index", CSV, lines)
}
