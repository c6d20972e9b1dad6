//! The command `finray press`.

use crate::commands::prelude::*;
use clap::value_parser;
use finray_contact::press::{ContactScene, NO_OBJECT, Press};
use finray_files::displacements;
use finray_report::{DrawnPress, press_svg, standalone};
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;

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
    /// Standard deviation of the noise in one coordinate of a node or outline point, mm [default: the scene's value, or 0]
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Elements per plate member [default: doubled until total forces change by under 0.1 %]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=100))]
    fineness: Option<u16>,
    /// Also write the displacements of the last step to FILE, in the format of `finray solve`
    #[arg(long, value_name = "FILE")]
    shape: Option<PathBuf>,
    /// Result file; a figure is also written, with suffix .svg; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    if let Some(shape) = &arguments.shape {
        if is_standard_stream(shape) {
            return Err(bad_input("--shape: expected a file, found -, but standard output receives the forces"));
        }
        if *shape == arguments.out || *shape == figure_path(&arguments.out) {
            return Err(bad_input(
                "expected different files for --shape and --out, and for the figure beside --out; found the same file twice",
            ));
        }
    }
    let SceneWithOutline { scene, corners, .. } = load_scene_with_outline(&arguments.scene)?;
    hints::of_scene(&arguments.scene, &scene);
    let Some(object) = &scene.object else {
        return Err(FileError::content(&arguments.scene, NO_OBJECT).into());
    };
    let mut contact_scene = ContactScene::new(&scene, object, &corners).map_err(bad_input)?;
    if let Some(fineness) = arguments.fineness {
        contact_scene = contact_scene.with_fineness(fineness.into());
    }
    let noise_mm = arguments.noise_mm.or(scene.noise_mm).unwrap_or(0.0);
    let bar = progress_bar(0, "press");
    let press = Press::run(&scene, &contact_scene, noise_mm, arguments.seed, |notes, steps| {
        bar.set_length(steps as u64);
        bar.suspend(|| notes.iter().for_each(print_message));
        bar.inc(1);
    });
    bar.finish_and_clear();
    let Press { steps, rows, .. } = &press;
    let ended = match &press.ended {
        Ok(warning) => {
            warning.iter().for_each(print_message);
            Ok(())
        }
        Err(error) => match Failure::from(*error) {
            Failure::BadInput(message) => return Err(bad_input(format!("{}: {message}", arguments.scene.display()))),
            Failure::NotComputed(message) => {
                Err(format!("step {} of {}: {message}", steps.len() + 1, contact_scene.step_count()))
            }
        },
    };
    let Some(last) = steps.last() else {
        return ended.map(|()| summary("no step", None::<&Path>)).map_err(not_computed);
    };
    let drawn = DrawnPress {
        finger: &scene.finger,
        name: &scene.name,
        noise_mm,
        outline: &contact_scene.object().outline.points(),
        rows,
        last,
    };
    let files = write(arguments, &drawn)?;
    if let Err(message) = ended {
        let force_n = last.pressed.contact_force().norm();
        let until = format!("the steps until then, to a travel of {:.3} mm with {force_n:.3} N", last.travel_mm);
        return Err(not_computed(format!("{message}; {until}, are written")));
    }
    press.validity_warnings().iter().for_each(print_message);
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
