//! Recorded results of studies that concern only the paper's finger: its claims, Tables I and II, one fit of Table I, causes of errors, times, the
//! lattice, and hard cases.
//!
//! The tests and benches that compute these results write them to `fixtures/results`; this file shows them. A full run (`FINRAY_TEST_CASES=full`)
//! records its results anew; every other run compares them with the record.

mod causes;
mod speed;

pub(super) use causes::causes;
pub(super) use speed::{seconds, speed};

use super::drawings::{Line, by_contact, error_bars};
use super::format::{figure, list, percent, verdict};
use crate::dataset::Value;
use crate::prelude::*;
use finray_studies::settings::GROSS_ERROR;
use std::collections::BTreeMap;

/// A row of a recorded table, by column.
type Row = BTreeMap<&'static str, Value>;

/// A recorded table.
struct Recorded {
    csv: &'static str,
    columns: Vec<&'static str>,
    rows: Vec<Row>,
}

/// Columns of a page's table: column of the file, heading and format.
type Shown<'c> = [(&'static str, &'c str, Format)];

impl Recorded {
    fn of(csv: &'static str) -> Result<Recorded, ReportError> {
        let text = finray_fixtures::results(csv);
        let columns: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
        let rows: Vec<csv::StringRecord> =
            csv::Reader::from_reader(text.as_bytes()).into_records().collect::<Result<_, _>>()?;
        // A column of texts, such as pairs of nodes, keeps its numbers as texts.
        let is_number = |cell: &str| cell.is_empty() || cell.parse::<f64>().is_ok();
        let numeric: Vec<bool> = (0..columns.len()).map(|i| rows.iter().all(|row| is_number(&row[i]))).collect();
        let value = |(i, cell): (usize, &str)| if numeric[i] { Value::parsed(cell) } else { Value::from(cell) };
        let rows = rows.iter().map(|row| columns.iter().copied().zip(row.iter().enumerate().map(value)).collect());
        Ok(Recorded { csv, rows: rows.collect(), columns })
    }

    fn keeping(mut self, keep: impl Fn(&Row) -> bool) -> Recorded {
        self.rows.retain(keep);
        self
    }

    fn dataset(self) -> Dataset<'static> {
        let columns = self
            .columns
            .into_iter()
            .fold(Columns::new(), |columns, key| columns.file(key, move |row: &Row| row[key].clone()));
        Dataset::new(self.csv, &columns, self.rows)
    }

    fn table(&self, caption: &str, shown: &Shown) -> Block {
        let columns = shown.iter().fold(Columns::new(), |columns, &(key, heading, format)| {
            columns.page(heading, format, move |row: &&Row| row[key].clone())
        });
        Block::Table(columns.table(caption, self.csv, &self.rows))
    }

    /// The values of a column, once each.
    fn distinct(&self, key: &str) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for value in self.rows.iter().map(|row| row[key].in_words()) {
            if !all.contains(&value) {
                all.push(value);
            }
        }
        all
    }

    /// Mean errors by two columns: one line for each value of `by`, with an error for each value of `along`.
    fn errors(&self, by: &str, along: &str) -> Vec<(String, Vec<Option<f64>>)> {
        let places = self.distinct(along);
        let error = |line: &str, place: &str, key: &str| {
            let here = |row: &&Row| row[by].in_words() == line && row[along].in_words() == place;
            self.rows.iter().find(here).and_then(|row| number(row, key))
        };
        let paper = |place: &String| self.distinct(by).iter().find_map(|line| error(line, place, "paper_mean_error"));
        let line = |line: String| {
            let errors = places.iter().map(|place| error(&line, place, "mean_error")).collect();
            (line, errors)
        };
        let papers = ("the paper, measured".to_owned(), places.iter().map(paper).collect());
        std::iter::once(papers).chain(self.distinct(by).into_iter().map(line)).collect()
    }
}

fn number(row: &Row, key: &str) -> Option<f64> {
    match row[key] {
        Value::Number(number) => Some(number),
        Value::Integer(number) => Some(number as f64),
        _ => None,
    }
}

/// Files of all recorded results, which are also arrays of the summary.
const FILES: [&str; 13] = [
    CONVERGENCE_CSV,
    speed::CSV,
    causes::CSV,
    LATTICE_CSV,
    AXIAL_CSV,
    SETTLING_CSV,
    "claims.csv",
    "table_two.csv",
    "table_one.csv",
    "twin.csv",
    "twin_zone_sets.csv",
    "twin_calibration.csv",
    "hard_cases.csv",
];

pub(super) fn datasets<'s>(Results { study }: Results<'s>) -> Result<Vec<Dataset<'s>>, ReportError> {
    let of = |csv| Recorded::of(csv).map(|recorded| recorded.keeping(|_| study.is_paper).dataset());
    let mut all = FILES.into_iter().map(of).collect::<Result<Vec<_>, _>>()?;
    all.push(of(causes::CELLS_CSV)?.csv_alone());
    Ok(all)
}

/// A section with its recorded sentences before its blocks; `None` unless the finger is the paper's.
fn section(
    study: &Study,
    [id, heading]: [&str; 2],
    blocks: impl FnOnce() -> Result<Vec<Block>, ReportError>,
) -> Result<Option<Section>, ReportError> {
    if !study.is_paper {
        return Ok(None);
    }
    let sentences = Recorded::of("sentences.csv")?.keeping(|row| row["section"].in_words() == id);
    let shown = |kind: &str| {
        let rows = sentences.rows.iter().filter(|row| row["shown"].in_words() == kind);
        rows.map(|row| row["sentence"].in_words()).collect::<Vec<_>>()
    };
    let mut all: Vec<Block> = shown("text").into_iter().map(text).collect();
    all.extend(blocks()?);
    Ok(Some(Section::new(id, heading, all).saying(shown("says"))))
}

/// Verdicts on claims, in words.
const VERDICTS: [(&str, &str); 7] = [
    ("reproduced", "reproduced"),
    ("not-reproduced", "not reproduced"),
    ("refuted", "refuted"),
    ("depends", "depend on assumptions"),
    ("in-simulation", "hold in simulation"),
    ("less-in-simulation", "err less in simulation"),
    ("not-tested", "not tested"),
];

pub(super) fn claims(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    let claims = Recorded::of("claims.csv")?;
    let count = |(verdict, words): (&str, &str)| {
        let of = claims.rows.iter().filter(|row| row["verdict"].in_words() == verdict);
        format!("{} {words}", of.count())
    };
    let says = format!("Of {} claims: {}.", claims.rows.len(), list(VERDICTS.map(count), ", "));
    let section = section(study, ["claims", "The paper's claims"], || {
        let words = Format::Words;
        let all = [("claim", "claim", words), ("paper", "paper", words), ("ours", "ours", words)];
        let all = [&[("verdict", "verdict", words)], &all[..], &[("criterion", "criterion", words)]].concat();
        let every = details("All claims", vec![claims.table("The paper's claims", &all)]);
        let refuted = claims.keeping(|row| row["verdict"].in_words() == "refuted");
        let short = [("claim", "refuted", words), ("ours", "ours", words)];
        Ok(vec![refuted.table("Claims that the model contradicts", &short), every])
    })?;
    Ok(section.map(|section| section.saying([says])))
}

pub(super) fn table_two(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["table-two", "The paper's Table II"], || {
        let all = Recorded::of("table_two.csv")?;
        let of_group = |row: &Row| {
            let recorded = row["estimator"].in_words().starts_with("network of the paper");
            let noisy = number(row, "noise_mm") > Some(0.0);
            noisy && row["truth"].in_words() == "corotational" && (recorded || row["nodes"].in_words() == "mean")
        };
        let mut means = all.keeping(of_group);
        for row in &mut means.rows {
            let group = format!("{}: {}", row["group"].in_words(), row["quantity"].in_words());
            row.insert("group", group.trim_end_matches(" force").into());
        }
        let lines = means.errors("estimator", "group");
        let title = "Table II: one force, two neighbours, two nodes apart";
        let caption = "Mean error of each force and of the sum: measured in the paper, and in simulation with the camera's noise.";
        let groups = means.distinct("group");
        let figure = bars(title, caption, Axis::categories("contact nodes", groups.clone()), &lines, means.csv)?;
        let table = error_table("Mean error of each force and of the sum", "sensed by", &groups, &lines, means.csv);
        Ok(vec![figure, details("By estimator", vec![table])])
    })
}

pub(super) fn table_one(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["table-one", "The paper's Table I"], || {
        let table = Recorded::of("table_one.csv")?;
        let mut lines = table.errors("angle_deg", "node");
        for (name, _) in lines.iter_mut().skip(1) {
            *name = format!("uniform finger, weights at {name} deg");
        }
        let caption =
            "Mean error over six weights: measured in the paper, and computed from geometric nonlinearity alone.";
        let nodes = table.distinct("node");
        let axis = Axis::categories("loaded node, tip to base", nodes.clone());
        let figure = bars("Table I and geometric nonlinearity", caption, axis, &lines[..3], table.csv)?;
        let every = error_table("Mean error by loaded node", "", &nodes, &lines, table.csv);
        Ok(vec![figure, details("Every direction", vec![every])])
    })
}

/// Bar chart of mean errors, with one group of bars for each category and one bar for each line; the first line is the paper's.
fn bars(
    title: &str,
    caption: &str,
    categories: Axis,
    lines: &[(String, Vec<Option<f64>>)],
    csv: &str,
) -> Result<Block, ReportError> {
    let bars = lines.iter().enumerate().map(|(n, (name, errors))| {
        let hue = n.checked_sub(1).map_or(Hue::NEUTRAL, Hue::nth);
        error_bars(name.as_str(), hue, errors.iter().copied())
    });
    let frame = Frame::full(title, format!("{title}. {caption}"));
    let chart = Chart::of_bars(frame, [categories, Axis::linear("mean error, %")], bars.collect());
    let svg = chart.compared([TRUSTED_ERROR, GROSS_ERROR].map(|limit| (100.0 * limit, percent(limit)))).svg()?;
    Ok(Block::Figure(Figure::wide(svg, caption, csv)))
}

fn error_table(caption: &str, by: &str, places: &[String], lines: &[(String, Vec<Option<f64>>)], csv: &str) -> Block {
    let columns = Columns::<&(String, Vec<Option<f64>>)>::new()
        .page(by, Format::Words, |(name, _)| name.clone())
        .each(places.iter().enumerate(), |columns, (i, place)| {
            columns.page(place, Format::Error, move |(_, errors)| errors[i])
        });
    Block::Table(columns.table(caption, csv, lines))
}

pub(super) fn twin(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["twin", "One fit of Table I: the finger with softer ends"], || {
        let twin = Recorded::of("twin.csv")?;
        let rows: Vec<(String, &Row)> = twin.rows.iter().rev().map(|row| (row["node"].in_words(), row)).collect();
        let lines: [Line<&Row>; 5] = [
            ("paper", |row| Some(100.0 * number(row, "paper_mean_error")?)),
            ("uniform finger", |row| Some(100.0 * number(row, "uniform_finger")?)),
            ("softer ends", |row| Some(100.0 * number(row, "twin")?)),
            ("zones known, least squares", |row| Some(100.0 * number(row, "noisy_zones_least_squares")?)),
            ("zones known, nonlinear", |row| Some(100.0 * number(row, "noisy_zones_nonlinear")?)),
        ];
        let title = "Table I, the finger with softer ends";
        let caption = "The first three lines show Table I without noise. The last two show random forces with the camera's noise, sensed \
            with the zones in the model.";
        let drawing = by_contact(Frame::full(title, format!("{title}. {caption}")), "mean error, %", &rows, &lines)?;
        let sets = [
            ("zones", "zones softened", Format::Words),
            ("factor", "factor", Format::Fixed(3)),
            ("misfit", "misfit", Format::Fixed(2)),
        ];
        let sets = Recorded::of("twin_zone_sets.csv")?
            .table("Sets of zones fitted to Table I; a set fits the table if its misfit is below 1", &sets);
        let factors = [
            ("parameter", "parameter", Format::Words),
            ("found_over_true", "found / true", Format::Fixed(4)),
            ("sigma", "stated sigma", Format::Fixed(4)),
        ];
        let first = Recorded::of("twin_calibration.csv")?.keeping(|row| number(row, "repetition") == Some(1.0));
        let first = first.table("One of the calibrations", &factors);
        let figure = drawing.map(|svg| Block::Figure(Figure::wide(svg, caption, twin.csv)));
        Ok(figure.into_iter().chain([details("The fits, and how zones are calibrated", vec![sets, first])]).collect())
    })
}

const CONVERGENCE_CSV: &str = "convergence.csv";
const LATTICE_CSV: &str = "lattice.csv";
const AXIAL_CSV: &str = "lattice_axial_springs.csv";
const SETTLING_CSV: &str = "lattice_settling.csv";

/// Lines of the errors of a table by force, over a number of parts.
fn by_force(table: &Recorded, parts: &str) -> Vec<Series> {
    let line = |(n, force): (usize, String)| {
        let rows = table.rows.iter().filter(|row| row["force_n"].in_words() == force);
        let mut points: Vec<Point> =
            rows.filter_map(|row| Some([number(row, parts)?, number(row, "error")?])).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Series::nth(n, format!("{force} N"), points)
    };
    table.distinct("force_n").into_iter().enumerate().map(line).collect()
}

pub(super) fn convergence(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["convergence", "How fine a mesh must be"], || {
        let table = Recorded::of(CONVERGENCE_CSV)?;
        let alt = "Worst error of the displacements by number of mesh nodes, one line per force, both axes logarithmic";
        let frame = Frame::full("Error of the shape by mesh", alt).with_plot_height(300.0);
        let axes = [Axis::log("nodes of the mesh"), Axis::log("error / largest displacement").within(1e-9, 0.03)];
        let chart = Chart::new(frame, axes, by_force(&table, "mesh_nodes"));
        let svg = chart.compared([(0.01, "1 %".to_owned()), (1e-4, "0.01 %".to_owned())]).svg()?;
        let figure = Figure::wide(svg, "Worst error by number of mesh nodes, for each force.", CONVERGENCE_CSV);
        let shown = [
            ("force_n", "force, N", Format::Plain),
            ("mesh_nodes", "mesh nodes", Format::Plain),
            ("elements_a_member", "elements per member", Format::Plain),
            ("error", "error", Format::PercentTwoDigits),
            ("least_order", "least order", Format::Fixed(1)),
            ("greatest_order", "greatest order", Format::Fixed(1)),
            ("left_on_finest_mesh", "remaining error", Format::PercentTwoDigits),
        ];
        let all =
            table.table("Worst error; remaining error of the finest mesh by Roache's grid convergence index", &shown);
        Ok(vec![Block::Figure(figure), details("By mesh and force", vec![all])])
    })
}

pub(super) fn lattice(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    section(study, ["lattice", "Another discretisation: the spring lattice"], || {
        let by_fineness = Recorded::of(LATTICE_CSV)?;
        let alt = "Worst difference of the lattice's displacements from converged beams by number of plate segments between two key nodes, one line \
            per force, both axes logarithmic";
        let x = Axis::log("segments of plate between two key nodes").within(1.85, 6.5);
        let x = x.with_ticks(by_fineness.distinct("segments").iter().filter_map(|segments| segments.parse().ok()));
        let frame = Frame::full("Lattice against beams, by fineness", alt).with_plot_height(320.0);
        let axes = [x, Axis::log("difference / largest displacement")];
        let chart = Chart::new(frame, axes, by_force(&by_fineness, "segments"));
        let caption = "Worst difference of the lattice's equilibrium from converged beams, by force.";
        let figure = Block::Figure(Figure::wide(chart.svg()?, caption, LATTICE_CSV));
        let two = Format::PercentTwoDigits;
        let axial = [
            ("axial_springs", "axial springs", Format::Words),
            ("force_n", "force, N", Format::Plain),
            ("error", "difference", two),
        ];
        let axial = Recorded::of(AXIAL_CSV)?
            .table("Difference from converged beams by axial springs, none without an equilibrium", &axial);
        let settling = [
            ("sweeps", "sweeps per step", Format::Plain),
            ("positions", "precision", Format::Words),
            ("error", "difference, if it settles", two),
        ];
        let caption = "Difference of the settled lattice from its equilibrium. In single precision, positions and rotations are rounded (the engine's \
            single-precision build was not run)";
        let settling = Recorded::of(SETTLING_CSV)?.table(caption, &settling);
        Ok(vec![figure, details("Choice of springs, and settings of settling", vec![axial, settling])])
    })
}

pub(super) fn hard_cases(Results { study }: Results) -> Result<Option<Section>, ReportError> {
    let cases = Recorded::of("hard_cases.csv")?;
    let says =
        format!("All {} hard cases are answered soundly or refused with a reason.", cases.distinct("case").len());
    let section = section(study, ["hard-cases", "Hard cases"], || {
        let columns = Columns::<&Row>::new()
            .page("case", Format::Words, |row| row["case"].clone())
            .page("expected", Format::Words, |row| row["expectation"].clone())
            .page("figure", Format::Words, |row| row["quantity"].clone())
            .page("against", Format::Words, |row| row["source"].clone())
            .each(["reference", "ours", "tolerance"], |columns, key| {
                columns.page(key, Format::Plain, move |row| number(row, key).map(figure))
            })
            .cells("verdict", Format::Words, |row| {
                let [reference, ours, tolerance] = ["reference", "ours", "tolerance"].map(|key| number(row, key));
                let off = ours.zip(reference).map(|(ours, reference)| (ours - reference).abs());
                verdict(off.is_some() && off <= tolerance, ["pass", "fail"])
            });
        let table = columns.table("Figures of each case, with their tolerances", cases.csv, &cases.rows);
        Ok(vec![details("The cases", vec![Block::Table(table)])])
    })?;
    Ok(section.map(|section| section.saying([says])))
}
