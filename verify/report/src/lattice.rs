//! The finger as a lattice of rigid bodies and springs: difference from beams, choice of the springs, and sensing on the lattice.

pub mod words;

use super::drawings;
use super::format::{error_as, percent_two_digits};
use super::maps::map_csv_name;
use crate::prelude::*;
use finray_lattice::settling::Precision;
use finray_studies::experiments::lattice::LatticeStudy;
use finray_studies::lattice::accuracy::FinenessRow;
use finray_studies::lattice::causes::{AxialRow, SettlingRow};
use finray_studies::problems::lattice::FINENESS;

const CSV: &str = "lattice.csv";
const AXIAL_CSV: &str = "lattice_axial_springs.csv";
const SETTLING_CSV: &str = "lattice_settling.csv";
/// The figure's axis extends beyond the first and the last point by this factor.
const BESIDE: f64 = 1.08;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    data(study.lattice.as_ref())
}

/// Datasets of the section: errors and times by fineness and force, errors with other axial springs, and errors with several settings for settling
/// the lattice.
pub fn data(lattice: Option<&LatticeStudy>) -> Vec<Dataset<'_>> {
    // Errors are relative to the largest displacement. `error` compares the equilibrium of the lattice with converged beams; `settling_error`
    // compares the settled lattice with the equilibrium of the lattice.
    let fineness = Columns::<(&FinenessRow, usize)>::new()
        .file("segments_a_stretch", |(row, _)| row.fineness)
        .file("bodies", |(row, _)| row.bodies)
        .file("springs", |(row, _)| row.springs)
        .file("force_n", |(row, force)| row.forces_n[*force])
        .file("error", |(row, force)| row.errors[*force])
        .file("newton_ms", |(row, _)| row.newton_ms)
        .file("settling_error", |(row, _)| Some(row.settling?.error))
        .file("settling_steps", |(row, _)| Some(row.settling?.steps))
        .file("settling_ms", |(row, _)| Some(row.settling?.ms));
    let axial = Columns::<(&AxialRow, usize, f64)>::new()
        .file("axial_springs", |(row, ..)| row.name)
        .file("inset", |(row, ..)| row.axial.inset)
        .file("stiffness", |(row, ..)| row.axial.stiffness)
        .file("force_n", |(.., force_n)| *force_n)
        .file("error", |(row, force, _)| row.errors.as_ref().map(|errors| errors[*force]));
    let lattices = || lattice.into_iter();
    let by_force = lattices().flat_map(|lattice| &lattice.rows);
    let by_force = by_force.flat_map(|row| (0..row.forces_n.len()).map(move |force| (row, force)));
    let axial_by_force = lattices().flat_map(|lattice| {
        let forces = move |row| lattice.axial_forces_n.iter().enumerate().map(move |(i, force_n)| (row, i, *force_n));
        lattice.axial.iter().flat_map(forces)
    });
    vec![
        Dataset::new(CSV, &fineness, by_force),
        Dataset::new(AXIAL_CSV, &axial, axial_by_force),
        Dataset::new(SETTLING_CSV, &settled(), lattices().flat_map(|lattice| &lattice.settling)),
    ]
}

/// Settings of settling: sweeps and precision. The error is missing if the lattice does not settle.
pub fn settled<'s>() -> Columns<'s, &'s SettlingRow> {
    Columns::<&SettlingRow>::new()
        .both("sweeps", "sweeps per step", Format::Plain, |row| row.sweeps)
        .both("positions", "precision", Format::Words, |row| match row.positions {
            Precision::Double => "double",
            Precision::Single => "single",
        })
        .both("error", "difference, if it settles", Format::PercentTwoDigits, |row| row.error)
        .file("steps", |row| row.steps)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(lattice) = &study.lattice else { return Ok(None) };
    let mut blocks = vec![text(words::ABOUT)];
    if lattice.settling.is_empty() {
        blocks.push(text("This quick report compares only equilibria, under fewer loads."));
    }
    let caption = "Worst difference of the lattice's equilibrium from converged beams, by force.";
    blocks.push(Block::Figure(Figure::wide(drawing(&lattice.rows)?, caption, CSV)));
    blocks.push(Block::List(words::findings(lattice)));
    blocks.push(Block::Figures(vec![map_figure(study, lattice)?, sensing_figure(lattice)?]));
    let mut folded = vec![text(words::SPRINGS), Block::Table(axial(lattice))];
    if !lattice.settling.is_empty() {
        let caption = "Difference of the settled lattice from its equilibrium. In single precision, positions and rotations are rounded (the \
                       engine's single-precision build was not run)";
        folded.push(Block::Table(settled().table(caption, SETTLING_CSV, &lattice.settling)));
    }
    folded.push(text(words::precision(lattice)));
    blocks.push(details("Choice of springs, and settings of settling", folded));
    let section = Section::new("lattice", "Another discretisation: the spring lattice", blocks);
    Ok(Some(section.saying(words::verdict(lattice))))
}

/// Table of the difference from beams for several choices of axial springs.
pub fn axial(lattice: &LatticeStudy) -> Table {
    let cell = |row: &&AxialRow, force: usize| match &row.errors {
        Some(errors) => error_as(percent_two_digits(errors[force]), errors[force]),
        None => Cell::plain("no equilibrium"),
    };
    let caption = format!("Difference from converged beams, {FINENESS} segments per plate member");
    Columns::<&AxialRow>::new()
        .page("axial springs", Format::Words, |row| row.name)
        .each(lattice.axial_forces_n.iter().enumerate(), |columns, (i, force_n)| {
            columns.cells(format!("{force_n} N"), Format::Plain, move |row| cell(row, i))
        })
        .table(caption, AXIAL_CSV, &lattice.axial)
}

fn map_figure(study: &Study, lattice: &LatticeStudy) -> Result<Figure, ReportError> {
    let (map, force_n) = (&lattice.sensing.least_squares, lattice.sensing.largest_n());
    let svg = drawings::map_figure_svg(&study.finger, map, Some(force_n))?;
    let caption = format!("Least squares; {}.", map.summary(Some(force_n)).counts());
    Ok(Figure::narrow(svg, caption, map_csv_name(map)))
}

/// Chart of each estimator's error on the lattice, by position.
pub fn sensing_figure(lattice: &LatticeStudy) -> Result<Figure, ReportError> {
    let force_n = lattice.sensing.largest_n();
    let title = format!("true finger: lattice, no noise, {force_n} N, worst direction");
    let series = lattice.sensing.maps().into_iter().enumerate().map(|(n, map)| {
        let worst = |&s_mm: &f64| {
            let here = map.cells.iter().filter(|cell| cell.s_mm == s_mm && cell.force_n == force_n);
            let error = worst(here.filter_map(|cell| cell.mean_error));
            (error > 0.0).then_some([s_mm, 100.0 * error])
        };
        Series::nth(n, map.estimator.label(), map.request.positions_mm.iter().filter_map(worst).collect())
    });
    let alt = format!("{title}: error of the sensed force by position, one line per estimator.");
    let axes = [Axis::linear(drawings::ALONG_THE_PLATE), Axis::log("error |sensed / true - 1|, %")];
    let series = series.filter(|series| !series.points.is_empty()).collect();
    let (svg, nonlinear) = (Chart::new(Frame::half(title, alt), axes, series).svg()?, &lattice.sensing.nonlinear);
    let caption =
        format!("Errors at the worst direction. Nonlinear estimator: {}.", nonlinear.summary(Some(force_n)).counts());
    Ok(Figure::narrow(svg, caption, map_csv_name(nonlinear)))
}

/// Chart of the difference from beams over the fineness, one series per force.
pub fn drawing(rows: &[FinenessRow]) -> Result<String, FigureError> {
    let forces_n = rows.first().map_or(&[][..], |row| &row.forces_n);
    let series: Vec<Series> = forces_n
        .iter()
        .enumerate()
        .map(|(n, force_n)| {
            let points = rows.iter().map(|row| [row.fineness as f64, row.errors[n]]);
            Series::nth(n, format!("{force_n} N"), points.filter(|point| point[1] > 0.0).collect())
        })
        .filter(|series| !series.points.is_empty())
        .collect();
    let finenesses: Vec<f64> = rows.iter().map(|row| row.fineness as f64).collect();
    let widest = [f64::INFINITY, 0.0_f64];
    let ends = finenesses.iter().fold(widest, |[low, high], &x| [low.min(x / BESIDE), high.max(x * BESIDE)]);
    let alt = "Worst difference of the lattice's displacements from converged beams by number of plate segments between two \
        key nodes, one line per force, both axes logarithmic";
    let x = Axis::log("segments of plate between two key nodes").within(ends[0], ends[1]).with_ticks(finenesses);
    let axes = [x, Axis::log("difference / largest displacement")];
    Chart::new(Frame::full("Lattice against beams, by fineness", alt).with_plot_height(320.0), axes, series).svg()
}
