//! Shared setup of the benches: the finger of the paper and its loads.

use finray_model::{Finger, Load, NodeId, Scene};

/// The paper's finger.
pub fn paper() -> Finger {
    Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the embedded scene is valid").finger
}

/// A force along the inward normal of a node.
pub fn push(finger: &Finger, node: usize, force_n: f64) -> Load {
    Load::at_node(NodeId(node), finger.direction(0.0) * force_n)
}
