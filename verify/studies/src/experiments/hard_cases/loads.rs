//! Hard cases: loads whose equilibrium path is hard to follow.

use super::soundness::{LIMIT, Soundness, difference};
use super::{Findings, Question, Unexpected, middle};
use crate::prelude::*;
use finray_model::statics::Equilibrium;

pub(super) const QUESTIONS: &[Question] = &[
    Question {
        case: "loads from 1e-9 N on",
        difficulty: "the finger hardly moves, so stopping rules with an absolute tolerance stop too early or never",
        expectation: "the relative change by geometric nonlinearity is proportional to the load",
        answer: tiny,
    },
    Question {
        case: "buckling and beyond",
        difficulty: "no equilibrium, or a distant equilibrium to which an iteration might jump",
        expectation: "for every load beyond the limit load, a clear refusal that states the carried load; a slightly smaller \
            load is carried",
        answer: buckling,
    },
    Question {
        case: "loads at the tip, along the plate, and pulling",
        difficulty: "directions in which the finger is stiffest, softest, or unstable",
        expectation: "sound equilibrium, or a clear refusal that states a load that is carried",
        answer: directions,
    },
];

const TINY_N: [f64; 5] = [1e-9, 1e-7, 1e-5, 1e-3, 1e-1];
/// Tolerance of the relative change of the displacement by geometric nonlinearity, per newton. It is the value for a vanishing load at the middle of
/// the finger, plus 10 %. The change is proportional to the load. If a stopping rule ended the iteration too early, the change would be larger.
const NONLINEARITY_PER_N: f64 = 1.1 * 0.08;
/// Load steps are not divided below this share of the requested load. A limit load is known to this share of the requested load.
const LAST_STEP: f64 = 1e-6;
/// Forces from the tip towards the base, N; the last three exceed the limit load.
const BUCKLING_N: [f64; 4] = [1.0, 100.0, 1e3, 1e6];
/// Force of the last case, N. The next constant contains its directions, degrees from the inward normal.
const FORCE_N: f64 = 3.0;
const ANGLES_DEG: [f64; 6] = [0.0, 90.0, -90.0, 135.0, -135.0, 180.0];

fn solve(mesh: &Mesh, node: NodeId, force: Vector, kinematics: Kinematics) -> Result<Equilibrium, StaticsError> {
    let load = mesh.frame_load(&Load::at_node(node, force))?;
    Statics::ladder(mesh, kinematics).equilibrium(&[load])
}

fn tiny(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let mut per_newton = Vec::new();
    for force_n in TINY_N {
        let force = finger.direction(0.0) * force_n;
        let moved = |kinematics| -> Result<FrameMotion, Unexpected> {
            Ok(solve(&mesh, middle(finger), force, kinematics)?.motion)
        };
        per_newton.push(difference(&moved(Kinematics::Corotational)?, &moved(Kinematics::Linear)?) / force_n);
    }
    let quantity = "difference / (largest displacement x force) (1/N)";
    findings.vanishes("linear limit", quantity, worst(per_newton), NONLINEARITY_PER_N);
    Ok(())
}

fn buckling(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let (tip, towards_base) = (finger.tip(), -finger.position(finger.tip()).normalize());
    let carries = |force_n: f64| solve(&mesh, tip, towards_base * force_n, Kinematics::Corotational).map(|_| ());
    let mut limits = Vec::new();
    for force_n in BUCKLING_N {
        match carries(force_n) {
            Ok(()) => {}
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                limits.push((force_n, converged_fraction * force_n))
            }
            Err(other) => return Err(other.into()),
        }
    }
    findings.counts("the limit load", "loads beyond it refused", BUCKLING_N.len() - 1, limits.len());
    let &[(_, limit), (_, again), (_, far_beyond), ..] = &limits[..] else { return Ok(()) };
    findings.note(format!("Limit load {limit:.4} N at the tip."));
    findings.vanishes("asking for 1000 N", "change of the limit load / limit load", (again / limit - 1.0).abs(), LIMIT);
    let resolution = LAST_STEP * BUCKLING_N[3] / limit;
    findings.check("asking for 1e6 N", "carried load / limit load", 1.0, far_beyond / limit, resolution + LIMIT);
    let said = carries(far_beyond * (1.0 - LIMIT)).is_ok();
    findings.counts(
        "asking for 1e6 N",
        "carried loads of 0.999 times the load that the refusal states",
        1,
        usize::from(said),
    );
    let load = mesh.frame_load(&Load::at_node(tip, towards_base * BUCKLING_N[1]))?;
    match Statics::sparse(mesh.frame(), Kinematics::Corotational).equilibrium(&[load]) {
        Err(StaticsError::NoEquilibrium { converged_fraction }) => {
            let change = (converged_fraction * BUCKLING_N[1] / limit - 1.0).abs();
            findings.vanishes("general sparse path", "change of the limit load / limit load", change, LIMIT);
        }
        _ => findings.counts("general sparse path", "loads refused", 1, 0),
    }
    let below = carries(limit * (1.0 - LIMIT)).is_ok();
    let above = carries(limit * (1.0 + LIMIT)).is_ok();
    findings.counts("below the limit load", "0.999 of the limit load carried", 1, usize::from(below));
    findings.counts("beyond the limit load", "1.001 of the limit load carried", 0, usize::from(above));
    Ok(())
}

fn directions(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let chosen = [Some(finger.tip()), Some(middle(finger)), finger.contact_nodes().last()];
    let mut sound = Soundness::default();
    let mut refused = Vec::new();
    for (node, angle_deg) in chosen.into_iter().flatten().flat_map(|node| ANGLES_DEG.map(|angle| (node, angle))) {
        let share = sound.add_or_refused(&mesh, node, finger.direction(angle_deg) * FORCE_N)?;
        if share < 1.0 {
            refused.push(format!("{:.3} N at node {node}, {angle_deg} deg", FORCE_N * share));
        }
    }
    if !refused.is_empty() {
        findings.note(format!("Largest forces carried (of {FORCE_N} N applied): {}.", refused.join("; ")));
    }
    sound.report(findings);
    Ok(())
}
