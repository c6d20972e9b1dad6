//! Node positions from images: find the markers (`colour`, `blobs`), measure their centres (`disc`), name them (`naming`), and measure them again
//! as markers that are alike (`together`).
//! The finger at rest is found without a guess of its pose (`pattern`, `rest`). Markers in grey light are found by their rims (`rim`,
//! `rim_locator`).

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
mod together;

pub use colour::GreyMarker;
pub use error::{LocateError, LocatorError};
pub use finger_placement::FingerPlacement;
pub use naming::NamingError;
pub use observer::{Observer, ObserverError};
pub use radii::{OtherRadius, SeenRadii};
pub use rest::{Rest, RestError};
pub use rim_locator::{RimLocator, SeenBase, SeenFinger};

use blobs::{Blob, LEAST_RADIUS_PX, blobs, commonest_radius, middle_of_colour};
use colour::{Colours, Side};
use disc::{Buffers, Disc, View};
use elsewhere::Scenery;
use finray_model::camera::{Camera, Lens, Pixel};
use finray_model::finger::Plate;
use finray_model::scene::{MarkerLook, Markers};
use finray_model::{Finger, NodeId, Vector};
use image::RgbImage;
use motion::motion_blur_px;
use naming::{Candidate, Marked, name, name_likely};
use together::{Common, located, measure_together};

/// A marker is sought within so many of its radii of where it was in the image before.
const NEAR: f64 = 1.6;
/// Share of the markers of the image before that must be found again near where they were; with fewer the whole image is searched.
const FOUND_AGAIN: f64 = 0.8;
/// Images after which a stream in which a marker is missing is searched again.
const SEARCH_AGAIN: usize = 10;
/// One of so many markers is looked at for the blur of a motion.
const FEW: usize = 5;
/// Ratio of the radius of patches to that of markers from which on they are another camera's.
const OTHER_SIZE: f64 = 1.2;

/// A marker in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Its node.
    pub node: NodeId,
    /// Where its centre is seen.
    pub pixel: Pixel,
    /// Its centre in the finger frame, mm.
    pub position: Vector,
    /// Standard deviation of one coordinate of the position, mm: noise of the image, and what shading and the model of the edge leave in
    /// rendered images. The errors of lens and pose are not in it.
    pub sd_mm: f64,
}

/// Finds the coloured markers of one finger with one camera.
#[derive(Debug, Clone)]
pub struct Locator<'f> {
    finger: &'f Finger,
    camera: Camera,
    markers: Markers,
    colours: Colours,
    radius_px: f64,
    on_front: Vec<NodeId>,
    /// Every marker that was seen since the last full search, where it was last seen.
    last: Vec<Located>,
    /// Markers that the last full search found, and images that were tracked since.
    searched: usize,
    tracked: usize,
    /// Markers in the last image.
    seen: usize,
    /// What its discs have in common.
    common: Option<Common>,
    buffers: Buffers,
}

impl<'f> Locator<'f> {
    /// A locator for a scene's finger, camera and markers.
    ///
    /// # Errors
    /// [`LocatorError`] for colours that cannot be found and a camera that does not see the finger.
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
            buffers: Buffers::default(),
        })
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Standard deviation of the blur, px, by which the finger or the camera moved in the last image that was searched whole; `None` of a round blur.
    pub fn motion_blur_px(&self) -> Option<f64> {
        self.common.and_then(|common| common.motion_px)
    }

    /// Median radius of the markers in the last image that was searched whole, mm.
    pub fn radius_mm(&self) -> Option<f64> {
        self.common.map(|common| common.outline.radius_mm)
    }

    /// Markers in an image, in the order of the nodes; hidden ones are left out. Nothing is assumed of the shape.
    ///
    /// # Errors
    /// [`LocateError`] if the image does not show the finger, or more than one way to name the markers fits.
    pub fn locate(&mut self, image: &RgbImage) -> Result<Vec<Located>, LocateError> {
        self.locate_about(image, true)
    }

    /// The same; `pose_holds`: whether the finger must be where the pose has it, not only about there.
    fn locate_about(&mut self, image: &RgbImage, pose_holds: bool) -> Result<Vec<Located>, LocateError> {
        require_size(&self.camera.lens, image)?;
        let mut buffers = std::mem::take(&mut self.buffers);
        let view = self.view(image, [1.0; 2], Vector::zeros());
        let measured =
            |blob: &Blob| Some((blob.side, view.measure(self.markers.radius_mm, &blob.centre, &mut buffers)?));
        let discs: Vec<(Side, Disc)> =
            blobs(image, &self.colours, self.radius_px).iter().filter_map(measured).collect();
        let mut named = self.named(&discs, pose_holds).map_err(|error| match error {
            LocateError::Naming(_) => self.other_size(image).unwrap_or(error),
            _ => error,
        })?;
        let common = measure_together(view, &self.markers, self.radius_px, &mut named, &mut buffers);
        self.buffers = buffers;
        let common = common?;
        self.common = Some(common);
        self.last = located(&named, &self.on_front, &common);
        (self.searched, self.tracked, self.seen) = (self.last.len(), 0, self.last.len());
        Ok(self.last.clone())
    }

    /// Markers in the next image of a stream: each is sought near where it was last seen, with the outline and the noise of the last full
    /// search. The whole image is searched if a fifth of what that search found is missing or does not fit a finger, and every tenth image
    /// while a marker is missing.
    ///
    /// # Errors
    /// As [`Locator::locate`].
    pub fn track(&mut self, image: &RgbImage) -> Result<Vec<Located>, LocateError> {
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
            let side = if self.on_front.contains(&last.node) { Side::Front } else { Side::Back };
            let side = if self.colours.are_alike() { Side::Front } else { side };
            let mut centre = middle_of_colour(image, &self.colours, side, &last.pixel, reach)?;
            // What was cut off at the border of the window is seen from there.
            if (centre - last.pixel).norm() > reach - self.radius_px {
                centre = middle_of_colour(image, &self.colours, side, &centre, reach)?;
            }
            Some((last.node, view.measure_centre(outline, &centre, &mut buffers)?))
        };
        let found: Vec<(NodeId, Disc)> = self.last.iter().filter_map(near).collect();
        self.buffers = buffers;
        // What is near where a node was is that node, unless no finger has such a shape.
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
        // A few markers show whether something moved, in the image before or in this one: by how much, a full search finds.
        let few = named.iter().step_by(FEW).map(|(_, disc)| disc);
        let blur_px = motion_blur_px(image, few, self.radius_px, outline.blurs_px[0]);
        if blur_px.or(common.motion_px).is_some() {
            return self.locate(image);
        }
        let found = located(&named, &self.on_front, &common);
        for last in &mut self.last {
            if let Some(now) = found.iter().find(|now| now.node == last.node) {
                *last = *now;
            }
        }
        self.seen = found.len();
        Ok(found)
    }

    /// Whether patches of the markers' colours have another size than the camera's.
    fn other_size(&self, image: &RgbImage) -> Option<LocateError> {
        let expected_px = self.radius_px;
        let (found_px, count) = commonest_radius(image, &self.colours)?;
        let is_other = (found_px / expected_px).ln().abs() > OTHER_SIZE.ln();
        (is_other && 2 * count > marker_count(self.finger)).then_some(LocateError::OtherSize { expected_px, found_px })
    }

    /// The discs that have a name; `pose_holds`: see [`Locator::locate_about`].
    fn named(&self, discs: &[(Side, Disc)], pose_holds: bool) -> Result<Vec<(NodeId, Disc)>, LocateError> {
        let alike = self.colours.are_alike();
        let candidate = |(side, disc): &(Side, Disc)| Candidate {
            sides: [Side::Front, Side::Back].map(|other| alike || other == *side),
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

    fn view<'a>(&'a self, image: &'a RgbImage, weights: [f64; 2], colour_shift_px: Vector) -> View<'a> {
        let height_mm = self.markers.height_mm;
        View { image, camera: &self.camera, height_mm, grey_inner_mm: None, weights, colour_shift_px }
    }
}

/// Markers of a finger, those of clamped nodes included.
fn marker_count(finger: &Finger) -> usize {
    (1..=finger.key_node_count()).filter(|&node| finger.has_marker(NodeId(node))).count()
}

/// Radius of a marker at the middle of the undeformed finger, px.
fn radius_px(finger: &Finger, camera: &Camera, markers: &Markers) -> Result<f64, LocateError> {
    let nodes = finger.key_node_count();
    let middle = (1..=nodes).map(|node| finger.position(NodeId(node))).sum::<Vector>() / nodes as f64;
    let pixel = camera.project(&middle.push(markers.height_mm))?;
    if !camera.lens.contains(&pixel) {
        return Err(LocateError::Outside);
    }
    radius_at(camera, &pixel, markers)
}

/// Radius of a marker that is seen at a pixel, px.
fn radius_at(camera: &Camera, pixel: &Pixel, markers: &Markers) -> Result<f64, LocateError> {
    let mm_a_px = camera.position_sd_mm(pixel, markers.height_mm, 1.0)?;
    let radius_px = markers.radius_mm / mm_a_px;
    if radius_px < LEAST_RADIUS_PX { Err(LocateError::TooSmall { radius_px }) } else { Ok(radius_px) }
}

fn require_size(lens: &Lens, image: &RgbImage) -> Result<(), LocateError> {
    let (expected, found) = (lens.size_px(), [image.width(), image.height()]);
    if expected == found { Ok(()) } else { Err(LocateError::Size { expected, found }) }
}
