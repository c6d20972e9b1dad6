//! The finger that the reader can push: its program, its scene and the maps of trusted cells.

use super::page::Pushable;
use super::trust::{SOFTER, Situation, situations};
use crate::prelude::*;
use finray_studies::sampling::situation::ContactKnowledge;
use finray_studies::settings::{DIRECTION_OFF_DEG, FRICTION_MAX, POSITION_OFF_MM};
use flate2::{Compression, write::GzEncoder};
use serde_json::{Value, json};
use std::io::Write;

/// Largest force that the reader can choose, relative to the largest force of the maps.
const MOST: f64 = 1.5;
/// Name of each situation in the script.
const SITUATIONS: [(&str, ContactKnowledge); 3] =
    [("sought", ContactKnowledge::Nothing), ("known", ContactKnowledge::Known), ("off", ContactKnowledge::Misjudged)];

/// Program and data of the finger on the first page.
pub(super) fn of(study: &Study) -> Result<Pushable, ReportError> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(finray_push::PROGRAM)?;
    let program = data_encoding::BASE64.encode(&packed.finish()?);
    Ok(Pushable { program, data: data(study), is_edited: false, is_current: finray_push::program_is_current() })
}

/// Program and data for the page on which the reader edits the scene. The data contain no maps, because the report's maps hold only for the report's
/// finger.
pub(super) fn edited(pushed: &Pushable, study: &Study) -> Pushable {
    let [most_n, first_n] = forces_n(study);
    let data = json!({
        "scene": study.scene_text, "other": null, "maps": {}, "cone_deg": FRICTION_MAX.atan().to_degrees(), "noise_mm": study.noise_mm, "most_n": most_n, "first_n": first_n,
    });
    Pushable { data: embedded(&data), is_edited: true, ..pushed.clone() }
}

/// Largest force that the reader can choose, and the initial force, N.
fn forces_n(study: &Study) -> [f64; 2] {
    let largest_n = study.forces.of_maps_n().into_iter().fold(0.0, f64::max);
    [MOST * largest_n, largest_n / 2.0]
}

/// JSON without `<`, so that it can be embedded in a page.
fn embedded(data: &Value) -> String {
    data.to_string().replace('<', "\\u003c")
}

fn data(study: &Study) -> String {
    let all = situations(study);
    let named = |(name, contact): (&str, ContactKnowledge)| {
        let situation = finray_studies::sampling::situation::Situation { contact, ..Default::default() };
        let is_it = |of: &&Situation| of.map.situation == situation && of.map.truth == TruthId::Corotational;
        Some((name.to_owned(), cells(all.iter().find(is_it)?)))
    };
    let softer = all.iter().find(|situation| situation.name == SOFTER).map(|of| ("other".to_owned(), cells(of)));
    let [most_n, first_n] = forces_n(study);
    let data = json!({
        "scene": study.scene_text,
        "other": study.is_paper.then_some(finray_fixtures::TWIN_SCENE),
        "maps": SITUATIONS.into_iter().filter_map(named).chain(softer).collect::<serde_json::Map<String, Value>>(),
        // The map of assumed contacts covers all combinations of signs of the position error and the direction error. Here the position error is
        // negative and the direction error positive, because with these signs the two errors do not compensate each other.
        "off": { "by_mm": -POSITION_OFF_MM, "by_deg": DIRECTION_OFF_DEG },
        "noise_mm": study.noise_mm,
        "most_n": most_n,
        "first_n": first_n,
    });
    embedded(&data)
}

fn cells(of: &Situation) -> Value {
    json!({
        "s_mm": of.map.request.positions_mm,
        "angle_deg": of.map.request.angles_deg,
        "state": of.cells.iter().map(|cell| cell.state.name()).collect::<Vec<_>>(),
        "worst_error": of.cells.iter().map(|cell| cell.worst_error).collect::<Vec<_>>(),
        "is_trusted": of.cells.iter().map(|cell| cell.is_trusted).collect::<Vec<_>>(),
    })
}
