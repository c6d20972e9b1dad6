//! The finger's plane about a marker, as its pixels see it.

use super::{Edge, Sample};
use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use image::RgbImage;
use nalgebra::{Matrix2, Vector3};

/// Brightness as JPEG and television have it (0.299 R + 0.587 G + 0.114 B, ITU-R BT.601), and two parts of the colour at right angles to it,
/// scaled so that noise that is alike in red, green and blue is alike in all three.
pub(super) fn light_of([r, g, b]: [u8; 3]) -> Vector3<f32> {
    let [r, g, b] = [f32::from(r), f32::from(g), f32::from(b)];
    // (0.299, 0.587, 0.114), (0.587, -0.299, 0) and their cross product, each of length 1.
    Vector3::new(
        0.447_233_1 * r + 0.878_012_8 * g + 0.170_517_0 * b,
        0.891_062_7 * r - 0.453_880_3 * g,
        0.077_394_3 * r + 0.151_941_3 * g - 0.985_354_7 * b,
    )
}

/// Positions in the plane about a pixel, to second order in the distance from it.
pub(super) struct PlaneMap {
    about: Pixel,
    /// The point at the middle, mm.
    pub origin: Vector,
    slope: Matrix2<f64>,
    /// Second derivatives by u u, u v and v v.
    curvature: [Vector; 3],
    /// mm a px, root of the area that a pixel has in the plane.
    pub scale: f64,
    /// Derivatives of the pixel by the plane's coordinates.
    by_point: Matrix2<f64>,
}

impl PlaneMap {
    pub fn new(camera: &Camera, height_mm: f64, about: &Pixel, radius_mm: f64) -> Option<PlaneMap> {
        let (origin, slope) = camera.on_plane_with_derivatives(about, height_mm).ok()?;
        let scale = slope.determinant().abs().sqrt();
        let step = radius_mm / scale;
        let at = |u: f64, v: f64| camera.on_plane(&(about + Pixel::new(u, v) * step), height_mm).ok();
        let (left, right, up, down) = (at(-1.0, 0.0)?, at(1.0, 0.0)?, at(0.0, -1.0)?, at(0.0, 1.0)?);
        let mixed = (at(1.0, 1.0)? - at(1.0, -1.0)? - at(-1.0, 1.0)? + at(-1.0, -1.0)?) / (4.0 * step * step);
        let second = |before: Vector, after: Vector| (before - origin * 2.0 + after) / (step * step);
        let slope = Matrix2::from_columns(&[(right - left) / (2.0 * step), (down - up) / (2.0 * step)]);
        Some(PlaneMap {
            about: *about,
            origin,
            slope,
            curvature: [second(left, right), mixed, second(up, down)],
            scale,
            by_point: slope.try_inverse()?,
        })
    }

    fn at(&self, step: &Pixel) -> Vector {
        let [uu, uv, vv] = &self.curvature;
        self.origin
            + self.slope * step
            + uu * (0.5 * step.x * step.x)
            + uv * (step.x * step.y)
            + vv * (0.5 * step.y * step.y)
    }

    /// The longest radius of the disc's image, px.
    pub fn radius_px(&self, radius_mm: f64) -> f64 {
        // The largest singular value.
        let (squares, determinant) = (self.by_point.norm_squared(), self.by_point.determinant());
        let spread = (squares * squares - 4.0 * determinant * determinant).max(0.0).sqrt();
        radius_mm * (0.5 * (squares + spread)).sqrt()
    }

    /// Pixels within a distance of the middle; `None` if they are not all in the image.
    pub fn samples(&self, image: &RgbImage, reach: f64) -> Option<Vec<Sample>> {
        let range = |axis: usize, size: u32| {
            let (from, to) = ((self.about[axis] - reach).ceil(), (self.about[axis] + reach).floor());
            // A disc at the border is measured by what is seen of its surroundings.
            let (from, to) = (from.max(0.0), to.min(f64::from(size) - 1.0));
            (from <= to).then_some(from as usize..=to as usize)
        };
        let (columns, rows) = (range(0, image.width())?, range(1, image.height())?);
        let mut samples = Vec::with_capacity((4.0 * reach * reach) as usize + 1);
        for v in rows {
            let start = 3 * (v * image.width() as usize + columns.start());
            let end = 3 * (v * image.width() as usize + columns.end() + 1);
            for (u, pixel) in columns.clone().zip(image.as_raw()[start..end].chunks_exact(3)) {
                let step = Pixel::new(u as f64, v as f64) - self.about;
                if step.norm_squared() <= reach * reach {
                    let light = light_of([pixel[0], pixel[1], pixel[2]]);
                    samples.push(Sample { at: self.at(&step), light });
                }
            }
        }
        Some(samples)
    }

    /// How a point lies to an edge.
    pub fn polar(&self, edge: &Edge, at: &Vector) -> Polar {
        let from_centre = at - edge.centre;
        let far = from_centre.norm();
        if far < 1e-12 {
            let px_a_mm = 1.0 / self.scale;
            return Polar { outside_px: -edge.radius * px_a_mm, direction: Vector::x(), px_a_mm, turn: 0.0 };
        }
        let direction = from_centre / far;
        // The distance in the plane grows along the pixels by |slope^T direction|.
        let px_a_mm = 1.0 / (self.slope.tr_mul(&direction)).norm();
        Polar { outside_px: (far - edge.radius) * px_a_mm, direction, px_a_mm, turn: turn(&direction) }
    }
}

/// How a point of the plane lies to an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polar {
    /// Distance outside the edge along the pixels, px.
    pub outside_px: f64,
    /// Direction from the centre, in the plane.
    pub direction: Vector,
    /// px a mm along it.
    pub px_a_mm: f64,
    /// The direction as a share of a whole turn, 0 to 1: see [`turn`].
    pub turn: f64,
}

/// The angle of a direction as a share of a whole turn, good to 6e-4: sectors need no more, and the arctangent would take half of the time.
///
/// # Reference
/// S. Rajan et al., Efficient approximations for the arctangent function, IEEE Signal Processing Magazine 23 (2006), eq. (7).
fn turn(direction: &Vector) -> f64 {
    let (x, y) = (direction.x, direction.y);
    let octant = |z: f64| z * (0.125 + (0.273 / std::f64::consts::TAU) * (1.0 - z.abs()));
    let turn = match x.abs() > y.abs() {
        true => octant(y / x) + if x < 0.0 { 0.5 } else { 0.0 },
        false => (if y > 0.0 { 0.25 } else { 0.75 }) - octant(x / y),
    };
    if turn < 0.0 { turn + 1.0 } else { turn }
}
