//! Causes of sensing errors on the paper's finger and on the finger with softer ends, and the errors that remain as remedies are added.

use super::{Recorded, Row, number, section};
use crate::drawings::{by_direction, error_bars, rank_of, small_maps};
use crate::format::{error_as, percent};
use crate::prelude::*;

pub(super) const CSV: &str = "causes.csv";
pub(super) const CELLS_CSV: &str = "causes_by_cell.csv";
/// Columns of errors as remedies are added one after the other, and the remedies.
const REMEDIES: [(&str, &str); 4] = [
    ("rms_error", "no remedy"),
    ("zones_known", "+ zones known"),
    ("contact_known", "+ contact known"),
    ("nonlinear", "+ nonlinear"),
];
const REGIONS: [&str; 3] = ["near the base", "middle", "near the tip"];

pub(crate) fn causes(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["paper-causes", "Causes of errors, and remedies"], || {
        let (regions, cells) = (Recorded::of(CSV)?, Recorded::of(CELLS_CSV)?);
        Ok(vec![clearing(study, &cells)?, bars(study, &cells)?, Block::Table(by_region(&regions.rows))])
    })
}

/// Name of a row's finger.
fn finger(row: &Row) -> String {
    let name = row["truth"].in_words();
    TruthId::ALL.iter().find(|truth| truth.name() == name).map_or(name, |truth| truth.label().to_owned())
}

/// Small maps of the error, one row per true finger, one column per remedy.
fn clearing(study: &Study, cells: &Recorded) -> Result<Block, ReportError> {
    let row = |rows: &[Row]| {
        let along = |key: &str| {
            let mut all: Vec<f64> = rows.iter().filter_map(|row| number(row, key)).collect();
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let (positions_mm, angles_deg) = (along("s_mm"), along("angle_deg"));
        let map = |(key, _)| {
            let state = |row: &Row| {
                if number(row, "rms_error").is_some() { CellState::Answered } else { CellState::WithoutEquilibrium }
            };
            let ranks = rows.iter().map(|row| Some(rank_of(state(row), number(row, key)) as f64));
            Some(by_direction(&positions_mm, &angles_deg, ranks))
        };
        (finger(&rows[0]), REMEDIES.map(map).into())
    };
    let rows = cells.rows.chunk_by(|a, b| a["truth"] == b["truth"]).map(row).collect();
    let title = "Error of 3 N as remedies are added, from left to right";
    let alt =
        format!("{title}: small maps by position and direction, a row for each finger, a column for each remedy.");
    let columns = REMEDIES.map(|(_, name)| name.to_owned()).into();
    let svg = small_maps(&study.finger, Frame::full(title, alt), columns, rows).svg()?;
    let caption = "Root mean square error of a force. First map: least squares with an assumed contact. Then, one after the other: modulus and zones \
        (softer base and tip) are known; the contact is known; the nonlinear estimator is used.";
    Ok(Block::Figure(Figure::wide(svg, caption, CELLS_CSV)))
}

/// Bars of the error at the contact nodes of the uniform finger as remedies are added. Each bar is a remaining error, so the bars do not add up.
fn bars(study: &Study, cells: &Recorded) -> Result<Block, ReportError> {
    let finger = &study.finger;
    let nodes: Vec<(NodeId, &Row)> = finger
        .contact_nodes()
        .rev()
        .filter_map(|node| {
            let s_mm = finger.front_position_mm(node)?;
            let here = |row: &&Row| {
                number(row, "angle_deg") == Some(0.0) && number(row, "s_mm").is_some_and(|at| (at - s_mm).abs() < 1e-6)
            };
            Some((node, cells.rows.iter().find(here)?))
        })
        .collect();
    let bars = REMEDIES.iter().enumerate().map(|(n, &(key, name))| {
        let hue = n.checked_sub(1).map_or(Hue::NEUTRAL, Hue::nth);
        error_bars(name, hue, nodes.iter().map(|(_, row)| number(row, key)))
    });
    let names = Axis::categories("contact node, base to tip", nodes.iter().map(|(node, _)| node.to_string()).collect());
    let title = "Remaining error of 3 N along the normal, uniform finger";
    let alt = "Root mean square error by contact node: with all causes, and as remedies are added one after the other.";
    let chart =
        Chart::of_bars(Frame::full(title, alt), [names, Axis::linear("root mean square error, %")], bars.collect());
    let caption =
        "Each bar is the remaining error. Causes may cancel each other, so a remedy can also make the error larger.";
    Ok(Block::Figure(Figure::wide(chart.svg()?, caption, CELLS_CSV)))
}

/// Table of the largest cause in each region, one row for each finger, estimator and knowledge of the contact.
fn by_region(rows: &[Row]) -> Table {
    let way = |row: &Row| ["truth", "estimator", "contact"].map(|key| row[key].in_words());
    let drawn: Vec<&Row> = rows.iter().filter(|row| number(row, "force_n") == Some(3.0)).collect();
    let cell = |rows: &&[&Row], region: &str| {
        let Some(row) = rows.iter().find(|row| row["region"].in_words() == region) else { return Cell::plain("") };
        let Some(all) = number(row, "rms_error") else { return Cell::plain("refused") };
        let why = row["largest"].in_words();
        let without =
            number(row, "rms_without").map_or_else(String::new, |rms| format!(", {} without it", percent(rms)));
        error_as(format!("{}: {why}{without}", percent(all)), all)
    };
    let caption = "Root mean square error at 3 N along the normal, its largest cause, and the error without this cause. \"Near an end\" means within a \
        sixth of the plate's length from an end. Amber marks errors above 10 %, red errors above 25 %";
    Columns::<&[&Row]>::new()
        .page("finger, contact", Format::Words, |rows| {
            format!("{}, {}", finger(rows[0]), rows[0]["contact"].in_words())
        })
        .page("sensed by", Format::Words, |rows| rows[0]["estimator"].clone())
        .each(REGIONS, |columns, region| columns.cells(region, Format::Words, move |rows| cell(rows, region)))
        .table(caption, CSV, drawn.chunk_by(|a, b| way(a) == way(b)))
}
