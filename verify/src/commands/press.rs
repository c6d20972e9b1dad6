//! The command `finray press`.

use super::validity::Pressing;
use crate::commands::prelude::*;
use clap::value_parser;
use finray_files::displacements;
use finray_report::{DrawnPress, press_svg, standalone};
use finray_studies::experiments::contact_scene::checks::BALANCE_TOLERANCE;
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::refined::TOTAL_TOLERANCE;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::experiments::contact_scene::{ContactScene, Refinement, TotalChange, force_rows};
use finray_studies::sampling::noise::Noise;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray press fixtures/scenes/contact/disc.toml
  finray press fixtures/scenes/contact/disc.toml --noise-mm 0 --shape shape.csv --out forces.csv
  finray press fixtures/scenes/contact/friction.toml --fineness 2 --seed 7

Guide: finray guide press-and-grasp";

/// Simulate an object pressed onto a finger, and sense the contact forces at each step.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML) with an object; - for standard input
    scene: PathBuf,
    /// Standard deviation of the noise in one coordinate of a node or outline point, mm [default: the scene's, or 0]
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Lattice segments per plate member [default: doubled until total forces change by under 0.1 %]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=100))]
    fineness: Option<u16>,
    /// Also write the displacements of the last step to FILE, in the format of `finray solve`
    #[arg(long, value_name = "FILE")]
    shape: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// A warning is printed if the object stops farther than this from its prescribed position, mm; rounding alone causes less.
const STOPPED_MM: f64 = 1e-6;

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    if let Some(shape) = &arguments.shape {
        if is_standard_stream(shape) {
            return Err(bad_input("--shape: expected a file, found -: standard output receives the forces"));
        }
        if *shape == arguments.out || *shape == figure_path(&arguments.out) {
            return Err(bad_input(
                "expected different files for --shape and --out, and for the figure beside --out; found the same file twice",
            ));
        }
    }
    let SceneWithOutline { scene, corners, .. } = load_scene_with_outline(&arguments.scene)?;
    let Some(object) = &scene.object else {
        let message = format!(
            "{}: line 1: object is missing: expected a table [object] with shape, at_mm and travel_mm or force_n",
            arguments.scene.display()
        );
        return Err(bad_input(message));
    };
    let mut contact_scene = ContactScene::new(&scene, object, &corners).map_err(bad_input)?;
    if let Some(fineness) = arguments.fineness {
        contact_scene = contact_scene.with_fineness(fineness.into());
    }
    let noise_mm = arguments.noise_mm.or(scene.noise_mm).unwrap_or(0.0);
    let mut noise = Noise::new(arguments.seed);
    let mut steps = Vec::new();
    let outcome = contact_scene.run(|step| steps.push(step));
    let mut rows = Vec::new();
    let mut validity = Pressing::default();
    let bar = progress_bar(steps.len() as u64, "press");
    let say = |message: std::fmt::Arguments| bar.suspend(|| print_message(message));
    for (number, step) in (1..).zip(&steps) {
        let sensed = contact_scene.sense(step, noise_mm, || noise.standard_normal());
        if let Err(refusal) = &sensed {
            say(format_args!("note: step {number}: {refusal}"));
        }
        if let Some(imbalance) = step.pressed.imbalance().filter(|imbalance| *imbalance > BALANCE_TOLERANCE) {
            say(format_args!(
                "note: step {number}: contact forces and the reaction at the base differ by {imbalance:.1e} of the contact forces"
            ));
        }
        if step.stopped_mm > STOPPED_MM {
            say(format_args!(
                "warning: step {number}: the clamped end of the finger stops the object {:.3} mm before its prescribed position",
                step.stopped_mm
            ));
        }
        rows.extend(force_rows(&contact_scene, number, step, sensed.ok().flatten().as_ref()));
        validity.examine(&scene, step);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let ended = match outcome {
        Ok(Refinement { fineness, change: Some(change) }) if change.share > TOTAL_TOLERANCE => {
            let TotalChange { step, share } = change;
            let differ = format!("with half as many segments, the total force differs by {:.1} %", 100.0 * share);
            print_message(format_args!(
                "warning: step {step}: a lattice of {fineness} segments per member is coarse: {differ}"
            ));
            Ok(())
        }
        Ok(_) => Ok(()),
        Err(error) => match Failure::from(error) {
            Failure::BadInput(message) => return Err(bad_input(format!("{}: {message}", arguments.scene.display()))),
            Failure::NotComputed(message) => {
                Err(format!("step {} of {}: {message}", steps.len() + 1, contact_scene.step_count()))
            }
        },
    };
    let Some(last) = steps.last() else {
        return ended.map(|()| summary("no step", None::<&Path>)).map_err(not_computed);
    };
    let press = DrawnPress {
        finger: &scene.finger,
        name: &scene.name,
        noise_mm,
        outline: &contact_scene.object().outline.points(),
        rows: &rows,
        last,
    };
    let files = write(arguments, &press)?;
    if let Err(message) = ended {
        let force_n = last.pressed.contact_force().norm();
        let until = format!("the steps until then, to a travel of {:.3} mm with {force_n:.3} N", last.travel_mm);
        return Err(not_computed(format!("{message}; {until}, are written")));
    }
    validity.warn();
    let force_n = last.pressed.contact_force().norm();
    let done =
        format!("{}, the last at a travel of {:.3} mm with {force_n:.3} N", count(steps.len(), "step"), last.travel_mm);
    Ok(summary(done, &files))
}

/// Writes the table, its figure and the shape, and returns their paths.
fn write(arguments: &Arguments, press: &DrawnPress) -> Result<Vec<PathBuf>, Failure> {
    let out = if is_stream(&arguments.out) { arguments.out.clone() } else { path_beside_figure(&arguments.out) };
    let mut files = Vec::new();
    if let Some(path) = &arguments.shape {
        files.push((path.clone(), displacements::to_csv(&press.last.pressed.shape, press.finger)?));
    }
    if !is_stream(&out) {
        files.push((figure_path(&out), standalone(&press_svg(press).map_err(not_computed)?)));
    }
    files.push((out, csv_text(press.rows)?));
    write_all_or_nothing(&files)?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}
