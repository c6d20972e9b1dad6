//! The command `finray render`.

use super::loads::Loads;
use crate::commands::prelude::*;
use finray_files::displacements;
use finray_imaging::render::{Disturbances, RenderRequest, render};
use finray_model::camera::Camera;
use image::ImageFormat;
use nalgebra::Isometry2;
use std::io::Cursor;

/// Largest accepted standard deviation of the blur, px; a larger blur makes a marker of a few pixels invisible.
const LARGEST_BLUR_PX: f64 = 100.0;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray render fixtures/scenes/camera.toml --load-at 80:2,-20 --out image.png
  finray render fixtures/scenes/bracketed.toml --base 60,-75,90 --load-at 75:3,5 --out image.png
  finray render fixtures/scenes/camera.toml --shape shape.csv --grey-noise 2 --blur-px 0.8
      --hide 18 --out image.png

Guide: finray guide photographs";

/// Render the scene camera's image of the finger, undeformed or under loads.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    #[command(flatten)]
    loads: Loads,
    /// Displacements instead of loads (CSV from `solve` or `press`); - for standard input
    #[arg(long, value_name = "FILE", conflicts_with_all = ["load", "load_at", "mesh_nodes"])]
    shape: Option<PathBuf>,
    /// Pose of a movable base, in the same frame as the camera's pose
    #[arg(long, value_name = "X_MM,Y_MM,DEG", value_parser = moved_base, allow_hyphen_values = true)]
    base: Option<Isometry2<f64>>,
    /// Standard deviation of pixel noise, in grey levels from 0 to 255
    #[arg(long, help_heading = "Camera", value_name = "S", value_parser = not_negative, default_value_t = 0.0)]
    grey_noise: f64,
    /// Standard deviation of a Gaussian blur, px
    #[arg(long, help_heading = "Camera", value_name = "S", value_parser = not_negative, default_value_t = 0.0)]
    blur_px: f64,
    /// Share of light missing in the image corners, 0 to 1
    #[arg(long, help_heading = "Camera", value_name = "SHARE", value_parser = share, default_value_t = 0.0)]
    light_falloff: f64,
    /// Number of added discs and boxes; half of the shapes have the markers' colours
    #[arg(long, help_heading = "Camera", value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1000))]
    clutter: u16,
    /// Nodes without markers in the image
    #[arg(long, help_heading = "Camera", value_name = "NODE", num_args = 1..)]
    hide: Vec<usize>,
    /// Seed of noise and clutter
    #[arg(long, help_heading = "Camera", value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Result file (PNG); - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    require_one_standard_input([&arguments.scene].into_iter().chain(&arguments.shape))?;
    if arguments.blur_px > LARGEST_BLUR_PX {
        let found = arguments.blur_px;
        return Err(bad_input(format!("--blur-px: expected at most {LARGEST_BLUR_PX} px, found {found}")));
    }
    let scene = load_scene(&arguments.scene)?;
    let finger = &scene.finger;
    let (camera, markers) = camera_and_markers(&arguments.scene, &scene)?;
    let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
    let camera = match (&arguments.base, &scene.base) {
        (None, _) => camera,
        (Some(base), Some(_)) => Camera { pose: camera.pose.of_moved_base(base), ..camera },
        (Some(_), None) => {
            return Err(bad_input("--base: expected a scene with a table [base], found none"));
        }
    };
    let hidden: Vec<NodeId> = arguments.hide.iter().copied().map(NodeId).collect();
    if let Some(unknown) = hidden.iter().find(|node| !(1..=finger.key_node_count()).contains(&node.0)) {
        let count = finger.key_node_count();
        return Err(bad_input(format!("--hide: node {unknown} does not exist: the finger has nodes 1 to {count}")));
    }
    let shape = match &arguments.shape {
        Some(path) => displacements::load_shape(path, finger)?,
        None => arguments.loads.drawn_shape(finger)?,
    };
    let image = render(&RenderRequest {
        camera: &camera,
        finger,
        shape: &shape,
        markers: &markers,
        offsets: &scene.marker_offsets,
        references,
        hidden: &hidden,
        disturbances: Disturbances {
            light_falloff: arguments.light_falloff,
            blur_px: arguments.blur_px,
            grey_noise: arguments.grey_noise,
            clutter: arguments.clutter.into(),
            seed: arguments.seed,
        },
    });
    let image = image.map_err(bad_input)?;
    let mut png = Cursor::new(Vec::new());
    image.write_to(&mut png, ImageFormat::Png).map_err(not_computed)?;
    write_file(&arguments.out, png.get_ref())?;
    let [width, height] = [image.width(), image.height()];
    Ok(summary(format!("image of {width} x {height} px"), [&arguments.out]))
}

/// Parses the pose of a base, `X_MM,Y_MM,DEG`.
fn moved_base(text: &str) -> Result<Isometry2<f64>, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x, y, turn_deg]) => Ok(Isometry2::new([x, y].into(), turn_deg.to_radians())),
        _ => Err("expected X_MM,Y_MM,DEG, three numbers".to_owned()),
    }
}
