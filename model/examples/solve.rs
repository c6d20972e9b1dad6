//! Shape of the paper's finger under 2 N at node 19, with warnings.
//!
//! `cargo run --release -p finray-model --example solve`

use finray_model::checked_shape::CheckedShape;
use finray_model::{Kinematics, Load, NodeId, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
    let load = Load::at_node(NodeId(19), 2.0 * scene.finger.direction(0.0));
    let solved = CheckedShape::under(&scene, &[load], Kinematics::Corotational, None)?;
    for node in scene.finger.contact_nodes() {
        let [ux_mm, uy_mm] = solved.shape.motion(node).displacement.into();
        println!("node {node}: {ux_mm:.3} mm, {uy_mm:.3} mm");
    }
    solved.warnings().for_each(|warning| println!("warning: {warning}"));
    Ok(())
}
