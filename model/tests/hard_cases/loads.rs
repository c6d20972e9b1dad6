//! Loads whose equilibrium path is hard to follow.

use super::soundness::{LIMIT, Soundness};
use super::{Case, Outcome, middle, worst};
use finray_model::statics::{Equilibrium, Statics, StaticsError};
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{motions_apart, paper};

/// Tolerance of the change of the displacement by geometric nonlinearity, per newton, between loads. It allows for the next order under 0.1 N,
/// about 0.1 N times the change of 0.08 per newton, and for rounding under 1e-9 N.
const PROPORTIONAL: f64 = 0.01;
/// Load steps are not divided below this share of the requested load. A limit load is known to this share of the requested load.
const LAST_STEP: f64 = 1e-6;

fn solve(mesh: &Mesh, node: NodeId, force: Vector, kinematics: Kinematics) -> Result<Equilibrium, StaticsError> {
    let load = mesh.frame_load(&Load::at_node(node, force))?;
    Statics::ladder(mesh, kinematics).equilibrium(&[load])
}

#[test]
fn tiny_loads() -> Outcome {
    let mut case = Case::new(
        "loads from 1e-9 N on",
        "the finger hardly moves, so stopping rules with an absolute tolerance stop too early or never",
        "the relative change by geometric nonlinearity is proportional to the load",
    );
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let mut per_newton = Vec::new();
    for force_n in [1e-9, 1e-7, 1e-5, 1e-3, 1e-1] {
        let moved = |kinematics| solve(&mesh, middle(&finger), finger.direction(0.0) * force_n, kinematics);
        let (bent, linear) = (moved(Kinematics::Corotational)?, moved(Kinematics::Linear)?);
        per_newton.push(motions_apart(&bent.motion, &linear.motion) / force_n);
    }
    // A stopping rule that ends the iteration after the linear solution would leave no change; the ratio is then infinite.
    let least = per_newton.iter().copied().fold(f64::INFINITY, f64::min);
    let quantity = "largest / smallest difference / (largest displacement x force) - 1";
    case.vanishes("linear limit", quantity, worst(per_newton) / least - 1.0, PROPORTIONAL);
    case.holds()
}

#[test]
fn buckling() -> Outcome {
    let mut case = Case::new(
        "buckling and beyond",
        "no equilibrium, or a distant equilibrium to which an iteration might jump",
        "for every load beyond the limit load, a clear refusal that states the carried load; a slightly smaller load is carried",
    );
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let (tip, towards_base) = (finger.tip(), -finger.position(finger.tip()).normalize());
    let carries = |force_n: f64| solve(&mesh, tip, towards_base * force_n, Kinematics::Corotational);
    let limit_n = |force_n: f64, answer| match answer {
        Err(StaticsError::NoEquilibrium { converged_fraction }) => converged_fraction * force_n,
        _ => f64::NAN,
    };
    carries(1.0)?;
    let [limit, again, far_beyond] = [100.0, 1e3, 1e6].map(|force_n| limit_n(force_n, carries(force_n)));
    case.is("closed interval", "limit load at the tip (N)", 5.6418, limit, 1e-3);
    let change = "change of the limit load / limit load";
    case.vanishes("asking for 1000 N", change, (again / limit - 1.0).abs(), LIMIT);
    let resolution = LAST_STEP * 1e6 / limit;
    case.is("asking for 1e6 N", "carried load / limit load", 1.0, far_beyond / limit, resolution + LIMIT);
    let load = mesh.frame_load(&Load::at_node(tip, towards_base * 100.0))?;
    let sparse = limit_n(100.0, Statics::sparse(mesh.frame(), Kinematics::Corotational).equilibrium(&[load]));
    case.vanishes("general sparse path", change, (sparse / limit - 1.0).abs(), LIMIT);
    for (source, quantity, force_n, carried) in [
        ("asking for 1e6 N", "0.999 of the load that the refusal states carried", far_beyond * (1.0 - LIMIT), 1),
        ("below the limit load", "0.999 of the limit load carried", limit * (1.0 - LIMIT), 1),
        ("beyond the limit load", "1.001 of the limit load carried", limit * (1.0 + LIMIT), 0),
    ] {
        case.counts(source, quantity, carried, usize::from(carries(force_n).is_ok()));
    }
    case.holds()
}

#[test]
fn directions() -> Outcome {
    let mut case = Case::new(
        "loads at the tip, along the plate, and pulling",
        "directions in which the finger is stiffest, softest, or unstable",
        "sound equilibrium, or a clear refusal that states a load that is carried",
    );
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let mut sound = Soundness::default();
    for node in [finger.tip(), middle(&finger)].into_iter().chain(finger.contact_nodes().last()) {
        for angle_deg in [0.0, 90.0, -90.0, 135.0, -135.0, 180.0] {
            sound.add_or_refused(&mesh, node, finger.direction(angle_deg) * 3.0)?;
        }
    }
    sound.report(&mut case);
    case.holds()
}
