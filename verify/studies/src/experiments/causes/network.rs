//! Errors that a network adds to the errors of the model with which it was trained.
//!
//! A network senses only at its contact nodes and along the normal. In the other studies of causes, sensing assumes a wrong contact and a wrong
//! model. Here, instead, the true contact deviates from the network's contact by [`POSITION_OFF_MM`](super::POSITION_OFF_MM) and
//! [`DIRECTION_OFF_DEG`](super::DIRECTION_OFF_DEG). Zones as a cause are eliminated by removing them from the true finger. The measurements are
//! noisy.

use super::cell::{Squared, beside};
use super::models::{WEIGHTS_N, calibrated, weighed, with_zones};
use super::{Cause, CauseCell, CauseMap, CauseRequest, ContactKnowledge, Practice, present};
use crate::experiments::ExperimentError;
use crate::prelude::*;
use crate::sampling::noise::Noise;
use crate::truths::{MeshTruth, Truth, TruthId, fine_mesh};

/// Number of noise samples of every shape. The root mean square error caused by noise then has a relative standard error of 11 %.
const SAMPLES: usize = 40;
const SEED: u64 = 1;

/// Causes of a network's errors on a true finger, at every contact node with a network. The network was trained on the `believed` finger. The network
/// may be used with another modulus, because forces are proportional to the modulus. Forces are in N, the noise is in mm.
///
/// # Errors
/// [`ExperimentError`] if the equations of a finger at rest cannot be solved, or its modulus cannot be calibrated.
pub fn causes(
    truth: TruthId,
    finger: &Finger,
    believed: &Finger,
    network: &(dyn Fn(NodeId) -> Result<Sensor, Refusal> + Sync),
    forces_n: &[f64],
    noise_mm: f64,
) -> Result<CauseMap, ExperimentError> {
    let mut request = CauseRequest {
        practices: vec![(Practice::Network, ContactKnowledge::Assumed)],
        positions_mm: Vec::new(),
        angles_deg: vec![0.0],
        forces_n: forces_n.to_vec(),
        noise_mm,
        zones_known: false,
        weights_n: WEIGHTS_N,
    };
    let causes = present(Practice::Network, ContactKnowledge::Assumed, finger, &request);
    let worlds = causes.iter().map(|cause| Some(*cause)).chain([None]);
    let worlds: Vec<World> = worlds
        .map(|off| World::without(off, truth, finger, believed, &request.weights_n))
        .collect::<Result<_, ExperimentError>>()?;
    let sensors: Vec<(NodeId, Sensor)> =
        believed.contact_nodes().filter_map(|node| Some((node, network(node).ok()?))).collect();
    let cells = |(node, network): &(NodeId, Sensor)| -> Vec<CauseCell> {
        let node = *node;
        let errors: Vec<_> = worlds.iter().map(|world| world.errors(node, network, forces_n, noise_mm)).collect();
        let cell = |(i, &force_n): (usize, &f64)| {
            let (without, all) = (&errors[..causes.len()], errors[causes.len()][i]);
            CauseCell {
                s_mm: believed.front_position_mm(node).unwrap_or(f64::NAN),
                angle_deg: 0.0,
                force_n,
                rms_error: all.map(f64::sqrt),
                shares: without.iter().map(|errors| Some(1.0 - errors[i]? / all?)).collect(),
                remedied: Vec::new(),
            }
        };
        forces_n.iter().enumerate().map(cell).collect()
    };
    let cells: Vec<CauseCell> = sensors.par_iter().with_max_len(1).flat_map_iter(cells).collect();
    request.positions_mm = sensors.iter().filter_map(|(node, _)| believed.front_position_mm(*node)).collect();
    Ok(CauseMap { request, truth, practice: Practice::Network, contact: ContactKnowledge::Assumed, causes, cells })
}

/// The true finger and its model, with one cause eliminated.
struct World {
    off: Option<Cause>,
    mesh: Mesh,
    truth: TruthId,
    /// Mesh of the finger that the network represents, with the modulus for which the network is used.
    model: Mesh,
    /// Modulus for which the network is used, divided by the modulus with which it was trained.
    modulus_factor: f64,
}

impl World {
    fn without(
        off: Option<Cause>,
        truth: TruthId,
        finger: &Finger,
        believed: &Finger,
        weights_n: &[f64],
    ) -> Result<World, ExperimentError> {
        let finger = with_zones(finger, off != Some(Cause::BaseCompliance), off != Some(Cause::TipCompliance))?;
        let mesh = fine_mesh(&finger)?;
        let modulus = |finger: &Finger| finger.description().front.youngs_modulus_mpa;
        let taken_for = if off == Some(Cause::Modulus) {
            modulus(&finger)
        } else {
            let cases = weighed(&finger, &MeshTruth::new(truth, &mesh, Kinematics::Corotational)?, weights_n);
            modulus(&calibrated(believed, &cases, Kinematics::Corotational)?)
        };
        let modulus_factor = taken_for / modulus(believed);
        let model = Mesh::with_elements_per_member(&believed.with_modulus_factor(modulus_factor)?, ELEMENTS);
        Ok(World { off, mesh, truth, model, modulus_factor })
    }

    /// Mean square of sensed / true - 1 at a node, by force (N); `None` if the finger has no equilibrium or sensing refuses.
    fn errors(&self, node: NodeId, network: &Sensor, forces_n: &[f64], noise_mm: f64) -> Vec<Option<f64>> {
        let off = |cause| self.off == Some(cause);
        let mut sums = vec![Some(0.0); forces_n.len()];
        let Ok(truth) = MeshTruth::new(self.truth, &self.mesh, Kinematics::Corotational) else {
            return vec![None; forces_n.len()];
        };
        let finger = self.mesh.finger();
        let Some(s_mm) = finger.front_position_mm(node) else { return Vec::new() };
        // The true contacts. Whatever the true contact is, the network assumes a force on the node along the normal.
        let contacts = beside(finger, s_mm, 0.0, [!off(Cause::Position), !off(Cause::Direction)]);
        for contact in &contacts {
            let shapes = truth.shapes(contact, forces_n);
            let seen: Vec<_> = shapes.iter().map(|shape| Measurement::of_shape(finger, shape)).collect();
            let errors = match self.off {
                Some(Cause::NetworkFit) => self.by_the_model(node, &seen, forces_n, noise_mm),
                Some(Cause::Noise) => self.by_the_network(network, &seen, forces_n, 0.0),
                _ => self.by_the_network(network, &seen, forces_n, noise_mm),
            };
            for (i, sum) in sums.iter_mut().enumerate() {
                let error = errors.get(i).copied().flatten();
                *sum = sum.zip(error).map(|(sum, error)| sum + error / contacts.len() as f64);
            }
        }
        sums
    }

    fn by_the_network(
        &self,
        network: &Sensor,
        seen: &[Measurement],
        forces_n: &[f64],
        noise_mm: f64,
    ) -> Vec<Option<f64>> {
        let mut noise = Noise::new(SEED);
        let samples = if noise_mm > 0.0 { SAMPLES } else { 1 };
        let mut of_force = |(seen, &force_n): (&Measurement, &f64)| {
            let mut sum = 0.0;
            for _ in 0..samples {
                let sample = noise.on(seen, noise_mm);
                let sensed = network.sense_displacements(&sample, Some(noise_mm.max(LEAST_STATED_MM)), None).ok()?;
                sum += (self.modulus_factor * sensed.forces[0].force_n / force_n - 1.0).powi(2);
            }
            Some(sum / samples as f64)
        };
        seen.iter().zip(forces_n).map(&mut of_force).collect()
    }

    fn by_the_model(&self, node: NodeId, seen: &[Measurement], forces_n: &[f64], noise_mm: f64) -> Vec<Option<f64>> {
        let contact = Contact::at_node(node);
        let Ok(mut estimator) = NonlinearEstimator::new(&self.model, &[contact.into()]) else { return Vec::new() };
        let squared = |(seen, &force_n): (&Measurement, &f64)| {
            Some(Squared::of_nonlinear(&mut estimator, seen, force_n, noise_mm)?.sum())
        };
        seen.iter().zip(forces_n).map(squared).collect()
    }
}
