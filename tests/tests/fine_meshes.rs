//! Meshes far finer than any use: they must take no more load steps than coarse ones, and come to the same shape.

use finray_model::mesh::FingerShape;
use finray_model::statics::{Equilibrium, Statics, StaticsError};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene};
use finray_tests::{cases, contact_node, finger_with_zones, force_for_deflection};
use proptest::prelude::*;

/// 11 or 12 are counted; Newton's corrections added as they are take 190.
const MOST_ITERATIONS: usize = 20;
/// Share by which a Richardson estimate may err: the next term of the error is some percent on 684 nodes.
const RICHARDSON: f64 = 0.2;

fn paper() -> Finger {
    Scene::from_toml(include_str!("../../fixtures/scenes/paper.toml")).expect("paper scene").finger
}

fn mesh(finger: &Finger, nodes: usize) -> Mesh {
    Mesh::with_nodes(finger, nodes).expect("within the limits")
}

fn bent(mesh: &Mesh, load: &Load) -> Result<Equilibrium, StaticsError> {
    Statics::ladder(mesh, Kinematics::Corotational).equilibrium(&[mesh.frame_load(load)?])
}

/// Largest difference at a key node, as a share of the largest displacement of one.
fn difference(a: &FingerShape, b: &FingerShape) -> f64 {
    let pairs = a.motions().iter().zip(b.motions());
    pairs.map(|(a, b)| (a.displacement - b.displacement).norm()).fold(0.0, f64::max) / b.largest_displacement_mm()
}

/// A hundred thousand nodes under 3 N: as many Newton iterations as two or three load steps take, and the shape that
/// Richardson extrapolation of two coarse meshes foretells.
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
        let foretold = difference(&coarse, &finer) * ratio / (ratio - 1.0);
        let left = difference(&coarse, &fine);
        assert!(
            (left - foretold).abs() <= RICHARDSON * foretold,
            "node {node}: {left:e} from 684 nodes, not {foretold:e}"
        );
    }
}

proptest! {
    #![proptest_config(cases(48))]

    /// Zones, hinges, arms and rigid ribs: 256 elements a member take hardly more load steps than four. Adding Newton's
    /// corrections as they are takes about sixteen times as many.
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
        // Near a limit load one mesh may find an equilibrium and the other none.
        let (Ok(coarse), Ok(fine)) = (coarse, fine) else { return Ok(()) };
        prop_assert!(fine.load_steps <= 2 * coarse.load_steps, "{} after {}", fine.load_steps, coarse.load_steps);
    }
}
