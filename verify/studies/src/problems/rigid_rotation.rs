//! A finger rotated as a rigid body has no strain, so no nodal forces.
//!
//! Source: objectivity (invariance of the strains under rigid motions).

use crate::prelude::*;
use finray_model::frame::{FrameMotion, PlaneFrame};
use finray_model::statics::Assembly;

/// Angles of rotation, rad.
const ANGLES: [f64; 7] = [1e-9, 1e-6, 1e-3, 0.1, 1.0, 3.0, std::f64::consts::PI];
/// Elements per member. Element lengths range from a fraction of a millimetre to a whole rib.
const ELEMENTS: [usize; 3] = [1, 4, 16];
/// Tolerance of nodal forces, relative to EA times the angle, which is the magnitude of the nodal forces in linear kinematics.
pub const TOLERANCE: f64 = 1e-10;

/// Motion of all nodes rotated about the origin by `angle` (rad). Half-angle formulas keep the digits of small rotations.
fn turned(frame: &PlaneFrame, angle: f64) -> FrameMotion {
    let half = (0.5 * angle).sin();
    let displaced = |at: Vector| Vector::new(-at.y, at.x) * angle.sin() - at * (2.0 * half * half);
    let mut motion = FrameMotion::at_rest(frame);
    for (node, displacement) in motion.displacements.iter_mut().enumerate() {
        *displacement = displaced(frame.position(node));
    }
    motion.rotations.fill(angle);
    motion
}

/// Largest nodal force of the rotated frame over all angles, relative to EA times the angle; angles above 1 rad count as 1 rad in this product.
fn force(frame: &PlaneFrame, kinematics: Kinematics) -> f64 {
    let rigidity = worst(frame.members().iter().map(|member| member.beam.axial_rigidity_n));
    let mut assembly = Assembly::new(frame, kinematics);
    worst(ANGLES.map(|angle| {
        assembly.evaluate(&turned(frame, angle), &[], 0.0);
        worst(assembly.residual().iter().map(|force| force.abs())) / (rigidity * angle.min(1.0))
    }))
}

/// One check for each co-rotational kinematics, over all angles and meshes.
pub fn checks(finger: &Finger) -> Vec<Check> {
    let meshes = ELEMENTS.map(|elements| Mesh::with_elements_per_member(finger, elements));
    [(Kinematics::Corotational, "shallow-arch strain"), (Kinematics::CorotationalChord, "chord strain")]
        .into_iter()
        .map(|(kinematics, name)| {
            let ours = worst(meshes.iter().map(|mesh| force(mesh.frame(), kinematics)));
            let problem = format!("finger turned by 1e-9 to pi rad, {name}, 1 to 16 elements per member");
            Kind::Analytical.on(problem, "rigid motion").vanishes("largest nodal force / (EA x turn)", ours, TOLERANCE)
        })
        .collect()
}
