//! Williams' toggle with snap-through: two shallow straight members, clamped, rigidly joined, loaded at the apex.
//!
//! Source: F. W. Williams, The non-linear behaviour of rigid jointed plane frameworks with finite deflections, Quart. J. Mech. Appl. Math. 17 (1964)
//! 451-469; the [`elastic_line`] gives the limit loads.

use super::ProblemError;
use super::elastic_line::{self, Rigidity};
use crate::prelude::*;
use finray_model::frame::{FrameLoad, NodeIndex, PlaneFrame, Section};
use finray_model::statics::{ArcLength, reaction};

/// Axial rigidity EA in lb, bending rigidity EI in lb in^2.
const RIGIDITY: Rigidity = Rigidity { axial: 1.885e6, bending: 9.27e3 };
/// Half the span, in.
const HALF_SPAN: f64 = 12.943;
/// Height of the apex, in.
const HEIGHT: f64 = 0.386;
/// Number of elements in each member.
const ELEMENTS: usize = 32;
/// Relative tolerance of a limit load. 32 elements per member cause an error of 1.5e-7.
pub const TOLERANCE: f64 = 1e-6;

/// The toggle, and its nodes at the left clamp and the apex.
fn frame() -> (PlaneFrame, [NodeIndex; 2]) {
    let section = Section {
        axial_rigidity_n: RIGIDITY.axial,
        bending_rigidity_nmm2: RIGIDITY.bending,
        shear_flexibility: 0.0,
        axis_mm: [0.0; 2],
    };
    let mut frame = PlaneFrame::default();
    let nodes: Vec<NodeIndex> = (0..=2 * ELEMENTS)
        .map(|i| {
            let x = (i as f64 / ELEMENTS as f64 - 1.0) * HALF_SPAN;
            frame.add_node(Vector::new(x, HEIGHT * (1.0 - x.abs() / HALF_SPAN)))
        })
        .collect();
    for pair in nodes.windows(2) {
        frame.add_beam(pair[0], pair[1], section);
    }
    frame.support(nodes[0], [true; 3]);
    frame.support(nodes[2 * ELEMENTS], [true; 3]);
    (frame, [nodes[0], nodes[ELEMENTS]])
}

/// Residuals at the apex of the elastic line, which is integrated from the clamp with an assumed horizontal force and moment at the clamp. The
/// residuals are the change of the axis direction and the horizontal displacement relative to half the span; by symmetry, both are zero.
fn miss(&[pull, moment, load]: &[f64; 3]) -> [f64; 2] {
    let direction = HEIGHT.atan2(HALF_SPAN);
    let clamp = elastic_line::Section { at: [0.0; 2], direction, force: [pull, -0.5 * load], moment };
    let apex = clamp.beyond(HALF_SPAN.hypot(HEIGHT), RIGIDITY);
    [apex.direction - direction, apex.at[0] / HALF_SPAN - 1.0]
}

/// Checks of both limit loads.
///
/// # Errors
/// [`ProblemError`] if the equilibrium path cannot be followed.
pub fn checks() -> Result<Vec<Check>, ProblemError> {
    let (frame, [clamp, apex]) = frame();
    let load = FrameLoad::Node { node: apex, force: Vector::new(0.0, -1.0), moment_nmm: 0.0 };
    let path = ArcLength::new(&frame, Kinematics::Corotational)
        .follow(&[load], 1000, |point| point.is_stable() && point.motion.displacements[apex].y < -1.8 * HEIGHT)?;
    let against = |kind: Kind, source| kind.on("Williams' toggle", source);
    let literature = against(Kind::Analytical, "Williams 1964");
    let shooting = against(Kind::Internal, "elastic line by shooting");
    let mut checks = vec![literature.counts("limit points of the path", 2, path.limits.len())];
    for (quantity, limit) in ["limit load (lb)", "load where it stiffens again (lb)"].into_iter().zip(&path.limits) {
        let held = reaction(&frame, &limit.motion, Kinematics::Corotational, &[], clamp);
        // The search on the elastic line starts from the limit point that the beam model finds, perturbed by 1 %.
        let start = [-held.force.x, -held.moment_nmm, limit.multiple];
        let reference = elastic_line::limit_load(miss, start.map(|x| x * 1.01), start.map(f64::abs))?;
        checks.push(shooting.is(quantity, reference, limit.multiple, TOLERANCE * reference));
    }
    Ok(checks)
}
