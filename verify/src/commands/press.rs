//! `finray press`

use super::validity::Pressing;
use crate::commands::prelude::*;
use clap::value_parser;
use finray_files::displacements;
use finray_studies::experiments::contact_scene::checks::BALANCE_TOLERANCE;
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::refined::TOTAL_TOLERANCE;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::experiments::contact_scene::{ContactScene, Refinement, SceneStep, TotalChange, force_rows};
use finray_studies::sampling::noise::Noise;

/// Press an object onto the finger, and sense the contact forces as it goes.
///
/// Needs a scene with an object table: a disc, a box, or a polygon from a CSV file (x_mm,y_mm,
/// beside the scene), with optional friction, pressed along a line to a travel or a force, or moved
/// along a path; see fixtures/scenes/contact. The finger is a lattice of rigid bodies and springs;
/// every step is its quasi-static equilibrium with the object at its prescribed position, with Coulomb
/// friction and its history. The forces of its contacts are the true ones. The report has the same
/// equilibria held in the physics engine rapier. Sensing uses what a camera measures: displacements
/// of the key nodes, and position and direction of every contact, read from the outlines of object
/// and finger; all with the noise of --noise-mm a coordinate. Which parts touch and the object's
/// coefficient of friction are assumed known; a force may lie anywhere in the cone of that friction
/// around its normal. sigma_n covers all of this. The object touches the front plate and its rods;
/// the finger does not touch itself.
///
/// Writes step,travel_mm,contact,s_mm,angle_deg,force_n,friction_n,sensed_n,sigma_n,read_s_mm,
/// read_angle_deg: a row a contact, from the base to the tip, and a row `total` a step: the force
/// along the object's way, without what the clamp takes.
/// `contact` is a node, `at` for a position between nodes, or `clamp` where a force is not sensed;
/// `angle_deg` is the normal, from the front plate's undeformed inward normal; `force_n` is the true
/// force along it and `friction_n` the one across it, positive towards the tip; `sensed_n` is the
/// sensed force along the normal, and `read_s_mm` and `read_angle_deg` are the position and normal,
/// with noise, that it was sensed from. They stay empty where the forces are not identifiable.
///
/// Where the clamped end of the plate is in its way, the object stops there, and a warning says so.
/// A press that fails (the finger lets go, jams or folds) writes the steps before and ends with
/// exit code 1.
///
/// A warning on standard error names the step that strains most where the beam model does not hold, as
/// beams under the true contact forces have it (see `finray solve --help`).
///
/// Examples:
///   finray press fixtures/scenes/contact/disc.toml
///   finray press fixtures/scenes/contact/disc.toml --noise-mm 0 --shape shape.csv --out forces.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML) with an object; - for standard input
    scene: PathBuf,
    /// Standard deviation of one displacement coordinate and of one coordinate of an outline point, mm;
    /// the scene's, or 0, if not given
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Segments of the lattice in a plate member of mean length; if not given, they are halved until no
    /// total changes by more than 0.1 %, and a warning says by how much it does where that takes too many.
    /// On the paper's finger under 5 N shapes are within 0.4 % with 2, 0.1 % with 3, 0.03 % with 4; 1 is for
    /// a first look (sigma_n does not allow for this difference)
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=100))]
    fineness: Option<u16>,
    /// Also write the last shape, as `finray solve` does
    #[arg(long, value_name = "FILE")]
    shape: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// A stop that is rounding, mm.
const STOPPED_MM: f64 = 1e-6;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(shape) = &arguments.shape {
        if is_standard_stream(shape) {
            return Err(bad_input("--shape: expected a file, found -: standard output takes the forces"));
        }
        if *shape == arguments.out {
            return Err(bad_input("--shape and --out are the same file"));
        }
    }
    let SceneWithOutline { scene, corners } = load_scene_with_outline(&arguments.scene)?;
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
    let bar = progress::bar(steps.len() as u64, "press");
    for (number, step) in (1..).zip(&steps) {
        let sensed = contact_scene.sense(step, noise_mm, || noise.standard_normal());
        if let Err(refusal) = &sensed {
            bar.suspend(|| print_message(format_args!("note: step {number}: {refusal}")));
        }
        if let Some(imbalance) = step.pressed.imbalance().filter(|imbalance| *imbalance > BALANCE_TOLERANCE) {
            let share = format!("{imbalance:.1e} of their size");
            bar.suspend(|| {
                print_message(format_args!(
                    "note: step {number}: contact forces and those on the base differ by {share}"
                ))
            });
        }
        if step.stopped_mm > STOPPED_MM {
            let short = format!("{:.3} mm before its prescribed position", step.stopped_mm);
            bar.suspend(|| {
                print_message(format_args!(
                    "warning: step {number}: the clamped end of the finger stops the object {short}"
                ))
            });
        }
        rows.extend(force_rows(&contact_scene, number, step, sensed.ok().flatten().as_ref()));
        validity.examine(&scene, step);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let ended = match outcome {
        Ok(Refinement { fineness, change: Some(change) }) if change.share > TOTAL_TOLERANCE => {
            let TotalChange { step, share } = change;
            let differ = format!("its total and that with half as many differ by {:.1} %", 100.0 * share);
            print_message(format_args!(
                "warning: step {step}: a lattice of {fineness} segments a member is coarse: {differ}"
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
    let Some(last) = steps.last() else { return ended.map_err(not_computed) };
    write(arguments, &scene.finger, csv_text(rows)?, last)?;
    if let Err(message) = ended {
        let force_n = last.pressed.contact_force().norm();
        let until = format!("the steps until then, to a travel of {:.3} mm with {force_n:.3} N", last.travel_mm);
        return Err(not_computed(format!("{message}; {until}, are written")));
    }
    validity.warn();
    Ok(())
}

fn write(arguments: &Arguments, finger: &Finger, forces: String, last: &SceneStep) -> Result<(), Failure> {
    let mut files = Vec::new();
    if let Some(path) = &arguments.shape {
        files.push((path.clone(), displacements::to_csv(&last.pressed.shape, finger)?));
    }
    files.push((arguments.out.clone(), forces));
    Ok(write_all_or_nothing(&files)?)
}
