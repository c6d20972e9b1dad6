//! Pictures of the markers' residuals over the image.

use super::MarkerResidual;
use crate::prelude::*;
use finray_model::calibration::LocatedView;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, crop_imm, resize};
use image::{ImageError, RgbImage};
use nalgebra::Point2;

/// Width of a picture, px, for display on a page.
const WIDTH_PX: u32 = 720;
/// Margin around the markers, relative to their extent.
const MARGIN: f64 = 0.35;
/// JPEG quality of the embedded picture, 0 to 100.
const QUALITY: u8 = 82;

/// Residual of a marker in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrow {
    /// Observed position of the marker (x, y), px.
    pub seen: [f64; 2],
    /// Computed minus observed position (x, y), px, not magnified.
    pub residual_px: [f64; 2],
}

/// Part of an image with the residuals of its markers.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Name of the image.
    pub image: String,
    /// Width and height of the picture, px.
    pub size_px: [u32; 2],
    /// Picture as a JPEG file.
    pub jpeg: Vec<u8>,
    /// Scale of the picture at the markers, px/mm.
    pub px_a_mm: f64,
    /// Residuals of the markers.
    pub arrows: Vec<Arrow>,
}

/// Picture of the part of an image that shows the finger, with residuals. `None` if the camera's pose is unknown, or if the image shows no marker.
pub(super) fn picture(
    scene: &Scene,
    seen: &LocatedView,
    residuals: &[MarkerResidual],
    image: &RgbImage,
) -> Result<Option<Picture>, ImageError> {
    let camera = scene.camera.and_then(|camera| Some(Camera { lens: camera.lens, pose: camera.pose? }));
    let Some(camera) = camera else { return Ok(None) };
    let height_mm = scene.markers.map_or(0.0, |markers| markers.height_mm);
    let pixel = |at: Vector| {
        let point = (seen.base * Point2::from(at)).coords.push(height_mm);
        camera.project(&point).ok()
    };
    let ends: Option<Vec<[Vector; 2]>> = residuals
        .iter()
        .map(|left| {
            let at = Vector::new(left.x_mm, left.y_mm);
            Some([pixel(at)?, pixel(at + Vector::new(left.residual_x_mm, left.residual_y_mm))?])
        })
        .collect();
    let Some(ends) = ends.filter(|ends| !ends.is_empty()) else { return Ok(None) };
    let [least, most] =
        ends.iter().fold([Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)], |m, end| {
            [m[0].inf(&end[0]), m[1].sup(&end[0])]
        });
    let beyond = (most - least).max() * MARGIN;
    let limit = Vector::new(f64::from(image.width()), f64::from(image.height()));
    let [from, to] = [least.add_scalar(-beyond), most.add_scalar(beyond)]
        .map(|corner| corner.sup(&Vector::zeros()).inf(&limit).map(f64::round));
    let size = to - from;
    if size.min() < 1.0 {
        return Ok(None);
    }
    let part = crop_imm(image, from.x as u32, from.y as u32, size.x as u32, size.y as u32).to_image();
    // The image is never enlarged.
    let scale = (f64::from(WIDTH_PX) / size.x).min(1.0);
    let size_px = [size.x, size.y].map(|side| ((side * scale).round() as u32).max(1));
    let part = resize(&part, size_px[0], size_px[1], FilterType::Triangle);
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, QUALITY).encode_image(&part)?;
    let arrow = |[seen, computed]: &[Vector; 2]| Arrow {
        seen: ((seen - from) * scale).into(),
        residual_px: ((computed - seen) * scale).into(),
    };
    let (px, mm) = ends.iter().zip(residuals).fold((0.0, 0.0), |(px, mm), ([seen, computed], left)| {
        (px + (computed - seen).norm(), mm + left.residual_x_mm.hypot(left.residual_y_mm))
    });
    let px_a_mm = if mm > 0.0 { scale * px / mm } else { 0.0 };
    Ok(Some(Picture {
        image: seen.view.name.clone(),
        size_px,
        jpeg,
        px_a_mm,
        arrows: ends.iter().map(arrow).collect(),
    }))
}
