//! Outlines of plates, ribs, brackets and base line in the image of a finger. The base line joins the two clamped nodes.

use finray_model::camera::Camera;
use finray_model::finger::{FingerPoint, Joints, Plate};
use finray_model::mesh::FingerShape;
use finray_model::{Finger, Vector};
use tiny_skia::{FillRule, Mask, Path, PathBuilder, Transform};

/// Number of points along the curve of a member.
const POINTS: usize = 24;
/// Thickness of the base line and the brackets, and of ribs without a stated thickness, mm.
const BASE_THICKNESS_MM: f64 = 3.0;

/// Share of each pixel that the finger's body covers, 0 to 255; `None` for an empty image. Parts of the body that the camera does not see are
/// omitted.
pub(super) fn finger_mask(camera: &Camera, finger: &Finger, shape: &FingerShape) -> Option<Mask> {
    let [width, height] = camera.lens.size_px();
    let mut mask = Mask::new(width, height)?;
    for strip in strips(finger, shape) {
        if let Some(path) = path(camera, &strip) {
            mask.fill_path(&path, FillRule::Winding, true, Transform::identity());
        }
    }
    Some(mask)
}

/// A segment of a plate, a rib, a bracket or the base line: points of its middle line (mm), and its thickness at both ends (mm).
struct Strip {
    middle: Vec<Vector>,
    thickness_mm: [f64; 2],
}

fn strips(finger: &Finger, shape: &FingerShape) -> Vec<Strip> {
    let mut strips = Vec::new();
    for plate in [Plate::Front, Plate::Back] {
        let nodes: Vec<_> =
            finger.plate_nodes(plate).into_iter().filter(|node| finger.junction(*node) == *node).collect();
        for pair in nodes.windows(2) {
            let from_base_mm = |node| (finger.position(node) - finger.base(plate)).norm();
            let thickness_mm = [pair[0], pair[1]].map(|node| finger.thickness_mm(plate, from_base_mm(node)));
            let middle = bent(finger, shape, [pair[0], pair[1]].map(FingerPoint::Node));
            strips.push(Strip { middle, thickness_mm });
        }
    }
    let straight = |points: [FingerPoint; 2]| points.map(|point| shape.point(point)).to_vec();
    let ribs = &finger.description().ribs;
    let thickness_mm = ribs.strip.map_or(BASE_THICKNESS_MM, |strip| strip.thickness_mm);
    let is_straight = ribs.strip.is_none() || ribs.joints == Joints::Hinged;
    for nodes in (0..finger.rib_count()).map(|rib| finger.rib_nodes(rib)) {
        let ends = nodes.map(FingerPoint::Hinge);
        let middle = if is_straight { straight(ends) } else { bent(finger, shape, ends) };
        strips.push(Strip { middle, thickness_mm: [thickness_mm; 2] });
        if finger.has_brackets() {
            let bracket = |node| straight([FingerPoint::Node(node), FingerPoint::Hinge(node)]);
            strips.extend(nodes.map(|node| Strip { middle: bracket(node), thickness_mm: [BASE_THICKNESS_MM; 2] }));
        }
    }
    let base = straight(finger.clamped_nodes().map(FingerPoint::Node));
    strips.push(Strip { middle: base, thickness_mm: [BASE_THICKNESS_MM; 2] });
    strips
}

/// Points of a member between two ends, mm. The points lie on a cubic: the shape of an unloaded Euler-Bernoulli beam with the positions and rotations of
/// its ends.
fn bent(finger: &Finger, shape: &FingerShape, ends: [FingerPoint; 2]) -> Vec<Vector> {
    let [from, to] = ends.map(|end| shape.point(end));
    let along = finger.point(ends[1]) - finger.point(ends[0]);
    let length = (to - from).norm();
    let [leaving, arriving] = ends.map(|end| {
        let (FingerPoint::Node(node) | FingerPoint::Hinge(node)) = end;
        let turn = nalgebra::Rotation2::new(shape.motion(node).rotation);
        turn * along * (length / along.norm().max(f64::MIN_POSITIVE))
    });
    let at = |k: usize| {
        let t = k as f64 / (POINTS - 1) as f64;
        let (t2, t3) = (t * t, t * t * t);
        from * (2.0 * t3 - 3.0 * t2 + 1.0)
            + leaving * (t3 - 2.0 * t2 + t)
            + to * (3.0 * t2 - 2.0 * t3)
            + arriving * (t3 - t2)
    };
    (0..POINTS).map(at).collect()
}

/// Outline of a strip, in pixel coordinates that are integers at the corners of pixels. `None` if the camera does not see one of the points.
fn path(camera: &Camera, strip: &Strip) -> Option<Path> {
    let count = strip.middle.len();
    let edge = |k: usize, side: f64| {
        let along = (strip.middle[(k + 1).min(count - 1)] - strip.middle[k.saturating_sub(1)]).normalize();
        let across = Vector::new(-along.y, along.x);
        let [from_mm, to_mm] = strip.thickness_mm;
        let thickness_mm = from_mm + (to_mm - from_mm) * k as f64 / (count - 1) as f64;
        let pixel = camera.project(&(strip.middle[k] + across * (side * thickness_mm / 2.0)).push(0.0)).ok()?;
        let pixel = [pixel.x as f32 + 0.5, pixel.y as f32 + 0.5];
        pixel.iter().all(|x| x.is_finite()).then_some(pixel)
    };
    let outline = (0..count).map(|k| edge(k, 1.0)).chain((0..count).rev().map(|k| edge(k, -1.0)));
    let mut builder = PathBuilder::new();
    for (k, corner) in outline.enumerate() {
        let [x, y] = corner?;
        if k == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    builder.close();
    builder.finish()
}
