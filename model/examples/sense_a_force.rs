//! A camera sees the paper's finger bend under 2 N: which force was it?
//!
//! `cargo run --release -p finray-model --example sense_a_force`

use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, NonlinearEstimator};
use finray_model::{Kinematics, Mesh, NodeId, Scene, statics};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The problem: a force on node 19 along the normal, and a camera with noise of 0.067 mm in each coordinate.
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE)?.finger;
    let contact = Contact::at_node(NodeId(19));
    let (force_n, noise_mm) = (2.0, 0.067);

    // What the camera sees: the equilibrium on a fine mesh, with noise.
    let fine = Mesh::with_elements_per_member(&finger, 16);
    let shape = statics::solve(&fine, &[contact.load(&finger, force_n)], Kinematics::Corotational)?;
    let mut seen = Measurement::of_shape(&finger, &shape);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    seen.add_noise(noise_mm, || StandardNormal.sample(&mut rng));

    // The estimate: the force follows from the displacements, on a coarser mesh.
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    let sensed = NonlinearEstimator::new(&mesh, &[contact.into()])?.estimate(&seen, Some(noise_mm))?.forces;

    // The comparison.
    let (sensed_n, sigma_n) = (sensed.forces_n[0], sensed.sigmas_n[0]);
    println!("true {force_n} N, sensed {sensed_n:.4} +- {sigma_n:.4} N");
    assert!((sensed_n - force_n).abs() < 3.0 * sigma_n);
    Ok(())
}
