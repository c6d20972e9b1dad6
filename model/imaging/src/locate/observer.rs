//! Conversion of images to observations. It uses a locator for the scene's markers, and the data that all images of a scene share.

use super::{
    ImageWarning, LocateError, Located, Locator, LocatorError, Rest, RestError, RimLocator, SeenBase, SeenRadii,
};
use crate::RgbRows;
use finray_model::camera::Camera;
use finray_model::measurement::BaseUncertainty;
use finray_model::observation::{
    EstimatedNoise, LocatedWith, Observation, ObservedBase, ObservedMarker, nodes_of_markers,
};
use finray_model::scene::{Base, MarkerLook, Markers, marker_offset};
use finray_model::sensor::FrameState;
use finray_model::{Finger, Scene, Vector};
use image::RgbImage;

/// Converts images of a finger to observations of its markers.
#[derive(Debug, Clone)]
pub struct Observer<'f> {
    finger: &'f Finger,
    locator: AnyLocator<'f>,
    /// Markers relative to their nodes, as in [`Scene::marker_offsets`].
    offsets: &'f [Vector],
    /// Markers of the unloaded finger; empty if no image of the unloaded finger was given.
    at_rest: Vec<Located>,
    /// Noise of the image of the unloaded finger, as in [`Locator::noise`].
    rest_noise: Option<EstimatedNoise>,
    /// The scene with which markers are located. `None` if the pose is not the scene's, as for a placed finger.
    located_with: Option<LocatedWith>,
    /// Residual standard deviation of one pixel coordinate, px, in the fit of the pose to coloured markers of the unloaded finger. `None` without such an
    /// image.
    pub rest_residual_px: Option<f64>,
    markers: Markers,
    /// The base, if it may move between images.
    base: Option<&'f Base>,
    /// Radii of markers and references in the last image that showed the finger.
    pub radii: SeenRadii,
    /// Warnings of the last image that showed the finger.
    pub warnings: Vec<ImageWarning>,
}

#[derive(Debug, Clone)]
enum AnyLocator<'f> {
    Coloured(Box<Locator<'f>>),
    Grey(Box<RimLocator<'f>>),
}

/// Reason why images cannot be evaluated with a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ObserverError {
    /// The scene has no camera.
    #[error("the scene has no [camera] with size_px, focal_px and principal_point_px")]
    NoCamera,
    /// The scene's camera has no pose, and no image of the unloaded finger was given to determine it.
    #[error("the scene has no rotation_vector_rad and translation_mm in [camera]")]
    NoPose,
    /// The scene has no markers.
    #[error("the scene has no [markers]")]
    NoMarkers,
    /// A locator for the markers cannot be created.
    #[error(transparent)]
    Locator(#[from] LocatorError),
    /// The image of the unloaded finger does not show its coloured markers.
    #[error(transparent)]
    Rest(#[from] RestError),
    /// The image of the unloaded finger does not show its grey markers.
    #[error(transparent)]
    GreyRest(LocateError),
}

impl<'f> Observer<'f> {
    /// An observer for the finger, camera and markers of a scene. If an image of the unloaded finger is given, displacements are relative to the
    /// marker positions in that image. Coloured markers in the image of the unloaded finger also determine the camera's pose.
    ///
    /// # Errors
    /// [`ObserverError`] for a scene without camera, pose or markers, or for an image that does not show the unloaded finger.
    pub fn new(scene: &'f Scene, rest: Option<&RgbImage>) -> Result<Observer<'f>, ObserverError> {
        let finger = &scene.finger;
        let description = scene.camera.ok_or(ObserverError::NoCamera)?;
        let markers = scene.markers.ok_or(ObserverError::NoMarkers)?;
        if let (MarkerLook::Coloured { .. }, Some(image)) = (markers.look, rest) {
            let offsets = &scene.marker_offsets;
            let rest = Rest::of((finger, offsets), &description.lens, description.pose, &markers, image)?;
            let observer = Observer::with(finger, &rest.camera, &markers, None)?;
            return Ok(Observer {
                offsets,
                at_rest: rest.located,
                rest_noise: rest.noise,
                located_with: LocatedWith::scene(scene).map(|with| with.from_rest(true)),
                rest_residual_px: Some(rest.residual_sd_px),
                ..observer
            });
        }
        let camera = Camera { lens: description.lens, pose: description.pose.ok_or(ObserverError::NoPose)? };
        let mut observer = Observer::with(finger, &camera, &markers, scene.base.as_ref())?;
        observer.offsets = &scene.marker_offsets;
        observer.located_with = LocatedWith::scene(scene);
        if let (AnyLocator::Grey(locator), Some(image)) = (&observer.locator, rest) {
            observer.at_rest = locator.locate(image).map_err(ObserverError::GreyRest)?.located;
            observer.located_with = observer.located_with.map(|with| with.from_rest(false));
        }
        Ok(observer)
    }

    /// An observer for a finger whose markers are centred on their nodes, and a camera of known pose. `base` contains the reference marks on a moving base;
    /// only locators of grey markers use it.
    ///
    /// # Errors
    /// [`LocatorError`] for markers that no locator supports, or a camera that does not see the finger.
    pub fn with(
        finger: &'f Finger,
        camera: &Camera,
        markers: &Markers,
        base: Option<&'f Base>,
    ) -> Result<Observer<'f>, LocatorError> {
        let locator = match markers.look {
            MarkerLook::Coloured { .. } => AnyLocator::Coloured(Box::new(Locator::new(finger, camera, markers)?)),
            MarkerLook::Grey { .. } => AnyLocator::Grey(Box::new(RimLocator::new(finger, camera, markers, base)?)),
        };
        let base = base.filter(|_| matches!(locator, AnyLocator::Grey(_)));
        let (radii, warnings) = (SeenRadii::default(), Vec::new());
        Ok(Observer {
            finger,
            locator,
            offsets: &[],
            at_rest: Vec::new(),
            rest_noise: None,
            located_with: None,
            rest_residual_px: None,
            markers: *markers,
            base,
            radii,
            warnings,
        })
    }

    /// Motion blur in the last image, px, as in [`Locator::motion_blur_px`]; `None` for grey markers.
    pub fn motion_blur_px(&self) -> Option<f64> {
        match &self.locator {
            AnyLocator::Coloured(locator) => locator.motion_blur_px(),
            AnyLocator::Grey(_) => None,
        }
    }

    /// Noise of the displacements in the last image, in which `located` was found: that of the image as in [`Locator::noise`], and of the image of the
    /// unloaded finger. `None` for grey markers.
    fn noise(&self, located: &[Located]) -> Option<EstimatedNoise> {
        let AnyLocator::Coloured(locator) = &self.locator else { return None };
        let mean_mm2 = |located: &[Located]| {
            located.iter().map(|seen| seen.sd_mm.powi(2)).sum::<f64>() / located.len().max(1) as f64
        };
        let images = [(locator.noise(), mean_mm2(located)), (self.rest_noise, mean_mm2(&self.at_rest))];
        EstimatedNoise::of_difference(images)
    }

    /// Whether markers are searched for near their positions in the previous image. If markers are tracked from image to image, the order of the
    /// images matters.
    pub fn is_tracking(&self) -> bool {
        matches!(self.locator, AnyLocator::Coloured(_))
    }

    /// Observes the finger in the next image of a stream. The image may be owned, borrowed ([`RgbView`](crate::RgbView)), or
    /// converted where it is read ([`RgbRows`]).
    ///
    /// # Errors
    /// [`LocateError`] if the image does not show the finger, or the markers cannot be assigned to nodes uniquely.
    pub fn observe(&mut self, image: &impl RgbRows) -> Result<Observation, LocateError> {
        let (located, base, radii) = match &mut self.locator {
            AnyLocator::Coloured(locator) => {
                let located = locator.track(image)?;
                (located, None, SeenRadii { markers_mm: locator.radius_mm(), references_mm: Vec::new() })
            }
            AnyLocator::Grey(locator) => {
                let found = locator.locate(image)?;
                (found.located, self.base.map(|_| found.base), found.radii)
            }
        };
        let positions: Vec<_> = located.iter().map(|seen| (seen.node, seen.position)).collect();
        let nodes = nodes_of_markers(self.finger, self.offsets, &positions);
        let markers = located.iter().zip(nodes).map(|(seen, node)| self.marker(seen, node, base.as_ref())).collect();
        let base = base.map(|base| ObservedBase {
            pose: base.pose,
            uncertainty: Some(uncertainty_at_origin(&base)),
            is_known: base.is_known,
        });
        let (noise, located_with) = (self.noise(&located), self.located_with);
        let seen = Observation { image: String::new(), markers, base, noise, located_with };
        let motion_blur_px = self.motion_blur_px();
        self.warnings = ImageWarning::of_image(self.finger, &self.markers, self.base, &seen, &radii, motion_blur_px);
        self.radii = radii;
        Ok(seen)
    }

    /// Observes the finger in the next image of a stream, for [`FingerTracker::evaluate`](finray_model::sensor::FingerTracker::evaluate).
    ///
    /// # Errors
    /// Returns the state of the finger and the reason if the image does not show the finger or has another size than the camera's images.
    pub fn observe_frame(&mut self, image: &impl RgbRows) -> Result<Observation, (FrameState, String)> {
        self.observe(image).map_err(|error| match error {
            LocateError::Size { .. } => (FrameState::Refused, error.to_string()),
            _ => (FrameState::Lost, error.to_string()),
        })
    }

    /// `node` contains the position of the marker's node, and the standard deviation of its conversion from the position of the marker, both mm.
    fn marker(&self, seen: &Located, node: (Vector, f64), base: Option<&SeenBase>) -> ObservedMarker {
        let (position, node_sd_mm) = node;
        let at_rest = self.at_rest.iter().find(|marker| marker.node == seen.node);
        let offset = marker_offset(self.offsets, seen.node);
        let (from, from_sd_mm) = at_rest
            .map_or_else(|| (self.finger.marker_position(seen.node), 0.0), |at| (at.position - offset, at.sd_mm));
        let sd_mm = seen.sd_mm.hypot(from_sd_mm).hypot(node_sd_mm);
        let own_sd_mm = base.map(|base| {
            let shared_mm = base.sd_at(&seen.position);
            (sd_mm * sd_mm - shared_mm * shared_mm).sqrt()
        });
        ObservedMarker {
            node: seen.node,
            pixel: Some(seen.pixel),
            position: Some(position),
            displacement: Some(position - from),
            sd_mm: Some(sd_mm),
            own_sd_mm,
        }
    }
}

/// Uncertainty of the base's pose at the origin of the finger frame. The uncertainty follows from errors of the references' mean position and of the
/// rotation about that position.
fn uncertainty_at_origin(base: &SeenBase) -> BaseUncertainty {
    let arm_mm = base.middle.norm() / std::f64::consts::SQRT_2;
    BaseUncertainty { sd_mm: base.sd_mm.hypot(base.sd_rad * arm_mm), sd_rad: base.sd_rad, ..BaseUncertainty::default() }
}
