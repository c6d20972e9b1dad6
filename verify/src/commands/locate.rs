//! The command `finray locate`.

use crate::commands::prelude::*;
use finray_files::image_names;
use finray_files::observations::{self, RefusedImage};
use finray_imaging::locate::{Observer, ObserverError, OtherRadius, SeenRadii};
use finray_model::Finger;
use finray_model::measurement::Marker;
use finray_model::observation::{LargestClampedMotion, Observation, ObservedMarker};
use finray_model::scene::{MarkerLook, Markers};
use nalgebra::UnitComplex;
use rayon::prelude::*;

/// A warning is printed if the residual of the pose in the image of the unloaded finger exceeds this value, px. Image noise and lens errors alone
/// cause a smaller residual.
const SURE_REST_PX: f64 = 0.3;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray locate fixtures/scenes/camera.toml --image fixtures/pictures/camera.png --out nodes.csv
  finray locate fixtures/scenes/camera.toml --image new.png --rest rest.png --out nodes.csv
  finray sense fixtures/scenes/camera.toml --displacements nodes.csv --contact-at 80@-20

Guide: finray guide photographs";

/// Locate a finger's markers in images, and compute the displacements of its nodes.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Images of the finger (PNG, JPEG), in the order in which they were taken; - for standard input
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    image: Vec<PathBuf>,
    /// Image of the unloaded finger: reference for displacements; with coloured markers, it also determines the pose
    #[arg(long, value_name = "FILE")]
    rest: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    require_one_standard_input([&arguments.scene].into_iter().chain(&arguments.image).chain(&arguments.rest))?;
    let names = image_names(&arguments.image)?;
    let scene = load_scene(&arguments.scene)?;
    let observer = observer(arguments, &scene)?;
    warn_of_rest(arguments, &observer);
    let found = images_with_their_radii(arguments, &scene, observer);
    // If every image is refused, there is no table to write, so the command fails with the first refusal.
    if found.iter().all(Result::is_err) {
        return Err(found
            .into_iter()
            .find_map(Result::err)
            .unwrap_or_else(|| bad_input("expected at least one image")));
    }
    let of_image = |((path, image), found): ((&PathBuf, String), Result<SeenImage, Failure>)| match found {
        Ok(SeenImage { observation, motion_blur_px, .. }) => {
            let seen = Observation { image, ..observation };
            warn_of_motion(path, motion_blur_px);
            warn_of_base(path, &scene.finger, &seen);
            warn_of_lost(path, &scene, &seen);
            Ok(seen)
        }
        Err(failure) => {
            let reason = failure.reason().to_owned();
            print_message(format_args!("warning: image refused: {reason}"));
            Err(RefusedImage { image, reason })
        }
    };
    let seen: Vec<_> = arguments.image.iter().zip(names).zip(found).map(of_image).collect();
    warn_of_turned(&seen);
    write_file(&arguments.out, &observations::to_csv(&seen)?)?;
    let located = seen.iter().flatten();
    let markers: usize = located.clone().map(|seen| seen.markers.len()).sum();
    let done = format!("{markers} markers located in {} of {}", located.count(), count(seen.len(), "image"));
    Ok(summary(done, [&arguments.out]))
}

/// Observation and marker radii of one image.
struct SeenImage {
    observation: Observation,
    radii: SeenRadii,
    motion_blur_px: Option<f64>,
}

type SeenImages = Vec<Result<SeenImage, Failure>>;

/// Locates the markers in all images. If measured marker radii differ from the scene's, prints a message and searches again with the measured radii.
fn images_with_their_radii(arguments: &Arguments, scene: &Scene, observer: Observer) -> SeenImages {
    let found = all_images(arguments, observer);
    let radii: Vec<&SeenRadii> = found.iter().flatten().map(|seen| &seen.radii).collect();
    let others = OtherRadius::of(scene, &radii);
    let is_file = |image: &PathBuf| !is_standard_stream(image);
    if others.is_empty() || !arguments.image.iter().chain(&arguments.rest).all(is_file) {
        others.iter().for_each(|other| print_message(format_args!("warning: {other}")));
        return found;
    }
    let mut corrected = scene.clone();
    others.iter().for_each(|other| other.correct(&mut corrected));
    let anew =
        self::observer(arguments, &corrected).map(|observer| all_images(arguments, observer)).unwrap_or_default();
    let count = |images: &SeenImages| images.iter().flatten().map(|seen| seen.observation.markers.len()).sum::<usize>();
    if are_alike(&found, &anew) {
        others.iter().for_each(|other| {
            print_message(format_args!("note: {other}; with either radius, the same markers are found"))
        });
        return found;
    }
    let (found, sought) = match count(&anew) >= count(&found) {
        true => (anew, ", and the markers were located again with this radius"),
        false => (found, ""),
    };
    for other in others {
        print_message(format_args!(
            "warning: {other}{sought}: correct this key; if its value is right, check lens, pose, height_mm and the size of the image"
        ));
    }
    found
}

/// The positions of a marker in two searches count as equal up to this distance, in standard deviations of the position.
const ALIKE_SIGMAS: f64 = 3.0;

/// Whether two searches found the same markers at the same positions in all images.
fn are_alike(one: &SeenImages, other: &SeenImages) -> bool {
    let is_alike = |(a, b): (&ObservedMarker, &ObservedMarker)| {
        let apart_mm = a.position.zip(b.position).map(|(a, b)| (a - b).norm());
        a.node == b.node && apart_mm.zip(a.sd_mm).is_some_and(|(apart_mm, sd_mm)| apart_mm <= ALIKE_SIGMAS * sd_mm)
    };
    let are_alike = |pair: (&Result<SeenImage, Failure>, &Result<SeenImage, Failure>)| match pair {
        (Ok(a), Ok(b)) => {
            let [a, b] = [a, b].map(|seen| &seen.observation.markers);
            a.len() == b.len() && a.iter().zip(b).all(is_alike)
        }
        (a, b) => a.is_err() == b.is_err(),
    };
    one.len() == other.len() && one.iter().zip(other).all(are_alike)
}

/// Locates the markers of all images in parallel. If markers are tracked, images are searched in order, each starting from the marker positions in
/// the previous image.
fn all_images(arguments: &Arguments, mut observer: Observer) -> SeenImages {
    if observer.is_tracking() {
        return arguments.image.iter().map(|path| observed(&mut observer, path)).collect();
    }
    arguments.image.par_iter().map_init(|| observer.clone(), |observer, path| observed(observer, path)).collect()
}

/// An image is probably upside down if its base is rotated by more than this, degrees, relative to the base in at least half of the images.
const TURNED_DEG: f64 = 150.0;

/// Warns of images whose base is rotated by more than `TURNED_DEG` relative to at least half of all images.
fn warn_of_turned(images: &[Result<Observation, RefusedImage>]) {
    let turn = |seen: &Observation| seen.base.filter(|base| base.is_known).map(|base| base.pose.rotation);
    let turns: Vec<_> = images.iter().flatten().filter_map(|seen| Some((&seen.image, turn(seen)?))).collect();
    for (image, own) in &turns {
        let away_deg = |(_, other): &(&String, UnitComplex<f64>)| own.angle_to(other).to_degrees().abs();
        if 2 * turns.iter().filter(|other| away_deg(other) > TURNED_DEG).count() >= turns.len() {
            print_message(format_args!(
                "warning: {image}: the base is turned by more than {TURNED_DEG} deg relative to other images: check the EXIF orientation of the image"
            ));
        }
    }
}

/// A warning is printed if at most this share of the grey markers is found. Occlusion hides few markers; with a wrong radius, many markers are not
/// found.
const MANY_LOST: f64 = 0.75;

/// Warns if many grey markers are missing, which a wrong radius explains better than occlusion.
fn warn_of_lost(path: &Path, scene: &Scene, seen: &Observation) {
    let Some(Markers { radius_mm, look: MarkerLook::Grey { .. }, .. }) = scene.markers else { return };
    let (all, found) = (scene.finger.marked_nodes().len(), seen.markers.len());
    if found as f64 <= MANY_LOST * all as f64 {
        print_message(format_args!(
            "warning: {}: {found} of {all} markers were found: if nothing hides the others, check markers.radius_mm = {radius_mm} and inner_radius_mm",
            path.display()
        ));
    }
}

/// Warns if the base's pose is uncertain, or disagrees with the markers of clamped nodes.
fn warn_of_base(path: &Path, finger: &Finger, seen: &Observation) {
    if seen.base.is_some_and(|base| !base.is_known) {
        print_message(format_args!(
            "warning: {}: no two references on the base were found, so the pose of the base is estimated from the \
                ribs: use these displacements only with an estimate of the base, as `finray sense` computes it",
            path.display()
        ));
    }
    if let Some(doubt) = doubt_of_pose(finger, seen) {
        print_message(format_args!(
            "warning: {}: {doubt}; for coloured markers, --rest finds the pose in an image of the unloaded finger",
            path.display()
        ));
    }
}

/// Builds the marker locator for a scene, with the image of the unloaded finger if one is given.
fn observer<'s>(arguments: &Arguments, scene: &'s Scene) -> Result<Observer<'s>, Failure> {
    let path = &arguments.scene;
    // Missing tables of the scene are reported before an image is read.
    camera_of(path, scene)?;
    let markers = markers_of(path, scene)?;
    let pose_is_sought = arguments.rest.is_some() && matches!(markers.look, MarkerLook::Coloured { .. });
    if !pose_is_sought {
        camera_and_markers(path, scene)?;
    }
    let image = arguments.rest.as_deref().map(load_image).transpose()?;
    Observer::new(scene, image.as_ref().map(|(image, _)| image)).map_err(|error| match (&error, &arguments.rest) {
        (ObserverError::Rest(_) | ObserverError::GreyRest(_), Some(path)) => FileError::content(path, &error).into(),
        _ => bad_input(error),
    })
}

/// Warns if markers in the image of the unloaded finger are far from their positions on the scene's unloaded finger.
fn warn_of_rest(arguments: &Arguments, observer: &Observer) {
    if let (Some(residual_px), Some(path)) = (observer.rest_residual_px, &arguments.rest)
        && residual_px > SURE_REST_PX
    {
        print_message(format_args!(
            "warning: {}: the markers are {residual_px:.1} px (rms) away from their positions on the scene's \
                unloaded finger. If the finger carries a load in this image, every sensed force is wrong by that load; \
                if the markers are merely mounted beside their nodes, this causes no error",
            path.display()
        ));
    }
}

/// Describes a contradiction between the markers of clamped nodes and the pose from which displacements are measured. `None` if these markers and the
/// pose agree, if the base is movable, or if no clamped node has a marker.
fn doubt_of_pose(finger: &Finger, seen: &Observation) -> Option<String> {
    let mut nodes = finger.clamped_nodes().into_iter().filter(|node| finger.has_marker(*node)).peekable();
    if seen.base.is_some() || nodes.peek().is_none() {
        return None;
    }
    let clamped: Vec<_> = nodes.filter_map(|node| seen.markers.iter().find(|marker| marker.node == node)).collect();
    if clamped.is_empty() {
        return Some("no marker of a clamped node is found, so the pose cannot be verified".to_owned());
    }
    let moved = clamped.iter().find_map(|seen| {
        let marker = Marker { node: seen.node, displacement: seen.displacement?, weight: 1.0 };
        LargestClampedMotion::of(Some(seen.sd_mm?), []).check(finger, &marker).err()?;
        Some(marker)
    })?;
    Some(format!(
        "the marker of clamped node {} is {:.2} mm away from the position that the pose gives for it: \
            displacements err by at least this distance, and sigma_mm does not include this error",
        moved.node,
        moved.displacement.norm()
    ))
}

fn observed(observer: &mut Observer, path: &Path) -> Result<SeenImage, Failure> {
    let observation = observer.observe(&load_image(path)?.0).map_err(|error| FileError::content(path, error))?;
    Ok(SeenImage { observation, radii: observer.radii.clone(), motion_blur_px: observer.motion_blur_px() })
}

fn warn_of_motion(path: &Path, motion_blur_px: Option<f64>) {
    if let Some(blur_px) = motion_blur_px {
        print_message(format_args!(
            "warning: {}: markers are blurred in one direction, by {blur_px:.1} px (standard deviation), probably by motion during the exposure; \
             sigma_mm includes the error that a steady motion causes",
            path.display()
        ));
    }
}
