//! The command `finray grasp`.

mod stream;

use crate::commands::prelude::*;
use clap::value_parser;
use finray_contact::WorldError;
use finray_figures::FigureError;
use finray_report::{grasp_animation_svg, grasp_svg, standalone};
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::experiments::grasp::file::{force_rows, object_row};
use finray_studies::experiments::grasp::{
    Eyes, FINENESS, GraspEnd, GraspError, GraspScene, GraspStep, Summary, finger_name,
};
use stream::{Streams, stream_of_finger};

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray grasp fixtures/scenes/grasp/disc.toml --out disc
  finray grasp fixtures/scenes/grasp/camera.toml --images --noise-mm 0.01 --out watched
  finray grasp fixtures/scenes/grasp/loop.toml --noise-mm 0.01 --out loop
  finray grasp scene.toml --images --stream left=- | finray live scene.toml --contact-at auto@auto --every-frame

Guide: finray guide press-and-grasp";

/// Simulate a gripper that grasps, carries and puts down an object; write true and sensed forces.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML) with a gripper, a free object and a grasp; - for standard input
    scene: PathBuf,
    /// Standard deviation of the noise in one coordinate of a node or outline point, mm [default: the scene's value, or 0]
    #[arg(long, help_heading = "Sensing", value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Sense from rendered images of each finger; --noise-mm then applies only to outline points, not to markers
    #[arg(long, help_heading = "Sensing")]
    images: bool,
    /// Standard deviation of pixel noise, in grey levels from 0 to 255
    #[arg(long, help_heading = "Sensing", value_name = "S", default_value_t = 2.0, value_parser = not_negative, requires = "images")]
    grey_noise: f64,
    /// Standard deviation of the Gaussian image blur, px
    #[arg(long, help_heading = "Sensing", value_name = "S", default_value_t = 0.8, value_parser = not_negative, requires = "images")]
    blur_px: f64,
    /// Write the images of a finger (left or right) as YUV4MPEG2, one frame per step, for `finray live`; - for standard output
    #[arg(long, help_heading = "Sensing", value_name = "FINGER=FILE", value_parser = stream_of_finger, requires = "images")]
    stream: Vec<(usize, PathBuf)>,
    /// Estimator, as in `finray sense`; it treats the measured contacts as exact and frictionless
    #[arg(long, help_heading = "Sensing", value_name = "E", value_parser = listed(EstimatorId::ALL, EstimatorId::name))]
    estimator: Option<EstimatorId>,
    /// Seed of the noise
    #[arg(long, help_heading = "Sensing", value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Elements per plate member
    #[arg(long, value_name = "N", default_value_t = FINENESS as u16, value_parser = value_parser!(u16).range(1..=12))]
    fineness: u16,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "finray-grasp")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    if is_stream(&arguments.out) {
        return Err(bad_input("--out: expected a folder for five files, found -"));
    }
    let SceneWithOutline { scene, corners, .. } = load_scene_with_outline(&arguments.scene)?;
    hints::of_scene(&arguments.scene, &scene);
    let name = name_of(&arguments.scene);
    let bad = |error: GraspError| {
        // A missing table has no line number; the message names line 1, as for any missing key.
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
            renders_free: !arguments.stream.is_empty(),
        }
    } else {
        Eyes::Noise(noise_mm)
    };
    require_folder(&arguments.out)?;
    let streams = arguments.stream.iter().map(|(_, file)| file.as_path());
    require_separate_files(streams.clone(), [arguments.scene.as_path(), &arguments.out])?;
    streams.clone().try_for_each(require_writable)?;
    let mut streams = Streams::open(&arguments.stream, &scene, grasp.grasp())?;
    let bar = progress_bar(grasp.most_steps() as u64, "grasp");
    bar.tick();
    let mut steps: Vec<GraspStep> = Vec::new();
    let ended = grasp.run_with_images(&eyes, arguments.seed, |step, images| {
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
        streams.write(images)
    });
    bar.finish_and_clear();
    let ended = ended.map_err(bad)?;
    streams.end()?;
    write(arguments, &scene.name, &grasp, &steps, &ended)?;
    match ended {
        GraspEnd::Done => {
            let done = format!("grasp of {} and its figures", count(steps.len(), "step"));
            Ok(summary(done, arguments.stream.iter().map(|(_, file)| file).chain([&arguments.out])))
        }
        failed => {
            let at = steps.last().map_or("before its first step".to_owned(), |step| {
                format!("after step {} ({}, motor at {:.1} degrees)", step.step, step.phase, step.motor_deg)
            });
            Err(not_computed(format!(
                "{at}: {failed}; the steps before the failure are in {}",
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
    let numbers = serde_json::to_string_pretty(&Summary::new(name, grasp, steps, ended)).map_err(not_computed)?;
    let mut files = vec![("forces.csv", forces), ("object.csv", object), ("summary.json", numbers + "\n")];
    if !steps.is_empty() {
        let drawn = |figure: Result<String, FigureError>| figure.map(|svg| standalone(&svg)).map_err(not_computed);
        files.push(("grasp.svg", drawn(grasp_svg(name, grasp, steps))?));
        files.push(("grasp-animation.svg", drawn(grasp_animation_svg(name, grasp, steps))?));
    }
    Ok(write_folder(&arguments.out, &files)?)
}

impl From<GraspError> for Failure {
    fn from(error: GraspError) -> Failure {
        match error {
            GraspError::World(WorldError::Finger(inner)) => inner.into(),
            other => bad_input(other),
        }
    }
}
