//! Lee's frame: a hinged right-angled frame with snap-back. It has two limit loads, one downwards and one upwards.
//!
//! Source: S. L. Lee, F. S. Manuel, E. C. Rossow, Large deflections and stability of elastic frames, J. Eng. Mech. Div. ASCE 94 (1968) 521-547; the
//! elastic line ([`elastic_line`]) gives the limit loads with more digits.

use super::ProblemError;
use super::elastic_line::{self, Rigidity};
use crate::prelude::*;
use finray_model::frame::{FrameLoad, NodeIndex, PlaneFrame, Section};
use finray_model::statics::{ArcLength, reaction};

/// Rigidities from E = 720, A = 6, I = 2; all units of this problem are consistent.
const RIGIDITY: Rigidity = Rigidity { axial: 4320.0, bending: 1440.0 };
/// Height of the column and length of the beam, in units of length.
const LENGTH: f64 = 120.0;
/// Distance of the load from the corner, in units of length.
const LOAD_AT: f64 = 24.0;
/// Number of elements in 24 units of length.
const ELEMENTS: usize = 8;
/// First limit load, in units of force: the value that several authors cite in the literature on path following.
const LITERATURE: f64 = 1.85565;
/// Tolerance relative to the value in the literature, whose last digits are uncertain.
pub const LITERATURE_TOLERANCE: f64 = 1e-4;
/// Tolerance relative to the limit load of the elastic line. 40 elements per member cause an error of 1e-7.
pub const TOLERANCE: f64 = 1e-6;

/// The frame, and its nodes at the base hinge, the corner, the load, and the hinge of the beam.
fn frame() -> (PlaneFrame, [NodeIndex; 4]) {
    let corners = [(0.0, 0.0), (0.0, LENGTH), (LOAD_AT, LENGTH), (LENGTH, LENGTH)].map(|(x, y)| Vector::new(x, y));
    let section = Section {
        axial_rigidity_n: RIGIDITY.axial,
        bending_rigidity_nmm2: RIGIDITY.bending,
        shear_flexibility: 0.0,
        axis_mm: [0.0; 2],
    };
    let mut frame = PlaneFrame::default();
    let nodes = corners.map(|at| frame.add_node(at));
    for i in 0..3 {
        let elements = ELEMENTS * ((corners[i + 1] - corners[i]).norm() / LOAD_AT).round() as usize;
        let mut from = nodes[i];
        for k in 1..elements {
            let next = frame.add_node(corners[i].lerp(&corners[i + 1], k as f64 / elements as f64));
            frame.add_beam(from, next, section);
            from = next;
        }
        frame.add_beam(from, nodes[i + 1], section);
    }
    for hinge in [nodes[0], nodes[3]] {
        frame.support(hinge, [true, true, false]);
    }
    (frame, nodes)
}

/// Residuals of the elastic line at the hinge of the beam: position relative to the frame's size, and dimensionless moment.
fn miss(&[rotation, fx, fy, load]: &[f64; 4]) -> [f64; 3] {
    let quarter = std::f64::consts::FRAC_PI_2;
    let base = elastic_line::Section { at: [0.0; 2], direction: quarter + rotation, force: [fx, fy], moment: 0.0 };
    let mut corner = base.beyond(LENGTH, RIGIDITY);
    corner.direction -= quarter;
    let mut loaded = corner.beyond(LOAD_AT, RIGIDITY);
    loaded.force[1] += load;
    let end = loaded.beyond(LENGTH - LOAD_AT, RIGIDITY);
    [end.at[0] / LENGTH - 1.0, end.at[1] / LENGTH - 1.0, end.moment * LENGTH / RIGIDITY.bending]
}

/// Checks of both limit loads, and of the unstable branch between them.
///
/// # Errors
/// [`ProblemError`] if the equilibrium path cannot be followed.
pub fn checks() -> Result<Vec<Check>, ProblemError> {
    let (frame, [base, _, loaded, _]) = frame();
    let load = FrameLoad::Node { node: loaded, force: Vector::new(0.0, -1.0), moment_nmm: 0.0 };
    let path = ArcLength::new(&frame, Kinematics::Corotational)
        .follow(&[load], 1000, |point| point.is_stable() && point.multiple > 1.1 * LITERATURE)?;
    let against = |kind: Kind, source| kind.on("Lee's frame, load 24 from the corner", source);
    let literature = against(Kind::Analytical, "Lee, Manuel, Rossow 1968");
    let first = path.limits.first().map_or(f64::NAN, |limit| limit.multiple);
    let mut checks = vec![
        literature.counts("limit points of the path", 2, path.limits.len()),
        literature.is("first limit load", LITERATURE, first, LITERATURE_TOLERANCE * LITERATURE),
    ];
    let shooting = against(Kind::Internal, "elastic line by shooting");
    for (quantity, limit) in ["first limit load", "second limit load"].into_iter().zip(&path.limits) {
        let held = reaction(&frame, &limit.motion, Kinematics::Corotational, &[], base).force;
        // The search on the elastic line starts from the limit point that the beam model finds, perturbed by 1 %.
        let start = [limit.motion.rotations[frame.rotation_of(base)], -held.x, -held.y, limit.multiple];
        let reference = elastic_line::limit_load(miss, start.map(|x| x * 1.01), start.map(f64::abs))?;
        let tolerance = TOLERANCE * reference.abs();
        checks.push(shooting.is(quantity, reference, limit.multiple, tolerance));
    }
    // The first and the last branch are stable, the branch between the limits is unstable.
    let limits: Vec<usize> = path.limits.iter().map(|limit| limit.after).collect();
    let between = |i: usize| limits.first().is_some_and(|&a| i > a) && limits.last().is_some_and(|&b| i <= b);
    let wrong = path.points.iter().enumerate().filter(|(i, point)| point.is_stable() == between(*i)).count();
    checks.push(against(Kind::Internal, "Dirichlet's criterion").counts("points of the wrong stability", 0, wrong));
    Ok(checks)
}
