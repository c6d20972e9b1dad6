//! Shapes interpolated from a coarse mesh onto a finer one.

use super::*;
use crate::{Kinematics, Load, NodeId, Scene, statics::Statics};

/// The interpolated shape of a bent finger lies within a thousandth of its displacements from the equilibrium of the fine mesh.
#[test]
fn an_interpolated_shape_is_near_the_equilibrium_of_the_fine_mesh() {
    let scene = finray_fixtures::PAPER_SCENE;
    // With hinged ribs, the finger carries 2 N at most.
    let hinged = scene.replace("joints = \"rigid\"", "joints = \"hinged\"");
    for (text, force_n) in [(scene, 3.0), (&hinged, 1.0)] {
        let finger = Scene::from_toml(text).expect("a scene").finger;
        let load = Load::at_node(NodeId(19), finger.direction(-30.0) * force_n);
        let [coarse, fine] = [4, 8].map(|elements| {
            let mesh = Mesh::with_elements_per_member(&finger, elements);
            let load = mesh.frame_load(&load).expect("a load on the plate");
            let found = Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&[load]).expect("carried");
            (mesh.clone(), found.motion)
        });
        let shape = fine.0.interpolate(&coarse.0, &coarse.1);
        let apart = |(a, b): (&crate::Vector, &crate::Vector)| (a - b).norm();
        let apart_mm = shape.displacements.iter().zip(&fine.1.displacements).map(apart).fold(0.0, f64::max);
        let turned = shape.rotations.iter().zip(&fine.1.rotations).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart_mm < 1e-3 * fine.1.largest_displacement(), "{apart_mm} mm");
        assert!(turned < 2e-3 * fine.1.largest_rotation(), "{turned} rad");
    }
}
