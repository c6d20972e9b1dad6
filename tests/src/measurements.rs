//! Simulated measurements of a finger.

use finray_model::measurement::Measurement;
use finray_model::sensing::Contact;
use finray_model::statics::StaticsError;
use finray_model::{Kinematics, Load, Mesh, statics};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Displacements of all free key nodes of a mesh under contact forces, without noise.
///
/// # Errors
/// [`StaticsError`] if the finger has no equilibrium under these forces.
pub fn seen(
    mesh: &Mesh,
    contacts: &[Contact],
    forces_n: &[f64],
    kinematics: Kinematics,
) -> Result<Measurement, StaticsError> {
    let finger = mesh.finger();
    let loads: Vec<Load> =
        contacts.iter().zip(forces_n).map(|(contact, force_n)| contact.load(finger, *force_n)).collect();
    Ok(Measurement::of_shape(finger, &statics::solve(mesh, &loads, kinematics)?))
}

/// The measurement with added Gaussian noise. `noise_mm` is the standard deviation of a coordinate at weight 1.
pub fn noisy(clean: &Measurement, noise_mm: f64, rng: &mut impl Rng) -> Measurement {
    let mut noisy = clean.clone();
    noisy.add_noise(noise_mm, || StandardNormal.sample(rng));
    noisy
}
