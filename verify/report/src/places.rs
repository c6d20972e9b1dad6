//! Can a force be trusted here? Errors of an unknown contact by part of the plate and by force.

use super::format::{error_as, percent};
use super::trust::situations;
use crate::prelude::*;
use finray_studies::sampling::trust::WorstCell;

const CSV: &str = "places.csv";
/// Parts of the plate: name, and ends as shares of the plate's length.
const PARTS: [(&str, [f64; 2]); 3] =
    [("base", [0.0, 1.0 / 3.0]), ("middle", [1.0 / 3.0, 2.0 / 3.0]), ("tip", [2.0 / 3.0, 1.0])];

/// Errors of one force in one part of the plate, over the directions that friction allows.
#[derive(Clone, Copy)]
struct Place {
    part: &'static str,
    /// Ends of the part, mm from the base.
    ends_mm: [f64; 2],
    force_n: f64,
    /// Mean of the mean errors of the answered cells, by weight; `None` without such cells.
    mean_error: Option<f64>,
    /// Share of the cells with an equilibrium that are refused; `None` without such cells.
    refused: Option<f64>,
}

fn places(study: &Study) -> Vec<[Place; 4]> {
    let all = situations(study);
    let Some(unknown) = all.first() else { return Vec::new() };
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let place = |(part, shares): (&'static str, [f64; 2]), force_n: f64| {
        let ends_mm = shares.map(|share| share * length_mm);
        let cells = unknown.map.worst_of(&study.finger, Some(force_n));
        let is_in = |cell: &&WorstCell| cell.s_mm > ends_mm[0] && cell.s_mm <= ends_mm[1] + 1e-9 * length_mm;
        let carried = || cells.iter().filter(is_in).filter(|cell| cell.state != CellState::WithoutEquilibrium);
        let weight = |state| carried().filter(|cell| cell.state == state).map(|cell| cell.weight).sum::<f64>();
        let [answered, refused] = [CellState::Answered, CellState::Refused].map(weight);
        let sum: f64 = carried().filter_map(|cell| Some(cell.weight * cell.worst_error?)).sum();
        let share = |part: f64, whole: f64| (whole > 0.0).then(|| part / whole);
        let (mean_error, refused) = (share(sum, answered), share(refused, answered + refused));
        Place { part, ends_mm, force_n, mean_error, refused }
    };
    PARTS.map(|part| study.forces.of_maps_n().map(|force_n| place(part, force_n))).into()
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let columns = Columns::<Place>::new()
        .file("part", |place| place.part)
        .file("from_mm", |place| place.ends_mm[0])
        .file("to_mm", |place| place.ends_mm[1])
        .file("force_n", |place| place.force_n)
        .file("mean_error", |place| place.mean_error)
        .file("share_refused", |place| place.refused);
    vec![Dataset::new(CSV, &columns, places(study).into_iter().flatten())]
}

/// The error with its colour: green if trusted. Refusals are stated if they are more than a tenth.
fn cell(Place { mean_error, refused, .. }: &Place) -> Cell {
    let refused = refused.filter(|share| *share > 0.1);
    match (mean_error, refused) {
        (None, None) => Cell::plain("no equilibrium"),
        (None, Some(_)) => Cell::shaded("refused", Shade::Red),
        (Some(error), Some(refused)) if refused > 0.5 => {
            Cell::shaded(format!("{} ({} refused)", percent(*error), percent(refused)), Shade::Red)
        }
        (Some(error), refused) => {
            let words =
                percent(*error) + &refused.map_or_else(String::new, |share| format!(" ({} refused)", percent(share)));
            if *error <= TRUSTED_ERROR { Cell::shaded(words, Shade::Pass) } else { error_as(words, *error) }
        }
    }
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let rows = places(study);
    let Some(first) = situations(study).into_iter().next().map(|of| of.name) else { return Ok(None) };
    let columns = Columns::<[Place; 4]>::new().page("part of the front plate", Format::Words, |row| {
        let Place { part, ends_mm: [from_mm, to_mm], .. } = row[0];
        format!("{part} ({from_mm:.0} to {to_mm:.0} mm)")
    });
    let columns = columns.each(study.forces.of_maps_n().into_iter().enumerate(), |columns, (nth, force_n)| {
        columns.cells(format!("{force_n} N"), Format::Error, move |row| cell(&row[nth]))
    });
    let caption = format!(
        "Mean error of a sensed force, {first}, over the directions that friction allows. Green: within {}",
        percent(TRUSTED_ERROR)
    );
    let table = Block::Table(columns.table(caption, CSV, rows));
    Ok(Some(Section::new("places", "Can I trust a force here?", vec![table])))
}
