//! The finger as rigid bodies and springs: how near it is to beams, what that rests on, and what sensing makes of it.

mod words;

use super::ReportError;
use super::convergence::percent;
use super::drawings;
use super::figures::{self, Axis, Dash, FigureError, Frame, Hue, LineChart, Series};
use super::page::{Block, Cell, Column, Figure, Row, Section, Table};
use super::sections::{self, text};
use super::tables;
use crate::lattice::accuracy::{FinenessRow, LoadGrid};
use crate::lattice::settling::Precision;
use crate::lattice::study::LatticeStudy;
use crate::map::AccuracyMap;
use crate::problems::lattice::FINENESS;
use crate::study::{DRAWN_FORCE_N, Study};
use serde::Serialize;

pub(super) use words::verdict;

pub(super) const CSV: &str = "lattice.csv";
pub(super) const AXIAL_CSV: &str = "lattice_axial_springs.csv";
pub(super) const SETTLING_CSV: &str = "lattice_settling.csv";
/// Order of the guide in the figure: an error by the fourth power of the segments' length.
const GUIDE_ORDER: i32 = 4;

/// Error and cost of one fineness at one force, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticeRow {
    /// Segments in a stretch of plate between two key nodes.
    pub segments_a_stretch: usize,
    /// Rigid bodies.
    pub bodies: usize,
    /// Springs.
    pub springs: usize,
    /// Force, N.
    pub force_n: f64,
    /// Largest difference of the lattice's equilibrium from converged beams / largest displacement.
    pub error: f64,
    /// Newton's method through all the forces under one load, ms.
    pub newton_ms: f64,
    /// Largest difference of the settled lattice from its equilibrium / largest displacement.
    pub settling_error: Option<f64>,
    /// Steps to rest.
    pub settling_steps: Option<usize>,
    /// Settling under one load, ms.
    pub settling_ms: Option<f64>,
}

/// Error of the lattice with some axial springs at one force, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxialSpringsRow {
    /// The springs, in words.
    pub axial_springs: &'static str,
    /// Share of a segment's length by which their points lie inside it.
    pub inset: f64,
    /// Stiffness in units of EA / l.
    pub stiffness: f64,
    /// Force, N.
    pub force_n: f64,
    /// Largest difference from converged beams / largest displacement; none where the lattice has no stable equilibrium.
    pub error: Option<f64>,
}

/// One way of settling, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettlingRow {
    /// Sweeps over the springs in a step.
    pub sweeps: usize,
    /// Precision that positions are kept in: `double` or `single`.
    pub positions: &'static str,
    /// Largest difference from the lattice's equilibrium / largest displacement; none if it does not settle.
    pub error: Option<f64>,
    /// Steps to rest.
    pub steps: Option<usize>,
}

pub(super) fn rows(lattice: &LatticeStudy) -> impl Iterator<Item = LatticeRow> {
    lattice.rows.iter().flat_map(|row| {
        row.forces_n.iter().zip(&row.errors).map(|(&force_n, &error)| LatticeRow {
            segments_a_stretch: row.fineness,
            bodies: row.bodies,
            springs: row.springs,
            force_n,
            error,
            newton_ms: row.newton_ms,
            settling_error: row.settling.map(|cost| cost.error),
            settling_steps: row.settling.map(|cost| cost.steps),
            settling_ms: row.settling.map(|cost| cost.ms),
        })
    })
}

pub(super) fn axial_rows(lattice: &LatticeStudy) -> impl Iterator<Item = AxialSpringsRow> {
    lattice.axial.iter().flat_map(|row| {
        lattice.axial_forces_n.iter().enumerate().map(|(force, &force_n)| AxialSpringsRow {
            axial_springs: row.name,
            inset: row.axial.inset,
            stiffness: row.axial.stiffness,
            force_n,
            error: row.errors.as_ref().map(|errors| errors[force]),
        })
    })
}

pub(super) fn settling_rows(lattice: &LatticeStudy) -> impl Iterator<Item = SettlingRow> {
    lattice.settling.iter().map(|row| SettlingRow {
        sweeps: row.sweeps,
        positions: precision(row.positions),
        error: row.error,
        steps: row.steps,
    })
}

fn precision(positions: Precision) -> &'static str {
    match positions {
        Precision::Double => "double",
        Precision::Single => "single",
    }
}

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    let Some(lattice) = &study.lattice else { return Ok(None) };
    let mut blocks = vec![text(
        "The finger is built a second time, of rigid bodies with springs between them, in which no element or solver of the \
         beams is used. Plates and ribs are cut into short segments, each an axial spring and two or three against bending. \
         The physics engine rapier2d lets the bodies move until they rest; where they rest, the springs' energy is \
         least, and Newton's method finds that equilibrium as well, which tells an error of the lattice from one of the \
         settling. No parameter is fitted. finray map --truth lattice maps any finger this way.",
    )];
    if lattice.settling.is_empty() {
        blocks.push(text(
            "This quick report compares equilibria alone, under fewer loads, on fewer finenesses and on coarser maps. A full \
             one also lets the lattice settle, says what sweeps and single precision cost, and holds the lattice to its \
             promises.",
        ));
    }
    blocks.push(Block::Table(by_fineness(lattice)));
    blocks.push(Block::Figure(Figure {
        svg: picture(&lattice.rows)?,
        caption: format!(
            "Worst difference of the lattice's equilibrium from converged beams by segments in a stretch of plate, for \
             each force; {}.",
            loads_in_words(&lattice.loads[0])
        ),
        csv: Some(CSV.to_owned()),
        wide: true,
    }));
    blocks.push(text("What agrees, what does not, and why:"));
    blocks.push(Block::List { items: words::findings(lattice) });
    blocks.push(Block::Table(axial(lattice)));
    if !lattice.settling.is_empty() {
        blocks.push(Block::Table(settling(lattice)));
    }
    let figures = lattice.sensing.maps().map(|map| map_figure(study, map)).into_iter().collect::<Result<_, _>>()?;
    blocks.push(Block::Figures { figures });
    Ok(Some(sections::section("lattice", "A second physics: the spring lattice", blocks)))
}

fn map_figure(study: &Study, map: &AccuracyMap) -> Result<Figure, ReportError> {
    Ok(Figure {
        svg: drawings::map_picture(&study.finger, map, Some(DRAWN_FORCE_N))?,
        caption: format!(
            "Sensed {} on the lattice, without noise; {DRAWN_FORCE_N} N.",
            match map.estimator.as_str() {
                "nonlinear" => "by the nonlinear estimator, whose model is the large-rotation finger,",
                _ => "by linear least squares",
            }
        ),
        csv: Some(tables::map_csv_name(map)),
        wide: false,
    })
}

/// Nodes and directions of a grid of loads.
fn loads_in_words(grid: &LoadGrid) -> String {
    let nodes = match (grid.nodes.iter().min(), grid.nodes.iter().max()) {
        (Some(low), Some(high)) if low < high => format!("{} nodes of {low} to {high}", grid.nodes.len()),
        (Some(one), _) => format!("node {one}"),
        _ => "no node".to_owned(),
    };
    let angles: Vec<String> = grid.angles_deg.iter().map(f64::to_string).collect();
    format!("{nodes}, {} deg", angles.join(", "))
}

/// A series a force, and the slope of the fourth order from where the last begins.
fn picture(rows: &[FinenessRow]) -> Result<String, FigureError> {
    let forces_n = rows.first().map_or(&[][..], |row| &row.forces_n);
    let mut series: Vec<Series> = forces_n
        .iter()
        .enumerate()
        .map(|(n, force_n)| {
            let points = rows.iter().map(|row| [row.fineness as f64, 100.0 * row.errors[n]]);
            Series::nth(n, format!("{force_n} N"), points.filter(|point| point[1] > 0.0).collect())
        })
        .filter(|series| !series.points.is_empty())
        .collect();
    if let Some([[first, error], .., [last, _]]) = series.last().map(|series| &series.points[..]) {
        let guide = Series {
            label: "slope of the fourth order".to_owned(),
            points: vec![[*first, *error], [*last, error * (first / last).powi(GUIDE_ORDER)]],
            hue: Hue::Neutral,
            dash: Some(Dash::Dotted),
            marker: None,
            spread: figures::Spread::None,
        };
        series.push(guide);
    }
    figures::lines(&LineChart {
        frame: Frame::full(
            "",
            "Worst difference of the lattice's displacements from converged beams by segments in a stretch of plate, a line \
             a force, both axes logarithmic",
        )
        .with_plot_height(320.0),
        x: Axis::log("segments in a stretch of plate").with_ticks(rows.iter().map(|row| row.fineness as f64).collect()),
        y: Axis::log("difference / largest displacement, %"),
        series,
        references: Vec::new(),
    })
}

fn by_fineness(lattice: &LatticeStudy) -> Table {
    let forces_n = lattice.rows.first().map_or(&[][..], |row| &row.forces_n);
    let settles = lattice.rows.iter().any(|row| row.settling.is_some());
    let row = |row: &FinenessRow| {
        let counts = [row.fineness, row.bodies, row.springs].map(|count| count.to_string());
        let errors = row.errors.iter().copied().map(percent);
        let settling = match row.settling {
            Some(cost) => [percent(cost.error), cost.steps.to_string(), milliseconds(cost.ms)],
            None => ["-"; 3].map(str::to_owned),
        };
        let cells = counts.into_iter().chain(errors).chain([milliseconds(row.newton_ms)]);
        Row { cells: cells.chain(settling.into_iter().filter(|_| settles)).map(Cell::plain).collect() }
    };
    let counts = ["segments a stretch", "bodies", "springs"].map(str::to_owned);
    let errors = forces_n.iter().map(|force_n| format!("{force_n} N"));
    let settling = ["settled against equilibrium", "steps", "settling, ms"].map(str::to_owned);
    let columns = counts.into_iter().chain(errors).chain(["Newton, ms".to_owned()]);
    let settled = match settles {
        true => format!(
            "; settling, which takes ever longer as segments are shorter: {}, {} N",
            loads_in_words(&lattice.loads[1]),
            lattice.loads[1].forces_n.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
        ),
        false => String::new(),
    };
    Table {
        caption: format!(
            "The lattice's equilibrium against converged beams, as a share of the largest displacement ({}), and the time on \
             one core of Newton's method through all the forces{settled}",
            loads_in_words(&lattice.loads[0])
        ),
        columns: columns.chain(settling.into_iter().filter(|_| settles)).map(Column::numbers).collect(),
        rows: lattice.rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}

fn milliseconds(ms: f64) -> String {
    if ms < 10.0 { format!("{ms:.1}") } else { format!("{ms:.0}") }
}

fn axial(lattice: &LatticeStudy) -> Table {
    let rows = lattice.axial.iter().map(|row| {
        let errors = (0..lattice.axial_forces_n.len()).map(|force| match &row.errors {
            Some(errors) => Cell { text: percent(errors[force]), ..tables::error(errors[force]) },
            None => Cell::plain("no equilibrium"),
        });
        let numbers = [format!("{:.3}", row.axial.inset), row.axial.stiffness.to_string()].map(Cell::plain);
        Row { cells: [Cell::plain(row.name)].into_iter().chain(numbers).chain(errors).collect() }
    });
    let forces = lattice.axial_forces_n.iter().map(|force_n| Column::numbers(format!("{force_n} N")));
    Table {
        caption: format!(
            "What the axial springs matter: the lattice of {FINENESS} segments a stretch against converged beams, by where \
             their points lie and how stiff they are"
        ),
        columns: [Column::words("axial springs")]
            .into_iter()
            .chain(["inset / length", "stiffness / (EA / l)"].map(Column::numbers))
            .chain(forces)
            .collect(),
        rows: rows.collect(),
        csv: Some(AXIAL_CSV.to_owned()),
    }
}

fn settling(lattice: &LatticeStudy) -> Table {
    let rows = settling_rows(lattice).map(|row| Row {
        cells: [
            row.sweeps.to_string(),
            row.positions.to_owned(),
            row.error.map_or_else(|| "does not settle".to_owned(), percent),
            row.steps.map_or_else(|| "-".to_owned(), |steps| steps.to_string()),
        ]
        .map(Cell::plain)
        .into(),
    });
    Table {
        caption: format!(
            "What settling matters: the settled lattice of {FINENESS} segments a stretch against its own equilibrium ({}, {} N)",
            loads_in_words(&lattice.settled),
            lattice.settled.forces_n.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
        ),
        columns: vec![
            Column::numbers("sweeps a step"),
            Column::words("positions kept in precision"),
            Column::numbers("largest difference"),
            Column::numbers("most steps"),
        ],
        rows: rows.collect(),
        csv: Some(SETTLING_CSV.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::accuracy::SettlingCost;
    use crate::lattice::causes::{self, AXIAL_SPRINGS, AxialRow, SETTLINGS};
    use crate::lattice::study::{LatticeSensing, MapDifference};
    use crate::map::{Cell as MapCell, MapRequest};
    use finray_model::NodeId;

    /// Least squares or the nonlinear estimator, off by `error` in its one cell.
    fn map(estimator: &str, error: f64) -> AccuracyMap {
        let request = MapRequest {
            places_mm: vec![76.5],
            angles_deg: vec![20.0],
            forces_n: vec![3.0],
            noise_levels_mm: vec![0.0],
            noise_pictures: 1,
            seed: 1,
        };
        let cell = MapCell {
            s_mm: 76.5,
            angle_deg: 20.0,
            force_n: 3.0,
            mean_error: Some(error),
            bias: Some(error),
            spread: Some(0.0),
        };
        AccuracyMap {
            request,
            truth: "lattice".to_owned(),
            estimator: estimator.to_owned(),
            noise_mm: 0.0,
            cells: vec![cell],
        }
    }

    /// A study of 2 and 4 segments a stretch: errors that fall to an eighth at 1 N and to a sixteenth at 5 N.
    pub(super) fn sample() -> LatticeStudy {
        let row = |fineness: usize, errors: [f64; 2], settling| FinenessRow {
            fineness,
            bodies: 40 * fineness,
            springs: 200 * fineness,
            forces_n: vec![1.0, 5.0],
            errors: errors.into(),
            newton_ms: 12.3,
            settling,
        };
        let loads =
            LoadGrid { nodes: vec![NodeId(14), NodeId(18)], angles_deg: vec![-60.0, 60.0], forces_n: vec![1.0, 5.0] };
        let axial = AXIAL_SPRINGS.into_iter().zip([Some(0.0016), Some(0.03), Some(0.7), None]);
        let settling = SETTLINGS.into_iter().zip([Some(0.02), Some(5e-4), Some(6e-5), Some(6e-5), Some(7e-4)]);
        let (least_squares, nonlinear) = (map("least-squares", 0.2), map("nonlinear", 4e-4));
        LatticeStudy {
            rows: vec![
                row(2, [8e-4, 1.6e-3], Some(SettlingCost { error: 1e-5, steps: 2331, ms: 512.4 })),
                row(4, [1e-4, 1e-4], None),
            ],
            loads: [loads.clone(), loads.clone()],
            axial: axial
                .map(|((name, axial), error)| AxialRow { name, axial, errors: error.map(|error| vec![error; 2]) })
                .collect(),
            axial_forces_n: vec![1.0, 5.0],
            settling: settling
                .map(|((sweeps, positions), error)| causes::SettlingRow { sweeps, positions, error, steps: Some(2000) })
                .collect(),
            settled: loads,
            out_of_balance: 6e-4,
            problem_checks: Vec::new(),
            comparisons: Vec::new(),
            linear: vec![(1.0, 0.1), (5.0, 0.5)],
            sensing: LatticeSensing {
                difference: MapDifference::of(&least_squares, &map("least-squares", 0.2003)),
                least_squares,
                nonlinear,
            },
        }
    }

    #[test]
    fn a_line_a_force_and_the_guide_are_drawn() {
        let rows = sample().rows;
        let svg = picture(&rows).expect("a figure");
        for words in [">1 N</text>", ">5 N</text>", ">slope of the fourth order</text>", ">2</text>", ">4</text>"] {
            assert!(svg.contains(words), "{words}");
        }
        // An error of nothing has no place on a logarithmic axis, and one fineness no slope.
        let one = FinenessRow { errors: vec![0.0, 1e-3], ..rows[0].clone() };
        let svg = picture(&[one]).expect("a figure");
        assert!(!svg.contains(">1 N</text>") && !svg.contains("fourth order"));
    }

    #[test]
    fn what_was_not_settled_is_not_shown() {
        let mut study = sample();
        let table = by_fineness(&study);
        assert!(table.rows.iter().all(|row| row.cells.len() == table.columns.len()));
        let last = |row: usize| table.rows[row].cells.last().map(|cell| cell.text.clone());
        assert_eq!((last(0).as_deref(), last(1).as_deref()), (Some("512"), Some("-")));
        study.rows[0].settling = None;
        let table = by_fineness(&study);
        assert!(table.rows.iter().all(|row| row.cells.len() == table.columns.len()));
        assert_eq!(table.columns.last().map(|column| column.name.as_str()), Some("Newton, ms"));
        assert!(!table.caption.contains("settling"));
    }

    #[test]
    fn what_has_no_equilibrium_or_does_not_settle_is_said() {
        let mut study = sample();
        let none = axial(&study).rows.pop().expect("springs left out");
        assert_eq!(none.cells[4].text, "no equilibrium");
        assert_eq!(axial_rows(&study).filter(|row| row.error.is_none()).count(), 2);
        (study.settling[4].error, study.settling[4].steps) = (None, None);
        let single = settling(&study).rows.pop().expect("single precision");
        assert_eq!(
            single.cells.iter().map(|cell| cell.text.as_str()).collect::<Vec<_>>(),
            ["32", "single", "does not settle", "-"]
        );
    }
}
