//! Files and tables of the maps: cells and key figures of each map, cells of the overview, and quantities that explain errors.

use super::{ExplainedQuantity, small};
use crate::prelude::*;
use finray_studies::sampling::map::MapSummary;
use finray_studies::sampling::situation::Situation;
use finray_studies::sampling::trust::WorstCell;
use finray_studies::statistics::median;
use serde::Serialize;

const MAPS: &str = "maps";
/// File of the overview's cells.
pub(super) const OVERVIEW_CSV: &str = "map_overview.csv";
/// File of the quantities that explain where sensing fails.
pub(super) const EXPLANATIONS_CSV: &str = "explanations.csv";

/// Name of the CSV file with a map's cells.
pub(crate) fn map_csv_name(map: &AccuracyMap) -> String {
    let noise = if map.noise_mm > 0.0 { "with_noise" } else { "without_noise" };
    let Situation { contact, hidden } = map.situation;
    if map.situation != Situation::default() {
        let contact = contact.name().replace('@', "_");
        return format!("map_contact_{contact}_hidden_{hidden}.csv");
    }
    match map.estimator {
        EstimatorId::LeastSquares => format!("map_{}_{noise}.csv", map.truth),
        estimator => format!("map_{}_{estimator}_{noise}.csv", map.truth),
    }
}

pub(crate) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let mut all = vec![
        Dataset::records(MAPS, entries(study)).summary_alone(),
        explained(study),
        overview(study),
        Dataset::records(EXPLANATIONS_CSV, &study.explanations.cells).csv_alone(),
    ];
    all.extend(study.maps.iter().map(|map| Dataset::records(&map_csv_name(map), &map.cells).csv_alone()));
    all
}

/// Key figures of a map, and the name of the file with its cells.
#[derive(Serialize)]
struct Entry {
    #[serde(flatten)]
    figures: MapSummary,
    csv: String,
}

/// Key figures of every map: first at the drawn force, then averaged over all forces of the map.
fn entries(study: &Study) -> impl Iterator<Item = Entry> {
    let of = |force_n: Option<f64>| {
        // For a map with a single force, the mean over forces is left out.
        let has = move |map: &&AccuracyMap| match force_n {
            Some(force_n) => map.request.forces_n.contains(&force_n),
            None => map.request.forces_n.len() > 1,
        };
        let maps = study.maps.iter().filter(has);
        maps.map(move |map| Entry { figures: map.summary(force_n), csv: map_csv_name(map) })
    };
    of(Some(study.forces.drawn_n())).chain(of(None))
}

/// Key figures of all maps.
pub(super) fn figures(study: &Study) -> Table {
    let forces = |figures: &MapSummary| match figures.forces_n[..] {
        [one] => format!("{one} N"),
        _ => "mean over all".to_owned(),
    };
    let caption = "Errors are over the answered cells, shares are of all cells with an equilibrium. A refused cell counts as above both limits";
    let table = Columns::<Entry>::new()
        .page("truth", Format::Words, |map| map.figures.truth.label())
        .page("sensed by", Format::Words, |map| map.figures.estimator.label())
        .page("noise, mm", Format::Words, |map| map.figures.noise_mm)
        .page("force", Format::Words, move |map| forces(&map.figures))
        .page("cells", Format::Plain, |map| map.figures.cells)
        .page("answered", Format::Plain, |map| map.figures.answered)
        .page("refused", Format::Plain, |map| map.figures.refused)
        .page("no equilibrium", Format::Plain, |map| map.figures.without_equilibrium)
        .page("mean error", Format::Percent, |map| map.figures.mean_error)
        .page("largest", Format::Percent, |map| map.figures.largest_error)
        .page("above 10 %", Format::Percent, |map| map.figures.share_above_10)
        .page("above 25 %", Format::Percent, |map| map.figures.share_above_25)
        .page("samples refused", Format::Percent, |map| map.figures.share_of_samples_refused)
        .cells("data", Format::Words, |map| Cell::file(map.csv.clone()))
        .table(caption, MAPS, entries(study));
    // Each row links to its own file.
    Table { csv: None, ..table }
}

/// Cells of the overview, with and without noise.
fn overview(study: &Study) -> Dataset<'static> {
    type Row = (TruthId, EstimatorId, f64, WorstCell);
    let pairs = || TruthId::ALL.iter().flat_map(|truth| EstimatorId::ALL.iter().map(|estimator| (*truth, *estimator)));
    let shown = [true, false].into_iter().flat_map(|noisy| {
        pairs().filter_map(move |(truth, estimator)| Some((truth, estimator, small(study, truth, estimator, noisy)?)))
    });
    let cells = shown.flat_map(|(truth, estimator, map)| {
        let noise_mm = map.noise_mm;
        map.worst(&study.finger).into_iter().map(move |cell| (truth, estimator, noise_mm, cell))
    });
    let columns = Columns::<Row>::new()
        .file("truth", |(truth, ..)| truth.name())
        .file("estimator", |(_, estimator, ..)| estimator.name())
        .file("noise_mm", |(_, _, noise_mm, _)| *noise_mm)
        .file("s_mm", |(.., cell)| cell.s_mm)
        .file("angle_deg", |(.., cell)| cell.angle_deg)
        .file("state", |(.., cell)| cell.state.name())
        .file("worst_error", |(.., cell)| cell.worst_error)
        .file("is_trusted", |(.., cell)| cell.is_trusted);
    Dataset::new(OVERVIEW_CSV, &columns, cells).csv_alone()
}

/// For each quantity that explains errors, a summary over all cells. A value is missing if the cell has no equilibrium or its direction is not
/// identifiable.
fn explained(study: &Study) -> Dataset<'_> {
    const QUANTITIES: [(&str, ExplainedQuantity); 6] = [
        ("bound", |cell| cell.bound),
        ("bound_unknown_direction", |cell| cell.bound_unknown_direction),
        ("direction_sigma_deg", |cell| cell.direction_sigma_deg),
        ("condition", |cell| cell.condition),
        ("error_per_deg", |cell| cell.error_per_deg),
        ("error_per_mm", |cell| cell.error_per_mm),
    ];
    let map = &study.explanations;
    let with_values = |(quantity, of): (&'static str, ExplainedQuantity)| {
        (quantity, map.cells.iter().filter_map(of).collect::<Vec<f64>>())
    };
    let columns = Columns::<(&str, Vec<f64>)>::new()
        .file("quantity", |(quantity, _)| *quantity)
        .file("force_n", |_| map.force_n)
        .file("noise_mm", |_| map.noise_mm)
        .file("median", |(_, values)| median(values.iter().copied()))
        .file("largest", |(_, values)| values.iter().copied().reduce(f64::max))
        .file("cells_without", |(_, values)| map.cells.len() - values.len())
        .file("csv", |_| EXPLANATIONS_CSV);
    Dataset::new(EXPLANATIONS_CSV, &columns, QUANTITIES.map(with_values)).summary_alone()
}
