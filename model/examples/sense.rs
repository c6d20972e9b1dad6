//! A camera sees the paper's finger bend under 2 N. The sensor estimates the force and its place.
//!
//! `cargo run --release -p finray-model --example sense`

use finray_model::measurement::Measurement;
use finray_model::observation::Observation;
use finray_model::sensor::{ContactSpec, Sensor, SensorContacts, SensorOptions};
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, statics};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use rand_distr::{Distribution, StandardNormal};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The camera sees the equilibrium on a fine mesh, with noise of 0.067 mm in each coordinate.
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
    let mesh = Mesh::with_elements_per_member(&scene.finger, 16);
    let load = Load::at_node(NodeId(19), 2.0 * scene.finger.direction(0.0));
    let mut seen = Measurement::of_shape(&scene.finger, &statics::solve(&mesh, &[load], Kinematics::Corotational)?);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    seen.add_noise(0.067, || StandardNormal.sample(&mut rng));
    // The force acts along the plate's normal at an unknown position.
    let contacts = SensorContacts::from_specs(&[ContactSpec::at_position("auto@normal")?], &scene, 0.0, None)?;
    let options = SensorOptions { noise_mm: Some(0.067), ..SensorOptions::default() };
    let sensed = Sensor::new(scene, contacts, options)?.sense(&Observation::of_displacements(&seen))?;
    let [least_n, most_n] = sensed.forces[0].interval_n();
    println!(
        "{:.3} N at {}: 95 % interval {least_n:.3} to {most_n:.3} N",
        sensed.forces[0].force_n, sensed.forces[0].contact
    );
    assert!(least_n < 2.0 && 2.0 < most_n);
    Ok(())
}
