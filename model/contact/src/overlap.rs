//! Overlap of an object with walls of a finger, whatever the side from which the object meets them.

use crate::TouchedPart;
use crate::outline::{ContactOutline, PoseInFinger};
use crate::region::Boundary;
use finray_model::frame::FrameMotion;
use finray_model::{Mesh, Vector};

/// Deepest overlap of an object with members of a deformed finger: the touched part, and the depth, mm. Members are straight between their nodes.
pub(crate) fn deepest<'b>(
    (mesh, motion): (&Mesh, &FrameMotion),
    (shape, pose): (&ContactOutline, &PoseInFinger),
    members: impl Iterator<Item = &'b Boundary>,
) -> Option<(TouchedPart, f64)> {
    let mut deepest: Option<(TouchedPart, f64)> = None;
    let mut add = |part: TouchedPart, depth_mm: f64| {
        if deepest.is_none_or(|(_, most_mm)| depth_mm > most_mm) {
            deepest = Some((part, depth_mm));
        }
    };
    for member in members {
        let at = |node: usize| pose.inwards(mesh.frame().position(node) + motion.displacements[node]);
        let mut s_mm = member.from_mm;
        for ends in member.line(mesh).nodes.windows(2) {
            let length_mm = (mesh.frame().position(ends[1]) - mesh.frame().position(ends[0])).norm();
            let half_mm = member.overlapping_half_mm(mesh.finger(), s_mm + 0.5 * length_mm);
            let (distance_mm, share) = distance_mm(shape, [at(ends[0]), at(ends[1])]);
            add(TouchedPart::On(member.wall, s_mm + share * length_mm), half_mm - distance_mm);
            s_mm += length_mm;
        }
    }
    deepest
}

/// Distance of a line segment from an object, mm, and the share of the segment's length at which it is smallest. The distance is negative if the
/// segment runs into the object: minus the depth of its deepest end or middle.
fn distance_mm(shape: &ContactOutline, segment: [Vector; 2]) -> (f64, f64) {
    let (corners, disc_mm) = shape.corners();
    let to_point = |point: &Vector| {
        let (away_mm, share) = to_segment(segment, *point);
        (away_mm - disc_mm, share)
    };
    let nearest = |a: (f64, f64), b: (f64, f64)| if b.0 < a.0 { b } else { a };
    let outside = corners.iter().map(to_point).fold((f64::INFINITY, 0.0), nearest);
    if corners.len() < 3 {
        return outside;
    }
    let depth_mm = |point: Vector| {
        let to_side = |side: [Vector; 2]| to_segment(side, point).0;
        let away_mm = shape.sides().map(to_side).fold(f64::INFINITY, f64::min);
        if shape.contains(point) { -away_mm } else { away_mm }
    };
    let crossing = shape.sides().filter_map(|side| crossing(segment, side)).map(|share| (0.0, share));
    let between = [0.0, 0.5, 1.0].map(|share| (depth_mm(segment[0].lerp(&segment[1], share)), share));
    between.into_iter().chain(crossing).fold(outside, nearest)
}

/// Distance of a point from a line segment, mm, and the share of the segment's length at which it is smallest.
pub(crate) fn to_segment([from, to]: [Vector; 2], point: Vector) -> (f64, f64) {
    let along = to - from;
    let share = (point - from).dot(&along) / along.norm_squared();
    // A segment of zero length is treated as a point.
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    ((point - from - along * share).norm(), share)
}

/// Share of the first segment's length at which it crosses the second segment; `None` if they do not cross.
pub(crate) fn crossing([from, to]: [Vector; 2], [other_from, other_to]: [Vector; 2]) -> Option<f64> {
    let (along, other) = (to - from, other_to - other_from);
    let [first, second] = [other_from, other_to].map(|end| along.perp(&(end - from)));
    let [before, after] = [from, to].map(|end| other.perp(&(end - other_from)));
    (first * second < 0.0 && before * after < 0.0).then(|| before / (before - after))
}
