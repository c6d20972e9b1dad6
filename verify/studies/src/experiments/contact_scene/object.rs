//! Preparation of a scene's object: its outline, starting position and motion.

use crate::prelude::*;
use earcut::Earcut;
use finray_lattice::grasp::surface::Shape;
use finray_lattice::pressing::Push;
use finray_lattice::pressing::settled::RigidObject;
use finray_model::scene::{ObjectDescription, ObjectMotion, Outline, Until};
use nalgebra::Rotation2;
use rapier2d::parry::transformation::hertel_mehlhorn;
use rapier2d::prelude::{Pose, SharedShape, Vector as RapierVector};

/// Why an object cannot be pressed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutlineError {
    /// The outline has fewer than three corners.
    #[error("expected three corners or more, found {corners}")]
    TooFewCorners {
        /// Number of corners found.
        corners: usize,
    },
    /// The outline encloses no area, or crosses itself.
    #[error("expected the corners in order around the object: the outline crosses itself or encloses nothing")]
    Crossed,
    /// The object is free: the scene prescribes no hand motion for the object.
    #[error(
        "the object is free (mass_g): use `finray grasp`, or state its path, either by at_mm with travel_mm or \
            force_n, or by path_mm"
    )]
    Free,
    /// A corner is too far from the object's reference point.
    #[error("corner {corner} is not within {FARTHEST_MM} mm of the origin")]
    TooFar {
        /// Number of the corner in the list, from 1.
        corner: usize,
    },
}

/// Largest admissible distance of a corner from the object's reference point, mm.
const FARTHEST_MM: f64 = 1e4;
/// Number of corners of a drawn disc.
const DRAWN_CORNERS: usize = 90;
/// Tolerance of the relative difference between the area of an outline and the total area of its triangles. Only an outline that crosses itself
/// exceeds this tolerance.
const AREA_TOLERANCE: f64 = 1e-9;

/// Outline of a pressed object about its reference point, rotated as the scene states.
#[derive(Debug, Clone, PartialEq)]
pub enum TurnedOutline {
    /// Radius, mm.
    Disc(f64),
    /// Corners in order, mm.
    Polygon(Vec<Vector>),
}

impl TurnedOutline {
    /// Rotates the outline of a scene's object. `corners` (mm) are a polygon's corners from its file; they are ignored for other outlines.
    ///
    /// # Errors
    /// [`OutlineError`] for corners that form no valid outline.
    pub fn new(object: &ObjectDescription, corners: &[Vector]) -> Result<TurnedOutline, OutlineError> {
        let turn = Rotation2::new(object.rotation_deg.to_radians());
        let turned = |corners: &[Vector]| TurnedOutline::Polygon(corners.iter().map(|corner| turn * corner).collect());
        Ok(match object.outline {
            Outline::Disc { radius_mm } => TurnedOutline::Disc(radius_mm),
            Outline::Box { width_mm, height_mm } => {
                let (x, y) = (0.5 * width_mm, 0.5 * height_mm);
                turned(&[Vector::new(-x, -y), Vector::new(x, -y), Vector::new(x, y), Vector::new(-x, y)])
            }
            Outline::Polygon { .. } => {
                triangles(corners)?;
                turned(corners)
            }
        })
    }

    /// Shape with which contacts are computed, mm.
    pub fn shape(&self) -> Shape {
        match self {
            TurnedOutline::Disc(radius_mm) => Shape::disc(*radius_mm),
            TurnedOutline::Polygon(corners) => Shape::polygon(corners),
        }
    }

    /// Shape for the physics engine; a non-convex outline is divided into convex pieces.
    pub(crate) fn engine_shape(&self) -> Result<SharedShape, OutlineError> {
        let corners = match self {
            TurnedOutline::Disc(radius_mm) => return Ok(SharedShape::ball(*radius_mm)),
            TurnedOutline::Polygon(corners) => corners,
        };
        let vertices: Vec<RapierVector> = corners.iter().map(|c| RapierVector::new(c.x, c.y)).collect();
        let pieces =
            hertel_mehlhorn(&vertices, &triangles(corners)?).into_iter().filter_map(SharedShape::convex_polyline);
        let mut pieces: Vec<(Pose, SharedShape)> = pieces.map(|piece| (Pose::IDENTITY, piece)).collect();
        match pieces.len() {
            0 => Err(OutlineError::Crossed),
            1 => Ok(pieces.swap_remove(0).1),
            _ => Ok(SharedShape::compound(pieces)),
        }
    }

    /// The outline as a closed polyline, mm; a disc becomes a polygon.
    pub fn points(&self) -> Vec<Vector> {
        let corners: Vec<Vector> = match self {
            TurnedOutline::Disc(radius_mm) => {
                let corner = |i: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * i as f64 / DRAWN_CORNERS as f64).sin_cos();
                    Vector::new(cos, sin) * *radius_mm
                };
                (0..DRAWN_CORNERS).map(corner).collect()
            }
            TurnedOutline::Polygon(corners) => corners.clone(),
        };
        let first = corners.first().copied();
        corners.into_iter().chain(first).collect()
    }

    /// Largest extent of the outline along a unit vector, from the reference point, mm.
    pub fn reach_mm(&self, along: Vector) -> f64 {
        match self {
            TurnedOutline::Disc(radius_mm) => *radius_mm,
            TurnedOutline::Polygon(corners) => {
                corners.iter().map(|corner| corner.dot(&along)).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}

/// Divides an outline into triangles, counter-clockwise.
fn triangles(corners: &[Vector]) -> Result<Vec<[u32; 3]>, OutlineError> {
    if corners.len() < 3 {
        return Err(OutlineError::TooFewCorners { corners: corners.len() });
    }
    if let Some(far) = corners.iter().position(|corner| corner.norm().is_nan() || corner.norm() > FARTHEST_MM) {
        return Err(OutlineError::TooFar { corner: far + 1 });
    }
    let vertices: Vec<[f64; 2]> = corners.iter().map(|corner| [corner.x, corner.y]).collect();
    let mut indices: Vec<u32> = Vec::new();
    Earcut::new().earcut(vertices.iter().copied(), &[], &mut indices);
    let missed = earcut::deviation(vertices.iter().copied(), &[] as &[u32], &indices);
    if indices.is_empty() || missed.is_nan() || missed > AREA_TOLERANCE {
        return Err(OutlineError::Crossed);
    }
    let corner = |index: u32| corners[index as usize];
    let counter_clockwise = |&[a, b, c]: &[u32; 3]| {
        if (corner(b) - corner(a)).perp(&(corner(c) - corner(a))) > 0.0 { [a, b, c] } else { [a, c, b] }
    };
    Ok(indices.as_chunks::<3>().0.iter().map(counter_clockwise).collect())
}

/// An object prepared for pressing.
#[derive(Debug, Clone)]
pub struct PreparedObject {
    /// Outline of the object.
    pub outline: TurnedOutline,
    /// Coefficient of friction, dimensionless.
    pub friction: f64,
    /// Starting position in the finger frame, mm.
    pub start: Vector,
    /// Unit vector of the motion in the finger frame; on a path, the direction at the end of the first step.
    pub along: Vector,
    /// Motion of the hand, step by step.
    pub steps: Vec<HandStep>,
}

/// Motion of the hand that moves the object, in one step.
#[derive(Debug, Clone, PartialEq)]
pub struct HandStep {
    /// Corners of the path that the object passes in the step, in the finger frame, mm.
    pub corners: Vec<Vector>,
    /// Position or force at the end of the step.
    pub end: Push,
    /// Unit vector of the motion at the end of the step, in the finger frame.
    pub along: Vector,
}

impl PreparedObject {
    /// Prepares the object of a scene. `corners` (mm) are a polygon's corners from its file; they are ignored for other outlines.
    ///
    /// # Errors
    /// [`OutlineError`] for a free object, or corners that form no valid outline.
    pub fn new(scene: &Scene, object: &ObjectDescription, corners: &[Vector]) -> Result<PreparedObject, OutlineError> {
        let finger = &scene.finger;
        let outline = TurnedOutline::new(object, corners)?;
        let share = |step: usize| step as f64 / object.steps as f64;
        let (start, along, steps) = match &object.motion {
            ObjectMotion::Free { .. } => return Err(OutlineError::Free),
            ObjectMotion::Press { at_mm, direction_deg, until } => {
                let along = finger.direction(*direction_deg);
                let start = first_touch(finger, scene.contact.rod_radius_mm, &outline, *at_mm, along);
                let step = |step| {
                    let end = match until {
                        Until::Travel(travel_mm) => Push::To(start + along * (travel_mm * share(step))),
                        Until::Force(force_n) => Push::With(force_n * share(step)),
                    };
                    HandStep { corners: Vec::new(), end, along }
                };
                (start, along, (1..=object.steps).map(step).collect())
            }
            ObjectMotion::Path(points) => {
                let steps: Vec<HandStep> =
                    (1..=object.steps).map(|step| step_on_path(points, share(step - 1), share(step))).collect();
                (points[0], steps.first().map_or(finger.direction(0.0), |step| step.along), steps)
            }
        };
        Ok(PreparedObject { outline, friction: object.friction, start, along, steps })
    }

    /// The object for the physics engine.
    ///
    /// # Errors
    /// [`OutlineError::Crossed`] for an outline that cannot be divided into convex pieces.
    pub fn rigid(&self) -> Result<RigidObject, OutlineError> {
        Ok(RigidObject { shape: self.outline.engine_shape()?, friction: self.friction })
    }
}

/// Position of an object (mm, finger frame) on its line of motion at which it first meets the straight line over the undeformed finger's rods.
fn first_touch(finger: &Finger, rod_radius_mm: f64, outline: &TurnedOutline, at_mm: f64, along: Vector) -> Vector {
    let inward = finger.direction(0.0);
    let surface_mm = rod_radius_mm.max(0.5 * finger.description().front.thickness_mm);
    let distance_mm = (outline.reach_mm(inward) + surface_mm) / along.dot(&inward);
    finger.plate_point(Plate::Front, at_mm) - along * distance_mm
}

/// Hand motion between two points of a path, given as shares (0 to 1) of the path's length.
fn step_on_path(points: &[Vector], from: f64, to: f64) -> HandStep {
    let segments: Vec<&[Vector]> = points.windows(2).filter(|pair| pair[0] != pair[1]).collect();
    let total: f64 = segments.iter().map(|pair| (pair[1] - pair[0]).norm()).sum();
    let (mut begins, mut corners) = (0.0, Vec::new());
    for (i, pair) in segments.iter().enumerate() {
        let way = pair[1] - pair[0];
        let ends = begins + way.norm();
        // Rounding may put the end of a step beyond the path; the last segment then contains this end.
        if to * total <= ends || i + 1 == segments.len() {
            let share = ((to * total - begins) / way.norm()).min(1.0);
            return HandStep { corners, end: Push::To(pair[0] + way * share), along: way.normalize() };
        }
        if from * total < ends {
            corners.push(pair[1]);
        }
        begins = ends;
    }
    HandStep { corners, end: Push::To(points[0]), along: Vector::x() }
}
