//! Inextensible cantilever (elastica) under a dead tip load, perpendicular or oblique.
//!
//! Source: `fixtures/elastica.csv`, accurate to 1e-7; agrees with Mattiasson, Int. J. Numer. Methods Eng. 17 (1981). L = EI = 1.

use super::ProblemError;
use crate::prelude::*;
use finray_model::frame::{NodeIndex, PlaneFrame, Section};
use finray_model::statics::solve_frame;

const ELEMENTS: usize = 400;
/// EA L^2 / EI, large because the reference beam is inextensible; a value of 1e6 would cause an error of 8e-6.
const AXIAL_RIGIDITY: f64 = 1e9;
/// Tolerance of a deflection (relative to the length) or rotation (rad): the accuracy of the reference. Errors of discretisation and stretching are
/// smaller.
pub const TOLERANCE: f64 = 1e-7;

/// One row of the reference: load and tip displacements, dimensionless; angle of the load from the axis, degrees; rotation of the tip, rad.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
struct Row {
    load_pl2_ei: f64,
    angle_deg: f64,
    w_over_l: f64,
    u_over_l: f64,
    theta_rad: f64,
}

/// A cantilever of unit length and unit bending rigidity along x, clamped at its first node.
pub(super) fn cantilever(elements: usize, axial_rigidity_n: f64) -> (PlaneFrame, Vec<NodeIndex>) {
    let mut frame = PlaneFrame::default();
    let nodes: Vec<_> = (0..=elements).map(|i| frame.add_node(Vector::new(i as f64 / elements as f64, 0.0))).collect();
    for pair in nodes.windows(2) {
        frame.add_beam(
            pair[0],
            pair[1],
            Section { axial_rigidity_n, bending_rigidity_nmm2: 1.0, shear_flexibility: 0.0, axis_mm: [0.0; 2] },
        );
    }
    frame.support(nodes[0], [true; 3]);
    (frame, nodes)
}

/// Tip displacements perpendicular to the undeformed axis (w) and along this axis towards the clamp (u), relative to the length, and tip rotation
/// (rad). `load` is P L^2 / EI.
pub(super) fn solve(
    load: f64,
    angle_deg: f64,
    elements: usize,
    kinematics: Kinematics,
) -> Result<[f64; 3], ProblemError> {
    let (frame, nodes) = cantilever(elements, AXIAL_RIGIDITY);
    let end = nodes[elements];
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let load = FrameLoad::Node { node: end, force: Vector::new(cos, sin) * load, moment_nmm: 0.0 };
    let motion = solve_frame(&frame, &[load], kinematics)?;
    let u = motion.displacements[end];
    Ok([u.y, -u.x, motion.rotations[frame.rotation_of(end)]])
}

/// One check for each quantity, over all rows of the reference.
///
/// # Errors
/// [`ProblemError`] if a load has no equilibrium.
pub fn checks() -> Result<Vec<Check>, ProblemError> {
    let rows: Vec<Row> =
        csv::Reader::from_reader(finray_fixtures::ELASTICA.as_bytes()).deserialize().collect::<Result<_, _>>()?;
    let off = |row: &Row| -> Result<[f64; 3], ProblemError> {
        let ours = solve(row.load_pl2_ei, row.angle_deg, ELEMENTS, Kinematics::Corotational)?;
        let theirs = [row.w_over_l, row.u_over_l, row.theta_rad];
        Ok([0, 1, 2].map(|i| (ours[i] - theirs[i]).abs()))
    };
    let off = rows.iter().map(off).collect::<Result<Vec<_>, _>>()?;
    let subject = Kind::Analytical.on(format!("cantilever under {} loads of its end", rows.len()), "elastica");
    let quantities = ["w / L", "u / L", "tip rotation (rad)"].into_iter().enumerate();
    let check = |(i, name): (usize, &str)| {
        subject.vanishes(format!("largest difference of {name}"), worst(off.iter().map(|off| off[i])), TOLERANCE)
    };
    Ok(quantities.map(check).collect())
}
