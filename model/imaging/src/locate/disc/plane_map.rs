//! Map from the pixels about a marker to positions in the finger's plane.

use super::Edge;
use crate::RgbRows;
use finray_model::Vector;
use finray_model::camera::{Camera, Pixel};
use nalgebra::Matrix2;

/// Brightness as in JPEG and television (0.299 R + 0.587 G + 0.114 B, ITU-R BT.601), and two orthogonal components of colour. The colour components
/// are scaled so that equal noise in red, green and blue gives equal noise in brightness and in each colour component.
fn light_of(pixel: &[u8]) -> [f32; 3] {
    let [r, g, b] = [f32::from(pixel[0]), f32::from(pixel[1]), f32::from(pixel[2])];
    // The rows are (0.299, 0.587, 0.114), (0.587, -0.299, 0) and their cross product, each scaled to length 1.
    [
        0.447_233_1 * r + 0.878_012_8 * g + 0.170_517 * b,
        0.891_062_7 * r - 0.453_880_3 * g,
        0.077_394_3 * r + 0.151_941_3 * g - 0.985_354_7 * b,
    ]
}

/// The pixels about a marker, one list per quantity.
#[derive(Debug, Clone, Default)]
pub(super) struct Pixels {
    /// Positions of the pixels in the finger's plane relative to the map's origin, in the map's units.
    pub at: [Vec<f32>; 2],
    /// Brightness and two components of colour of each pixel, grey levels.
    pub light: [Vec<f32>; 3],
    /// Signed distance of each pixel from the last measured edge, px; positive outside the disc.
    pub outside: Vec<f32>,
    /// Buffer for the pixels of a row of the image.
    row: Vec<u8>,
}

/// Second-order map from the pixels about one pixel to positions in the finger's plane. Its unit, `unit_mm`, is about the size of a pixel.
pub(super) struct PlaneMap {
    /// The middle pixel, about which the map is expanded.
    about: Pixel,
    /// The position of the middle pixel in the finger's plane, mm, finger frame.
    pub origin: Vector,
    /// First derivatives of a position by the pixel's coordinates, map units/px, from central differences over about one marker radius to each side.
    slope: Matrix2<f64>,
    /// Second derivatives of a position by the pixel's coordinates u and v, map units/px^2: uu, uv and vv.
    curvature: [Vector; 3],
    /// Unit of the map, mm: root of the area of a pixel in the finger's plane.
    pub unit_mm: f64,
    /// First derivatives of the pixel by the position in the finger's plane, px per map unit.
    by_point: Matrix2<f64>,
}

impl PlaneMap {
    pub fn new(camera: &Camera, height_mm: f64, about: &Pixel, radius_mm: f64) -> Option<PlaneMap> {
        let (origin, slope) = camera.on_plane_with_derivatives(about, height_mm).ok()?;
        let unit_mm = slope.determinant().abs().sqrt();
        let step = radius_mm / unit_mm;
        let at = |u: f64, v: f64| {
            let point = camera.on_plane(&(about + Pixel::new(u, v) * step), height_mm).ok()?;
            Some((point - origin) / unit_mm)
        };
        let (left, right, up, down) = (at(-1.0, 0.0)?, at(1.0, 0.0)?, at(0.0, -1.0)?, at(0.0, 1.0)?);
        let mixed = (at(1.0, 1.0)? - at(1.0, -1.0)? - at(-1.0, 1.0)? + at(-1.0, -1.0)?) / (4.0 * step * step);
        let second = |before: Vector, after: Vector| (before + after) / (step * step);
        let slope = Matrix2::from_columns(&[(right - left) / (2.0 * step), (down - up) / (2.0 * step)]);
        Some(PlaneMap {
            about: *about,
            origin,
            slope,
            curvature: [second(left, right), mixed, second(up, down)],
            unit_mm,
            by_point: slope.try_inverse()?,
        })
    }

    /// Longest radius in the image, px, of a disc whose radius is given in the map's units.
    pub fn radius_px(&self, radius: f64) -> f64 {
        // The scale from map units to px is the largest singular value of `by_point`.
        let (squares, determinant) = (self.by_point.norm_squared(), self.by_point.determinant());
        let spread = (squares * squares - 4.0 * determinant * determinant).max(0.0).sqrt();
        radius * (0.5 * (squares + spread)).sqrt()
    }

    /// Gathers the pixels of the image within `reach` px of the middle. For a disc at the image border, only the visible part of the surroundings is
    /// gathered.
    pub fn gather(&self, image: &dyn RgbRows, reach: f64, pixels: &mut Pixels) {
        pixels.at.iter_mut().chain(&mut pixels.light).for_each(Vec::clear);
        let within = |middle: f64, reach: f64, size: u32| {
            let size = f64::from(size);
            let from = (middle - reach).ceil().clamp(0.0, size);
            let end = ((middle + reach).floor() + 1.0).clamp(from, size);
            from as usize..end as usize
        };
        let [uu, uv, vv] = self.curvature;
        let [width, height] = image.size_px();
        for row in within(self.about.y, reach, height) {
            let v = row as f64 - self.about.y;
            let half = (reach * reach - v * v).max(0.0).sqrt();
            let columns = within(self.about.x, half, width);
            // Coefficients of a polynomial in u: constant, slope, half the curvature.
            let rest = self.slope.column(1) * v + vv * (0.5 * v * v);
            let by_u = self.slope.column(0) + uv * v;
            for (axis, list) in pixels.at.iter_mut().enumerate() {
                let terms = [rest[axis] as f32, by_u[axis] as f32, (0.5 * uu[axis]) as f32];
                let first = (columns.start as f64 - self.about.x) as f32;
                list.extend((0..columns.len()).map(|k| {
                    let u = first + k as f32;
                    terms[0] + u * (terms[1] + u * terms[2])
                }));
            }
            for pixel in image.row(row, columns, &mut pixels.row).chunks_exact(3) {
                for (list, light) in pixels.light.iter_mut().zip(light_of(pixel)) {
                    list.push(light);
                }
            }
        }
        pixels.outside.resize(pixels.at[0].len(), 0.0);
    }

    /// Computes the signed distance of each pixel from an edge, px; positive outside the disc.
    pub fn measure_from(&self, edge: &Edge, pixels: &mut Pixels) {
        let polar = self.about_edge(edge);
        let Pixels { at: [x, y], outside, .. } = pixels;
        for ((x, y), outside) in x.iter().zip(y.iter()).zip(outside) {
            let Polar { far, along, .. } = polar.of(*x, *y);
            *outside = (far - polar.radius) * (far / along);
        }
    }

    /// Combines an edge with the first derivatives of this map, for the geometry of points relative to the edge.
    pub fn about_edge(&self, edge: &Edge) -> AboutEdge {
        AboutEdge {
            centre: [edge.centre.x as f32, edge.centre.y as f32],
            radius: edge.radius as f32,
            slope: [0, 1, 2, 3].map(|i| self.slope[i] as f32),
        }
    }
}

/// An edge with the first derivatives of the map.
#[derive(Debug, Clone, Copy)]
pub(super) struct AboutEdge {
    /// Centre of the edge in the map's units.
    centre: [f32; 2],
    /// Radius of the edge in the map's units.
    radius: f32,
    /// First derivatives of the position by the pixel's coordinates, column by column.
    slope: [f32; 4],
}

/// Geometry of a point relative to an edge, in the map's units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polar {
    /// Vector from the edge's centre to the point.
    pub step: [f32; 2],
    /// Length of the vector from the centre.
    pub far: f32,
    /// `far` times the largest increase of `far` per px in the image.
    pub along: f32,
}

impl AboutEdge {
    /// Geometry of the point (x, y) relative to the edge.
    #[inline]
    pub fn of(&self, x: f32, y: f32) -> Polar {
        // Avoids a division by zero for a point at the centre.
        const LEAST: f32 = 1e-3;
        let step = [x - self.centre[0], y - self.centre[1]];
        let far = (step[0] * step[0] + step[1] * step[1]).sqrt().max(LEAST);
        // In the image, the distance from the centre grows by at most |slope^T direction| per px.
        let by_u = self.slope[0] * step[0] + self.slope[1] * step[1];
        let by_v = self.slope[2] * step[0] + self.slope[3] * step[1];
        Polar { step, far, along: (by_u * by_u + by_v * by_v).sqrt().max(LEAST) }
    }
}

/// Angle of a direction as a share of a full turn, accurate to 6e-4. This accuracy suffices to assign pixels to sectors, and the exact arctangent
/// would take half of the computing time.
///
/// # Reference
/// S. Rajan et al., Efficient approximations for the arctangent function, IEEE Signal Processing Magazine 23 (2006), eq. (7).
#[inline]
pub(super) fn turn([x, y]: [f32; 2]) -> f32 {
    let octant = |z: f32| z * (0.125 + (0.273 / std::f32::consts::TAU) * (1.0 - z.abs()));
    let turn = match x.abs() > y.abs() {
        true => octant(y / x) + if x < 0.0 { 0.5 } else { 0.0 },
        false => (if y > 0.0 { 0.25 } else { 0.75 }) - octant(x / y),
    };
    if turn < 0.0 { turn + 1.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use finray_model::camera::{Distortion, Lens, Pose};

    /// Checks that the pixels at and beyond the corners of an image are counted correctly.
    #[test]
    fn pixels_are_gathered_at_the_border() {
        let [width, height] = [64, 48];
        let lens = Lens::new([width, height], [500.0; 2], [31.5, 23.5], Distortion::default()).expect("a lens");
        let camera = Camera { lens, pose: Pose::new([std::f64::consts::PI, 0.0, 0.0], [0.0, 0.0, 100.0]) };
        let image = image::RgbImage::new(width, height);
        let mut pixels = Pixels::default();
        for (u, v) in [(31.0, 23.0), (-1.0, -2.0), (65.85, 28.8), (65.85, 49.5), (70.0, 20.0), (-9.0, 47.0)] {
            let map = PlaneMap::new(&camera, 0.0, &Pixel::new(u, v), 1.0).expect("a plane");
            for reach in [3.0, 18.25, 100.0] {
                map.gather(&image, reach, &mut pixels);
                let within = |row: u32, column: u32| (f64::from(column) - u).hypot(f64::from(row) - v) <= reach;
                let expected = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
                let expected = expected.filter(|(row, column)| within(*row, *column)).count();
                assert_eq!((pixels.at[0].len(), pixels.light[2].len()), (expected, expected), "{u} {v} {reach}");
            }
        }
    }
}
