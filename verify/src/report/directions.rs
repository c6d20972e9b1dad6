//! Forces of unknown direction: where they can be told.

use super::ReportError;
use super::drawings::{ALONG_THE_PLATE, percent_line, plate_map};
use super::page::{Block, Figure, Section};
use super::sections::{self, text};
use super::tables::percent;
use crate::experiments::direction::{
    Assumption, DirectionCell, DirectionStudy, FORCES_N, FrictionlessPush, TOLD_ANSWERED, TOLD_DEG, TOLD_FORCE,
};
use crate::figures::{Axis, Cells, Chart, ColourScale, FigureError, Frame, Map, Series, Shades};
use crate::study::Study;
use finray_model::Finger;
use serde::Serialize;

pub(super) const CSV: &str = "directions.csv";
pub(super) const FRICTIONLESS_CSV: &str = "directions_without_friction.csv";
/// Colours of errors of a direction, degrees, and of a force, %.
const COLOURS: [f64; 2] = [0.1, 100.0];

/// One force at one place in one direction, sensed with the direction unknown; errors are root mean squares.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DirectionRow {
    /// Place on the front plate, mm from the base.
    pub s_mm: f64,
    /// True direction, degrees from the undeformed inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Noise pictures; none where the finger carries no such force.
    pub pictures: usize,
    /// Pictures that were answered.
    pub answered: usize,
    /// Whether direction and force are told.
    pub told: bool,
    /// Error of the direction, degrees.
    pub angle_error_deg: Option<f64>,
    /// Its Cramer-Rao bound, degrees.
    pub angle_bound_deg: Option<f64>,
    /// Error of the force as a share of it.
    pub force_error: Option<f64>,
    /// Its Cramer-Rao bound.
    pub force_bound: Option<f64>,
    /// Standard deviation that the estimator states of the force, as a share of it.
    pub force_sigma: Option<f64>,
}

/// A push along the deformed normal, sensed under an assumption; errors are root mean squares.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrictionlessRow {
    /// The contact node.
    pub node: usize,
    /// Its place on the front plate, mm from the base.
    pub s_mm: f64,
    /// True force, N.
    pub force_n: f64,
    /// Direction of the push, degrees from the undeformed normal; `None` where the finger carries no such push.
    pub angle_deg: Option<f64>,
    /// `undeformed`, `normal` or `unknown` direction.
    pub assumed: Assumption,
    /// Noise pictures.
    pub pictures: usize,
    /// Pictures that were answered.
    pub answered: usize,
    /// Error of the direction, degrees.
    pub angle_error_deg: Option<f64>,
    /// Error of the force as a share of it.
    pub force_error: Option<f64>,
    /// Standard deviation that the estimator states of the force, as a share of it.
    pub force_sigma: Option<f64>,
}

pub(super) fn rows(directions: &DirectionStudy) -> impl Iterator<Item = DirectionRow> {
    directions.cells.iter().map(|cell| DirectionRow {
        s_mm: cell.s_mm,
        angle_deg: cell.angle_deg,
        force_n: cell.force_n,
        pictures: cell.answers.pictures,
        answered: cell.answers.answered,
        told: cell.answers.told(),
        angle_error_deg: cell.answers.angle_error_deg,
        angle_bound_deg: cell.angle_bound_deg,
        force_error: cell.answers.force_error,
        force_bound: cell.force_bound,
        force_sigma: cell.answers.force_sigma,
    })
}

pub(super) fn frictionless_rows(directions: &DirectionStudy) -> impl Iterator<Item = FrictionlessRow> {
    directions.without_friction.iter().map(|push| FrictionlessRow {
        node: push.node,
        s_mm: push.s_mm,
        force_n: push.force_n,
        angle_deg: push.angle_deg,
        assumed: push.assumed,
        pictures: push.answers.pictures,
        answered: push.answers.answered,
        angle_error_deg: push.answers.angle_error_deg,
        force_error: push.answers.force_error,
        force_sigma: push.answers.force_sigma,
    })
}

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    let Some(directions) = &study.directions else { return Ok(None) };
    let finger = &study.finger;
    let mut blocks = vec![text(format!(
        "The paper takes the direction of a force as known: with size and direction both unknown, sensing \"will not work\" \
         (Fig. 13). Here the nonlinear estimator is told the place alone, under {} mm of noise, {} pictures a cell. A cell \
         counts as told where the direction is known to {TOLD_DEG} deg and the force to {} (root mean squares) and at least {} of the \
         pictures are answered; the rest is hatched. What the noise leaves open, the estimator refuses rather than guesses.",
        directions.noise_mm,
        directions.pictures,
        percent(TOLD_FORCE),
        percent(TOLD_ANSWERED)
    ))];
    blocks.extend(where_told(directions).map(text));
    let told = |cell: &DirectionCell| cell.answers.angle_error_deg.filter(|_| cell.answers.told());
    let answered = |cell: &DirectionCell| cell.answers.angle_error_deg;
    let force = |cell: &DirectionCell| cell.answers.force_error.map(|error| 100.0 * error);
    let bound = |cell: &DirectionCell| cell.angle_bound_deg;
    let all = |map: &Shown| -> Result<Block, FigureError> {
        let figures = FORCES_N.map(|force_n| map.figure(finger, directions, force_n));
        Ok(Block::Figures { figures: figures.into_iter().collect::<Result<_, _>>()? })
    };
    blocks.push(all(&Shown {
        what: "error of the direction, deg",
        line: None,
        missing: "cannot be told",
        value: &told,
    })?);
    blocks.push(Block::Details {
        summary: "The least that any estimator can reach, and the errors of all answers".to_owned(),
        blocks: vec![
            all(&Shown {
                what: "Cramer-Rao bound of the direction, deg",
                line: Some(TOLD_DEG),
                missing: "open",
                value: &bound,
            })?,
            all(&Shown {
                what: "error of answered directions, deg",
                line: Some(TOLD_DEG),
                missing: "no answer",
                value: &answered,
            })?,
            all(&Shown {
                what: "error of answered forces, %",
                line: Some(100.0 * TOLD_FORCE),
                missing: "no answer",
                value: &force,
            })?,
        ],
    });
    blocks.extend(without_friction(directions).map(text));
    let charts = [FORCES_N[0], FORCES_N[2]].map(|force_n| frictionless_chart(directions, force_n));
    blocks.push(Block::Figures { figures: charts.into_iter().collect::<Result<_, FigureError>>()? });
    Ok(Some(sections::section("directions", "Unknown directions", blocks)))
}

/// One quantity by place and direction.
struct Shown<'v> {
    what: &'v str,
    /// Where a line is drawn.
    line: Option<f64>,
    missing: &'v str,
    value: &'v dyn Fn(&DirectionCell) -> Option<f64>,
}

impl Shown<'_> {
    fn figure(&self, finger: &Finger, directions: &DirectionStudy, force_n: f64) -> Result<Figure, FigureError> {
        let Shown { what, line, missing, value } = *self;
        let cells: Vec<&DirectionCell> = directions.cells.iter().filter(|cell| cell.force_n == force_n).collect();
        let mut places: Vec<f64> = cells.iter().map(|cell| cell.s_mm).collect();
        places.dedup();
        let angles: Vec<f64> =
            cells.iter().take_while(|cell| Some(&cell.s_mm) == places.first()).map(|cell| cell.angle_deg).collect();
        // Cells go by place, then direction; rows of the map by direction, then place.
        let row = |angle| cells.iter().skip(angle).step_by(angles.len().max(1)).map(|cell| value(cell)).collect();
        let title = format!("{force_n} N");
        let frame = Frame::half(&title, format!("{title}: {what}, by place and true direction of the force."));
        let values = (0..angles.len()).map(row).collect();
        let shades = Shades::Scale(ColourScale::log(COLOURS[0], COLOURS[1]), what.to_owned());
        let cells = Cells::new(&places, &angles, values);
        let map = Map { missing_label: missing.to_owned(), ..plate_map(finger, frame, shades, cells) };
        Ok(Figure {
            svg: Map { contours: line.into_iter().collect(), ..map }.svg()?,
            caption: format!("{force_n} N: {what}, by place and true direction; hatched: {missing}."),
            csv: Some(CSV.to_owned()),
            wide: false,
        })
    }
}

/// At how many places and in which directions both are told.
fn where_told(directions: &DirectionStudy) -> Option<String> {
    let shares: Vec<String> = FORCES_N
        .iter()
        .filter_map(|&force_n| {
            let [told, all] = directions.told(force_n);
            (all > 0).then(|| format!("{} at {force_n} N", percent(told as f64 / all as f64)))
        })
        .collect();
    // Places at which every direction is told under the largest force, and those at which none is.
    let largest = FORCES_N[FORCES_N.len() - 1];
    let mut places: Vec<(f64, usize, usize)> = Vec::new();
    let carried = |cell: &&DirectionCell| cell.force_n == largest && cell.answers.pictures > 0;
    for cell in directions.cells.iter().filter(carried) {
        match places.last_mut().filter(|(s_mm, ..)| *s_mm == cell.s_mm) {
            Some((_, told, all)) => (*told, *all) = (*told + usize::from(cell.answers.told()), *all + 1),
            None => places.push((cell.s_mm, usize::from(cell.answers.told()), 1)),
        }
    }
    let of = |wanted: fn(usize, usize) -> bool| {
        let list: Vec<f64> = places.iter().filter(|(_, told, all)| wanted(*told, *all)).map(|place| place.0).collect();
        match &list[..] {
            [] => None,
            [one] => Some(format!("{one:.0} mm")),
            [first, .., last] => {
                Some(format!("{first:.0} to {last:.0} mm from the base ({} of {} places)", list.len(), places.len()))
            }
        }
    };
    let everywhere = of(|told, all| told == all)
        .map_or("at no place are all directions told".to_owned(), |list| format!("all directions are told at {list}"));
    let nowhere =
        of(|told, _| told == 0).map_or("at every place some are".to_owned(), |list| format!("none is at {list}"));
    let [told, all] = directions.told(largest);
    let verdict = match 2 * told > all {
        true => {
            "the paper's \"will not work\" holds for small forces and for places that hardly show a direction, not for the finger"
        }
        false => "the paper's \"will not work\" holds for most pushes, though not for all",
    };
    (!shares.is_empty()).then(|| {
        format!(
            "Direction and force together are told in these shares of the places and directions: {}. Under {largest} N \
             {everywhere}, {nowhere}. So {verdict}.",
            shares.join(", ")
        )
    })
}

/// How much better it is to assume the deformed normal.
fn without_friction(directions: &DirectionStudy) -> Option<String> {
    let errors = |assumed: Assumption, force_n: f64| {
        let rows =
            directions.without_friction.iter().filter(move |row| row.assumed == assumed && row.force_n == force_n);
        let errors: Vec<f64> = rows.filter_map(|row| row.answers.force_error).collect();
        (!errors.is_empty()).then(|| {
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            format!("{} (at worst {})", percent(mean), percent(errors.into_iter().fold(0.0, f64::max)))
        })
    };
    let of_all = |count: fn(&FrictionlessPush) -> usize| -> usize {
        directions.without_friction.iter().filter(|row| row.assumed == Assumption::Unknown).map(count).sum()
    };
    let (pictures, answered) = (of_all(|row| row.answers.pictures), of_all(|row| row.answers.answered));
    let [small, _, large] = FORCES_N;
    Some(format!(
        "A contact without friction pushes along the normal of the deformed plate. Who assumes so has no direction to tell: the \
         force errs by {} at {small} N and by {} at {large} N, mean over the nodes, against {} and {} with the direction unknown \
         (refused in {} of {pictures} pictures of all forces, which count in no error) and {} and {} with the undeformed normal assumed.",
        errors(Assumption::Normal, small)?,
        errors(Assumption::Normal, large)?,
        errors(Assumption::Unknown, small)?,
        errors(Assumption::Unknown, large)?,
        pictures - answered,
        errors(Assumption::Undeformed, small)?,
        errors(Assumption::Undeformed, large)?,
    ))
}

/// Error of the force by place, a line for each assumption.
fn frictionless_chart(directions: &DirectionStudy, force_n: f64) -> Result<Figure, FigureError> {
    let series = Assumption::ALL.iter().enumerate().map(|(n, &assumed)| {
        let rows = directions.without_friction.iter().filter(|row| row.assumed == assumed && row.force_n == force_n);
        let points = rows.filter_map(|row| Some([row.s_mm, 100.0 * row.answers.force_error?])).collect();
        let label = match assumed {
            Assumption::Undeformed => "undeformed normal assumed",
            Assumption::Normal => "deformed normal assumed",
            Assumption::Unknown => "direction unknown",
        };
        Series::nth(n, label, points)
    });
    let title = format!("Pushed without friction, {force_n} N");
    let alt = format!("{title}: error of the force by place, a line for each assumption.");
    let axes = [Axis::linear(ALONG_THE_PLATE), Axis::log("root mean square error of the force, %")];
    let chart = Chart::new(Frame::half(title, alt), axes, series.collect());
    Ok(Figure {
        svg: chart.compared([percent_line(100.0 * TOLD_FORCE)]).svg()?,
        caption: format!(
            "{force_n} N along the deformed normal: error of the force by what is assumed of its direction."
        ),
        csv: Some(FRICTIONLESS_CSV.to_owned()),
        wide: false,
    })
}
