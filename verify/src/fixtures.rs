//! Reference data that travel inside the binary; `fixtures/` says where each comes from.

/// The paper's finger, the default scene.
pub const PAPER_SCENE: &str = include_str!("../../fixtures/scenes/paper.toml");
/// The spring-steel finger with hinged rigid ribs.
pub const SPRING_STEEL_SCENE: &str = include_str!("../../fixtures/scenes/spring-steel.toml");
/// Displacements of the paper's finger from OpenSees.
pub const OPENSEES_PAPER: &str = include_str!("../../fixtures/opensees/paper.csv");
/// Large deflections of a cantilever.
pub const ELASTICA: &str = include_str!("../../fixtures/elastica.csv");
/// Sensing networks for the paper's finger, by name.
pub const NETWORKS: [(&str, &[u8]); 0] = [];
