//! `finray grasp`

use crate::commands::prelude::*;
use clap::value_parser;
use finray_figures::FigureError;
use finray_report::{grasp_animation_svg, grasp_svg, standalone};
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::experiments::grasp::file::{force_rows, object_row};
use finray_studies::experiments::grasp::{
    Eyes, FINENESS, GraspEnd, GraspError, GraspScene, GraspStep, Summary, finger_name,
};

/// Two fingers grasp a free object, carry it and put it down: true forces, and those that are sensed.
///
/// Needs a scene with the tables gripper, object (a free one, with mass_g and centre_mm) and grasp.
/// The frame is that of the gripper where it starts: origin on the screw's axis at the height of the
/// fixed joints, x to the right finger, y along the screw to the fingertips. Each finger is a lattice
/// of rigid bodies and springs on its moving base; object and fingers touch with Coulomb friction;
/// every step is solved for equilibrium. Sensing is given the motor's angle, the displacements of the
/// key nodes and points of the outlines with the noise of --noise-mm, or with --images what is
/// located in images that are rendered of each finger; which parts touch and the coefficient of
/// friction are assumed known. The support (grasp.support) is rails between which the fingers pass, or
/// a table; a grasp ends where a finger touches the table or the other finger.
///
/// Writes into the folder --out:
///   forces.csv    step,motor_deg,phase,finger,contact,s_mm,angle_deg,force_n,friction_n,sensed_n,
///                 sigma_n: a row a contact as `finray press` has it, and a row `total` a finger and
///                 step: force_n across the gripper, friction_n along it
///   object.csv    step,motor_deg,phase,x_mm,y_mm,rotation_rad,force_x_n,force_y_n,support_x_n,
///                 support_y_n: the object's point, and the forces of both fingers and of the support
///                 on it
///   grasp.svg     fingers and object at some steps, forces step by step and over the motor's angle
///   grasp-animation.svg
///                 the whole grasp in one drawing that moves (in print it stands still)
///   summary.json  how it ended, balance, errors of the sensed forces, and in `energy` where the
///                 motor's work went, N mm: stored in the fingers and in the weight, lost to friction
///                 and to the resistance where the equilibrium jumps, what was created, and the error
///                 of the account
///
/// phase is approach, close, hold, lift, carry, place or open. A grasp that fails (the object drops,
/// slips or is out of reach, the fingers fold, jam or touch each other or the table) writes what was
/// until then and ends with exit code 1.
///
/// Examples:
///   finray grasp fixtures/scenes/grasp/disc.toml --out disc
///   finray grasp fixtures/scenes/grasp/loop.toml --noise-mm 0.01 --out loop
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML) with a gripper, a free object and a grasp; - for standard input
    scene: PathBuf,
    /// Standard deviation of one displacement coordinate and of one coordinate of an outline point, mm;
    /// the scene's, or 0, if not given
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Sense from images that the scene's camera would take of each finger, standing before it, or on the gripper, as the scene has it;
    /// the noise is then that of outline points alone
    #[arg(long)]
    images: bool,
    /// With --images: noise of every channel of every pixel, grey levels of 255
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = not_negative, requires = "images")]
    grey_noise: f64,
    /// With --images: blur, px
    #[arg(long, value_name = "S", default_value_t = 0.8, value_parser = not_negative, requires = "images")]
    blur_px: f64,
    /// Sense with an estimator of `finray sense` instead: contacts are then what they are read as, without friction, which sigma_n does
    /// not allow for; the network takes forces for normal to the undeformed plate
    #[arg(long, value_name = "E", value_parser = listed::<EstimatorId>())]
    estimator: Option<EstimatorId>,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Segments of the lattice in a member of a plate, between two rods: shapes are within 0.4 % of converged beams
    /// under 5 N with 2, 0.1 % with 3, 0.03 % with 4
    #[arg(long, value_name = "N", default_value_t = FINENESS as u16, value_parser = value_parser!(u16).range(1..=12))]
    fineness: u16,
    /// Folder of the results
    #[arg(long, value_name = "DIR", default_value = "finray-grasp")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if is_stream(&arguments.out) {
        return Err(Failure::BadInput("--out: expected a folder, for five files".to_owned()));
    }
    let SceneWithOutline { scene, corners } = load_scene_with_outline(&arguments.scene)?;
    let name = name_of(&arguments.scene);
    let bad = |error: GraspError| {
        // What is missing stands on no line: the first is named, as for any other key.
        let at = if matches!(error, GraspError::Missing { .. } | GraspError::NotFree) { "line 1: " } else { "" };
        match Failure::from(error) {
            Failure::BadInput(message) => Failure::BadInput(format!("{name}: {at}{message}")),
            other => other,
        }
    };
    let mut grasp = GraspScene::new(&scene, &corners).map_err(bad)?.with_fineness(arguments.fineness.into());
    if let Some(estimator) = arguments.estimator {
        grasp = grasp.with_estimator(estimator, Networks::read(&finray_fixtures::NETWORKS)?);
    }
    let noise_mm = arguments.noise_mm.or(scene.noise_mm).unwrap_or(0.0);
    let eyes = if arguments.images {
        let (camera, markers) = camera_and_markers(&arguments.scene, &scene)?;
        Eyes::Images {
            camera: Box::new(camera),
            markers,
            grey_noise: arguments.grey_noise,
            blur_px: arguments.blur_px,
            outline_noise_mm: noise_mm,
        }
    } else {
        Eyes::Noise(noise_mm)
    };
    require_folder(&arguments.out)?;
    let bar = progress::bar(grasp.most_steps() as u64, "grasp");
    bar.tick();
    let mut steps: Vec<GraspStep> = Vec::new();
    let ended = grasp.run(&eyes, arguments.seed, |step| {
        for (finger, of) in step.fingers.iter().enumerate() {
            if let Err(refusal) = &of.sensed {
                bar.suspend(|| {
                    print_message(format_args!("note: step {}, {} finger: {refusal}", step.step, finger_name(finger)))
                });
            }
        }
        bar.set_message(step.phase.to_string());
        bar.inc(1);
        steps.push(step.clone());
    });
    bar.finish_and_clear();
    let ended = ended.map_err(bad)?;
    write(arguments, &scene.name, &grasp, &steps, &ended)?;
    match ended {
        GraspEnd::Done => Ok(()),
        failed => {
            let last = steps.last();
            let at = last.map_or("before its first step".to_owned(), |step| {
                format!("after step {} ({}, motor at {:.1} degrees)", step.step, step.phase, step.motor_deg)
            });
            Err(Failure::NotComputed(format!(
                "{at}: {failed}; the steps until then are in {}",
                arguments.out.display()
            )))
        }
    }
}

fn write(
    arguments: &Arguments,
    name: &str,
    grasp: &GraspScene,
    steps: &[GraspStep],
    ended: &GraspEnd,
) -> Result<(), Failure> {
    let forces = csv_text(steps.iter().flat_map(|step| force_rows(grasp, step)))?;
    let object = csv_text(steps.iter().map(object_row))?;
    let summary = serde_json::to_string_pretty(&Summary::new(name, grasp, steps, ended))
        .map_err(|error| Failure::NotComputed(error.to_string()))?;
    let mut files = vec![("forces.csv", forces), ("object.csv", object), ("summary.json", summary + "\n")];
    if !steps.is_empty() {
        let drawn = |figure: Result<String, FigureError>| {
            figure.map(|svg| standalone(&svg)).map_err(|error| Failure::NotComputed(error.to_string()))
        };
        files.push(("grasp.svg", drawn(grasp_svg(name, grasp, steps))?));
        files.push(("grasp-animation.svg", drawn(grasp_animation_svg(name, grasp, steps))?));
    }
    let files: Vec<(PathBuf, String)> = files.into_iter().map(|(name, text)| (PathBuf::from(name), text)).collect();
    Ok(write_folder(&arguments.out, &files)?)
}

impl From<GraspError> for Failure {
    fn from(error: GraspError) -> Failure {
        match error {
            GraspError::Lattice(inner) => inner.into(),
            GraspError::World(finray_lattice::grasp::WorldError::Lattice(inner)) => inner.into(),
            other => Failure::BadInput(other.to_string()),
        }
    }
}
