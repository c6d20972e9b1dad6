//! Positions of the finger's nodes from images.
//!
//! Coloured markers are found (`colour`, `blobs`), measured (`disc`), assigned to nodes (`naming`), and measured again with a common outline (`together`).
//! The unloaded finger is found without an initial pose (`pattern`, `rest`). Grey markers are found by their rims (`rim`, `rim_locator`).

mod blobs;
mod colour;
mod disc;
mod elsewhere;
mod error;
mod finger_placement;
mod motion;
mod naming;
mod observer;
mod pattern;
mod radii;
mod rest;
mod rim;
mod rim_locator;
mod survey;
mod together;
mod warning;

pub use colour::GreyMarker;
pub use error::{LocateError, LocatorError};
pub use finger_placement::FingerPlacement;
pub use naming::NamingError;
pub use observer::{Observer, ObserverError};
pub use radii::{OtherRadius, SeenRadii};
pub use rest::{Rest, RestError};
pub use rim_locator::{RimLocator, SeenBase, SeenFinger};
pub use survey::{DotColour, MissingDot, Survey};
pub use warning::ImageWarning;

use crate::RgbRows;
use blobs::{Blob, LEAST_RADIUS_PX, blobs, commonest_radius, middle_of_colour};
use colour::Colours;
use disc::{Buffers, Disc, View};
use elsewhere::Scenery;
use finray_model::camera::{Camera, Lens, Pixel, ViewError};
use finray_model::finger::Plate;
use finray_model::observation::EstimatedNoise;
use finray_model::scene::{MarkerLook, Markers};
use finray_model::{Finger, NodeId, Vector};
use motion::motion_blur_px;
use naming::{Candidate, Marked, name, name_likely};
use together::{Common, located, measure_together};

/// Radius of the search for a marker about its last position, in marker radii.
const NEAR: f64 = 1.6;
/// If less than this share of the previous markers is found near their last positions, the whole image is searched.
const FOUND_AGAIN: f64 = 0.8;
/// Number of images after which the whole image is searched again if a marker is missing.
const SEARCH_AGAIN: usize = 10;
/// One of every [`FEW`] markers is tested for motion blur.
const FEW: usize = 5;
/// [`LocateError::OtherSize`] is reported if the most common radius of the patches differs from the expected radius of the markers by more than this factor.
const OTHER_SIZE: f64 = 1.2;

/// A marker that was located in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Key node to which the marker belongs.
    pub node: NodeId,
    /// Pixel of the marker's centre.
    pub pixel: Pixel,
    /// Position of the marker's centre, mm, finger frame.
    pub position: Vector,
    /// Standard deviation of one coordinate of the position, mm. The standard deviation covers image noise, and the errors of shading and edge model
    /// that occur in rendered images, and what may cover a part of the marker. The standard deviation excludes errors of lens and pose.
    pub sd_mm: f64,
}

/// Locator of the coloured markers of one finger with one camera.
#[derive(Debug, Clone)]
pub struct Locator<'f> {
    finger: &'f Finger,
    camera: Camera,
    markers: Markers,
    colours: Colours,
    /// Expected radius of a marker in the image, px.
    radius_px: f64,
    /// Key nodes of the front plate.
    on_front: Vec<NodeId>,
    /// Last known state of every marker that the last full search found.
    last: Vec<Located>,
    /// Number of markers in the last full search.
    searched: usize,
    /// Number of images that were tracked since the last full search.
    tracked: usize,
    /// Number of markers that were found in the last image.
    seen: usize,
    /// Common properties of the discs, measured in the last full search; `None` before a full search.
    common: Option<Common>,
    /// Noise in the last image.
    noise: Option<EstimatedNoise>,
    buffers: Buffers,
}

impl<'f> Locator<'f> {
    /// A locator for the finger, camera and markers of a scene.
    ///
    /// # Errors
    /// [`LocatorError`] for grey markers, colours close to grey, shared junctions of ribs, or a camera that does not see the finger.
    pub fn new(finger: &'f Finger, camera: &Camera, markers: &Markers) -> Result<Locator<'f>, LocatorError> {
        let MarkerLook::Coloured { front_rgb, back_rgb } = markers.look else {
            return Err(LocatorError::NotColoured);
        };
        error::require_own_junctions(finger)?;
        let colours = Colours::new([front_rgb, back_rgb])?;
        let radius_px = radius_px(finger, camera, markers)?;
        Ok(Locator {
            finger,
            camera: *camera,
            markers: *markers,
            colours,
            radius_px,
            on_front: finger.plate_nodes(Plate::Front),
            last: Vec::new(),
            searched: 0,
            tracked: 0,
            seen: 0,
            common: None,
            noise: None,
            buffers: Buffers::default(),
        })
    }

    /// Standard deviation of the motion blur in the last full search, px; `None` if the blur is isotropic (no motion).
    pub fn motion_blur_px(&self) -> Option<f64> {
        self.common.and_then(|common| common.motion_px)
    }

    /// Noise in the last image if the errors of neighbouring pixels are correlated, as after compression; `None` if they are independent.
    pub fn noise(&self) -> Option<EstimatedNoise> {
        self.noise
    }

    /// Median radius of the markers in the last full search, mm; `None` before the first full search.
    pub fn radius_mm(&self) -> Option<f64> {
        self.common.map(|common| common.outline.radius_mm)
    }

    /// Locates the markers in an image. Returns the located markers in the order of their nodes, without hidden markers. The search makes no
    /// assumption about the shape of the finger.
    ///
    /// # Errors
    /// [`LocateError`] if the image does not show the finger, or the markers cannot be assigned to nodes uniquely.
    pub fn locate(&mut self, image: &impl RgbRows) -> Result<Vec<Located>, LocateError> {
        self.locate_about(image, true)
    }

    /// Same as [`locate`](Locator::locate). If `pose_holds`, the finger must be exactly where the camera's pose puts it; otherwise, the finger may
    /// also be nearby.
    fn locate_about(&mut self, image: &dyn RgbRows, pose_holds: bool) -> Result<Vec<Located>, LocateError> {
        require_size(&self.camera.lens, image)?;
        let mut buffers = std::mem::take(&mut self.buffers);
        let view = self.view(image, [1.0; 2], Vector::zeros());
        let measured =
            |blob: &Blob| Some((blob.side, view.measure(self.markers.radius_mm, &blob.centre, &mut buffers)?));
        let discs: Vec<(Plate, Disc)> =
            blobs(image, &self.colours, self.radius_px).iter().filter_map(measured).collect();
        let mut named = self.named(&discs, pose_holds).map_err(|error| match error {
            LocateError::Naming(_) => self.other_size(image).unwrap_or(error),
            _ => error,
        })?;
        let common = measure_together(view, &self.markers, self.radius_px, &mut named, &mut buffers);
        self.buffers = buffers;
        let common = common?;
        self.common = Some(common);
        (self.last, self.noise) = located(&named, &self.on_front, &common);
        (self.searched, self.tracked, self.seen) = (self.last.len(), 0, self.last.len());
        Ok(self.last.clone())
    }

    /// Locates the markers in the next image of a stream. Each marker is searched for near its last position, with the outline and noise of the last
    /// full search. If more than a fifth of the markers of the last full search is missing or does not fit a finger, the whole image is searched.
    /// While a marker is missing, every tenth image is also searched completely.
    ///
    /// # Errors
    /// [`LocateError`] as for [`Locator::locate`].
    pub fn track(&mut self, image: &impl RgbRows) -> Result<Vec<Located>, LocateError> {
        require_size(&self.camera.lens, image)?;
        let reach = NEAR * self.radius_px;
        let Some(common) = self.common.filter(|_| !self.last.is_empty()) else {
            return self.locate(image);
        };
        let Common { outline, weights, colour_shift_px, .. } = common;
        self.tracked += 1;
        if self.seen < marker_count(self.finger) && self.tracked.is_multiple_of(SEARCH_AGAIN) {
            return self.locate(image);
        }
        let mut buffers = std::mem::take(&mut self.buffers);
        let view = self.view(image, weights, colour_shift_px);
        let near = |last: &Located| {
            let side = if self.on_front.contains(&last.node) { Plate::Front } else { Plate::Back };
            let side = if self.colours.are_alike() { Plate::Front } else { side };
            let mut centre = middle_of_colour(image, &self.colours, side, &last.pixel, reach, &mut buffers.row)?;
            // The search window may cut off part of the marker, so the search is repeated about the new centre.
            if (centre - last.pixel).norm() > reach - self.radius_px {
                centre = middle_of_colour(image, &self.colours, side, &centre, reach, &mut buffers.row)?;
            }
            Some((last.node, view.measure_centre(outline, &centre, &mut buffers)?))
        };
        let found: Vec<(NodeId, Disc)> = self.last.iter().filter_map(near).collect();
        self.buffers = buffers;
        // A marker near the last position of a node belongs to that node, unless no shape of the finger fits.
        let candidate = |(node, disc): &(NodeId, Disc)| Candidate {
            sides: [true; 2],
            at: disc.centre,
            node: Some(*node),
            cost: 0.0,
        };
        let candidates: Vec<Candidate> = found.iter().map(candidate).collect();
        let names = name_likely(Marked::at_base(self.finger), &candidates);
        let named: Vec<(NodeId, Disc)> = names.iter().flatten().map(|&i| found[i]).collect();
        if (named.len() as f64) < FOUND_AGAIN * self.searched as f64 {
            return self.locate(image);
        }
        // A few markers suffice to detect motion blur. If motion blur is detected, a full search measures it. The image after a blurred image is also
        // searched fully.
        let few = named.iter().step_by(FEW).map(|(_, disc)| disc);
        let blur_px = motion_blur_px(image, few, self.radius_px, outline.blurs_px[0]);
        if blur_px.or(common.motion_px).is_some() {
            return self.locate(image);
        }
        let found;
        (found, self.noise) = located(&named, &self.on_front, &common);
        for last in &mut self.last {
            if let Some(now) = found.iter().find(|now| now.node == last.node) {
                *last = *now;
            }
        }
        self.seen = found.len();
        Ok(found)
    }

    /// The error for patches of the markers' colours whose size does not fit the camera; `None` if their size fits.
    fn other_size(&self, image: &dyn RgbRows) -> Option<LocateError> {
        let expected_px = self.radius_px;
        let (found_px, count) = commonest_radius(image, &self.colours)?;
        let is_other = (found_px / expected_px).ln().abs() > OTHER_SIZE.ln();
        (is_other && 2 * count > marker_count(self.finger)).then_some(LocateError::OtherSize { expected_px, found_px })
    }

    /// The discs that are assigned to nodes. `pose_holds` has the meaning of [`Locator::locate_about`].
    fn named(&self, discs: &[(Plate, Disc)], pose_holds: bool) -> Result<Vec<(NodeId, Disc)>, LocateError> {
        let alike = self.colours.are_alike();
        let candidate = |(side, disc): &(Plate, Disc)| Candidate {
            sides: [Plate::Front, Plate::Back].map(|other| alike || other == *side),
            at: disc.centre,
            node: None,
            cost: 0.0,
        };
        let candidates: Vec<Candidate> = discs.iter().map(candidate).collect();
        let names = name(Marked::at_base(self.finger), &candidates);
        if pose_holds {
            let seen: Vec<_> =
                candidates.iter().zip(discs).map(|(candidate, (_, disc))| (*candidate, disc.pixel)).collect();
            let (finger, camera, height_mm) = (self.finger, &self.camera, self.markers.height_mm);
            if let Some(error) = (Scenery { finger, camera, height_mm, seen: &seen }).elsewhere(&names) {
                return Err(error);
            }
        }
        let named = |(i, name): (usize, &Option<usize>)| Some((NodeId(i + 1), discs[(*name)?].1));
        Ok(names?.iter().enumerate().filter_map(named).collect())
    }

    fn view<'a>(&'a self, image: &'a dyn RgbRows, weights: [f64; 2], colour_shift_px: Vector) -> View<'a> {
        let height_mm = self.markers.height_mm;
        View { image, camera: &self.camera, height_mm, grey_inner_mm: None, weights, colour_shift_px }
    }
}

/// Number of markers of a finger, including those of clamped nodes.
fn marker_count(finger: &Finger) -> usize {
    (1..=finger.key_node_count()).filter(|&node| finger.has_marker(NodeId(node))).count()
}

/// Radius of a marker in the image, px, at the middle of the undeformed finger.
fn radius_px(finger: &Finger, camera: &Camera, markers: &Markers) -> Result<f64, LocateError> {
    let nodes = finger.key_node_count();
    let middle = (1..=nodes).map(|node| finger.position(NodeId(node))).sum::<Vector>() / nodes as f64;
    let pixel = camera.project(&middle.push(markers.height_mm))?;
    if !camera.lens.contains(&pixel) {
        return Err(LocateError::Outside);
    }
    // If the distortion folds in the image, a marker beyond the fold may be seen at a pixel that the model assigns to another point.
    let is_beyond = |node: &NodeId| {
        let at = finger.marker_position(*node).push(markers.height_mm);
        camera.project(&at) == Err(ViewError::Folded)
    };
    let mut marked = (1..=nodes).map(NodeId).filter(|node| finger.has_marker(*node));
    if camera.lens.folds_image()
        && let Some(node) = marked.find(is_beyond)
    {
        return Err(LocateError::Folded { node });
    }
    radius_at(camera, &pixel, markers)
}

/// Radius of a marker in the image, px, at a given pixel.
fn radius_at(camera: &Camera, pixel: &Pixel, markers: &Markers) -> Result<f64, LocateError> {
    let mm_a_px = camera.position_sd_mm(pixel, markers.height_mm, 1.0)?;
    let radius_px = markers.radius_mm / mm_a_px;
    if radius_px < LEAST_RADIUS_PX { Err(LocateError::TooSmall { radius_px }) } else { Ok(radius_px) }
}

fn require_size(lens: &Lens, image: &dyn RgbRows) -> Result<(), LocateError> {
    let (expected, found) = (lens.size_px(), image.size_px());
    if expected == found { Ok(()) } else { Err(LocateError::Size { expected, found }) }
}
