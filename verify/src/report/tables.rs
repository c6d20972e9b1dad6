//! Rows for the page's tables, and the CSV files behind figures and tables.

use super::page::{Cell, Column, Row, Shade, Table};
use super::{
    causes, claims, contact_scenes, convergence, coverage, curves, directions, displacement_noise, hard_cases, lattice,
    maps, networks, pairs, recipes, scatter, speed_error, table_two, twin,
};
use crate::check::{Check, Comparison, Kind, worst};
use crate::claims::Claim;
use crate::experiments::table_one::{TableOne, WEIGHTS_G};
use crate::files::csv_text;
use crate::sampling::map::AccuracyMap;
use crate::study::Study;
use finray_model::finger::Plate;
use serde::Serialize;
use std::path::PathBuf;

pub(super) const CHECKS_CSV: &str = "checks.csv";
pub(super) const COMPARISONS_CSV: &str = "comparisons.csv";
pub(super) const TABLE_ONE_CSV: &str = "table_one.csv";
pub(super) const FINGER_CSV: &str = "finger.csv";
pub(super) const SHAPES_CSV: &str = "shapes.csv";

/// File of a map's cells.
pub(super) fn map_csv_name(map: &AccuracyMap) -> String {
    let noise = if map.noise_mm > 0.0 { "with_noise" } else { "without_noise" };
    match map.estimator.as_str() {
        "least-squares" => format!("map_{}_{noise}.csv", map.truth),
        estimator => format!("map_{}_{estimator}_{noise}.csv", map.truth),
    }
}

#[derive(Serialize)]
struct TableOneCell {
    angle_deg: f64,
    node: usize,
    weight_g: f64,
    error: f64,
    mean_error: f64,
    paper_mean_error: f64,
    modulus_factor: f64,
}

#[derive(Serialize)]
struct NodeRow {
    node: usize,
    x_mm: f64,
    y_mm: f64,
    s_front_mm: Option<f64>,
}

#[derive(Serialize)]
struct ShapeRow<'a> {
    shape: &'a str,
    line: usize,
    x_mm: f64,
    y_mm: f64,
}

/// All CSV files of a report.
pub(super) fn csv_files(study: &Study, claimed: &[Claim]) -> Result<Vec<(PathBuf, String)>, csv::Error> {
    let table_one = study.tables_one.iter().flat_map(|table| {
        table.rows.iter().flat_map(|row| {
            row.errors.iter().zip(WEIGHTS_G).map(|(&error, weight_g)| TableOneCell {
                angle_deg: table.angle_deg,
                node: row.node,
                weight_g,
                error,
                mean_error: row.mean_error,
                paper_mean_error: row.paper_mean_error,
                modulus_factor: table.modulus_factor,
            })
        })
    });
    let finger = &study.finger;
    let nodes =
        finger.plate_nodes(Plate::Back).into_iter().chain(finger.plate_nodes(Plate::Front).into_iter().rev().skip(1));
    let nodes = nodes.map(|node| {
        let at = finger.position(node);
        NodeRow { node: node.0, x_mm: at.x, y_mm: at.y, s_front_mm: finger.front_place_mm(node) }
    });
    let shapes = study.bent.iter().flat_map(|bent| {
        bent.lines.iter().enumerate().flat_map(move |(line, points)| {
            points.iter().map(move |p| ShapeRow { shape: &bent.label, line: line + 1, x_mm: p.x, y_mm: p.y })
        })
    });
    let mut files: Vec<(PathBuf, String)> = vec![
        (CHECKS_CSV.into(), csv_text(study.all_checks())?),
        (COMPARISONS_CSV.into(), csv_text(&study.comparisons)?),
        (FINGER_CSV.into(), csv_text(nodes)?),
        (SHAPES_CSV.into(), csv_text(shapes)?),
        (convergence::CSV.into(), csv_text(study.convergence.rows())?),
    ];
    if !study.coverage.is_empty() {
        files.push((coverage::CSV.into(), csv_text(&study.coverage)?));
    }
    if !study.hard_cases.is_empty() {
        files.push((hard_cases::CSV.into(), csv_text(hard_cases::rows(study))?));
    }
    if !study.tables_one.is_empty() {
        files.push((TABLE_ONE_CSV.into(), csv_text(table_one)?));
    }
    if let Some(study) = &study.twin {
        files.push((twin::CSV.into(), csv_text(twin::rows(study))?));
        files.push((twin::SETS_CSV.into(), csv_text(twin::set_rows(study))?));
        files.push((twin::CALIBRATION_CSV.into(), csv_text(twin::calibration_rows(study))?));
    }
    if !study.causes.is_empty() {
        files.push((causes::CSV.into(), csv_text(causes::rows(study))?));
    }
    if let Some(noise) = &study.noise {
        files.push((scatter::CSV.into(), csv_text(scatter::csv_rows(noise))?));
        if !noise.pairs.is_empty() {
            files.push((pairs::CSV.into(), csv_text(pairs::rows(noise))?));
        }
    }
    if let Some(noise) = &study.displacement_noise {
        files.push((displacement_noise::CSV.into(), csv_text(&noise.rows)?));
    }
    if let Some(study) = &study.directions {
        files.push((directions::CSV.into(), csv_text(directions::rows(study))?));
        files.push((directions::FRICTIONLESS_CSV.into(), csv_text(directions::frictionless_rows(study))?));
    }
    if !study.speed_error.is_empty() {
        files.push((speed_error::CSV.into(), csv_text(&study.speed_error)?));
    }
    if !claimed.is_empty() {
        files.push((claims::CSV.into(), csv_text(claimed)?));
    }
    if !study.contact_scenes.is_empty() {
        files.push((contact_scenes::CSV.into(), csv_text(contact_scenes::rows(study))?));
    }
    if study.table_two.is_some() {
        files.push((table_two::CSV.into(), csv_text(table_two::rows(study))?));
    }
    if let Some(study) = &study.networks {
        files.push((networks::CSV.into(), csv_text(networks::rows(study))?));
    }
    if !study.records.recipes.is_empty() {
        files.push((recipes::CSV.into(), csv_text(&study.records.recipes)?));
    }
    if !study.records.curves.is_empty() {
        files.push((curves::CSV.into(), csv_text(&study.records.curves)?));
    }
    if let Some(study) = &study.lattice {
        files.push((lattice::CSV.into(), csv_text(lattice::rows(study))?));
        files.push((lattice::AXIAL_CSV.into(), csv_text(lattice::axial_rows(study))?));
        if !study.settling.is_empty() {
            files.push((lattice::SETTLING_CSV.into(), csv_text(lattice::settling_rows(study))?));
        }
    }
    files.push((maps::OVERVIEW_CSV.into(), csv_text(maps::overview_rows(study))?));
    files.push((maps::EXPLANATIONS_CSV.into(), csv_text(&study.explanations.cells)?));
    for map in study.all_maps() {
        files.push((map_csv_name(map).into(), map.to_csv()?));
    }
    Ok(files)
}

/// A figure for reading: four significant digits, powers of ten where it is very small or large.
pub(super) fn figure(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size == 0.0 { 0 } else { (3 - size.log10().floor() as i32).clamp(0, 7) as usize };
    format!("{value:.digits$}")
}

pub(super) fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        p if p < 0.05 && p > 0.0 => format!("{:.0e} %", 100.0 * share),
        p if p < 9.95 => format!("{:.1} %", 100.0 * share),
        _ => format!("{:.0} %", 100.0 * share),
    }
}

/// An error, shaded as the paper shades its Table I: grey above 10 %, dark above 25 %.
pub(super) fn error(share: f64) -> Cell {
    match share {
        e if e > 0.25 => Cell::shaded(percent(e), Shade::Dark),
        e if e > 0.10 => Cell::shaded(percent(e), Shade::Grey),
        e => Cell::plain(percent(e)),
    }
}

/// Whether a promise holds, in green or red.
pub(super) fn verdict(holds: bool, [kept, broken]: [&str; 2]) -> Cell {
    if holds { Cell::shaded(kept, Shade::Pass) } else { Cell::shaded(broken, Shade::Fail) }
}

/// The checks in short: a row for each reference, grouped by its kind, with how close its closest check comes to failing.
pub(super) fn checks_by_source(checks: &[Check]) -> Table {
    let mut sources: Vec<(Kind, &str)> = Vec::new();
    for check in checks {
        if !sources.contains(&(check.kind, &check.source)) {
            sources.push((check.kind, &check.source));
        }
    }
    sources.sort_by_key(|(kind, _)| *kind);
    let row = |(kind, source): (Kind, &str)| {
        let of_source = || checks.iter().filter(|check| (check.kind, check.source.as_str()) == (kind, source));
        let closest = worst(of_source().map(|check| (check.ours - check.reference).abs() / check.tolerance));
        let figures = [of_source().count().to_string(), percent(closest)].map(Cell::plain);
        let verdict = verdict(of_source().all(Check::passes), ["pass", "fail"]);
        let words = [kind.name(), source].map(Cell::plain);
        Row { cells: words.into_iter().chain(figures).chain([verdict]).collect() }
    };
    Table {
        caption: "Checks by kind and source of their reference".to_owned(),
        columns: ["kind", "source"]
            .map(Column::words)
            .into_iter()
            .chain(["checks", "largest difference / tolerance"].map(Column::numbers))
            .chain([Column::words("verdict")])
            .collect(),
        rows: sources.into_iter().map(row).collect(),
        csv: Some(CHECKS_CSV.to_owned()),
    }
}

pub(super) fn checks<'c>(checks: impl IntoIterator<Item = &'c Check>) -> Table {
    let row = |check: &Check| {
        let verdict = verdict(check.passes(), ["pass", "fail"]);
        let words = [check.kind.name(), &check.problem, &check.source, &check.quantity].map(Cell::plain);
        let numbers = [check.reference, check.ours].map(|x| Cell::plain(reference_digits(x, check.tolerance)));
        let tolerance = Cell::plain(format!("{:.0e}", check.tolerance));
        Row { cells: words.into_iter().chain(numbers).chain([tolerance, verdict]).collect() }
    };
    Table {
        caption: "Checks: our figure against a reference, and the largest difference that passes".to_owned(),
        columns: ["kind", "problem", "source", "quantity"]
            .map(Column::words)
            .into_iter()
            .chain(["reference", "ours", "tolerance"].map(Column::numbers))
            .chain([Column::words("verdict")])
            .collect(),
        rows: checks.into_iter().map(row).collect(),
        csv: Some(CHECKS_CSV.to_owned()),
    }
}

/// As many decimals as the tolerance speaks of, so that small differences can be seen.
fn reference_digits(value: f64, tolerance: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if value.abs() < 10.0 * tolerance {
        return format!("{value:.1e}");
    }
    let decimals = (1.0 - tolerance.log10()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$}")
}

pub(super) fn comparisons(comparisons: &[Comparison]) -> Table {
    let row = |c: &Comparison| Row {
        cells: [&c.problem, &c.source, &c.quantity]
            .map(Cell::plain)
            .into_iter()
            .chain([c.reference, c.ours].map(|x| Cell::plain(figure(x))))
            .collect(),
    };
    Table {
        caption: "Where a difference is expected and nothing is promised".to_owned(),
        columns: ["problem", "source", "quantity"]
            .map(Column::words)
            .into_iter()
            .chain(["reference", "ours"].map(Column::numbers))
            .collect(),
        rows: comparisons.iter().map(row).collect(),
        csv: Some(COMPARISONS_CSV.to_owned()),
    }
}

/// Table I: mean error by node, the paper's and ours for each assumed direction, shaded as the paper shades it.
pub(super) fn table_one(tables: &[TableOne]) -> Table {
    let nodes: Vec<(usize, f64)> =
        tables.first().map_or_else(Vec::new, |t| t.rows.iter().map(|r| (r.node, r.paper_mean_error)).collect());
    let rows = nodes
        .iter()
        .enumerate()
        .map(|(i, &(node, paper))| {
            let ours = tables.iter().map(|table| error(table.rows[i].mean_error));
            Row { cells: [Cell::plain(node.to_string()), error(paper)].into_iter().chain(ours).collect() }
        })
        .collect();
    let ours = tables.iter().map(|table| Column::numbers(format!("ours, {} deg", table.angle_deg)));
    Table {
        caption: "Mean error of the sensed force over six weights (50 to 300 g) by loaded node; grey above 10 %, dark \
                  above 25 %, as in the paper's Table I"
            .to_owned(),
        columns: [Column::numbers("node"), Column::numbers("paper")].into_iter().chain(ours).collect(),
        rows,
        csv: Some(TABLE_ONE_CSV.to_owned()),
    }
}

/// The maps in a few figures each.
pub(super) fn map_figures(summary: &super::Summary) -> Table {
    let shown = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), percent);
    let rows = summary.maps.iter().map(|entry| {
        let m = &entry.figures;
        let forces = match m.forces_n[..] {
            [one] => format!("{one} N"),
            _ => "mean over all".to_owned(),
        };
        let cells = [
            m.truth.clone(),
            m.estimator.clone(),
            m.noise_mm.to_string(),
            forces,
            m.cells.to_string(),
            m.answered.to_string(),
            m.refused.to_string(),
            m.without_equilibrium.to_string(),
            shown(m.mean_error),
            shown(m.largest_error),
            shown(m.share_above_10),
            shown(m.share_above_25),
            shown(m.share_of_samples_refused),
        ];
        let file = Cell::file(entry.csv.clone());
        Row { cells: cells.map(Cell::plain).into_iter().chain([file]).collect() }
    });
    Table {
        caption: "The maps in figures: mean and largest error are those of the answered cells; the shares are of all cells with an \
                  equilibrium, a refused one counts as above. A cell is refused if more than half of its noise samples are; the last \
                  column is the share of single samples. The network's cells are contact nodes along the normal"
            .to_owned(),
        columns: ["truth", "sensed by", "noise, mm", "force"]
            .map(Column::words)
            .into_iter()
            .chain(
                [
                    "cells",
                    "answered",
                    "refused",
                    "no equilibrium",
                    "mean error",
                    "largest",
                    "above 10 %",
                    "above 25 %",
                    "samples refused",
                ]
                .map(Column::numbers),
            )
            .chain([Column::words("data")])
            .collect(),
        rows: rows.collect(),
        csv: None,
    }
}
