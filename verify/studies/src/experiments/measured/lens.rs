//! Positions at which a camera model without lens distortion would locate the markers of an image.

use finray_model::calibration::LocatedView;
use finray_model::camera::{Camera, Distortion, Pixel};
use finray_model::observation::{ObservedBase, ObservedMarker};
use finray_model::{Scene, Vector};
use nalgebra::{DMatrix, DVector, Isometry2, Point2, UnitComplex};

/// Grid of pixels, across and down the image, to which the camera without distortion is fitted, as if from a calibration board.
const BOARD: [usize; 2] = [16, 10];

/// Projective map from pixels to the plane z = 0, fitted to a board that fills the image.
///
/// # Reference
/// Direct linear transformation (Hartley and Zisserman, Multiple View Geometry in Computer Vision, sec. 4.1). Pixel coordinates are divided by the
/// size of the image.
struct Projective {
    size_px: Vector,
    entries: DVector<f64>,
}

impl Projective {
    fn of(camera: &Camera) -> Option<Projective> {
        let [width, height] = camera.lens.size_px().map(f64::from);
        let size_px = Vector::new(width, height);
        let [columns, rows] = BOARD;
        let pixel = |i: usize| {
            let share = |k: usize, of: usize| (k as f64 + 0.5) / of as f64;
            Vector::new(width * share(i % columns, columns), height * share(i / columns, rows))
        };
        let board = (0..columns * rows).map(pixel);
        let points: Vec<(Vector, Vector)> =
            board.filter_map(|pixel| Some((pixel, camera.on_plane(&pixel, 0.0).ok()?))).collect();
        let mut equations = DMatrix::zeros(2 * points.len(), 8);
        let mut right = DVector::zeros(2 * points.len());
        for (i, (pixel, point)) in points.iter().enumerate() {
            let scaled = pixel.component_div(&size_px);
            for k in 0..2 {
                let row = 2 * i + k;
                let of_point = [scaled.x, scaled.y, 1.0];
                for (j, value) in of_point.into_iter().enumerate() {
                    equations[(row, 3 * k + j)] = value;
                }
                equations[(row, 6)] = -point[k] * scaled.x;
                equations[(row, 7)] = -point[k] * scaled.y;
                right[row] = point[k];
            }
        }
        let entries = equations.svd(true, true).solve(&right, f64::EPSILON).ok()?;
        Some(Projective { size_px, entries })
    }

    fn on_plane(&self, pixel: &Pixel) -> Vector {
        let at = pixel.component_div(&self.size_px);
        let row = |i: usize| self.entries[i] * at.x + self.entries[i + 1] * at.y;
        Vector::new(row(0) + self.entries[2], row(3) + self.entries[5]) / (row(6) + 1.0)
    }
}

/// The view as a camera model without distortion would locate it; `None` if the scene has no camera pose or no distortion.
pub(super) fn without_distortion(scene: &Scene, seen: &LocatedView) -> Option<LocatedView> {
    let description = scene.camera?;
    let camera = Camera { lens: description.lens, pose: description.pose? };
    if *camera.lens.distortion() == Distortion::default() {
        return None;
    }
    let projective = Projective::of(&camera)?;
    let eye = camera.pose.eye();
    let moved = |point: Vector, height_mm: f64| {
        let pixel = camera.project(&point.push(height_mm)).ok()?;
        Some(eye.xy() + (projective.on_plane(&pixel) - eye.xy()) * (1.0 - height_mm / eye.z))
    };
    let mut observation = seen.observation.clone();
    let seen_base = observation.base.map_or_else(Isometry2::identity, |base| base.pose);
    // The neglected distortion displaces the marks on the base in the same way as the markers.
    let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
    let marks = references.iter().map(|reference| {
        let placed = (seen_base * Point2::from(reference.at)).coords;
        Some((reference.at, moved(placed, reference.markers.height_mm)?))
    });
    let base = match marks.collect::<Option<Vec<_>>>()?[..] {
        [(first, first_at), .., (last, last_at)] => {
            let rotation = UnitComplex::rotation_between(&(last - first), &(last_at - first_at));
            let middle = 0.5 * (first_at + last_at) - rotation * (0.5 * (first + last));
            Isometry2::from_parts(middle.into(), rotation)
        }
        _ => seen_base,
    };
    let height_mm = scene.markers.map_or(0.0, |markers| markers.height_mm);
    let markers = observation.markers.iter().map(|marker| {
        let at = moved((seen_base * Point2::from(marker.position?)).coords, height_mm)?;
        let position = (base.inverse() * Point2::from(at)).coords;
        Some(ObservedMarker { position: Some(position), displacement: None, ..*marker })
    });
    observation.markers = markers.collect::<Option<Vec<_>>>()?;
    observation.base = observation.base.map(|seen| ObservedBase { pose: base, ..seen });
    let force = seen.view.force.map(|force| seen.base.rotation * force);
    Some(LocatedView { object: seen.object.clone(), ..LocatedView::new(observation, scene, force).ok()? })
}
