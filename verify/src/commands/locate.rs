//! `finray locate`

use super::cameras::{camera_and_markers, camera_of, markers_of};
use super::{Failure, bad_input, not_both_from_standard_input};
use finray_files::{FileError, csv_text, image_name, is_standard_stream, load_image, load_scene, write_text};
use finray_imaging::locate::{Located, Locator, LocatorError, Rest, RimLocator, SeenBase};
use finray_model::scene::MarkerLook;
use finray_model::{Finger, NodeId, Scene, Vector};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Residual of the pose at rest, px, beyond which more than the noise of an image and a lens that was found is in it.
const SURE_REST_PX: f64 = 0.3;

/// Locate the nodes of a finger in images of its markers.
///
/// Writes image,node,u_px,v_px,x_mm,y_mm,ux_mm,uy_mm,sigma_mm, a row a marker found; a hidden one has
/// none. x_mm, y_mm is its position in the finger frame, ux_mm, uy_mm its displacement from the
/// scene's undeformed node. `finray sense` reads this.
///
/// --rest takes an image of the unloaded finger: the pose comes from it, and displacements count from
/// where its markers are.
///
/// sigma_mm is the standard deviation of one coordinate of the displacement, from the noise of the
/// image. It does not hold errors of the lens, nor of a pose that the scene states.
///
/// Several images are taken for a stream: markers are sought near where they were in the one before.
/// Markers are named by their order along the plates and by what a finger can do; where two ways to
/// name them fit alike, or too few are seen, the image is refused.
///
/// Markers with a shade instead of colours are found by their rims, each image by itself. Where the
/// base moves (table base), its pose comes from the references on it, and base_x_mm,base_y_mm,base_deg,
/// base_sigma_mm,base_sigma_deg follow: errors that all markers of an image share. marker_sigma_mm is
/// what sigma_mm is without them: `finray sense` seeks the base together with the forces.
///
/// Examples:
///   finray render fixtures/scenes/camera.toml --load-at 80:2,-20 --grey-noise 2 --out image.png
///   finray locate fixtures/scenes/camera.toml --image image.png --out nodes.csv
///   finray sense fixtures/scenes/camera.toml --displacements nodes.csv --contact-at 80@-20
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Image of the finger (PNG, JPEG); several in the order in which they were taken; - for standard input
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    image: Vec<PathBuf>,
    /// Image of the unloaded finger
    #[arg(long, value_name = "FILE")]
    rest: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Row {
    image: String,
    node: usize,
    u_px: f64,
    v_px: f64,
    x_mm: f64,
    y_mm: f64,
    ux_mm: f64,
    uy_mm: f64,
    sigma_mm: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs = || arguments.image.iter().chain(&arguments.rest);
    for image in inputs() {
        not_both_from_standard_input(&arguments.scene, image, "an image")?;
    }
    if inputs().filter(|image| is_standard_stream(image)).count() > 1 {
        return Err(bad_input("two images cannot both be -: standard input can be read only once"));
    }
    let scene = load_scene(&arguments.scene)?;
    camera_of(&arguments.scene, &scene)?;
    let table = match markers_of(&arguments.scene, &scene)?.look {
        MarkerLook::Coloured { .. } => csv_text(by_colour(arguments, &scene)?)?,
        MarkerLook::Grey { .. } if scene.base.is_some() => csv_text(by_rims(arguments, &scene)?)?,
        MarkerLook::Grey { .. } => csv_text(by_rims(arguments, &scene)?.into_iter().map(|(row, _)| row))?,
    };
    Ok(write_text(&arguments.out, &table)?)
}

fn refused(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::from(FileError::Content { path: path.to_owned(), message: error.to_string() })
}

fn row(image: &str, seen: &Located, (from, from_sd_mm): (Vector, f64)) -> Row {
    let Located { node, pixel, position, sd_mm } = *seen;
    Row {
        image: image.to_owned(),
        node: node.0,
        u_px: pixel.x,
        v_px: pixel.y,
        x_mm: position.x,
        y_mm: position.y,
        ux_mm: position.x - from.x,
        uy_mm: position.y - from.y,
        sigma_mm: sd_mm.hypot(from_sd_mm),
    }
}

/// Where a marker is without load, mm, with its standard deviation: where an image of the finger at rest has it, or the scene.
fn at_rest(finger: &Finger, rest: Option<&[Located]>, node: NodeId) -> (Vector, f64) {
    let seen = rest.unwrap_or_default().iter().find(|marker| marker.node == node);
    seen.map_or((finger.marker_position(node), 0.0), |marker| (marker.position, marker.sd_mm))
}

fn by_colour(arguments: &Arguments, scene: &Scene) -> Result<Vec<Row>, Failure> {
    let finger = &scene.finger;
    let rest = match &arguments.rest {
        None => None,
        Some(path) => {
            let markers = markers_of(&arguments.scene, scene)?;
            let image = load_image(path)?;
            let (lens, pose) = camera_of(&arguments.scene, scene)?;
            let rest = Rest::of(finger, &lens, pose, &markers, &image).map_err(|error| refused(path, &error))?;
            if rest.residual_sd_px > SURE_REST_PX {
                eprintln!(
                    "warning: {}: the markers are {:.1} px rms from those of the scene's unloaded finger: a load that is on it already is missing in \
                     every force that is sensed; markers that are off their nodes are allowed for",
                    path.display(),
                    rest.residual_sd_px
                );
            }
            Some(rest)
        }
    };
    let (camera, markers) = match &rest {
        Some(rest) => (rest.camera, markers_of(&arguments.scene, scene)?),
        None => camera_and_markers(&arguments.scene, scene)?,
    };
    let located_at_rest = rest.as_ref().map(|rest| rest.located.as_slice());
    let mut locator = Locator::new(finger, &camera, &markers).map_err(cannot_locate)?;
    let mut rows = Vec::new();
    for path in &arguments.image {
        let image = load_image(path)?;
        let found = locator.track(&image).map_err(|error| refused(path, &error))?;
        let name = image_name(path);
        rows.extend(found.iter().map(|seen| row(&name, seen, at_rest(finger, located_at_rest, seen.node))));
    }
    Ok(rows)
}

/// Where the base is, repeated on each row of its image.
#[derive(Serialize, Clone, Copy)]
struct BaseRow {
    base_x_mm: f64,
    base_y_mm: f64,
    base_deg: f64,
    base_sigma_mm: f64,
    base_sigma_deg: f64,
    marker_sigma_mm: f64,
}

impl BaseRow {
    /// The base of an image, beside one of its markers.
    fn beside(base: &SeenBase, row: &Row) -> BaseRow {
        let shared_mm = base.sd_at(&Vector::new(row.x_mm, row.y_mm));
        // Errors of the middle of the references and of the turn about it move the origin.
        let arm_mm = base.middle.norm() / std::f64::consts::SQRT_2;
        BaseRow {
            base_x_mm: base.pose.translation.x,
            base_y_mm: base.pose.translation.y,
            base_deg: base.pose.rotation.angle().to_degrees(),
            base_sigma_mm: base.sd_mm.hypot(base.sd_rad * arm_mm),
            base_sigma_deg: base.sd_rad.to_degrees(),
            marker_sigma_mm: (row.sigma_mm * row.sigma_mm - shared_mm * shared_mm).sqrt(),
        }
    }
}

fn by_rims(arguments: &Arguments, scene: &Scene) -> Result<Vec<(Row, BaseRow)>, Failure> {
    let finger = &scene.finger;
    let (camera, markers) = camera_and_markers(&arguments.scene, scene)?;
    let locator = RimLocator::new(finger, &camera, &markers, scene.base.as_ref()).map_err(cannot_locate)?;
    let seen = |path: &Path| locator.locate(&load_image(path)?).map_err(|error| refused(path, &error));
    let rest = arguments.rest.as_deref().map(seen).transpose()?;
    let located_at_rest = rest.as_ref().map(|rest| rest.located.as_slice());
    // Each image by itself.
    let found = arguments.image.par_iter().map(|path| seen(path)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (path, found) in arguments.image.iter().zip(found) {
        let name = image_name(path);
        if !found.base.is_known {
            eprintln!(
                "warning: {}: two references on the base were not found, so the finger frame is only about where the ribs have it: \
                 displacements are to be used where the base is sought with the forces, as `finray sense` does",
                path.display()
            );
        }
        rows.extend(found.located.iter().map(|seen| {
            let row = row(&name, seen, at_rest(finger, located_at_rest, seen.node));
            let base = BaseRow::beside(&found.base, &row);
            (row, base)
        }));
    }
    Ok(rows)
}

fn cannot_locate(error: LocatorError) -> Failure {
    bad_input(error)
}
