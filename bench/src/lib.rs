//! Shared setup of the benchmarks: the paper's finger and its loads.

use finray_model::{Finger, Load, NodeId, Scene};

/// The finger of Xu et al. 2021.
pub fn paper() -> Finger {
    Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the embedded scene is valid").finger
}

/// A force (N) along the inward normal at a node of the front plate.
pub fn push(finger: &Finger, node: usize, force_n: f64) -> Load {
    Load::at_node(NodeId(node), finger.direction(0.0) * force_n)
}
