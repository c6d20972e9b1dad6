//! Cantilever bent into a full circle by a moment at its end, M = 2 pi EI / L.
//!
//! Source: closed form (pure bending): the axis is an arc of radius EI / M. L = EI = 1.

use super::ProblemError;
use crate::prelude::*;
use finray_model::frame::{FrameLoad, NodeIndex, PlaneFrame, Section};
use finray_model::statics::solve_frame;
use std::f64::consts::{PI, TAU};

/// Elements of the cantilever.
const ELEMENTS: usize = 64;
/// EA L^2 / EI; without an axial force its value only sets how well the equations are conditioned.
const AXIAL_RIGIDITY: f64 = 1e6;
/// Rounding: equal elements turn by equal angles, so their chords close whatever their number.
pub const CLOSURE_TOLERANCE: f64 = 1e-9;
/// An element that bends to the half angle a has a chord of (1 - a^2 / 6) instead of sin a / a: short by a^4 / 120,
/// 4.8e-8 for 64 elements.
pub const CHORD_TOLERANCE: f64 = 1e-7;

/// Where the tip comes to rest, how far it turns, and how far away the middle is.
pub(crate) fn checks() -> Result<Vec<Check>, ProblemError> {
    let mut frame = PlaneFrame::new();
    let section = Section { axial_rigidity_n: AXIAL_RIGIDITY, bending_rigidity_nmm2: 1.0 };
    let nodes: Vec<NodeIndex> =
        (0..=ELEMENTS).map(|i| frame.add_node(Vector::new(i as f64 / ELEMENTS as f64, 0.0))).collect();
    for pair in nodes.windows(2) {
        frame.add_beam(pair[0], pair[1], section);
    }
    let (tip, middle) = (nodes[ELEMENTS], nodes[ELEMENTS / 2]);
    frame.support(nodes[0], [true; 3]);
    let moment = FrameLoad::Node { node: tip, force: Vector::zeros(), moment_nmm: TAU };
    let motion = solve_frame(&frame, &[moment], Kinematics::Corotational)?;
    let position = |node: NodeIndex| frame.position(node) + motion.displacements[node];
    let circle = Kind::Analytical.on("cantilever, end moment 2 pi EI / L", "closed form");
    Ok(vec![
        circle.vanishes("distance of the tip from the clamp / L", position(tip).norm(), CLOSURE_TOLERANCE),
        circle.is("rotation of the tip (rad)", TAU, motion.rotations[frame.rotation_of(tip)], CLOSURE_TOLERANCE),
        circle.is("height of the middle / L", 1.0 / PI, position(middle).y, CHORD_TOLERANCE),
    ])
}
