//! Young's modulus of a finger from its displacements under a known force.
//!
//! `cargo run --release -p finray-model --example calibrate`

use finray_model::calibration::{CalibrationCase, FactorModel, UnknownFactor, factors};
use finray_model::measurement::Measurement;
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, statics};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = finray_fixtures::PAPER_SCENE;
    let [scene, softer] = [text, &text.replace("= 47.976", "= 40.0")].map(Scene::from_toml);
    let (scene, softer) = (scene?, softer?);
    // The real finger is softer than the scene says; its displacements are measured.
    let load = Load::at_node(NodeId(19), 2.0 * scene.finger.direction(0.0));
    let mesh = Mesh::with_elements_per_member(&softer.finger, 8);
    let shape = statics::solve(&mesh, &[load], Kinematics::Corotational)?;
    let case = CalibrationCase { load, measurement: Measurement::of_shape(&softer.finger, &shape) };
    let model = FactorModel { kinematics: Kinematics::Corotational, elements: 8, noise_mm: Some(0.067) };
    let found = factors(&scene.finger, &[case], &[UnknownFactor::Modulus], &model)?;
    let (modulus_mpa, share) = (47.976 * found.factors[0], found.relative_sigmas[0]);
    println!("Young's modulus: {modulus_mpa:.2} +- {:.2} MPa", modulus_mpa * share);
    assert!((modulus_mpa / 40.0 - 1.0).abs() < 1e-3);
    Ok(())
}
