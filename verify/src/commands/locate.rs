//! `finray locate`

use crate::commands::prelude::*;
use finray_files::image_names;
use finray_files::observations::{self, RefusedImage};
use finray_imaging::locate::{Observer, ObserverError};
use finray_model::Finger;
use finray_model::measurement::Marker;
use finray_model::observation::{LargestClampedMotion, Observation};
use finray_model::scene::{MarkerLook, Markers};
use rayon::prelude::*;

/// Residual of the pose at rest, px, beyond which more than the noise of an image and a lens that was found is in it.
const SURE_REST_PX: f64 = 0.3;

/// Below the options.
const AFTER_HELP: &str = "\
Examples:
  finray locate fixtures/scenes/camera.toml --image fixtures/pictures/camera.png --out nodes.csv
  finray locate fixtures/scenes/camera.toml --image new.png --rest rest.png --out nodes.csv
  finray sense fixtures/scenes/camera.toml --displacements nodes.csv --contact-at 80@-20

Guide: finray guide photographs";

/// Locate the markers of a finger in images: positions and displacements of its nodes.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Image of the finger (PNG, JPEG); several in the order they were taken; - for standard input
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    image: Vec<PathBuf>,
    /// Image of the unloaded finger: gives the pose, and displacements count from it
    #[arg(long, value_name = "FILE")]
    rest: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let inputs = || arguments.image.iter().chain(&arguments.rest);
    for image in inputs() {
        not_both_from_standard_input(&arguments.scene, image, "an image")?;
    }
    if inputs().filter(|image| is_standard_stream(image)).count() > 1 {
        return Err(bad_input("two images cannot both be -: standard input can be read only once"));
    }
    let names = image_names(&arguments.image)?;
    let scene = load_scene(&arguments.scene)?;
    let observer = observer(arguments, &scene)?;
    // Unless markers are tracked, each image is read by itself.
    let found: Vec<Result<Observation, Failure>> = if observer.is_tracking() {
        let mut observer = observer;
        arguments.image.iter().map(|path| observed(&mut observer, path)).collect()
    } else {
        arguments.image.par_iter().map_init(|| observer.clone(), |observer, path| observed(observer, path)).collect()
    };
    // Without any located image there is no table.
    if found.iter().all(Result::is_err) {
        return found.into_iter().find_map(Result::err).map_or(Ok(()), Err);
    }
    let of_image = |((path, image), found): ((&PathBuf, String), Result<Observation, Failure>)| match found {
        Ok(seen) => {
            let seen = Observation { image, ..seen };
            warn_of_base(path, &scene.finger, &seen);
            warn_of_lost(path, &scene, &seen);
            Ok(seen)
        }
        Err(failure) => {
            let reason = failure.reason().to_owned();
            print_message(format_args!("warning: {reason}: refused"));
            Err(RefusedImage { image, reason })
        }
    };
    let seen: Vec<_> = arguments.image.iter().zip(names).zip(found).map(of_image).collect();
    Ok(write_text(&arguments.out, &observations::to_csv(&seen)?)?)
}

/// Markers with a shade of which no more than this share is found: hidden ones are few, ones of another size many.
const MANY_LOST: f64 = 0.75;

/// Warns of markers that are lost though nothing may hide them.
fn warn_of_lost(path: &Path, scene: &Scene, seen: &Observation) {
    let Some(Markers { radius_mm, look: MarkerLook::Grey { .. }, .. }) = scene.markers else { return };
    let (all, found) = (scene.finger.marked_nodes().len(), seen.markers.len());
    if found as f64 <= MANY_LOST * all as f64 {
        print_message(format_args!(
            "warning: {}: {found} of {all} markers were found: if nothing hides the others, markers.radius_mm = {radius_mm} or inner_radius_mm are those of \
             other markers",
            path.display()
        ));
    }
}

/// Warns of a base that is not where displacements need it.
fn warn_of_base(path: &Path, finger: &Finger, seen: &Observation) {
    if seen.base.is_some_and(|base| !base.is_known) {
        print_message(format_args!(
            "warning: {}: two references on the base were not found, so the finger frame is only about where the ribs have it: \
             displacements are to be used where the base is sought with the forces, as `finray sense` does",
            path.display()
        ));
    }
    if let Some(doubt) = doubt_of_pose(finger, seen) {
        print_message(format_args!(
            "warning: {}: {doubt}; --rest finds the pose in an image of the unloaded finger",
            path.display()
        ));
    }
}

/// The scene's locator, with the image of the unloaded finger.
fn observer<'s>(arguments: &Arguments, scene: &'s Scene) -> Result<Observer<'s>, Failure> {
    let path = &arguments.scene;
    // What the scene lacks is said before an image is read.
    camera_of(path, scene)?;
    let markers = markers_of(path, scene)?;
    let pose_is_sought = arguments.rest.is_some() && matches!(markers.look, MarkerLook::Coloured { .. });
    if !pose_is_sought {
        camera_and_markers(path, scene)?;
    }
    let image = arguments.rest.as_deref().map(load_image).transpose()?;
    let observer = Observer::new(scene, image.as_ref()).map_err(|error| match (&error, &arguments.rest) {
        (ObserverError::Rest(_) | ObserverError::GreyRest(_), Some(path)) => refused(path, &error),
        _ => bad_input(error),
    })?;
    if let (Some(residual_px), Some(path)) = (observer.rest_residual_px(), &arguments.rest)
        && residual_px > SURE_REST_PX
    {
        print_message(format_args!(
            "warning: {}: the markers are {residual_px:.1} px rms from those of the scene's unloaded finger: a load that is on it already is missing in \
             every force that is sensed; markers that are off their nodes are allowed for",
            path.display()
        ));
    }
    Ok(observer)
}

/// What the markers of clamped nodes say against the pose from which displacements count; `None` of a base that moves or has no markers.
fn doubt_of_pose(finger: &Finger, seen: &Observation) -> Option<String> {
    let mut nodes = finger.clamped_nodes().into_iter().filter(|node| finger.has_marker(*node)).peekable();
    if seen.base.is_some() || nodes.peek().is_none() {
        return None;
    }
    let clamped: Vec<_> = nodes.filter_map(|node| seen.markers.iter().find(|marker| marker.node == node)).collect();
    if clamped.is_empty() {
        return Some(
            "no marker of a clamped node is seen where the pose has it, so nothing shows that the pose holds"
                .to_owned(),
        );
    }
    let moved = clamped.iter().find_map(|seen| {
        let marker = Marker { node: seen.node, displacement: seen.displacement?, weight: 1.0 };
        LargestClampedMotion::of(Some(seen.sd_mm?), []).check(finger, &marker).err()?;
        Some(marker)
    })?;
    Some(format!(
        "the marker of clamped node {} is seen {:.2} mm from where the pose has it: displacements err by as much or more, which sigma_mm does not hold",
        moved.node,
        moved.displacement.norm()
    ))
}

fn observed(observer: &mut Observer, path: &Path) -> Result<Observation, Failure> {
    let seen = observer.observe(&load_image(path)?).map_err(|error| refused(path, &error))?;
    if let Some(blur_px) = observer.motion_blur_px() {
        print_message(format_args!(
            "warning: {}: markers are blurred in one direction, by {blur_px:.1} px (standard deviation), as of a motion while the shutter was open; sigma_mm \
             holds what that leaves in steady motion",
            path.display()
        ));
    }
    Ok(seen)
}

fn refused(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::from(FileError::Content { path: path.to_owned(), message: error.to_string() })
}
