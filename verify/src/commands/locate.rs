//! `finray locate`

use crate::commands::prelude::*;
use finray_files::{image_names, observations};
use finray_imaging::locate::{Observer, ObserverError};
use finray_model::observation::Observation;
use finray_model::scene::MarkerLook;
use rayon::prelude::*;

/// Residual of the pose at rest, px, beyond which more than the noise of an image and a lens that was found is in it.
const SURE_REST_PX: f64 = 0.3;

/// Locate the nodes of a finger in images of its markers.
///
/// Writes image,node,u_px,v_px,x_mm,y_mm,ux_mm,uy_mm,sigma_mm, a row a marker found; a hidden one has
/// none. image is the file's name, with as many of its folders as distinguish it from the others.
/// x_mm, y_mm is its position in the finger frame, ux_mm, uy_mm its displacement from the scene's
/// undeformed node. `finray sense` reads this.
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
    let mut observed: Vec<Observation> = if observer.is_tracking() {
        let mut observer = observer;
        arguments.image.iter().map(|path| observed(&mut observer, path)).collect::<Result<_, _>>()?
    } else {
        let images = arguments.image.par_iter();
        images.map_init(|| observer.clone(), |observer, path| observed(observer, path)).collect::<Result<_, _>>()?
    };
    for ((path, name), seen) in arguments.image.iter().zip(names).zip(&mut observed) {
        seen.image = name;
        if seen.base.is_some_and(|base| !base.is_known) {
            print_message(format_args!(
                "warning: {}: two references on the base were not found, so the finger frame is only about where the ribs have it: \
                 displacements are to be used where the base is sought with the forces, as `finray sense` does",
                path.display()
            ));
        }
    }
    Ok(write_text(&arguments.out, &observations::to_csv(&observed)?)?)
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

fn observed(observer: &mut Observer, path: &Path) -> Result<Observation, Failure> {
    observer.observe(&load_image(path)?).map_err(|error| refused(path, &error))
}

fn refused(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::from(FileError::Content { path: path.to_owned(), message: error.to_string() })
}
