//! `finray press`

use super::validity::Pressing;
use crate::commands::prelude::*;
use clap::value_parser;
use finray_files::displacements;
use finray_studies::experiments::contact_scene::checks::{BALANCE_TOLERANCE, SETTLING_TOLERANCE};
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::experiments::contact_scene::{ContactScene, FINENESS, SceneStep, force_rows};
use finray_studies::sampling::noise::Noise;

/// Press an object onto the finger, and sense the contact forces as it goes.
///
/// Needs a scene with an object table: a disc, a box, or a polygon from a CSV file (x_mm,y_mm,
/// beside the scene), with optional friction, pressed along a line to a travel or a force, or moved
/// along a path; see fixtures/scenes/contact. The finger is a lattice of rigid bodies and springs in
/// the physics engine rapier: the forces of its contacts are the true ones. Sensing uses what a camera
/// measures: displacements of the key nodes, and position and direction of every contact, read from the
/// outlines of object and finger; all with the noise of --noise-mm a coordinate. Which parts touch and
/// the object's coefficient of friction are assumed known; a force may lie anywhere in the cone of
/// that friction around its normal. sigma_n covers all of this. The object touches the front plate
/// and its rods; the finger does not touch itself.
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
    /// Segments of the lattice in a member of a plate, between two rods: shapes are within 0.4 % under
    /// 5 N with 2, 0.1 % with 3, 0.03 % with 4, in 1, 2 and 4 times the time; 1 is for a first look
    /// (sigma_n does not allow for this difference: with 1 it is more than the camera's noise)
    #[arg(long, value_name = "N", default_value_t = FINENESS as u16, value_parser = value_parser!(u16).range(1..=12))]
    fineness: u16,
    /// Also write the last shape, as `finray solve` does
    #[arg(long, value_name = "FILE")]
    shape: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

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
    let contact_scene =
        ContactScene::new(&scene, object, &corners).map_err(bad_input)?.with_fineness(arguments.fineness.into());
    let noise_mm = arguments.noise_mm.or(scene.noise_mm).unwrap_or(0.0);
    let mut noise = Noise::new(arguments.seed);
    let (mut rows, mut steps, mut last) = (Vec::new(), 0, None);
    let mut validity = Pressing::default();
    let bar = progress::bar(contact_scene.step_count() as u64, "press");
    bar.tick();
    let outcome = contact_scene.run(|step| {
        steps += 1;
        let sensed = contact_scene.sense(&step, noise_mm, || noise.standard_normal());
        if let Err(refusal) = &sensed {
            bar.suspend(|| print_message(format_args!("note: step {steps}: {refusal}")));
        }
        if let Some(doubt) = doubt(&step) {
            bar.suspend(|| print_message(format_args!("note: step {steps}: {doubt}")));
        }
        rows.extend(force_rows(&contact_scene, steps, &step, sensed.ok().flatten().as_ref()));
        validity.examine(&scene, &step);
        last = Some(step);
        bar.inc(1);
    });
    bar.finish_and_clear();
    if let Err(error) = outcome {
        let reached = last.map_or(String::new(), |step| {
            let force_n = step.pressed.contact_force().norm();
            format!(" (step {steps} came to rest at a travel of {:.3} mm with {force_n:.3} N)", step.travel_mm)
        });
        return Err(match Failure::from(error) {
            Failure::BadInput(message) => bad_input(format!("{}: {message}", arguments.scene.display())),
            Failure::NotComputed(message) => {
                not_computed(format!("step {} of {}: {message}{reached}", steps + 1, contact_scene.step_count()))
            }
        });
    }
    write(arguments, &scene.finger, csv_text(rows)?, last.as_ref())?;
    validity.warn();
    Ok(())
}

/// Why a step would fail the checks of the report.
fn doubt(step: &SceneStep) -> Option<String> {
    let imbalance = step.pressed.imbalance()?;
    if imbalance > BALANCE_TOLERANCE {
        return Some(format!(
            "contact forces, the object's and those on the base differ by {imbalance:.1e} of their size"
        ));
    }
    match step.equilibrium_difference {
        Some(difference) if difference <= SETTLING_TOLERANCE => None,
        Some(difference) => Some(format!(
            "the shape is {difference:.1e} of the largest displacement off equilibrium under these forces"
        )),
        None => Some("Newton's method finds no equilibrium under these forces".to_owned()),
    }
}

fn write(arguments: &Arguments, finger: &Finger, forces: String, last: Option<&SceneStep>) -> Result<(), Failure> {
    let mut files = Vec::new();
    if let (Some(path), Some(step)) = (&arguments.shape, last) {
        files.push((path.clone(), displacements::to_csv(&step.pressed.shape, finger)?));
    }
    files.push((arguments.out.clone(), forces));
    Ok(write_all_or_nothing(&files)?)
}
