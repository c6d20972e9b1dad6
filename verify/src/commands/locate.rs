//! The command `finray locate`.

use crate::commands::prelude::*;
use finray_files::image_names;
use finray_files::observations::{self, RefusedImage};
use finray_imaging::locate::{ImageWarning, Observer, ObserverError, OtherRadius, SeenRadii};
use finray_model::observation::{Observation, ObservedMarker};
use finray_model::scene::MarkerLook;
use rayon::prelude::*;

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
    let Arguments { scene: path, image, rest, out } = arguments;
    require_one_standard_input([path].into_iter().chain(image).chain(rest))?;
    let images = Images { scene: path, images: image, rest: rest.as_deref() };
    let seen = images.located(&load_scene(path)?)?;
    write_file(out, &observations::to_csv(&seen)?)?;
    let located: Vec<&Observation> = seen.iter().flatten().collect();
    let markers: usize = located.iter().map(|seen| seen.markers.len()).sum();
    let done = format!("{markers} markers located in {} of {}", located.len(), count(seen.len(), "image"));
    Ok(summary(done, [out]))
}

/// Image files of a finger.
pub struct Images<'a> {
    /// The scene file, named in messages.
    pub scene: &'a Path,
    /// The images, in the order in which they were taken.
    pub images: &'a [PathBuf],
    /// Image of the unloaded finger.
    pub rest: Option<&'a Path>,
}

impl Images<'_> {
    /// Locates the markers in all images and prints the warnings.
    ///
    /// # Errors
    /// [`Failure`] if the scene cannot locate markers, or if every image is refused.
    pub fn located(&self, scene: &Scene) -> Result<Vec<Result<Observation, RefusedImage>>, Failure> {
        let names = image_names(self.images)?;
        let observer = self.observer(scene)?;
        if let Some(path) = self.rest {
            observer.rest_residual_px.and_then(ImageWarning::of_rest).iter().for_each(warn(path));
        }
        let found = self.with_their_radii(scene, observer);
        // If every image is refused, there is no table to write, so the command fails with the first refusal.
        if found.iter().all(Result::is_err) {
            let first = found.into_iter().find_map(Result::err);
            return Err(first.unwrap_or_else(|| bad_input("expected at least one image")));
        }
        let of_image = |((path, image), found): ((&PathBuf, String), Result<SeenImage, Failure>)| match found {
            Ok(SeenImage { observation, warnings, .. }) => {
                // Radii are compared once for all images.
                warnings.iter().filter(|warning| !matches!(warning, ImageWarning::OtherRadius(_))).for_each(warn(path));
                Ok(Observation { image, ..observation })
            }
            Err(failure) => {
                let reason = failure.reason().to_owned();
                print_message(format_args!("warning: image refused: {reason}"));
                Err(RefusedImage { image, reason })
            }
        };
        let seen: Vec<_> = self.images.iter().zip(names).zip(found).map(of_image).collect();
        let located: Vec<&Observation> = seen.iter().flatten().collect();
        for (seen, is_turned) in located.iter().zip(ImageWarning::turned(&located)) {
            is_turned.then_some(&ImageWarning::Turned).into_iter().for_each(warn(Path::new(&seen.image)));
        }
        Ok(seen)
    }

    /// Locates the markers in all images. If measured marker radii differ from the scene's, prints a message and searches again with the measured radii.
    fn with_their_radii(&self, scene: &Scene, observer: Observer) -> SeenImages {
        let found = self.in_all(observer);
        let radii: Vec<&SeenRadii> = found.iter().flatten().map(|seen| &seen.radii).collect();
        let others: Vec<OtherRadius> =
            scene.markers.iter().flat_map(|markers| OtherRadius::of(markers, scene.base.as_ref(), &radii)).collect();
        let is_file = |image: &Path| !is_standard_stream(image);
        if others.is_empty() || !self.images.iter().map(PathBuf::as_path).chain(self.rest).all(is_file) {
            others.iter().for_each(|other| print_message(format_args!("warning: {other}")));
            return found;
        }
        let mut corrected = scene.clone();
        others.iter().for_each(|other| other.correct(&mut corrected));
        let anew = self.observer(&corrected).map(|observer| self.in_all(observer)).unwrap_or_default();
        let count =
            |images: &SeenImages| images.iter().flatten().map(|seen| seen.observation.markers.len()).sum::<usize>();
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

    /// Locates the markers of all images in parallel. If markers are tracked, images are searched in order, each starting from the marker positions in
    /// the previous image.
    fn in_all(&self, mut observer: Observer) -> SeenImages {
        if observer.is_tracking() {
            return self.images.iter().map(|path| observed(&mut observer, path)).collect();
        }
        self.images.par_iter().map_init(|| observer.clone(), |observer, path| observed(observer, path)).collect()
    }

    /// Builds the marker locator for a scene, with the image of the unloaded finger if one is given.
    pub fn observer<'s>(&self, scene: &'s Scene) -> Result<Observer<'s>, Failure> {
        let path = self.scene;
        // Missing tables of the scene are reported before an image is read.
        camera_of(path, scene)?;
        let markers = markers_of(path, scene)?;
        let pose_is_sought = self.rest.is_some() && matches!(markers.look, MarkerLook::Coloured { .. });
        if !pose_is_sought {
            camera_and_markers(path, scene)?;
        }
        let image = self.rest.map(load_image).transpose()?;
        Observer::new(scene, image.as_ref().map(|(image, _)| image)).map_err(|error| match (&error, self.rest) {
            (ObserverError::Rest(_) | ObserverError::GreyRest(_), Some(path)) => {
                FileError::content(path, &error).into()
            }
            _ => bad_input(error),
        })
    }
}

/// Prints a warning of an image.
fn warn(path: &Path) -> impl Fn(&ImageWarning) {
    move |warning| print_message(format_args!("warning: {}: {warning}", path.display()))
}

/// Observation, marker radii and warnings of one image.
struct SeenImage {
    observation: Observation,
    radii: SeenRadii,
    warnings: Vec<ImageWarning>,
}

type SeenImages = Vec<Result<SeenImage, Failure>>;

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

fn observed(observer: &mut Observer, path: &Path) -> Result<SeenImage, Failure> {
    let observation = observer.observe(&load_image(path)?.0).map_err(|error| FileError::content(path, error))?;
    Ok(SeenImage { observation, radii: observer.radii.clone(), warnings: observer.warnings.clone() })
}
