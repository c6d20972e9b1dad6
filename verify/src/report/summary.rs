//! `summary.json`: every figure that the page shows, for machines.

use super::causes::CauseSummary;
use super::directions::{self, DirectionRow, FrictionlessRow};
use super::lattice::{self, AxialSpringsRow, LatticeRow, SettlingRow};
use super::maps::{self, ExplanationRow};
use super::networks::{self, NetworkRow};
use super::pairs::{self, PairRow};
use super::table_two::{self, TableTwoRow};
use super::twin::{self, CalibrationRow, TwinRow, ZoneSetRow};
use super::{causes, tables, verdict, words};
use crate::check::{Check, Comparison};
use crate::claims::Claim;
use crate::experiments::coverage::CoverageRow;
use crate::experiments::displacement_noise::DisplacementNoiseRow;
use crate::experiments::networks::records::{CurveRow, RecipeRow};
use crate::experiments::speed_error::SpeedErrorPoint;
use crate::experiments::table_one::TableOne;
use crate::sampling::map::{AccuracyMap, MapSummary};
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;
use serde::Serialize;

/// A map in a few figures, and where its cells are.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapEntry {
    /// The figures.
    #[serde(flatten)]
    pub figures: MapSummary,
    /// File with the cells, beside the summary.
    pub csv: String,
}

/// What the page shows, as data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// Version of finray that made it.
    pub version: &'static str,
    /// What the numbers say: the verdict at the head of the page, then what its sections say.
    pub verdict: Vec<String>,
    /// Promises.
    pub checks: Vec<Check>,
    /// Differences that are expected.
    pub comparisons: Vec<Comparison>,
    /// Time and error of models and estimators.
    pub speed_error: Vec<SpeedErrorPoint>,
    /// The paper's figures against ours.
    pub claims: Vec<Claim>,
    /// Maps at the drawn force and over all forces.
    pub maps: Vec<MapEntry>,
    /// Stated intervals against the truth, by finger and estimator.
    pub coverage: Vec<CoverageRow>,
    /// What makes sensed forces wrong, by truth, way of sensing, force and region.
    pub causes: Vec<CauseSummary>,
    /// What limits sensing of the drawn force, over all places and directions.
    pub explanations: Vec<ExplanationRow>,
    /// Table I of the paper, for each assumed direction.
    pub table_one: Vec<TableOne>,
    /// The digital twin of Table I, by loaded node.
    pub twin: Vec<TwinRow>,
    /// Zones that were fitted to Table I.
    pub twin_zone_sets: Vec<ZoneSetRow>,
    /// The twin's factors from noisy pictures.
    pub twin_calibration: Vec<CalibrationRow>,
    /// Table II of the paper, by finger, noise, estimator and contacts.
    pub table_two: Vec<TableTwoRow>,
    /// Two contacts at once, by pair and estimator.
    pub pairs: Vec<PairRow>,
    /// Floors by the origin of the undeformed positions, by contacts and noise.
    pub displacement_noise: Vec<DisplacementNoiseRow>,
    /// Forces of unknown direction, by place, direction and force.
    pub directions: Vec<DirectionRow>,
    /// Pushes along the deformed normal, by node, force and assumption.
    pub directions_without_friction: Vec<FrictionlessRow>,
    /// The networks that ship, by contacts.
    pub networks: Vec<NetworkRow>,
    /// Three ways to train, recorded.
    pub training_recipes: Vec<RecipeRow>,
    /// Error of networks against training cases and size, recorded.
    pub training_curves: Vec<CurveRow>,
    /// Error and cost of the spring lattice, by fineness and force.
    pub lattice: Vec<LatticeRow>,
    /// The lattice with other axial springs.
    pub lattice_axial_springs: Vec<AxialSpringsRow>,
    /// The lattice settled in several ways.
    pub lattice_settling: Vec<SettlingRow>,
}

impl Summary {
    /// Collects a study.
    pub fn of(study: &Study, claims: &[Claim]) -> Summary {
        let entry = |force_n: Option<f64>| {
            // The mean over a single force is that force's map.
            let has = move |map: &&AccuracyMap| match force_n {
                Some(force_n) => map.request.forces_n.contains(&force_n),
                None => map.request.forces_n.len() > 1,
            };
            let maps = study.all_maps().filter(has);
            maps.map(move |map| MapEntry { figures: map.summary(force_n), csv: tables::map_csv_name(map) })
        };
        let findings = words::findings(study).into_iter().map(|finding| finding.sentence);
        Summary {
            scene: study.scene.clone(),
            version: env!("CARGO_PKG_VERSION"),
            verdict: verdict::sentences(study).into_iter().chain(findings).collect(),
            checks: study.all_checks().cloned().collect(),
            comparisons: study.comparisons.clone(),
            speed_error: study.speed_error.clone(),
            claims: claims.to_vec(),
            maps: entry(Some(DRAWN_FORCE_N)).chain(entry(None)).collect(),
            coverage: study.coverage.clone(),
            causes: causes::summaries(study),
            explanations: maps::explanation_rows(&study.explanations),
            table_one: study.tables_one.clone(),
            twin: study.twin.iter().flat_map(twin::rows).collect(),
            twin_zone_sets: study.twin.iter().flat_map(twin::set_rows).collect(),
            twin_calibration: study.twin.iter().flat_map(twin::calibration_rows).collect(),
            table_two: table_two::rows(study),
            pairs: study.noise.iter().flat_map(pairs::rows).collect(),
            displacement_noise: study.displacement_noise.iter().flat_map(|noise| noise.rows.clone()).collect(),
            directions: study.directions.iter().flat_map(directions::rows).collect(),
            directions_without_friction: study.directions.iter().flat_map(directions::frictionless_rows).collect(),
            networks: study.networks.iter().flat_map(networks::rows).collect(),
            training_recipes: study.records.recipes.clone(),
            training_curves: study.records.curves.clone(),
            lattice: study.lattice.iter().flat_map(lattice::rows).collect(),
            lattice_axial_springs: study.lattice.iter().flat_map(lattice::axial_rows).collect(),
            lattice_settling: study.lattice.iter().flat_map(lattice::settling_rows).collect(),
        }
    }
}
