//! Cantilever bent into a full circle by a moment at its end, M = 2 pi EI / L.
//!
//! Source: closed form (pure bending): the axis is an arc of radius EI / M. L = EI = 1.

use super::ProblemError;
use super::elastica::cantilever;
use crate::prelude::*;
use finray_model::frame::{FrameLoad, NodeIndex};
use finray_model::statics::solve_frame;
use std::f64::consts::{PI, TAU};

const ELEMENTS: usize = 64;
/// EA L^2 / EI. There is no axial force, so this value affects only the conditioning of the equations.
const AXIAL_RIGIDITY: f64 = 1e6;
/// Tolerance of the tip's position (relative to the length) and rotation (rad): rounding error. Equal elements turn by equal angles, so their chords
/// form a closed polygon for any number of elements.
pub const CLOSURE_TOLERANCE: f64 = 1e-9;
/// Tolerance of the height of the cantilever's middle, relative to the cantilever's length. Relative to its length, an element that bends by the
/// angle 2 a has a chord of 1 - a^2 / 6 instead of sin a / a. With half the bending angle a of an element, the chord is too short by a^4 / 120, here
/// 4.8e-8.
pub const CHORD_TOLERANCE: f64 = 1e-7;

/// Checks of the tip's position, the tip's rotation, and the height of the middle.
pub(crate) fn checks() -> Result<Vec<Check>, ProblemError> {
    let (frame, nodes) = cantilever(ELEMENTS, AXIAL_RIGIDITY);
    let (tip, middle) = (nodes[ELEMENTS], nodes[ELEMENTS / 2]);
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
