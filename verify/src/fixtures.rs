//! Reference data that travel inside the binary; `fixtures/` says where each comes from.

/// The paper's finger, the default scene.
pub const PAPER_SCENE: &str = include_str!("../../fixtures/scenes/paper.toml");
/// The digital twin of the finger behind the paper's Table I.
pub const TWIN_SCENE: &str = include_str!("../../fixtures/scenes/twin.toml");
/// The spring-steel finger with hinged rigid ribs.
pub const SPRING_STEEL_SCENE: &str = include_str!("../../fixtures/scenes/spring-steel.toml");
/// Contact scenes with the paper's finger.
pub const DISC_SCENE: &str = include_str!("../../fixtures/scenes/contact/disc.toml");
/// A box.
pub const BOX_SCENE: &str = include_str!("../../fixtures/scenes/contact/box.toml");
/// A fork, by its corners.
pub const FORK_SCENE: &str = include_str!("../../fixtures/scenes/contact/fork.toml");
/// Corners of the fork.
pub const FORK_OUTLINE: &str = include_str!("../../fixtures/scenes/contact/fork.csv");
/// A disc with friction.
pub const FRICTION_SCENE: &str = include_str!("../../fixtures/scenes/contact/friction.toml");
/// Displacements of the paper's finger from OpenSees.
pub const OPENSEES_PAPER: &str = include_str!("../../fixtures/opensees/paper.csv");
/// A finger with unequal plates and zones.
pub const ASYMMETRIC_SCENE: &str = include_str!("../../fixtures/opensees/asymmetric.toml");
/// The paper's finger with a soft zone.
pub const SOFT_ZONE_SCENE: &str = include_str!("../../fixtures/mujoco/soft-zone.toml");
/// Shapes of the paper's finger under single forces, from MuJoCo.
pub const MUJOCO_PAPER: &str = include_str!("../../fixtures/mujoco/paper.csv");
/// Shapes of the finger with unequal plates and zones, from MuJoCo.
pub const MUJOCO_ASYMMETRIC: &str = include_str!("../../fixtures/mujoco/asymmetric.csv");
/// Shapes of the finger with a soft zone, from MuJoCo.
pub const MUJOCO_SOFT_ZONE: &str = include_str!("../../fixtures/mujoco/soft-zone.csv");
/// A cylinder pushed into the paper's finger, from MuJoCo.
pub const MUJOCO_CONTACT: &str = include_str!("../../fixtures/mujoco/contact.csv");
/// Large deflections of a cantilever.
pub const ELASTICA: &str = include_str!("../../fixtures/elastica.csv");
/// Sensing networks for the paper's finger.
pub const NETWORKS: [&[u8]; 16] = [
    include_bytes!("../../fixtures/networks/14.safetensors"),
    include_bytes!("../../fixtures/networks/15.safetensors"),
    include_bytes!("../../fixtures/networks/16.safetensors"),
    include_bytes!("../../fixtures/networks/17.safetensors"),
    include_bytes!("../../fixtures/networks/18.safetensors"),
    include_bytes!("../../fixtures/networks/19.safetensors"),
    include_bytes!("../../fixtures/networks/20.safetensors"),
    include_bytes!("../../fixtures/networks/21.safetensors"),
    include_bytes!("../../fixtures/networks/22.safetensors"),
    include_bytes!("../../fixtures/networks/23.safetensors"),
    include_bytes!("../../fixtures/networks/24.safetensors"),
    include_bytes!("../../fixtures/networks/19-20.safetensors"),
    include_bytes!("../../fixtures/networks/16-17.safetensors"),
    include_bytes!("../../fixtures/networks/18-20.safetensors"),
    include_bytes!("../../fixtures/networks/16-20.safetensors"),
    include_bytes!("../../fixtures/networks/any.safetensors"),
];
/// Three ways to train a network, recorded.
pub const RECIPES: &str = include_str!("../../fixtures/networks/recipes.csv");
/// Error of networks against training cases and size, recorded.
pub const CURVES: &str = include_str!("../../fixtures/networks/curves.csv");
