//! Forces of unknown direction: where they are identifiable.

use super::dataset::{Columns, Dataset};
use super::drawings::{ALONG_THE_PLATE, percent_classes, percent_line, plate_map};
use super::format::{Span, percent};
use super::page::{Block, Figure, Section, text};
use super::{ReportError, Results};
use crate::experiments::direction::{
    Assumption, DirectionCell, DirectionStudy, FORCES_N, FrictionlessPush, IDENTIFIED_ANSWERED, IDENTIFIED_DEG,
    IDENTIFIED_FORCE,
};
use crate::figures::{Axis, Cells, Chart, Class, FigureError, Frame, Map, Series};
use finray_model::Finger;

const CSV: &str = "directions.csv";
const FRICTIONLESS_CSV: &str = "directions_without_friction.csv";
pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // Errors are root mean squares; without samples the finger carries no such force.
    let by_cell = Columns::<&DirectionCell>::new()
        .file("s_mm", |cell| cell.s_mm)
        .file("angle_deg", |cell| cell.angle_deg)
        .file("force_n", |cell| cell.force_n)
        .file("pictures", |cell| cell.answers.samples)
        .file("answered", |cell| cell.answers.answered)
        .file("told", |cell| cell.answers.is_identified())
        .file("angle_error_deg", |cell| cell.answers.angle_error_deg)
        .file("angle_bound_deg", |cell| cell.angle_bound_deg)
        .file("force_error", |cell| cell.answers.force_error)
        .file("force_bound", |cell| cell.force_bound)
        .file("force_sigma", |cell| cell.answers.force_sigma);
    let without_friction = Columns::<&FrictionlessPush>::new()
        .file("node", |push| push.node)
        .file("s_mm", |push| push.s_mm)
        .file("force_n", |push| push.force_n)
        .file("angle_deg", |push| push.angle_deg)
        .file("assumed", |push| push.assumed.name())
        .file("pictures", |push| push.answers.samples)
        .file("answered", |push| push.answers.answered)
        .file("angle_error_deg", |push| push.answers.angle_error_deg)
        .file("force_error", |push| push.answers.force_error)
        .file("force_sigma", |push| push.answers.force_sigma);
    let directions = || study.directions.iter();
    vec![
        Dataset::new(CSV, &by_cell, directions().flat_map(|of| &of.cells)),
        Dataset::new(FRICTIONLESS_CSV, &without_friction, directions().flat_map(|of| &of.without_friction)),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(directions) = &study.directions else { return Ok(None) };
    let finger = &study.finger;
    let mut blocks = vec![text(format!(
        "The nonlinear estimator knows the position alone, under {} mm noise, {} samples a cell. Identifiable: the direction to {IDENTIFIED_DEG} deg and the \
         force to {} (root mean squares), with at least {} of the samples answered.",
        directions.noise_mm,
        directions.samples,
        percent(IDENTIFIED_FORCE),
        percent(IDENTIFIED_ANSWERED)
    ))];
    blocks.extend(where_identifiable(directions).map(text));
    let identified = |cell: &DirectionCell| cell.answers.angle_error_deg.filter(|_| cell.answers.is_identified());
    let all = |map: &Shown| -> Result<Block, FigureError> {
        let figures = FORCES_N.map(|force_n| map.figure(finger, directions, force_n));
        Ok(Block::Figures { figures: figures.into_iter().collect::<Result<_, _>>()? })
    };
    blocks.push(all(&Shown { what: "error of the direction, deg", missing: "not identifiable", value: &identified })?);
    blocks.extend(without_friction(directions).map(text));
    blocks.push(Block::Figure(frictionless_chart(directions, FORCES_N[0])?));
    Ok(Some(Section::new("directions", "Unknown directions", blocks)))
}

/// A quantity of a cell.
type Value<'v> = &'v dyn Fn(&DirectionCell) -> Option<f64>;

/// One quantity by position and direction.
struct Shown<'v> {
    what: &'v str,
    missing: &'v str,
    value: Value<'v>,
}

impl Shown<'_> {
    fn figure(&self, finger: &Finger, directions: &DirectionStudy, force_n: f64) -> Result<Figure, FigureError> {
        let Shown { what, missing, value } = *self;
        let cells: Vec<&DirectionCell> = directions.cells.iter().filter(|cell| cell.force_n == force_n).collect();
        let mut places: Vec<f64> = cells.iter().map(|cell| cell.s_mm).collect();
        places.dedup();
        let angles: Vec<f64> =
            cells.iter().take_while(|cell| Some(&cell.s_mm) == places.first()).map(|cell| cell.angle_deg).collect();
        // Cells go by position, then direction; rows of the map by direction, then position.
        let row = |angle| cells.iter().skip(angle).step_by(angles.len().max(1)).map(|cell| value(cell)).collect();
        let title = format!("{force_n} N");
        let frame = Frame::third(&title, format!("{title}: {what}, by position and true direction of the force."));
        let values = (0..angles.len()).map(row).collect();
        let cells = Cells::new(&places, &angles, values);
        let map = Map { missing_label: missing.to_owned(), ..plate_map(finger, frame, degree_classes(), cells) };
        Ok(Figure::narrow(
            map.svg()?,
            format!("{force_n} N: {what}, by position and true direction; hatched: {missing}."),
            CSV,
        ))
    }
}

/// Classes of the error of an identifiable direction, deg.
fn degree_classes() -> Vec<Class> {
    let green = percent_classes().into_iter().take(3).zip([1.0, 3.0, IDENTIFIED_DEG]);
    green.map(|(class, up_to)| Class { up_to, label: format!("up to {up_to} deg"), ..class }).collect()
}

/// In which cells both are identifiable.
fn where_identifiable(directions: &DirectionStudy) -> Option<String> {
    let shares: Vec<String> = FORCES_N
        .iter()
        .filter_map(|&force_n| {
            let [identified, all] = directions.identified(force_n);
            (all > 0).then(|| format!("{} at {force_n} N", percent(identified as f64 / all as f64)))
        })
        .collect();
    // Positions at which every direction is identifiable under the largest force, and those at which none is.
    let largest = FORCES_N[FORCES_N.len() - 1];
    let mut places: Vec<(f64, usize, usize)> = Vec::new();
    let carried = |cell: &&DirectionCell| cell.force_n == largest && cell.answers.samples > 0;
    for cell in directions.cells.iter().filter(carried) {
        match places.last_mut().filter(|(s_mm, ..)| *s_mm == cell.s_mm) {
            Some((_, identified, all)) => {
                (*identified, *all) = (*identified + usize::from(cell.answers.is_identified()), *all + 1)
            }
            None => places.push((cell.s_mm, usize::from(cell.answers.is_identified()), 1)),
        }
    }
    let of = |wanted: fn(usize, usize) -> bool| {
        let list: Vec<f64> =
            places.iter().filter(|(_, identified, all)| wanted(*identified, *all)).map(|place| place.0).collect();
        match &list[..] {
            [] => None,
            [one] => Some(format!("{one:.0} mm")),
            [first, .., last] => {
                Some(format!("{first:.0} to {last:.0} mm from the base ({} of {} positions)", list.len(), places.len()))
            }
        }
    };
    let everywhere = of(|identified, all| identified == all)
        .map_or("at no position are all directions identifiable".to_owned(), |list| {
            format!("all directions are identifiable at {list}")
        });
    let nowhere = of(|identified, _| identified == 0)
        .map_or("at every position some are".to_owned(), |list| format!("none is at {list}"));
    let [identified, all] = directions.identified(largest);
    let verdict = match 2 * identified > all {
        true => {
            "So the paper's \"will not work\" (Fig. 13) holds for small forces and near the ends, not for the whole finger"
        }
        false => "So the paper's \"will not work\" (Fig. 13) holds for most pushes",
    };
    (!shares.is_empty()).then(|| {
        format!(
            "Both are identifiable in {} of the cells. Under {largest} N {everywhere}, {nowhere}. {verdict}.",
            shares.join(", ")
        )
    })
}

/// How much better it is to assume the deformed normal.
fn without_friction(directions: &DirectionStudy) -> Option<String> {
    let errors = |assumed: Assumption, force_n: f64| {
        let rows =
            directions.without_friction.iter().filter(move |row| row.assumed == assumed && row.force_n == force_n);
        let errors = Span::of(rows.filter_map(|row| row.answers.force_error))?;
        Some(format!("{} (at worst {})", percent(errors.mean), percent(errors.greatest)))
    };
    let of_all = |count: fn(&FrictionlessPush) -> usize| -> usize {
        directions.without_friction.iter().filter(|row| row.assumed == Assumption::Unknown).map(count).sum()
    };
    let (samples, answered) = (of_all(|row| row.answers.samples), of_all(|row| row.answers.answered));
    let [small, _, large] = FORCES_N;
    Some(format!(
        "Without friction a contact pushes along the deformed normal. Assuming so, the force errs by {} at {small} N and by {} at {large} N, mean over \
         the nodes; with the direction unknown by {} and {} ({} of {samples} samples refused), with the undeformed normal by {} and {}.",
        errors(Assumption::Normal, small)?,
        errors(Assumption::Normal, large)?,
        errors(Assumption::Unknown, small)?,
        errors(Assumption::Unknown, large)?,
        samples - answered,
        errors(Assumption::Undeformed, small)?,
        errors(Assumption::Undeformed, large)?,
    ))
}

/// Error of the force by position, a line for each assumption.
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
    let alt = format!("{title}: error of the force by position, a line for each assumption.");
    let axes = [Axis::linear(ALONG_THE_PLATE), Axis::log("root mean square error of the force, %")];
    let chart = Chart::new(Frame::half(title, alt), axes, series.collect());
    Ok(Figure::narrow(
        chart.compared([percent_line(100.0 * IDENTIFIED_FORCE)]).svg()?,
        format!("{force_n} N along the deformed normal: error of the force by what is assumed of its direction."),
        FRICTIONLESS_CSV,
    ))
}
