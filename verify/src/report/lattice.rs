//! The finger as rigid bodies and springs: how near it is to beams, what that rests on, and what sensing makes of it.

#[cfg(test)]
mod samples;
mod tables;
mod words;

use super::dataset::Dataset;
use super::format::list;
use super::maps::map_csv_name;
use super::page::{Block, Figure, Section, text};
use super::{ReportError, Results, drawings};
use crate::check::worst;
use crate::experiments::lattice::LatticeStudy;
use crate::figures::{Axis, Chart, FigureError, Frame, Series};
use crate::lattice::accuracy::{FinenessRow, LoadGrid};
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;

const CSV: &str = "lattice.csv";
const AXIAL_CSV: &str = "lattice_axial_springs.csv";
const SETTLING_CSV: &str = "lattice_settling.csv";
/// Order of the guide in the figure: an error by the fourth power of the segments' length.
const GUIDE_ORDER: i32 = 4;
/// Room beside the first and the last point of the figure, as a factor of their places.
const BESIDE: f64 = 1.08;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    tables::datasets(study.lattice.as_ref())
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(lattice) = &study.lattice else { return Ok(None) };
    let mut blocks = vec![text(
        "The finger is built a second time, of rigid bodies with springs between them, in which no element or solver of the \
         beams is used. The springs' stiffnesses are EA / l, 12 EI / l^3 and EI / l of the same sections: agreement verifies solver and \
         co-rotational kinematics, not Euler-Bernoulli theory. Plates and ribs are cut into short segments, each an axial spring and two or three against bending. \
         The physics engine rapier2d lets the bodies move until they rest; where they rest, the springs' energy is \
         least, and Newton's method finds that equilibrium as well, which separates an error of the lattice from one of the \
         settling. No parameter is fitted. finray map --truth lattice maps any finger this way.",
    )];
    if lattice.settling.is_empty() {
        blocks.push(text(
            "This quick report compares equilibria alone, under fewer loads, on fewer finenesses and on coarser maps. A full \
             one also lets the lattice settle, says what sweeps and single precision cost, and holds the lattice to its \
             tolerances.",
        ));
    }
    blocks.push(Block::Table(tables::by_fineness(lattice)));
    blocks.push(Block::Figure(Figure {
        svg: drawing(&lattice.rows)?,
        caption: format!(
            "Worst difference of the lattice's equilibrium from converged beams by segments of plate between two key nodes, for \
             each force; {}.",
            loads_in_words(&lattice.loads[0])
        ),
        csv: Some(CSV.to_owned()),
        wide: true,
    }));
    blocks.push(Block::Table(tables::costs(lattice)));
    blocks.push(text("What agrees, what does not, and why:"));
    blocks.push(Block::List { items: words::findings(lattice) });
    blocks.push(Block::Table(tables::axial(lattice)));
    if !lattice.settling.is_empty() {
        blocks.push(Block::Table(tables::settling(lattice)));
    }
    blocks.push(Block::Figures { figures: vec![map_figure(study, lattice)?, sensing_figure(lattice)?] });
    let section = Section::new("lattice", "Another discretisation: the spring lattice", blocks);
    Ok(Some(section.saying(words::verdict(lattice))))
}

fn map_figure(study: &Study, lattice: &LatticeStudy) -> Result<Figure, ReportError> {
    let map = &lattice.sensing.least_squares;
    Ok(Figure {
        svg: drawings::map_figure_svg(&study.finger, map, Some(DRAWN_FORCE_N))?,
        caption: format!(
            "Sensed by linear least squares on the lattice, without noise; {DRAWN_FORCE_N} N; {}.",
            map.summary(Some(DRAWN_FORCE_N)).counts()
        ),
        csv: Some(map_csv_name(map)),
        wide: false,
    })
}

/// What each estimator errs by on the lattice, by position.
fn sensing_figure(lattice: &LatticeStudy) -> Result<Figure, ReportError> {
    let title = format!("lattice truth, no noise, {DRAWN_FORCE_N} N, worst direction");
    let series = lattice.sensing.maps().into_iter().enumerate().map(|(n, map)| {
        let worst = |&s_mm: &f64| {
            let here = map.cells.iter().filter(|cell| cell.s_mm == s_mm && cell.force_n == DRAWN_FORCE_N);
            let error = worst(here.filter_map(|cell| cell.mean_error));
            (error > 0.0).then_some([s_mm, 100.0 * error])
        };
        Series::nth(n, map.estimator.label(), map.request.positions_mm.iter().filter_map(worst).collect())
    });
    let alt = format!("{title}: error of the sensed force by position, one line an estimator.");
    let axes = [Axis::linear(drawings::ALONG_THE_PLATE), Axis::log("error |sensed / true - 1|, %")];
    let series = series.filter(|series| !series.points.is_empty()).collect();
    Ok(Figure {
        svg: Chart::new(Frame::half(title, alt), axes, series).svg()?,
        caption: format!(
            "The same force at its worst direction: least squares, and the nonlinear estimator, whose model is the \
             co-rotational finger, on {} directions ({}).",
            lattice.sensing.nonlinear.request.angles_deg.len(),
            lattice.sensing.nonlinear.summary(Some(DRAWN_FORCE_N)).counts()
        ),
        csv: Some(map_csv_name(&lattice.sensing.nonlinear)),
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
    format!("{nodes}, {} deg", list(&grid.angles_deg, ", "))
}

/// A series a force, and the slope of the fourth order from where the last begins.
fn drawing(rows: &[FinenessRow]) -> Result<String, FigureError> {
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
        let guide = vec![[*first, *error], [*last, error * (first / last).powi(GUIDE_ORDER)]];
        series.push(Series::guide("slope of the fourth order", guide));
    }
    let finenesses: Vec<f64> = rows.iter().map(|row| row.fineness as f64).collect();
    let widest = [f64::INFINITY, 0.0_f64];
    let ends = finenesses.iter().fold(widest, |[low, high], &x| [low.min(x / BESIDE), high.max(x * BESIDE)]);
    let alt = "Worst difference of the lattice's displacements from converged beams by segments of plate between two key nodes, a line \
               a force, both axes logarithmic";
    let x = Axis::log("segments of plate between two key nodes").within(ends[0], ends[1]).with_ticks(finenesses);
    let axes = [x, Axis::log("difference / largest displacement, %")];
    Chart::new(Frame::full("", alt).with_plot_height(320.0), axes, series).svg()
}

#[cfg(test)]
mod tests {
    use super::samples::sample;
    use super::tables::{axial, by_fineness, costs, datasets, settling};
    use super::*;

    #[test]
    fn a_line_a_force_and_the_guide_are_drawn() {
        let rows = sample().rows;
        let svg = drawing(&rows).expect("a figure");
        for words in [">1 N</text>", ">5 N</text>", ">slope of the fourth order</text>", ">2</text>", ">4</text>"] {
            assert!(svg.contains(words), "{words}");
        }
        // An error of nothing has no place on a logarithmic axis, and one fineness no slope.
        let one = FinenessRow { errors: vec![0.0, 1e-3], ..rows[0].clone() };
        let svg = drawing(&[one]).expect("a figure");
        assert!(!svg.contains(">1 N</text>") && !svg.contains("fourth order"));
    }

    #[test]
    fn both_estimators_are_drawn_and_their_cells_named() {
        let figure = sensing_figure(&sample()).expect("a figure");
        assert!(figure.svg.contains(">least squares</text>") && figure.svg.contains(">nonlinear</text>"));
        assert_eq!(figure.csv.as_deref(), Some("map_lattice_nonlinear_without_noise.csv"));
    }

    #[test]
    fn what_was_not_settled_is_not_shown() {
        let mut study = sample();
        let table = costs(&study);
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
        let last = |row: usize| table.rows[row].last().map(|cell| cell.text.clone());
        assert_eq!((last(0).as_deref(), last(1).as_deref()), (Some("0.0010 %"), Some("-")));
        study.rows[0].settling = None;
        let table = costs(&study);
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
        assert_eq!(table.columns.last().map(|column| column.name.as_str()), Some("Newton, ms"));
        assert!(!table.caption.contains("settle"));
        assert!(by_fineness(&study).rows.iter().all(|row| row.len() == 3));
    }

    #[test]
    fn what_has_no_equilibrium_or_does_not_settle_is_said() {
        let mut study = sample();
        let none = axial(&study).rows.pop().expect("springs left out");
        assert_eq!(none[4].text, "no equilibrium");
        let file = datasets(Some(&study))[1].csv().expect("text").expect("a file").1;
        assert_eq!(file.lines().filter(|line| line.ends_with(',')).count(), 2);
        (study.settling[4].error, study.settling[4].steps) = (None, None);
        let single = settling(&study).rows.pop().expect("single precision");
        assert_eq!(
            single.iter().map(|cell| cell.text.as_str()).collect::<Vec<_>>(),
            ["32", "single", "does not settle", "-"]
        );
    }
}
