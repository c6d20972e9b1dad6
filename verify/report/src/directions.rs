//! Forces of unknown direction: positions and directions at which they are identifiable.

use super::drawings::{ALONG_THE_PLATE, by_direction, percent_classes, plate_map};
use super::format::{list, percent};
use crate::prelude::*;
use finray_studies::experiments::direction::{
    Assumption, DirectionCell, DirectionStudy, FrictionlessPush, IDENTIFIED_ANSWERED, IDENTIFIED_DEG, IDENTIFIED_FORCE,
};

const CSV: &str = "directions.csv";
const FRICTIONLESS_CSV: &str = "directions_without_friction.csv";
pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    // Errors are root mean squares. A cell has no samples if the finger has no equilibrium under the cell's force.
    let by_cell = Columns::<&DirectionCell>::new()
        .file("s_mm", |cell| cell.s_mm)
        .file("angle_deg", |cell| cell.angle_deg)
        .file("force_n", |cell| cell.force_n)
        .file("samples", |cell| cell.answers.samples)
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
        .file("samples", |push| push.answers.samples)
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
    let mut blocks = vec![text(about(directions))];
    blocks.extend(where_identifiable(directions).map(text));
    let figures = directions.forces_n.map(|force_n| map(&study.finger, directions, force_n));
    blocks.push(Block::Figures(figures.into_iter().collect::<Result<_, _>>()?));
    blocks.extend(without_friction(directions).map(text));
    blocks.push(Block::Figure(frictionless_chart(directions, directions.forces_n[0])?));
    Ok(Some(Section::new("directions", "Unknown directions", blocks)))
}

/// Text on the known quantities, and on when a cell counts as identifiable.
fn about(DirectionStudy { noise_mm, samples, .. }: &DirectionStudy) -> String {
    let [force, answered] = [IDENTIFIED_FORCE, IDENTIFIED_ANSWERED].map(percent);
    format!(
        "The nonlinear estimator knows only the position of the contact. The noise is {noise_mm} mm, with {samples} samples per cell (position and \
         direction). A cell is identifiable if the direction errs by at most {IDENTIFIED_DEG} deg and the force by at most {force} (root mean squares). At \
         least {answered} of the samples must be answered."
    )
}

/// Map of the error of the direction under one force.
fn map(finger: &Finger, directions: &DirectionStudy, force_n: f64) -> Result<Figure, FigureError> {
    let cells: Vec<&DirectionCell> = directions.cells.iter().filter(|cell| cell.force_n == force_n).collect();
    let mut places: Vec<f64> = cells.iter().map(|cell| cell.s_mm).collect();
    places.dedup();
    let angles: Vec<f64> =
        cells.iter().take_while(|cell| Some(&cell.s_mm) == places.first()).map(|cell| cell.angle_deg).collect();
    let identified = |cell: &&DirectionCell| cell.answers.angle_error_deg.filter(|_| cell.answers.is_identified());
    let cells = by_direction(&places, &angles, cells.iter().map(identified));
    let what = "error of the direction, deg, by position and true direction";
    let frame = Frame::third(format!("{force_n} N"), format!("{force_n} N: {what} of the force."));
    let drawn = plate_map(finger, frame, degree_classes(), cells);
    let svg = Map { missing_label: "not identifiable".to_owned(), ..drawn }.svg()?;
    Ok(Figure::narrow(svg, format!("{force_n} N: {what}; hatched: not identifiable."), CSV))
}

/// Colour classes of the error of a direction, degrees.
fn degree_classes() -> Vec<Class> {
    let green = percent_classes().into_iter().take(3).zip([1.0, 3.0, IDENTIFIED_DEG]);
    green.map(|(class, up_to)| Class { up_to, label: format!("up to {up_to} deg"), ..class }).collect()
}

/// Text on the shares of the cells in which force and direction are identifiable, on the positions at which all directions are identifiable, and on
/// the positions at which no direction is.
fn where_identifiable(directions: &DirectionStudy) -> Option<String> {
    let share = |force_n: &f64| match directions.identified(*force_n) {
        [_, 0] => None,
        [identified, all] => Some(format!("{} at {force_n} N", percent(identified as f64 / all as f64))),
    };
    let shares: Vec<String> = directions.forces_n.iter().filter_map(share).collect();
    // Under the largest force: positions at which every direction is identifiable, and positions at which none is.
    let largest_n = directions.forces_n[directions.forces_n.len() - 1];
    let carried = directions.cells.iter().filter(|cell| cell.force_n == largest_n && cell.answers.samples > 0);
    let carried: Vec<&DirectionCell> = carried.collect();
    let places: Vec<&[&DirectionCell]> = carried.chunk_by(|a, b| a.s_mm == b.s_mm).collect();
    let of = |wanted: bool| {
        let is_so = |place: &&&[&DirectionCell]| place.iter().all(|cell| cell.answers.is_identified() == wanted);
        let list: Vec<f64> = places.iter().filter(is_so).map(|place| place[0].s_mm).collect();
        match &list[..] {
            [] => None,
            [one] => Some(format!("{one:.0} mm")),
            [first, .., last] => {
                Some(format!("{first:.0} to {last:.0} mm from the base ({} of {} positions)", list.len(), places.len()))
            }
        }
    };
    let everywhere = match of(true) {
        None => "at no position are all directions identifiable".to_owned(),
        Some(everywhere) => format!("all directions are identifiable at {everywhere}"),
    };
    let nowhere = match of(false) {
        None => "and at every position some directions are identifiable".to_owned(),
        Some(nowhere) => format!("and no direction is identifiable at {nowhere}"),
    };
    let [identified, all] = directions.identified(largest_n);
    let fails = match 2 * identified > all {
        true => "small forces and for positions near the ends, but not for the whole finger",
        false => "most forces",
    };
    (!shares.is_empty()).then(|| {
        let shares = list(shares, ", ");
        format!(
            "Force and direction are identifiable in {shares} of the cells. Under {largest_n} N {everywhere}, {nowhere}. The paper's \"will not \
             work\" (Fig. 13) therefore holds for {fails}."
        )
    })
}

/// Sentences on the error of the force: with the deformed normal assumed, with the direction unknown, and with the undeformed normal assumed.
fn without_friction(directions: &DirectionStudy) -> Option<String> {
    let [small_n, _, large_n] = directions.forces_n;
    let error = |assumed: Assumption, force_n: f64| {
        let rows =
            directions.without_friction.iter().filter(move |row| row.assumed == assumed && row.force_n == force_n);
        let errors = Span::of(rows.filter_map(|row| row.answers.force_error))?;
        Some(format!("{} (at worst {})", percent(errors.mean), percent(errors.greatest)))
    };
    let errors = |assumed| Some([error(assumed, small_n)?, error(assumed, large_n)?]);
    let of_all = |count: fn(&FrictionlessPush) -> usize| -> usize {
        directions.without_friction.iter().filter(|row| row.assumed == Assumption::Unknown).map(count).sum()
    };
    let (samples, answered) = (of_all(|row| row.answers.samples), of_all(|row| row.answers.answered));
    let [small_normal, large_normal] = errors(Assumption::Normal)?;
    let unknown = errors(Assumption::Unknown)?.join(" and ");
    let undeformed = errors(Assumption::Undeformed)?.join(" and ");
    let refused = samples - answered;
    Some(format!(
        "Without friction a contact pushes along the deformed normal. If this direction is assumed, the force errs by {small_normal} at {small_n} N and by \
         {large_normal} at {large_n} N, on average over the nodes. If the direction is unknown, the force errs by {unknown} ({refused} of {samples} \
         samples refused); if the undeformed normal is assumed, by {undeformed}."
    ))
}

/// Chart of the error of the force by position, one line per assumed direction.
fn frictionless_chart(directions: &DirectionStudy, force_n: f64) -> Result<Figure, FigureError> {
    let series = Assumption::ALL.iter().enumerate().map(|(n, &assumed)| {
        let rows = directions.without_friction.iter().filter(|row| row.assumed == assumed && row.force_n == force_n);
        let points = rows.filter_map(|row| Some([row.s_mm, 100.0 * row.answers.force_error?])).collect();
        let label = match assumed {
            Assumption::Undeformed => "undeformed normal assumed",
            Assumption::Normal => "deformed normal assumed",
            Assumption::Unknown => "direction unknown",
        };
        // The first line is wider, so that it stays visible where another line coincides with it.
        Series { width: if n == 0 { 6.0 } else { 2.6 }, ..Series::nth(n, label, points) }
    });
    let title = format!("Pushed without friction, {force_n} N");
    let alt = format!("{title}: error of the force by position, a line for each assumption.");
    let axes = [Axis::linear(ALONG_THE_PLATE), Axis::log("root mean square error of the force, %")];
    let chart = Chart::new(Frame::half(title, alt), axes, series.collect());
    let svg = chart.compared([(100.0 * IDENTIFIED_FORCE, percent(IDENTIFIED_FORCE))]).svg()?;
    let caption = format!("{force_n} N along the deformed normal: error of the force by assumed direction.");
    Ok(Figure::narrow(svg, caption, FRICTIONLESS_CSV))
}
