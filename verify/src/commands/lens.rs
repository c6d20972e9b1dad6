//! The command `finray lens`.

use crate::commands::prelude::*;
use finray_imaging::grid::{Grid, GridKind, find_grid, lens_of_grids};
use finray_imaging::lens_fit::{LENS_PARAMETERS, LensFit};
use finray_model::camera::Pose;
use finray_model::keys::{CAMERA, SceneTable};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::fmt::Write;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray lens --grid-mm 5 --image grid1.png grid2.png grid3.png --out lens.toml
  finray lens --plane --grid-mm 25 --image photo*.jpg --out lens.toml

Guide: finray guide lens";

/// Calibrate a camera's lens from images of a plane grid of dots or holes, or of a chessboard.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Distance between dots, side of a chessboard square, or row spacing of an asymmetric grid, mm
    #[arg(long, value_name = "P", value_parser = positive)]
    grid_mm: f64,
    /// Images of the grid (PNG, JPEG), all from one camera
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    image: Vec<PathBuf>,
    /// Also write the pose of the grid's plane
    #[arg(long)]
    plane: bool,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// A warning is printed if the relative standard deviation of the focal length exceeds this share. Distances from the camera, and heights above the
/// grid's plane, have about the same relative error as the focal length.
const LARGEST_FOCAL_SHARE: f64 = 0.05;
/// The plane counts as moved if its normal in one image differs from the mean normal by more than this, degrees. The plane also counts as moved if
/// its distance from the camera differs from the mean distance by more than the share `SAME_DISTANCE`.
const SAME_NORMAL_DEG: f64 = 0.5;
const SAME_DISTANCE: f64 = 0.005;

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let seen = arguments.image.par_iter().map(|path| {
        let (image, turn) = load_image(path)?;
        let grid = find_grid(&image).map_err(|error| FileError::content(path, error))?;
        Ok((([image.width(), image.height()], turn), grid))
    });
    let (seen, grids): (Vec<_>, Vec<_>) = seen.collect::<Result<Vec<_>, Failure>>()?.into_iter().unzip();
    let (sizes, turns): (Vec<[u32; 2]>, Vec<_>) = seen.into_iter().unzip();
    let size_px = sizes[0];
    if let Some(other) = sizes.iter().position(|size| *size != size_px) {
        let ([w, h], [x, y]) = (size_px, sizes[other]);
        let message = format!("expected {w} x {h} px, the size of the first image, found {x} x {y}");
        return Err(FileError::content(&arguments.image[other], message).into());
    }
    let (fit, left_out) = lens_of_grids(size_px, arguments.grid_mm, &grids).map_err(bad_input)?;
    let dots = grids.iter().map(|grid| grid.dots.len()).sum::<usize>() - left_out;
    let kind = Grid::common_kind(&grids).unwrap_or(GridKind::Dots);
    let pose = arguments.plane.then(|| pose_of_plane(&fit)).transpose().map_err(bad_input)?;
    let text = to_toml(&fit, pose, arguments, kind, dots);
    write_file(&arguments.out, &text)?;
    if let Some(other) = turns.iter().position(|turn| *turn != turns[0]) {
        print_message(format_args!(
            "warning: {}: the EXIF orientation differs from the first image's, so the principal point is elsewhere; hold the camera the same way in all \
             images",
            arguments.image[other].display()
        ));
    }
    if kind == GridKind::AsymmetricDots {
        print_message(format_args!(
            "note: the grid is asymmetric: --grid-mm is used as the distance between its rows, {} mm; neighbouring dots are {:.3} mm apart",
            arguments.grid_mm,
            arguments.grid_mm * std::f64::consts::SQRT_2
        ));
    }
    if let Some(note) = not_shown(&fit) {
        print_message(format_args!("note: {note}"));
    }
    if let Some(warning) = uncertain_focus(&fit) {
        print_message(format_args!("warning: {warning}"));
    }
    let points = if kind == GridKind::Chessboard { "corner" } else { "dot" };
    let done = format!("lens of {} in {}", count(dots, points), count(grids.len(), "image"));
    Ok(summary(done, [&arguments.out]))
}

/// Mean pose of the grid's plane over all images; an error if the plane moved between images.
fn pose_of_plane(fit: &LensFit) -> Result<Pose, String> {
    let ray = fit.lens.ray(&fit.lens.middle()).map_err(|error| format!("--plane: the middle of the image {error}"))?;
    let seen: Vec<[Vector3<f64>; 2]> = fit
        .poses
        .iter()
        .map(|pose| {
            let normal = pose.rotation * Vector3::z();
            let normal = if normal.dot(&pose.translation_mm) > 0.0 { -normal } else { normal };
            [normal, ray * (normal.dot(&pose.translation_mm) / normal.dot(&ray))]
        })
        .collect();
    let [normal, origin] = [0, 1].map(|part| seen.iter().map(|of| of[part]).sum::<Vector3<f64>>() / seen.len() as f64);
    for (number, of) in seen.iter().enumerate() {
        let turned_deg = of[0].angle(&normal).to_degrees();
        let farther = (of[1] - origin).norm() / origin.norm();
        if turned_deg > SAME_NORMAL_DEG || farther > SAME_DISTANCE {
            return Err(format!(
                "--plane: expected a grid that does not move between images, found a plane in image {} that \
                    differs from the mean of all images: it is rotated by {turned_deg:.2} deg and shifted by {:.2} % \
                    of its distance from the camera",
                number + 1,
                100.0 * farther
            ));
        }
    }
    Ok(Pose::in_plane(&normal, &origin))
}

fn to_toml(fit: &LensFit, pose: Option<Pose>, arguments: &Arguments, kind: GridKind, dots: usize) -> String {
    let lens = &fit.lens;
    let mut text = String::new();
    let images = count(arguments.image.len(), "image");
    let (grid_mm, residual) = (arguments.grid_mm, fit.residual_sd_px);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "# Lens from {images} of {} with a pitch of {grid_mm} mm: {dots} {}, residual {residual:.3} px.",
        kind.name(),
        if kind == GridKind::Chessboard { "corners" } else { "dots" },
    );
    let _ = writeln!(text, "# Standard deviations:");
    for (name, sd) in LENS_PARAMETERS.iter().zip(fit.sds) {
        let _ = writeln!(text, "#   {name} {sd:.2e}");
    }
    for note in not_shown(fit).into_iter().chain(uncertain_focus(fit)) {
        let _ = writeln!(text, "# {note}");
    }
    let _ = writeln!(text, "[{}]", CAMERA.path());
    let _ = writeln!(text, "{} = {:?}", CAMERA.size_px.name, lens.size_px());
    let _ = writeln!(text, "{} = {:?}", CAMERA.focal_px.name, lens.focal_px());
    let _ = writeln!(text, "{} = {:?}", CAMERA.principal_point_px.name, lens.principal_point_px());
    let _ = writeln!(text, "{} = {:?}", CAMERA.distortion.name, lens.distortion().to_opencv());
    if let Some(pose) = pose {
        let _ = writeln!(text, "{} = {:?}", CAMERA.rotation_vector_rad.name, pose.rotation_vector_rad());
        let _ = writeln!(text, "{} = {:?}", CAMERA.translation_mm.name, <[f64; 3]>::from(pose.translation_mm));
    }
    text
}

/// A warning if the focal length is so uncertain that distances from the camera and slants of planes are inaccurate.
fn uncertain_focus(fit: &LensFit) -> Option<String> {
    let share = fit.sds[0] / fit.lens.focal_px()[0];
    (share > LARGEST_FOCAL_SHARE).then(|| {
        format!(
            "the focal length is uncertain by {:.0} %, and distances from the camera, heights and slants are similarly uncertain: add images of the \
             whole grid, slanted by 20 to 40 degrees to both sides",
            100.0 * share
        )
    })
}

/// A note that names the lens parameters that the images hardly determine; `None` if they determine all.
fn not_shown(fit: &LensFit) -> Option<String> {
    let names: Vec<&str> =
        LENS_PARAMETERS.iter().zip(fit.is_shown).filter(|(_, shown)| !shown).map(|(name, _)| *name).collect();
    (!names.is_empty()).then(|| {
        format!(
            "the images hardly determine {}; a prior keeps these parameters near usual values: add images of a slanted grid",
            names.join(", ")
        )
    })
}
