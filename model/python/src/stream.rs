//! Contact forces for each frame of a stream, as `finray live` prints them.

use crate::arrays::LARGEST_INTEGER;
use crate::error::failed;
use crate::images::{ImageArgument, ImageView};
use crate::observation::Observation;
use crate::scene::Scene;
use crate::sensor::{contacts, options};
use finray_files::live::{FrameInfo, Line};
use finray_imaging::locate::{Observer, ObserverError};
use finray_model::sensor::{FingerTracker, FrameState, Refusal};
use pyo3::prelude::*;
use self_cell::self_cell;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// State of the evaluation of a stream.
struct Evaluation<'s> {
    finger: FingerTracker,
    /// Locator of the markers; `None` before the first image.
    observer: Option<Observer<'s>>,
    /// Number of evaluated and dropped frames.
    frames: usize,
}

self_cell!(
    struct OwnedEvaluation {
        owner: Arc<finray_model::Scene>,
        #[not_covariant]
        dependent: Evaluation,
    }
);

/// Senses the forces in each frame of a stream, and determines how many contacts a frame shows, as `finray live` does.
///
/// Args:
///     scene: the finger; for images, with the tables camera and markers.
///     contact_at: contacts at positions along a plate, as for Sensor: a number in mm, a text such as "auto@normal", or a sequence of them.
///     contact: contacts at nodes, as for Sensor: a node, a text such as "19@normal", or a sequence of them.
///     noise_mm: standard deviation of one coordinate, mm; None: the scene's, else that of each marker.
///     estimator: name of the estimator, as in `finray live --help`.
///     network: file of a network of `finray train`; None: the shipped networks.
///     rest_frames: number of first frames that show the unloaded finger; displacements are then measured from their mean positions.
///
/// Raises FinrayError if the contacts are wrong, or the estimator does not support them.
#[pyclass(frozen, module = "finray")]
pub struct StreamSensor(Mutex<OwnedEvaluation>);

/// Image or marker positions of a frame, or the reason why the frame has neither.
enum Content<'a> {
    Image(ImageView<'a>),
    Markers(&'a Observation),
    Unreadable(String),
}

#[pymethods]
impl StreamSensor {
    #[new]
    #[pyo3(signature = (
        scene, contact_at=None, *, contact=None, noise_mm=None, estimator="nonlinear", network=None, rest_frames=0
    ))]
    fn new(
        scene: &Scene,
        contact_at: Option<&Bound<'_, PyAny>>,
        contact: Option<&Bound<'_, PyAny>>,
        noise_mm: Option<f64>,
        estimator: &str,
        network: Option<PathBuf>,
        rest_frames: usize,
    ) -> PyResult<StreamSensor> {
        let contacts = contacts(scene, contact_at, contact, 0.0)?;
        let options = options(estimator, network, noise_mm, None)?;
        let evaluation = OwnedEvaluation::try_new(scene.scene.clone(), |scene| {
            let finger = FingerTracker::new("", scene.clone(), contacts, options, rest_frames)?;
            Ok::<_, Refusal>(Evaluation { finger, observer: None, frames: 0 })
        });
        Ok(StreamSensor(Mutex::new(evaluation.map_err(failed)?)))
    }

    /// Evaluate the next frame. Returns the line of JSON that `finray live` prints; `finray guide live` lists its keys.
    ///
    /// Args:
    ///     frame: image, as for Locator.locate, or Observation.
    ///     time_s: time of the frame, s; None if unknown.
    ///     dropped: number of frames dropped since the previous line, at most 2^53.
    ///
    /// Raises FinrayError for an array that is not an image, and for an image if the scene has no camera or markers. If forces are missing for a
    /// reason that raises no error, the line states the reason.
    #[pyo3(signature = (frame, *, time_s=None, dropped=0))]
    fn line(&self, py: Python<'_>, frame: &Bound<'_, PyAny>, time_s: Option<f64>, dropped: usize) -> PyResult<String> {
        let arrived = Instant::now();
        if let Ok(observation) = frame.cast::<Observation>() {
            let content = Content::Markers(observation.get());
            return py.detach(|| self.evaluate(content, arrived, time_s, dropped));
        }
        let image = ImageArgument::of(frame)?;
        let content = Content::Image(image.view()?);
        py.detach(|| self.evaluate(content, arrived, time_s, dropped))
    }

    /// The line of a frame that cannot be read, with the reason.
    #[pyo3(signature = (reason, *, time_s=None, dropped=0))]
    fn refused_line(&self, py: Python<'_>, reason: String, time_s: Option<f64>, dropped: usize) -> PyResult<String> {
        let arrived = Instant::now();
        py.detach(|| self.evaluate(Content::Unreadable(reason), arrived, time_s, dropped))
    }
}

impl StreamSensor {
    fn evaluate(&self, content: Content, arrived: Instant, time_s: Option<f64>, dropped: usize) -> PyResult<String> {
        // A line of JSON states larger numbers inexactly.
        if dropped > LARGEST_INTEGER as usize {
            return Err(failed(format!("dropped: expected at most {LARGEST_INTEGER}, found {dropped}")));
        }
        let mut evaluation = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        evaluation.with_dependent_mut(|scene, evaluation| {
            let Evaluation { finger, observer, frames } = evaluation;
            let seen = match content {
                Content::Image(image) => observer_of(observer, scene).map_err(failed)?.observe_frame(&image),
                Content::Markers(observation) => Ok(observation.seen.clone()),
                Content::Unreadable(reason) => Err((FrameState::Refused, reason)),
            };
            let number = *frames + dropped;
            *frames = number + 1;
            let result = [finger.evaluate(seen)];
            Line::new(&FrameInfo { number, time_s, arrived, dropped }, &result).to_json().map_err(failed)
        })
    }
}

/// The locator of a stream, created for its first image.
fn observer_of<'o, 's>(
    observer: &'o mut Option<Observer<'s>>,
    scene: &'s finray_model::Scene,
) -> Result<&'o mut Observer<'s>, ObserverError> {
    match observer {
        Some(observer) => Ok(observer),
        none => Ok(none.insert(Observer::new(scene, None)?)),
    }
}
