//! Which error limits a sensed force in which part of the plate: noise, a wrong direction or a wrong position, to first order.

use super::format::{error, list, percent};
use crate::prelude::*;
use finray_studies::experiments::explain::{CAUSES, Explanation};
use finray_studies::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};
use finray_studies::statistics::rms;

const CSV: &str = "limits.csv";
/// Length of each of the regions near base and tip, as a share of the plate length. On the paper's finger this is the length of two members.
const NEAR_AN_END: f64 = 1.0 / 6.0;
/// A region of the plate: its name, and whether it covers a position (share of the plate length).
type Region = (&'static str, fn(f64) -> bool);
const REGIONS: [Region; 3] = [
    ("near the base", |along| along <= NEAR_AN_END),
    ("in the middle", |along| along > NEAR_AN_END && along < 1.0 - NEAR_AN_END),
    ("near the tip", |along| along >= 1.0 - NEAR_AN_END),
];

/// Root mean square of each error over the forces along the normal in a region; `None` without an equilibrium there.
fn errors(study: &Study, (_, covers): Region) -> Option<[f64; 3]> {
    let length_mm = study.finger.plate_length_mm(Plate::Front);
    let within = |cell: &&Explanation| cell.angle_deg == 0.0 && covers(cell.s_mm / length_mm);
    let found: Vec<[f64; 3]> = study.explanations.cells.iter().filter(within).filter_map(Explanation::errors).collect();
    let each = [0, 1, 2].map(|cause| rms(found.iter().map(|errors| errors[cause])));
    Some([each[0]?, each[1]?, each[2]?])
}

/// The largest of some errors, by its place in [`CAUSES`].
pub(super) fn largest(errors: [f64; 3]) -> usize {
    (0..errors.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or(0)
}

/// Text that names the regions in which an assumed contact makes forces along the normal fail, with the largest cause in each.
pub(super) fn largest_by_region(study: &Study) -> String {
    let force_n = study.explanations.force_n;
    let failing = REGIONS.into_iter().filter_map(|region| {
        let errors = errors(study, region)?;
        let all = errors.iter().map(|error| error * error).sum::<f64>().sqrt();
        (all > TRUSTED_ERROR).then(|| format!("{}, mostly because of {}", region.0, CAUSES[largest(errors)]))
    });
    match &failing.collect::<Vec<_>>()[..] {
        [] => format!("errors of {force_n} N along the normal stay within {}", percent(TRUSTED_ERROR)),
        failing => format!("{force_n} N along the normal fails {}", list(failing, "; ")),
    }
}

fn columns<'s>(study: &'s Study) -> Columns<'s, usize> {
    let of = |region, cause: &usize| errors(study, region).map(|errors| errors[*cause]);
    let keys = ["near_the_base", "in_the_middle", "near_the_tip"];
    Columns::<usize>::new().both("cause", "cause", Format::Words, |cause| CAUSES[*cause]).each(
        REGIONS.into_iter().zip(keys),
        |columns, (region, key)| {
            columns.file(key, move |cause| of(region, cause)).cells(region.0, Format::Plain, move |cause| {
                of(region, cause).map_or(Cell::plain("no equilibrium"), error)
            })
        },
    )
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::new(CSV, &columns(study), 0..CAUSES.len())]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let caption = format!(
        "Root mean square error of {} N along the normal that each cause alone brings about, to first order: noise at the Cramer-Rao bound, a direction \
         that is {DIRECTION_OFF_DEG} deg wrong, a position that is {POSITION_OFF_MM} mm wrong. \"Near an end\" means within a sixth of the plate's length from an end",
        study.explanations.force_n
    );
    let table = columns(study).table(caption, CSV, 0..CAUSES.len());
    Ok(Some(Section::new("causes", "What limits a sensed force", vec![Block::Table(table)])))
}
