//! How many cases a network must see, and how large it must be.

use super::ReportError;
use super::page::{Block, Cell, Column, Figure, Row, Table};
use super::sections::text;
use super::tables::percent;
use crate::experiments::networks::records::CurveRow;
use crate::figures::{Axis, Chart, Frame, Series, Spread};

pub(super) const CSV: &str = "training_curves.csv";
/// So many cases are enough if more of them lower the error by no more than this share.
const ENOUGH: f64 = 0.05;
/// A network keeps the error of another if its own is no more than this share above it.
const KEEPS: f64 = 0.1;
/// Hidden layers of the networks that ship for given contacts.
const SHIP: &str = "32-32";
/// The paper's hidden layers.
const PAPERS: &str = "150-200-150";

/// The networks of one recipe and all seeds.
struct Point {
    /// Training cases, or trained numbers.
    x: usize,
    layers: String,
    /// Mean error over that of the bound: mean over the seeds, least and greatest.
    over_bound: f64,
    range: [f64; 2],
    error: f64,
    bound: f64,
}

/// The points of one set of contact nodes.
struct Curve {
    nodes: String,
    points: Vec<Point>,
}

pub(super) fn blocks(rows: &[CurveRow]) -> Result<Vec<Block>, ReportError> {
    let (samples, sizes) = (curves(rows, "samples", |row| row.samples), curves(rows, "size", |row| row.weights));
    let mut blocks = Vec::new();
    let mut figures = Vec::new();
    if !samples.is_empty() {
        blocks.extend(samples_in_words(&samples).map(text));
        figures.push(figure(&samples, "training cases", "Error of recipe (c) by the number of its training cases.")?);
    }
    if !sizes.is_empty() {
        blocks.extend(sizes_in_words(&sizes).map(text));
        let caption = "Error of recipe (c) by the size of the network: trained numbers, linear branch included.";
        figures.push(figure(&sizes, "weights", caption)?);
    }
    if !figures.is_empty() {
        blocks.push(Block::Figures { figures });
    }
    if !sizes.is_empty() {
        let table = Block::Table(table(&sizes));
        blocks.push(Block::Details { summary: "Networks by size".to_owned(), blocks: vec![table] });
    }
    Ok(blocks)
}

fn curves(rows: &[CurveRow], curve: &str, x: fn(&CurveRow) -> usize) -> Vec<Curve> {
    let of_curve: Vec<&CurveRow> = rows.iter().filter(|row| row.curve == curve).collect();
    let mut nodes: Vec<&str> = Vec::new();
    for row in &of_curve {
        if !nodes.contains(&row.nodes.as_str()) {
            nodes.push(&row.nodes);
        }
    }
    let points = |nodes: &str| {
        let mut of_nodes: Vec<&CurveRow> = of_curve.iter().copied().filter(|row| row.nodes == nodes).collect();
        of_nodes.sort_by(|a, b| (x(a), &a.hidden_layers).cmp(&(x(b), &b.hidden_layers)));
        let same = |a: &&CurveRow, b: &&CurveRow| x(a) == x(b) && a.hidden_layers == b.hidden_layers;
        of_nodes.chunk_by(same).filter_map(|seeds| point(seeds, x)).collect()
    };
    nodes.into_iter().map(|nodes| Curve { nodes: nodes.to_owned(), points: points(nodes) }).collect()
}

/// Networks that differ in nothing but their seed; `None` if one sensed nothing.
fn point(seeds: &[&CurveRow], x: fn(&CurveRow) -> usize) -> Option<Point> {
    let errors = seeds.iter().map(|row| Some([row.mean_error?, row.mean_error_bound?]));
    let errors: Vec<[f64; 2]> = errors.collect::<Option<_>>()?;
    let mean = |of: fn(&[f64; 2]) -> f64| errors.iter().map(of).sum::<f64>() / errors.len() as f64;
    let over_bound = |[error, bound]: &[f64; 2]| error / bound;
    let range = [f64::INFINITY, f64::NEG_INFINITY];
    let range = errors.iter().map(over_bound).fold(range, |[low, high], over| [low.min(over), high.max(over)]);
    let first = seeds.first()?;
    Some(Point {
        x: x(first),
        layers: first.hidden_layers.clone(),
        over_bound: mean(over_bound),
        range,
        error: mean(|row| row[0]),
        bound: mean(|row| row[1]),
    })
}

fn nodes_in_words(nodes: &str) -> String {
    match nodes.contains(' ') {
        true => format!("nodes {}", nodes.replace(' ', " and ")),
        false => format!("node {nodes}"),
    }
}

fn figure(curves: &[Curve], x_label: &str, caption: &str) -> Result<Figure, ReportError> {
    let series = curves.iter().enumerate().map(|(n, curve)| {
        let points = curve.points.iter().map(|point| [point.x as f64, point.over_bound]).collect();
        let spread = Spread::Bars(curve.points.iter().map(|point| point.range).collect());
        Series { spread, ..Series::nth(n, nodes_in_words(&curve.nodes), points) }
    });
    let frame = Frame::half("", format!("{caption} A line a set of contacts."));
    let chart = Chart::new(frame, [Axis::log(x_label), Axis::linear("mean error / bound")], series.collect());
    let svg = chart.compared([(1.0, "bound".to_owned())]).svg()?;
    Ok(Figure { svg, caption: caption.to_owned(), csv: Some(CSV.to_owned()), wide: false })
}

/// From how many cases on the error is that of the most.
fn samples_in_words(curves: &[Curve]) -> Option<String> {
    let enough = |curve: &Curve| {
        let last = curve.points.last()?;
        let worse = curve.points.iter().rposition(|point| point.error > (1.0 + ENOUGH) * last.error);
        Some((curve.points[worse.map_or(0, |i| i + 1)].x, last.x))
    };
    let enough: Vec<(usize, usize)> = curves.iter().filter_map(enough).collect();
    let (needed, most) = enough.into_iter().max()?;
    Some(match needed < most {
        true => format!(
            "How many cases? From {needed} on, the error is within {} of that with {most}, for every set of contacts here.",
            in_words(ENOUGH)
        ),
        false => format!("How many cases? The error still falls by more than {} towards {most}.", in_words(ENOUGH)),
    })
}

/// Whether the paper's size is needed, and the smallest that keeps its error.
fn sizes_in_words(curves: &[Curve]) -> Option<String> {
    let find = |curve: &Curve, layers: &str| curve.points.iter().position(|point| point.layers == layers);
    // Layers in the order of their size, by the first contacts; others have an output more.
    let order = &curves.first()?.points;
    let keeps = |layers: &str| {
        curves.iter().all(|curve| match (find(curve, layers), find(curve, PAPERS)) {
            (Some(of), Some(papers)) => curve.points[of].error <= (1.0 + KEEPS) * curve.points[papers].error,
            _ => false,
        })
    };
    let smallest = order.iter().find(|point| keeps(&point.layers))?;
    let papers = order.iter().find(|point| point.layers == PAPERS)?;
    let mut words = if smallest.x < papers.x {
        format!(
            "Is {PAPERS} needed? No: {} ({} weights instead of {}) is the smallest that keeps its error within {}, for every \
             set of contacts here.",
            layers_in_words(&smallest.layers),
            smallest.x,
            papers.x,
            in_words(KEEPS)
        )
    } else {
        format!("Is {PAPERS} needed? Yes: every smaller network errs by more than {} more.", in_words(KEEPS))
    };
    let above = curves.iter().filter_map(|curve| {
        Some(curve.points[find(curve, SHIP)?].error / curve.points[find(curve, PAPERS)?].error - 1.0)
    });
    if let Some(above) = above.reduce(f64::max).filter(|above| *above > 0.0) {
        words += &format!(" With {SHIP}, as ships, the error is at most {} above it.", percent(above));
    }
    let alone = curves.iter().filter_map(|curve| Some((&curve.nodes, &curve.points[find(curve, "none")?])));
    let alone: Vec<String> =
        alone.map(|(nodes, point)| format!("{} for {}", percent(point.error), nodes_in_words(nodes))).collect();
    if !alone.is_empty() && smallest.layers != "none" {
        words += &format!(" Linear regression alone errs by {}.", alone.join(", "));
    }
    Some(words)
}

/// The share in whole percent.
fn in_words(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn layers_in_words(layers: &str) -> String {
    match layers {
        "none" => "linear regression".to_owned(),
        several if several.contains('-') => several.to_owned(),
        one => format!("one layer of {one}"),
    }
}

fn table(curves: &[Curve]) -> Table {
    let rows = curves.iter().flat_map(|curve| {
        curve.points.iter().map(|point| Row {
            cells: [
                curve.nodes.replace(' ', ", "),
                layers_in_words(&point.layers),
                point.x.to_string(),
                percent(point.error),
                percent(point.bound),
                format!("{:.2}", point.over_bound),
            ]
            .map(Cell::plain)
            .into(),
        })
    });
    Table {
        caption: "Mean error of each force by size of the network, mean over the seeds".to_owned(),
        columns: ["nodes", "hidden layers"]
            .map(Column::words)
            .into_iter()
            .chain(["weights", "mean error", "bound", "error / bound"].map(Column::numbers))
            .collect(),
        rows: rows.collect(),
        csv: Some(CSV.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two seeds whose mean error is the bound's 2 % and a share of it.
    fn rows(curve: &str, networks: &[(usize, &str, usize, f64)]) -> Vec<CurveRow> {
        let row = |seed: u64, nodes: &str, &(samples, layers, weights, above): &(usize, &str, usize, f64)| CurveRow {
            curve: curve.to_owned(),
            nodes: nodes.to_owned(),
            samples,
            hidden_layers: layers.to_owned(),
            weights,
            seed,
            cases: 100,
            mean_error: Some(0.02 * (1.0 + above + if seed == 1 { 0.01 } else { -0.01 })),
            mean_error_bound: Some(0.02),
        };
        let seeds = [1, 2];
        let of_nodes = |nodes: &'static str| {
            seeds.iter().flat_map(move |&seed| networks.iter().map(move |network| row(seed, nodes, network)))
        };
        of_nodes("24").chain(of_nodes("19 20")).collect()
    }

    fn sizes(rows: &[CurveRow]) -> String {
        sizes_in_words(&curves(rows, "size", |row| row.weights)).expect("words")
    }

    #[test]
    fn the_smallest_network_that_keeps_the_error_is_named() {
        let [none, small, large] = [(1, "none", 94, 1.0), (1, "16-16", 1400, 0.05), (1, PAPERS, 70_000, 0.03)];
        let said = sizes(&rows("size", &[large, none, small]));
        assert!(said.contains("No: 16-16 (1400 weights instead of 70000)"), "{said}");
        assert!(
            said.contains("Linear regression alone errs by 4.0 % for node 24, 4.0 % for nodes 19 and 20"),
            "{said}"
        );
        let worse = (1, "16-16", 1400, 0.2);
        assert!(sizes(&rows("size", &[large, none, worse])).contains("Yes"));
        // It must keep the error for every set of contacts.
        let mut uneven = rows("size", &[large, none, small]);
        let of_pair = uneven.iter_mut().filter(|row| row.hidden_layers == "16-16" && row.nodes == "19 20");
        of_pair.for_each(|row| row.mean_error = row.mean_error.map(|error| 1.2 * error));
        assert!(sizes(&uneven).contains("Yes"));
    }

    #[test]
    fn the_number_of_cases_that_is_enough_is_named() {
        let said = |networks: &[(usize, &str, usize, f64)]| {
            let all = rows("samples", networks);
            samples_in_words(&curves(&all, "samples", |row| row.samples)).expect("words")
        };
        let [few, some, many] = [(1000, "32-32", 1, 0.8), (5000, "32-32", 1, 0.12), (20_000, "32-32", 1, 0.1)];
        assert!(said(&[many, few, some]).contains("From 5000 on"), "{}", said(&[many, few, some]));
        let still = (5000, "32-32", 1, 0.3);
        assert!(said(&[few, still, many]).contains("still falls"));
    }

    #[test]
    fn seeds_are_gathered_and_nothing_recorded_is_nothing_shown() {
        let all = rows("samples", &[(1000, "32-32", 1, 0.5)]);
        let [one, pair] = &curves(&all, "samples", |row| row.samples)[..] else { panic!("two curves") };
        assert_eq!((one.nodes.as_str(), pair.nodes.as_str(), one.points.len()), ("24", "19 20", 1));
        let point = &one.points[0];
        assert!((point.over_bound - 1.5).abs() < 1e-12 && (point.range[0] - 1.49).abs() < 1e-12, "{:?}", point.range);
        assert!(blocks(&[]).expect("nothing to draw").is_empty());
        assert_eq!(blocks(&all).expect("a figure").len(), 2);
    }
}
