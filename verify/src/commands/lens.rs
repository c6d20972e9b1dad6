//! The command `finray lens`.

use crate::commands::prelude::*;
use finray_files::load_lens;
use finray_imaging::grid::{Grid, GridKind, find_grid, lens_of_grids, poses_of_grids};
use finray_imaging::lens_fit::{LENS_PARAMETERS, LensFit};
use finray_model::camera::{Lens, Pose};
use finray_model::keys::{CAMERA, SceneTable};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::fmt::Write;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray lens --grid-mm 5 --image grid1.png grid2.png grid3.png --out lens.toml
  finray lens --plane --grid-mm 25 --image photo*.jpg --out lens.toml
  finray lens --from camera_info.yaml --out lens.toml
  finray lens --from camera_info.yaml --plane --grid-mm 25 --image board.png --out lens.toml

Guide: finray guide lens";

/// Calibrate a camera's lens from images of a plane grid of dots or holes, or of a chessboard; or read it from a file of ROS or OpenCV.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Distance between dots, side of a chessboard square, or row spacing of an asymmetric grid, mm
    #[arg(long, value_name = "P", value_parser = positive, required_unless_present = "from", requires = "image")]
    grid_mm: Option<f64>,
    /// Images of the grid (PNG, JPEG), all from one camera
    #[arg(long, value_name = "FILE", required_unless_present = "from", num_args = 1.., requires = "grid_mm")]
    image: Vec<PathBuf>,
    /// Lens from a camera_info of ROS (YAML) or a file of OpenCV (YAML, XML, JSON); images then show the plane alone
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Also write the pose of the grid's plane
    #[arg(long, requires = "image")]
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
    let known = arguments.from.as_deref().map(load_lens).transpose()?;
    let (Some(grid_mm), false) = (arguments.grid_mm, arguments.image.is_empty()) else {
        return Ok(match (&known, &arguments.from) {
            (Some(lens), Some(path)) => {
                write_file(&arguments.out, &(source(path) + &keys(lens, None)))?;
                summary(format!("lens from {}", name_of(path)), [&arguments.out])
            }
            _ => return Err(bad_input("expected --grid-mm and --image, or --from")),
        });
    };
    if known.is_some() && !arguments.plane {
        return Err(bad_input("--from states the lens, so images serve only the plane of the grid: expected --plane"));
    }
    let (size_px, grids) = read_grids(arguments, known.as_ref())?;
    let kind = Grid::common_kind(&grids).unwrap_or(GridKind::Dots);
    let found = grids.iter().map(|grid| grid.dots.len()).sum::<usize>();
    let plane = |lens: &Lens, poses: &[Pose]| arguments.plane.then(|| pose_of_plane(lens, poses)).transpose();
    let (text, left_out, notes) = match (&known, &arguments.from) {
        (Some(lens), Some(path)) => {
            let (poses, left_out) = poses_of_grids(lens, grid_mm, &grids).map_err(bad_input)?;
            (source(path) + &keys(lens, plane(lens, &poses).map_err(bad_input)?), left_out, Vec::new())
        }
        _ => {
            let (fit, left_out) = lens_of_grids(size_px, grid_mm, &grids).map_err(bad_input)?;
            let pose = plane(&fit.lens, &fit.poses).map_err(bad_input)?;
            let images = count(grids.len(), "image");
            let notes: Vec<String> = not_shown(&fit).map(|note| format!("note: {note}")).into_iter().collect();
            let warned = uncertain_focus(&fit).map(|warning| format!("warning: {warning}"));
            let text = accuracy(&fit, &images, grid_mm, kind, found - left_out) + &keys(&fit.lens, pose);
            (text, left_out, notes.into_iter().chain(warned).collect())
        }
    };
    write_file(&arguments.out, &text)?;
    if kind == GridKind::AsymmetricDots {
        print_message(format_args!(
            "note: the grid is asymmetric: --grid-mm is used as the distance between its rows, {grid_mm} mm; neighbouring dots are {:.3} mm apart",
            grid_mm * std::f64::consts::SQRT_2
        ));
    }
    notes.iter().for_each(print_message);
    let points = if kind == GridKind::Chessboard { "corner" } else { "dot" };
    let what = if known.is_some() { "plane" } else { "lens" };
    let done = format!("{what} of {} in {}", count(found - left_out, points), count(grids.len(), "image"));
    Ok(summary(done, [&arguments.out]))
}

/// Size of the images, and the grid in each image.
fn read_grids(arguments: &Arguments, known: Option<&Lens>) -> Result<([u32; 2], Vec<Grid>), Failure> {
    let seen = arguments.image.par_iter().map(|path| {
        let (image, turn) = load_image(path)?;
        let grid = find_grid(&image).map_err(|error| FileError::content(path, error))?;
        Ok((([image.width(), image.height()], turn), grid))
    });
    let (seen, grids): (Vec<_>, Vec<_>) = seen.collect::<Result<Vec<_>, Failure>>()?.into_iter().unzip();
    let (sizes, turns): (Vec<[u32; 2]>, Vec<_>) = seen.into_iter().unzip();
    let (size_px, whose) = known.map_or((sizes[0], "the first image"), |lens| (lens.size_px(), "the lens"));
    if let Some(other) = sizes.iter().position(|size| *size != size_px) {
        let ([w, h], [x, y]) = (size_px, sizes[other]);
        let message = format!("expected {w} x {h} px, the size of {whose}, found {x} x {y}");
        return Err(FileError::content(&arguments.image[other], message).into());
    }
    if let Some(other) = turns.iter().position(|turn| *turn != turns[0]) {
        print_message(format_args!(
            "warning: {}: the EXIF orientation differs from the first image's, so the principal point is elsewhere; hold the camera the same way in all \
             images",
            arguments.image[other].display()
        ));
    }
    Ok((size_px, grids))
}

/// Mean pose of the grid's plane over all images; an error if the plane moved between images.
fn pose_of_plane(lens: &Lens, poses: &[Pose]) -> Result<Pose, String> {
    let ray = lens.ray(&lens.middle()).map_err(|error| format!("--plane: the middle of the image {error}"))?;
    let seen: Vec<[Vector3<f64>; 2]> = poses
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

/// Comment that names the file of a lens.
fn source(path: &Path) -> String {
    format!("# Lens from {}.\n", name_of(path))
}

/// Comments on the accuracy of a fitted lens.
fn accuracy(fit: &LensFit, images: &str, grid_mm: f64, kind: GridKind, dots: usize) -> String {
    let points = if kind == GridKind::Chessboard { "corners" } else { "dots" };
    let (name, residual) = (kind.name(), fit.residual_sd_px);
    let mut text = format!(
        "# Lens from {images} of {name} with a pitch of {grid_mm} mm: {dots} {points}, residual {residual:.3} px.\n# Standard deviations:\n"
    );
    // Writing to a string cannot fail.
    for (name, sd) in LENS_PARAMETERS.iter().zip(fit.sds) {
        let _ = writeln!(text, "#   {name} {sd:.2e}");
    }
    for note in not_shown(fit).into_iter().chain(uncertain_focus(fit)) {
        let _ = writeln!(text, "# {note}");
    }
    text
}

/// The table `[camera]` of a lens and, if known, of the pose of the grid's plane.
fn keys(lens: &Lens, pose: Option<Pose>) -> String {
    let mut text = format!("[{}]\n", CAMERA.path());
    let mut add = |name: &str, value: &dyn std::fmt::Debug| {
        let _ = writeln!(text, "{name} = {value:?}");
    };
    add(CAMERA.size_px.name, &lens.size_px());
    add(CAMERA.focal_px.name, &lens.focal_px());
    add(CAMERA.principal_point_px.name, &lens.principal_point_px());
    if lens.distortion().is_fisheye() {
        add(CAMERA.distortion_model.name, &"fisheye");
    }
    add(CAMERA.distortion.name, &lens.distortion().coefficients());
    if let Some(pose) = pose {
        add(CAMERA.rotation_vector_rad.name, &pose.rotation_vector_rad());
        add(CAMERA.translation_mm.name, &<[f64; 3]>::from(pose.translation_mm));
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
