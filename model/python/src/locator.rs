//! Locating markers in images.

use crate::error::{failed, refused};
use crate::images::ImageArgument;
use crate::observation::Observation;
use crate::scene::Scene;
use finray_files::load_image;
use finray_imaging::locate::{ImageWarning, LocateError, Observer};
use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use self_cell::self_cell;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

self_cell!(
    struct OwnedObserver {
        owner: Arc<finray_model::Scene>,
        #[not_covariant]
        dependent: Observer,
    }
);

/// Locates the markers of a scene's finger in images. Coloured markers are tracked from image to image, so the order of images matters.
///
/// Args:
///     scene: scene with the tables camera and markers.
///     rest: image of the unloaded finger, as for `locate`; pose and displacements are then measured from this image. None: from the scene.
///
/// Raises FinrayError for a scene without camera, pose or markers, and for an image that does not show the unloaded finger.
#[pyclass(frozen, module = "finray")]
pub struct Locator {
    observer: Mutex<OwnedObserver>,
    rest_residual_px: Option<f64>,
}

#[pymethods]
impl Locator {
    #[new]
    #[pyo3(signature = (scene, rest=None))]
    fn new(py: Python<'_>, scene: &Scene, rest: Option<&Bound<'_, PyAny>>) -> PyResult<Locator> {
        let scene = scene.scene.clone();
        let rest = rest.map(ImageArgument::of).transpose()?;
        let rest = rest.as_ref().map(ImageArgument::view).transpose()?;
        let observer = py.detach(|| {
            let rest = rest.map(|view| view.to_image());
            OwnedObserver::try_new(scene, |scene| Observer::new(scene, rest.as_ref())).map_err(failed)
        })?;
        let rest_residual_px = observer.with_dependent(|_, observer| observer.rest_residual_px);
        Ok(Locator { observer: Mutex::new(observer), rest_residual_px })
    }

    /// Locate the markers in the next image.
    ///
    /// Args:
    ///     image: C-contiguous uint8 array of shape (height, width, 3), in the order red, green, blue, or of shape (height, width) for a grey image.
    ///         The array is read in place and must not change during the call.
    ///
    /// Raises Refused if the image does not show the finger, and FinrayError for an array of another type or size.
    fn locate(&self, py: Python<'_>, image: &Bound<'_, PyAny>) -> PyResult<Observation> {
        let image = ImageArgument::of(image)?;
        let view = image.view()?;
        let found = py.detach(|| {
            let mut observer = self.observer.lock().unwrap_or_else(PoisonError::into_inner);
            observer
                .with_dependent_mut(|_, observer| observer.observe(&view).map(|seen| (seen, observer.warnings.clone())))
        });
        match found {
            Ok((seen, warnings)) => {
                Ok(Observation::new(seen).with_warnings(warnings.iter().map(ToString::to_string).collect()))
            }
            Err(error @ LocateError::Size { .. }) => Err(failed(error)),
            Err(error) => Err(refused(error)),
        }
    }

    /// Residual standard deviation of one pixel coordinate in the fit of the pose to `rest`, px; None if the pose was not fitted.
    #[getter]
    fn rest_residual_px(&self) -> Option<f64> {
        self.rest_residual_px
    }

    /// Warning of the image `rest`, if its markers are away from their positions on the scene's unloaded finger; None otherwise.
    #[getter]
    fn rest_warning(&self) -> Option<String> {
        self.rest_residual_px.and_then(ImageWarning::of_rest).map(|warning| warning.to_string())
    }

    /// Standard deviation of the motion blur in the last image, px; None without motion and for grey markers.
    #[getter]
    fn motion_blur_px(&self, py: Python<'_>) -> Option<f64> {
        py.detach(|| {
            let observer = self.observer.lock().unwrap_or_else(PoisonError::into_inner);
            observer.with_dependent(|_, observer| observer.motion_blur_px())
        })
    }
}

/// Read an image file (PNG, JPEG) as the command `finray` does: rotated according to its EXIF orientation.
///
/// Returns a uint8 array of shape (height, width, 3), in the order red, green, blue.
#[pyfunction]
pub fn read_image(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyArray3<u8>>> {
    let (image, _) = py.detach(|| load_image(&path)).map_err(failed)?;
    let size = [image.height() as usize, image.width() as usize, 3];
    image.into_raw().into_pyarray(py).reshape(size)
}
