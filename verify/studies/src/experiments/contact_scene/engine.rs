//! Outlines of objects for the physics engine.

use finray_contact::outline::Shape;
use rapier2d::parry::transformation::hertel_mehlhorn;
use rapier2d::prelude::{Pose, SharedShape, Vector as RapierVector};

/// The outline of an object for the physics engine; a non-convex outline is divided into convex pieces.
pub(crate) fn engine_shape(outline: &Shape) -> SharedShape {
    let (corners, disc_mm) = outline.corners();
    if disc_mm > 0.0 {
        return SharedShape::ball(disc_mm);
    }
    let vertices: Vec<RapierVector> = corners.iter().map(|c| RapierVector::new(c.x, c.y)).collect();
    let pieces = hertel_mehlhorn(&vertices, &outline.triangles()).into_iter().filter_map(SharedShape::convex_polyline);
    let mut pieces: Vec<(Pose, SharedShape)> = pieces.map(|piece| (Pose::IDENTITY, piece)).collect();
    if pieces.len() == 1 { pieces.swap_remove(0).1 } else { SharedShape::compound(pieces) }
}
