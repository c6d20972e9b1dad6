//! Meshes much finer than useful need no more load steps than coarse meshes, and converge to the same shape.

use finray_model::finger::{FingerDescription, Part, Zone};
use finray_model::statics::{Equilibrium, Statics, StaticsError};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, statics};
use finray_tests::{cases, contact_node, finger, finger_with_zones, force_for_deflection, paper, shapes_apart};
use proptest::prelude::*;

/// Largest number of Newton iterations on a mesh of a hundred thousand nodes; the number is the same on 684 nodes. A retraction with a kink at the
/// ends of members needs 11 iterations. Newton's corrections without retraction need 190.
const MOST_ITERATIONS: usize = 6;
/// Largest relative error of a Richardson estimate. On 684 nodes, the next term of the error is some per cent of the first term.
const RICHARDSON: f64 = 0.2;
/// Error of a linear solution on any mesh, as a share of the largest displacement. Stretching is up to 1e5 times stiffer than bending, and each rib
/// and element adds a rounding error.
const ROUNDING: f64 = 1e-10;
/// Largest excess of the stated number of digits over the true number. An excess of 0.3 digits corresponds to a factor of two.
const OVERSTATED: f64 = 0.3;

fn mesh(finger: &Finger, nodes: usize) -> Mesh {
    Mesh::with_nodes(finger, nodes).expect("within the limits")
}

fn bent(mesh: &Mesh, load: &Load) -> Result<Equilibrium, StaticsError> {
    Statics::ladder(mesh, Kinematics::Corotational).equilibrium(&[mesh.frame_load(load)?])
}

/// Under 3 N, a mesh of a hundred thousand nodes needs at most six Newton iterations, as many as two or three load steps need. The shape on the mesh
/// of a hundred thousand nodes equals the Richardson extrapolation of two coarse meshes.
#[test]
fn a_hundred_thousand_nodes_are_where_coarse_meshes_point() {
    let finger = paper();
    let meshes = [684, 1340, 100_000].map(|nodes| mesh(&finger, nodes));
    for node in [14, 19, 22] {
        let load = Load::at_node(NodeId(node), finger.direction(0.0) * 3.0);
        let found = meshes.each_ref().map(|mesh| bent(mesh, &load).expect("3 N are carried"));
        let spent = found[2].iterations;
        assert!(spent <= MOST_ITERATIONS, "{spent} iterations under 3 N at node {node}");
        let [coarse, finer, fine] = [0, 1, 2].map(|i| meshes[i].shape(&found[i].motion));
        // The error falls with the square of the elements' length.
        let ratio = (1340.0_f64 / 684.0).powi(2);
        let foretold = shapes_apart(&coarse, &finer) * ratio / (ratio - 1.0);
        let left = shapes_apart(&coarse, &fine);
        assert!(
            (left - foretold).abs() <= RICHARDSON * foretold,
            "node {node}: {left:e} from 684 nodes, not {foretold:e}"
        );
    }
}

proptest! {
    #![proptest_config(cases(48))]

    /// With zones, hinges, arms and rigid ribs, 256 elements per member need hardly more load steps than four. Newton's corrections without
    /// retraction need about sixteen times as many load steps. There are exceptions: a finger whose front plate is a sixth as thick as its back plate
    /// needed 170 steps instead of 20. This happened with 128 or more elements per member.
    #[test]
    fn load_steps_do_not_grow_with_the_mesh(
        finger in finger_with_zones(),
        at in 0.0..1.0,
        angle in -80.0..80.0,
        share in 0.01..0.1,
    ) {
        let node = contact_node(&finger, at);
        let load = Load::at_node(node, force_for_deflection(&finger, node, angle, share));
        let [coarse, fine] = [4, 256].map(|elements| bent(&Mesh::with_elements_per_member(&finger, elements), &load));
        // Near a limit load, only one of the two meshes may have an equilibrium. Cases in which one of the two meshes has no equilibrium are counted
        // and replaced by new draws.
        let (Ok(coarse), Ok(fine)) = (coarse, fine) else { return Err(TestCaseError::reject("no equilibrium")) };
        // If one mesh just accepts a step and the other mesh just rejects it, the mesh that rejects the step continues with shorter steps.
        let most = 2 * coarse.load_steps + 2;
        prop_assert!(fine.load_steps <= most, "{} after {}", fine.load_steps, coarse.load_steps);
    }
}

proptest! {
    #![proptest_config(cases(48))]

    /// Meshes with a thousand and with sixteen elements per member approximate the same continuous finger, so Newton's method needs the same number
    /// of iterations. One iteration more is allowed on the fine mesh, because a correction may just pass the tolerance on one mesh and just exceed it
    /// on the other. Without zones, the linear shape is equal on all meshes and keeps its digits. Near limit loads, one rejected step changes all
    /// later steps, so only cases that a coarse mesh solves in one step are counted. On meshes with a thousand elements per member, elimination node
    /// by node would lose nine digits of the tangent.
    #[test]
    fn iterations_and_digits_do_not_depend_on_the_mesh(
        finger in finger(),
        at in 0.0..1.0,
        angle in -80.0..80.0,
        share in 0.005..0.03,
    ) {
        let node = contact_node(&finger, at);
        let load = Load::at_node(node, force_for_deflection(&finger, node, angle, share));
        let meshes = [16, 1024].map(|elements| Mesh::with_elements_per_member(&finger, elements));
        let Ok(coarse) = bent(&meshes[0], &load) else { return Err(TestCaseError::reject("no equilibrium")) };
        if coarse.load_steps > 1 {
            return Err(TestCaseError::reject("near a limit load"));
        }
        let fine = bent(&meshes[1], &load).expect("carried by the coarse mesh in one step");
        prop_assert_eq!(fine.load_steps, 1);
        prop_assert!(fine.iterations <= coarse.iterations + 1, "{} after {}", fine.iterations, coarse.iterations);

        let linear = |mesh: &Mesh| {
            let load = mesh.frame_load(&load).expect("a key node");
            mesh.shape(&Statics::ladder(mesh, Kinematics::Linear).equilibrium(&[load]).expect("linear solution").motion)
        };
        let error = shapes_apart(&linear(&meshes[1]), &linear(&Mesh::key_nodes(&finger)));
        prop_assert!(error <= ROUNDING, "{error:e}");
    }
}

/// The paper's finger, a finger with plates like foil, and two fingers with a member that is 10^12 times stiffer or a million times softer. Each
/// finger has a force, N, that bends it a little.
pub(super) fn hard_fingers() -> Vec<(Finger, f64)> {
    let of = |change: &dyn Fn(&mut FingerDescription)| {
        let mut description = paper().description().clone();
        change(&mut description);
        Finger::new(description).expect("hard, but possible")
    };
    let zone = |modulus_factor| {
        move |description: &mut FingerDescription| {
            let rib = description.front_length_mm / 12.0;
            description.zones.push(Zone { part: Part::Front, from_mm: 4.0 * rib, to_mm: 6.0 * rib, modulus_factor });
        }
    };
    vec![
        (paper(), 1.0),
        (of(&|description| description.front.thickness_mm = 0.01), 1e-6),
        (of(&zone(1e12)), 1.0),
        (of(&zone(1e-6)), 1e-6),
    ]
}

/// The linear solution on the key nodes alone is exact, so it is the reference for any mesh. No solution has fewer correct digits than stated, and no
/// solution with fewer than four digits is returned.
#[test]
fn stated_digits_are_there() {
    let mut refused = 0;
    for (finger, force) in hard_fingers() {
        let load = Load::at_node(NodeId(19), finger.direction(0.0) * force);
        let key_nodes = Mesh::key_nodes(&finger);
        let exact = Statics::sparse(key_nodes.frame(), Kinematics::Linear)
            .equilibrium(&[key_nodes.frame_load(&load).expect("node 19 is free")])
            .map(|found| key_nodes.shape(&found.motion))
            .expect("linear solution");
        for nodes in [684, 10_000, 15_000, 30_000, 100_000] {
            let mesh = mesh(&finger, nodes);
            let loads = [mesh.frame_load(&load).expect("node 19 is free")];
            let mut statics = Statics::ladder(&mesh, Kinematics::Linear);
            match statics.accurate_equilibrium(&loads) {
                Ok(found) => {
                    let stated = statics.digits_left(&found.motion, &loads);
                    let error = shapes_apart(&mesh.shape(&found.motion), &exact);
                    assert!(-error.log10() >= stated - OVERSTATED, "{nodes} nodes: {stated} digits, but {error:e} off");
                }
                Err(StaticsError::TooFewDigits { .. } | StaticsError::NotHeld) => refused += 1,
                Err(other) => panic!("{nodes} nodes: {other}"),
            }
        }
    }
    assert!((1..10).contains(&refused), "{refused} of 20 refused");
}

/// If rounding leaves no correct digits, the mesh is refused, and the reason is not snap-through.
#[test]
fn meshes_that_are_too_fine_are_refused() {
    let (finger, force) = hard_fingers().swap_remove(2);
    let load = Load::at_node(NodeId(19), finger.direction(0.0) * force);
    for nodes in [15_000, 30_000] {
        let found = statics::solve(&mesh(&finger, nodes), &[load], Kinematics::Corotational);
        let refused = matches!(found, Err(StaticsError::TooFewDigits { .. } | StaticsError::NotHeld));
        assert!(refused, "{nodes} nodes: {found:?}");
    }
}
