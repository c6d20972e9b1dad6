//! How many cases a network must see, and how large it must be: recorded trainings.

use super::ReportError;
use super::dataset::Dataset;
use super::format::Span;
use super::page::{Block, Figure, text};
use super::words::say;
use crate::experiments::networks::records::CurveRow;
use crate::figures::{Axis, Chart, Frame, Series, Spread};
use minijinja::context;

const CSV: &str = "training_curves.csv";
/// So many cases are enough if more of them lower the error by no more than this share.
const ENOUGH: f64 = 0.05;
/// A network keeps the error of another if its own is no more than this share above it.
const KEEPS: f64 = 0.1;
/// The paper's hidden layers.
pub const PAPERS: &str = "150-200-150";

/// The networks of one recipe and all seeds.
pub struct Point {
    /// Training cases, or trained numbers.
    x: usize,
    layers: String,
    /// Mean error over that of the bound.
    pub over_bound: Span,
    error: f64,
}

/// The points of one set of contact nodes.
pub struct Curve {
    /// Contact nodes, by spaces.
    pub nodes: String,
    /// By rising size.
    pub points: Vec<Point>,
}

pub(super) fn dataset(rows: &[CurveRow]) -> Dataset<'_> {
    Dataset::records(CSV, rows)
}

/// Sentences and figures; none where nothing is recorded.
pub fn blocks(rows: &[CurveRow]) -> Result<Vec<Block>, ReportError> {
    let (samples, sizes) = (curves(rows, "samples", |row| row.samples), curves(rows, "size", |row| row.weights));
    let mut blocks = Vec::new();
    let mut figures = Vec::new();
    if !samples.is_empty() {
        blocks.extend(samples_in_words(&samples)?.map(text));
        figures.push(figure(&samples, "training cases", "Recipe (c) by its training cases")?);
    }
    if !sizes.is_empty() {
        blocks.extend(sizes_in_words(&sizes)?.map(text));
        figures.push(figure(&sizes, "weights", "Recipe (c) by the size of the network")?);
    }
    if !figures.is_empty() {
        blocks.push(Block::Figures { figures });
    }
    Ok(blocks)
}

/// Networks that differ in nothing but their seed make a point; those of which one sensed nothing are left out.
pub fn curves(rows: &[CurveRow], curve: &str, x: fn(&CurveRow) -> usize) -> Vec<Curve> {
    let mut of_curve: Vec<&CurveRow> = rows.iter().filter(|row| row.curve == curve).collect();
    let first = |row: &CurveRow| rows.iter().position(|other| other.curve == curve && other.nodes == row.nodes);
    of_curve.sort_by(|a, b| (first(a), x(a), &a.hidden_layers).cmp(&(first(b), x(b), &b.hidden_layers)));
    let point = |seeds: &[&CurveRow]| {
        let errors: Vec<f64> = seeds.iter().map(|row| row.mean_error).collect::<Option<_>>()?;
        let bounds: Vec<f64> = seeds.iter().map(|row| row.mean_error_bound).collect::<Option<_>>()?;
        Some(Point {
            x: x(seeds.first()?),
            layers: seeds.first()?.hidden_layers.clone(),
            over_bound: Span::of(errors.iter().zip(&bounds).map(|(error, bound)| error / bound))?,
            error: Span::of(errors)?.mean,
        })
    };
    let of_nodes = of_curve.chunk_by(|a, b| a.nodes == b.nodes).map(|of_nodes| Curve {
        nodes: of_nodes[0].nodes.clone(),
        points: of_nodes
            .chunk_by(|a, b| (x(a), &a.hidden_layers) == (x(b), &b.hidden_layers))
            .filter_map(point)
            .collect(),
    });
    of_nodes.collect()
}

fn contacts_in_words(nodes: &str) -> String {
    match nodes.contains(' ') {
        true => format!("nodes {}", nodes.replace(' ', " and ")),
        false => format!("node {nodes}"),
    }
}

fn figure(curves: &[Curve], x_label: &str, title: &str) -> Result<Figure, ReportError> {
    let series = curves.iter().enumerate().map(|(n, curve)| {
        let points = curve.points.iter().map(|point| [point.x as f64, point.over_bound.mean]).collect();
        let spread = Spread::Bars(
            curve.points.iter().map(|point| [point.over_bound.least, point.over_bound.greatest]).collect(),
        );
        Series { spread, ..Series::nth(n, contacts_in_words(&curve.nodes), points) }
    });
    let frame = Frame::half(title, format!("{title}: error over the Cramer-Rao bound, a line a set of contacts."));
    let chart = Chart::new(frame, [Axis::log(x_label), Axis::linear("mean error / bound")], series.collect());
    let svg = chart.compared([(1.0, "bound".to_owned())]).svg()?;
    let caption = "Mean over the seeds, bars from least to greatest.".to_owned();
    Ok(Figure::narrow(svg, caption, CSV))
}

/// From how many cases on the error is that of the most.
pub fn samples_in_words(curves: &[Curve]) -> Result<Option<String>, ReportError> {
    let enough = |curve: &Curve| {
        let last = curve.points.last()?;
        let worse = curve.points.iter().rposition(|point| point.error > (1.0 + ENOUGH) * last.error);
        Some((curve.points[worse.map_or(0, |i| i + 1)].x, last.x))
    };
    let most = curves.iter().filter_map(enough).max();
    say("curves.samples", most.map(|(needed, most)| context! { needed, most, enough => ENOUGH }))
}

/// Whether the paper's size is needed, and the smallest that keeps its error.
pub fn sizes_in_words(curves: &[Curve]) -> Result<Option<String>, ReportError> {
    let find = |curve: &Curve, layers: &str| curve.points.iter().position(|point| point.layers == layers);
    let keeps = |layers: &str| {
        curves.iter().all(|curve| match (find(curve, layers), find(curve, PAPERS)) {
            (Some(of), Some(papers)) => curve.points[of].error <= (1.0 + KEEPS) * curve.points[papers].error,
            _ => false,
        })
    };
    let numbers = || {
        // Layers in the order of their size, by the first contacts; others have an output more.
        let order = &curves.first()?.points;
        let smallest = order.iter().find(|point| keeps(&point.layers))?;
        let papers = order.iter().find(|point| point.layers == PAPERS)?;
        let weights = |curve: &Curve| {
            let of = |layers: &str| find(curve, layers).map(|at| curve.points[at].x);
            let (few, papers) = (of(&smallest.layers)?, of(PAPERS)?);
            Some(context! { contacts => contacts_in_words(&curve.nodes), few, papers })
        };
        Some(context! {
            papers => PAPERS, keeps => KEEPS, needed => smallest.x >= papers.x, layers => smallest.layers.as_str(),
            weights => curves.iter().filter_map(weights).collect::<Vec<_>>(),
        })
    };
    say("curves.sizes", numbers())
}
