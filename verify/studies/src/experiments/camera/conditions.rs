//! Conditions under which the camera is tested. Each condition changes one property of the scene's camera.

use finray_imaging::render::Disturbances;
use finray_model::camera::{Camera, Lens, Pose, Radial};
use finray_model::scene::Markers;
use image::RgbImage;
use jpeg_encoder::{ChromaSubsamplingMethod, ColorType, Encoder, SamplingFactor};
use nalgebra::{Rotation3, Vector3};

pub(super) struct Condition {
    pub item: &'static str,
    pub setting: &'static str,
    pub change: Change,
    /// Whether displacements are relative to the undeformed positions seen by the same camera.
    pub is_rest_seen: bool,
}

pub(super) enum Change {
    /// Change of the images that are rendered and searched for markers.
    Image(ImageChange),
    /// Change of the assumed camera.
    Assumed(AssumedChange),
    /// No camera: exact displacements of a finger whose mesh is this many times as fine as the estimator's.
    FinerFinger(usize),
}

/// Difference of an image from the image of the scene's camera.
pub(super) struct ImageChange {
    /// Standard deviation of the noise, in grey levels of 255. The next field, `blur_px`, is the standard deviation of the blur, px.
    grey_noise: f64,
    blur_px: f64,
    /// Factor of the number of pixels along each side. The next field, `radius`, is the factor of the markers' radius.
    resolution: f64,
    radius: f64,
    /// Quality of JPEG compression, 0 to 100. As in ordinary cameras, colour is stored at half the resolution along each side.
    quality: Option<u8>,
    clutter: usize,
}

/// Loss of light in the image corners relative to the middle, dimensionless.
const FALLOFF: f64 = 0.3;
/// An ordinary industrial camera in focus.
pub(super) const ORDINARY: ImageChange =
    ImageChange { grey_noise: 2.0, blur_px: 0.8, resolution: 1.0, radius: 1.0, quality: None, clutter: 0 };

/// Difference of the assumed camera from the true camera.
pub(super) struct AssumedChange {
    /// Error added to the distortion coefficient k1, dimensionless.
    k1: f64,
    /// Factor of the focal lengths.
    focal: f64,
    /// Rotation of the finger's plane about the y axis of that plane, degrees.
    tilt_deg: f64,
    /// Error added to the height of the markers, mm.
    height_mm: f64,
}

const TRUE: AssumedChange = AssumedChange { k1: 0.0, focal: 1.0, tilt_deg: 0.0, height_mm: 0.0 };

const fn image(item: &'static str, setting: &'static str, change: ImageChange) -> Condition {
    Condition { item, setting, change: Change::Image(change), is_rest_seen: false }
}

const fn assumed(item: &'static str, setting: &'static str, change: AssumedChange, is_rest_seen: bool) -> Condition {
    Condition { item, setting, change: Change::Assumed(change), is_rest_seen }
}

/// All conditions. The first condition is the scene's unchanged camera. A quick study uses only the first few conditions.
pub(super) const CONDITIONS: &[Condition] = &[
    image(super::AS_IT_IS, "noise 2 of 255, blur 0.8 px", ORDINARY),
    image("resolution", "1/4 along each side", ImageChange { resolution: 0.25, ..ORDINARY }),
    Condition {
        item: "mesh",
        setting: "key nodes alone, no camera",
        change: Change::FinerFinger(8),
        is_rest_seen: false,
    },
    assumed("lens", "k1 off by 0.01", AssumedChange { k1: 0.01, ..TRUE }, false),
    assumed("lens", "k1 off by 0.01", AssumedChange { k1: 0.01, ..TRUE }, true),
    assumed("pose", "tilted by 0.5 deg", AssumedChange { tilt_deg: 0.5, ..TRUE }, false),
    assumed("pose", "tilted by 0.5 deg", AssumedChange { tilt_deg: 0.5, ..TRUE }, true),
    assumed("height", "markers 1 mm higher", AssumedChange { height_mm: 1.0, ..TRUE }, false),
    assumed("height", "markers 1 mm higher", AssumedChange { height_mm: 1.0, ..TRUE }, true),
    image("noise", "none", ImageChange { grey_noise: 0.0, ..ORDINARY }),
    image("noise", "5 of 255", ImageChange { grey_noise: 5.0, ..ORDINARY }),
    image("noise", "10 of 255", ImageChange { grey_noise: 10.0, ..ORDINARY }),
    image("blur", "1.6 px", ImageChange { blur_px: 1.6, ..ORDINARY }),
    image("blur", "3.2 px", ImageChange { blur_px: 3.2, ..ORDINARY }),
    image("resolution", "1/2 along each side", ImageChange { resolution: 0.5, ..ORDINARY }),
    image("markers", "2/3 of the radius", ImageChange { radius: 2.0 / 3.0, ..ORDINARY }),
    image("markers", "0.4 of the radius", ImageChange { radius: 0.4, ..ORDINARY }),
    image("compression", "JPEG, quality 92", ImageChange { quality: Some(92), ..ORDINARY }),
    image("compression", "JPEG, quality 75", ImageChange { quality: Some(75), ..ORDINARY }),
    image("clutter", "40 patches", ImageChange { clutter: 40, ..ORDINARY }),
    assumed("lens", "k1 off by 0.001", AssumedChange { k1: 0.001, ..TRUE }, false),
    assumed("lens", "focal length off by 0.1 %", AssumedChange { focal: 1.001, ..TRUE }, false),
    assumed("lens", "focal length off by 0.1 %", AssumedChange { focal: 1.001, ..TRUE }, true),
    assumed("pose", "tilted by 0.05 deg", AssumedChange { tilt_deg: 0.05, ..TRUE }, false),
    assumed("height", "markers 0.1 mm higher", AssumedChange { height_mm: 0.1, ..TRUE }, false),
];

impl ImageChange {
    /// Camera and markers for rendering and reading the image; `None` if the lens is invalid.
    pub fn applied(&self, camera: &Camera, markers: &Markers) -> Option<(Camera, Markers)> {
        let markers = Markers { radius_mm: markers.radius_mm * self.radius, ..*markers };
        let lens = &camera.lens;
        let side = |px: u32| ((f64::from(px) * self.resolution).round() as u32).max(1);
        let focal = lens.focal_px().map(|px| px * self.resolution);
        // Pixel coordinates (0, 0) are the centre of the first pixel, so the scaling applies to px + 0.5.
        let middle = lens.principal_point_px().map(|px| (px + 0.5) * self.resolution - 0.5);
        let lens = Lens::new(lens.size_px().map(side), focal, middle, *lens.distortion()).ok()?;
        Some((Camera { lens, pose: camera.pose }, markers))
    }

    pub fn disturbances(&self, seed: u64) -> Disturbances {
        let &ImageChange { grey_noise, blur_px, clutter, .. } = self;
        Disturbances { light_falloff: FALLOFF, blur_px, grey_noise, clutter, seed }
    }

    /// The image after compression; `None` if compression fails.
    pub fn compressed(&self, image: RgbImage) -> Option<RgbImage> {
        let Some(quality) = self.quality else { return Some(image) };
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, quality);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
        encoder.set_chroma_subsampling_method(ChromaSubsamplingMethod::Average);
        let [width, height] = [image.width(), image.height()].map(|px| u16::try_from(px).ok());
        encoder.encode(&image, width?, height?, ColorType::Rgb).ok()?;
        Some(image::load_from_memory_with_format(&bytes, image::ImageFormat::Jpeg).ok()?.into_rgb8())
    }
}

impl AssumedChange {
    /// Assumed camera and assumed height of the markers (mm), with which points are read; `None` if the lens is invalid.
    pub fn applied(&self, camera: &Camera, markers: &Markers) -> Option<(Camera, f64)> {
        let mut distortion = *camera.lens.distortion();
        match &mut distortion.radial {
            Radial::Rational { numerator: [k1, ..], .. } | Radial::Fisheye([k1, ..]) => *k1 += self.k1,
        }
        let focal = camera.lens.focal_px().map(|px| px * self.focal);
        let lens = Lens::new(camera.lens.size_px(), focal, camera.lens.principal_point_px(), distortion).ok()?;
        let turned = Rotation3::from_axis_angle(&Vector3::y_axis(), self.tilt_deg.to_radians());
        let pose = Pose { rotation: camera.pose.rotation * turned, translation_mm: camera.pose.translation_mm };
        Some((Camera { lens, pose }, markers.height_mm + self.height_mm))
    }
}
