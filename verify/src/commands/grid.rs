//! Code shared by `finray map`, `sweep` and `merge`: the grid of cells, the models and estimators evaluated on it, and the output table.

use crate::commands::prelude::*;
use finray_files::{open_stream, streamed};
use finray_model::sensing::SensingError;
use finray_model::sensor::PreparedScene;
use finray_report::{map_figure_svg, standalone};
use finray_studies::sampling::map::AccuracyMap;
use finray_studies::sampling::sampled::SampledSensor;
use finray_studies::sampling::situation::{ContactKnowledge, HiddenMarkers, Situation};
use finray_studies::sampling::sweep::{Grid, Head, Partial, Request, Shard, Sweep, Table};
use finray_studies::settings::TRUSTED_ERROR;
use finray_studies::truths::{SAME, Truth};
use std::io::{Read, Write};

#[derive(clap::Args)]
pub struct GridArguments {
    /// Scene file (TOML); - for standard input [default: the paper's finger]
    scene: Option<PathBuf>,
    /// Network file from `finray train` [default: the shipped networks]
    #[arg(long, value_name = "FILE")]
    network: Option<PathBuf>,
    /// Force magnitudes, N, for instance 1,2,3
    #[arg(long, help_heading = "Cells", value_name = "F", value_delimiter = ',', default_values_t = [3.0], value_parser = positive)]
    force_n: Vec<f64>,
    /// Noise samples per cell; a cell is one position and one direction
    #[arg(long, help_heading = "Cells", value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: u32,
    /// Seed of the noise
    #[arg(long, help_heading = "Cells", value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Approximate number of contact positions along the front plate; not used with --truth mujoco or continuum
    #[arg(long, help_heading = "Cells", value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    places: u32,
    /// Step between force directions from -80 to 80 degrees; a step of 90 gives only the normal direction; not used with --truth mujoco or continuum
    #[arg(long, help_heading = "Cells", value_name = "D", default_value_t = 5.0, value_parser = degrees_between)]
    step_deg: f64,
    /// What the sensor knows of the contact: position and direction (known), the same wrongly by 1.5 mm and 12.5 degrees (off), or as in --contact-at
    /// of `sense`; with @, true directions are those that friction allows [default: known]
    #[arg(long, help_heading = "Cells", value_parser = listed(ContactKnowledge::ALL, ContactKnowledge::name))]
    pub knows: Option<ContactKnowledge>,
    /// Hidden markers: none, or those of a third of the front plate at the contact (object) or next to the tip (tip)
    #[arg(long, help_heading = "Cells", value_parser = listed(HiddenMarkers::ALL, HiddenMarkers::name), default_value_t = HiddenMarkers::None)]
    hidden: HiddenMarkers,
    /// Compute only shard I of N; `finray merge` joins the shards
    #[arg(long, help_heading = "Cells", value_name = "I/N")]
    shard: Option<Shard>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

impl GridArguments {
    fn knowledge(&self) -> ContactKnowledge {
        self.knows.unwrap_or(ContactKnowledge::Known)
    }
}

/// Computes a table and writes it row by row. For a map, it also writes the figure. `noise_mm` has the standard deviations of the noise in one
/// coordinate, mm. If `noise_mm` is empty, the scene's value is used, or 0 if the scene states none.
pub fn run(
    arguments: &GridArguments,
    table: Table,
    truth_ids: &[TruthId],
    estimator_ids: &[EstimatorId],
    noise_mm: &[f64],
) -> Result<String, Failure> {
    let (networks, digest) = networks_of(arguments.network.as_deref(), estimator_ids)?;
    let (scene, text) = scene_or_papers(arguments.scene.as_deref(), |_| false)?;
    hints::of_neglected_thickness(&scene);
    let finger = &scene.finger;
    let truth_meshes = truth_ids.iter().map(|id| id.mesh(finger)).collect::<Result<Vec<_>, _>>()?;
    let truths = truth_ids.iter().zip(&truth_meshes).map(|(id, mesh)| id.on(mesh, &scene));
    let truths = truths.collect::<Result<Vec<_>, _>>()?;
    // The true fingers have no other errors of the scene than those of beam theory and stiffness.
    let mut sensed = scene.of_same_finger();
    sensed.contact.lean = scene.contact.lean;
    let sensed = PreparedScene::from(sensed);
    let situation = Situation { contact: arguments.knowledge(), hidden: arguments.hidden };
    let sensor = |id: &EstimatorId| SampledSensor { situation, ..SampledSensor::new(*id, &networks) };
    let sensors: Vec<SampledSensor> = estimator_ids.iter().map(sensor).collect();
    let grid = grid(arguments, noise_mm, &scene, &truths)?;
    for sensor in &sensors {
        require_an_answer(&sensed, sensor, &grid)?;
    }
    let sweep = Sweep::new(sensed, truths.iter().map(|truth| &**truth).collect(), sensors, &grid);
    let request = Request {
        finray: env!("CARGO_PKG_VERSION").to_owned(),
        table,
        truths: truth_ids.to_vec(),
        estimators: estimator_ids.to_vec(),
        situation,
        network: digest,
        scene: text,
        grid: grid.clone(),
    };
    write(&sweep, &scene, Head { shard: arguments.shard, request }, &arguments.out)
}

fn grid(
    arguments: &GridArguments,
    noise_mm: &[f64],
    scene: &Scene,
    truths: &[Box<dyn Truth + '_>],
) -> Result<Grid, Failure> {
    // True fingers from exported data have fixed contact positions and directions. If there are such fingers, the whole grid uses the positions and
    // directions common to all of them.
    let given = truths.iter().map(|truth| truth.positions(&arguments.force_n)).collect::<Result<Vec<_>, _>>()?;
    let exported = given.into_iter().flatten().reduce(|one, other| (shared(one.0, &other.0), shared(one.1, &other.1)));
    let knows = arguments.knowledge();
    if exported.is_some() && knows.is_leaning() {
        return Err(bad_input(format!(
            "--knows {knows}: expected a true finger that can be bent in any direction, because the force follows the bent plate; \
             shapes of --truth mujoco and continuum exist only for fixed directions"
        )));
    }
    let (positions_mm, angles_deg) =
        exported.unwrap_or_else(|| Grid::of_knowledge(scene, knows, arguments.places as usize, arguments.step_deg));
    let growing = |numbers: &[f64]| {
        let mut numbers = numbers.to_vec();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        numbers
    };
    let noise_levels_mm = match noise_mm {
        [] => vec![scene.noise_mm.unwrap_or(0.0)],
        given => growing(given),
    };
    Ok(Grid {
        positions_mm,
        angles_deg,
        is_leaning: knows.is_leaning(),
        forces_n: growing(&arguments.force_n),
        noise_levels_mm,
        noise_samples: arguments.seeds as usize,
        seed: arguments.seed,
    })
}

/// Values (mm or degrees) that are in both lists.
fn shared(one: Vec<f64>, other: &[f64]) -> Vec<f64> {
    one.into_iter().filter(|figure| other.iter().any(|theirs| (figure - theirs).abs() < SAME)).collect()
}

/// Checks that the estimator supports the contact of at least one cell of the grid; otherwise returns the first cell's refusal.
fn require_an_answer(scene: &PreparedScene, sensor: &SampledSensor, grid: &Grid) -> Result<(), Failure> {
    let mut refusal = None;
    for contact in 0..grid.contact_count() {
        match sensor.at(scene, grid.contact(contact)) {
            Ok(_) => return Ok(()),
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    Err(refusal.unwrap_or(SensingError::NoContact.into()).into())
}

fn write(sweep: &Sweep, scene: &Scene, head: Head, out: &Path) -> Result<String, Failure> {
    let table = head.request.table;
    let blocks = head.shard.map_or(0..sweep.block_count(), |shard| shard.blocks(sweep.block_count()));
    let rows = blocks.len() * head.request.rows_in_block();
    let bar = progress_bar(blocks.len() as u64, if table == Table::Map { "map" } else { "sweep" });
    if is_stream(out) {
        let mut stream = open_stream(out)?;
        let begin =
            if head.shard.is_some() { head.to_text().map_err(not_computed)? } else { table.header().to_owned() };
        let mut say = |text: &str| stream.write_all(text.as_bytes()).and_then(|()| stream.flush());
        let said = say(&begin).and_then(|()| {
            sweep.stream(table, blocks, |count, rows| {
                bar.inc(count as u64);
                say(rows)
            })
        });
        bar.finish_and_clear();
        streamed(out, said)?;
        return Ok(summary(count(rows, "row"), None::<&Path>));
    }
    let out = table_path(table, out);
    let whole = head.shard.is_none();
    if whole && table == Table::Map {
        require_writable(&figure_path(&out))?;
    }
    let request = head.request.clone();
    let mut partial = Partial::open(&out, head)?;
    bar.set_position(partial.blocks_done() as u64);
    bar.reset_eta();
    let rest = blocks.start + partial.blocks_done()..blocks.end;
    sweep.stream(table, rest, |count, rows| {
        bar.inc(count as u64);
        partial.append(count, rows).map_err(Failure::from)
    })?;
    bar.finish_and_clear();
    let map = if whole { map_of(&request, partial.table()?)? } else { None };
    let figure = map.as_ref().map(|map| figure(&scene.finger, map, &out)).transpose()?;
    let beside: Vec<_> = figure.into_iter().collect();
    partial.finish(&beside)?;
    let result = map.map_or_else(|| count(rows, "row"), |map| trusted(scene, &map));
    Ok(summary(result, std::iter::once(&out).chain(beside.iter().map(|(path, _)| path))))
}

/// The accuracy map of a complete table; `None` for a sweep.
pub fn map_of(request: &Request, table: impl Read) -> Result<Option<AccuracyMap>, Failure> {
    let is_map = request.table == Table::Map;
    is_map.then(|| AccuracyMap::from_csv(request, table).map_err(bad_input)).transpose()
}

/// Path and SVG text of the map's figure, which is written beside the table `out`.
pub fn figure(finger: &Finger, map: &AccuracyMap, out: &Path) -> Result<(PathBuf, String), Failure> {
    let figure = map_figure_svg(finger, map, None).map_err(not_computed)?;
    Ok((figure_path(out), standalone(&figure)))
}

/// Summary of a map: its trusted share, what limits it if the modulus does, and the shares of the noise samples that are refused and that are answered
/// with a warning.
pub fn trusted(scene: &Scene, map: &AccuracyMap) -> String {
    let trust = map.trust(&scene.finger);
    let weighed = map.weighed(&scene.finger, scene.stiffness_error).map_or_else(String::new, |it| format!("; {it}"));
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let share = trust.share().map_or("none".to_owned(), percent);
    let noise = match map.noise_mm {
        0.0 => "no camera noise".to_owned(),
        noise_mm => format!("{noise_mm} mm noise"),
    };
    let samples = trust.samples().map_or_else(String::new, |shares| {
        let [refused, warned] = shares.map(percent);
        format!(", {refused} of samples refused, {warned} with a warning")
    });
    let without = match trust.without_equilibrium {
        0 => String::new(),
        without => format!(", {without} of {} without equilibrium", count(trust.cells, "cell")),
    };
    let limit = percent(TRUSTED_ERROR);
    format!("{share} trusted ({}, error up to {limit}, {noise}){samples}{without}{weighed}", map.situation)
}

/// Path of a table; for a map, the suffix becomes csv if the figure would have the same path as the table.
pub fn table_path(table: Table, out: &Path) -> PathBuf {
    if table == Table::Map { path_beside_figure(out) } else { out.to_owned() }
}
