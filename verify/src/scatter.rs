//! Nonlinear sensing under camera noise: scatter against the Cramer-Rao bound, and what the stated sigma covers.
//!
//! Random forces bend a true finger, noise is added to what the camera sees, and the estimator, which knows the contact
//! nodes and directions (along the undeformed normal), starts afresh. Errors are divided by the bound at the case's own
//! true forces, so their root mean square is 1 for an estimator that wastes nothing.

use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPlace, NonlinearEstimator, SensingError};
use finray_model::statics::Statics;
use finray_model::{Finger, Kinematics, Mesh, NodeId};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Serialize;

/// Forces on one contact node, N (sec. V-C of the paper; below 0.5 N the noise alone is worth several percent).
pub const ONE_FORCE_N: [f64; 2] = [0.5, 3.0];
/// Forces on each of two contact nodes, N (sec. V-C of the paper).
pub const TWO_FORCES_N: [f64; 2] = [0.3, 3.0];
/// Half width of the interval that holds 95 % of a normal distribution, in standard deviations.
pub const TWO_SIDED_95: f64 = 1.96;
/// Mean of |x| for x of a normal distribution with standard deviation 1: sqrt(2 / pi).
const MEAN_ABSOLUTE: f64 = 0.797_884_560_802_865_4;
/// A finger that carries none of so many draws in a row carries no force of the range.
const MOST_DRAWS: usize = 100;
/// More contact nodes than these are thinned out.
const MOST_NODES: usize = 12;

/// What is asked of an estimator.
#[derive(Debug, Clone, Copy)]
pub struct ScatterRequest<'m> {
    /// The true finger's mesh.
    pub truth: &'m Mesh,
    /// The estimator's mesh, of the same finger.
    pub model: &'m Mesh,
    /// Standard deviation of a coordinate, mm.
    pub noise_mm: f64,
    /// Random cases for each set of contacts.
    pub cases: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Errors of one quantity, a force or the sum of all.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Scatter {
    /// Mean of |sensed / true - 1|.
    pub mean_error: f64,
    /// What an estimator that reaches the Cramer-Rao bound has as its mean error.
    pub mean_error_bound: f64,
    /// Root mean square of error / bound.
    pub over_bound: f64,
    /// Mean of error / bound.
    pub bias_over_bound: f64,
    /// Share of cases in which the truth lies within one stated standard deviation; 0.683 is meant.
    pub covered_by_one_sigma: f64,
    /// Share of cases in which it lies within 1.96; 0.95 is meant.
    pub covered_by_two_sigma: f64,
}

/// Results for one set of contact nodes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScatterRow {
    /// The contact nodes.
    pub nodes: Vec<usize>,
    /// Cases that were sensed.
    pub cases: usize,
    /// Draws that were repeated because the finger does not carry them.
    pub not_carried: usize,
    /// Cases that the estimator refused; they count nowhere else.
    pub refused: usize,
    /// Each force in the order of the nodes.
    pub forces: Vec<Scatter>,
    /// The sum of the forces.
    pub sum: Scatter,
}

impl ScatterRow {
    /// Mean error of all forces.
    pub fn mean_error(&self) -> f64 {
        self.forces.iter().map(|scatter| scatter.mean_error).sum::<f64>() / self.forces.len() as f64
    }
}

/// A row for each set of contact nodes, forces drawn evenly from `range_n`. `progress` is called after each set.
///
/// # Errors
/// [`SensingError`] for a node that is no contact node.
pub fn scatter(
    request: &ScatterRequest,
    sets: &[Vec<NodeId>],
    range_n: [f64; 2],
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<ScatterRow>, SensingError> {
    let of_set = |(stream, nodes): (usize, &Vec<NodeId>)| {
        let row = row(request, nodes, range_n, stream as u64);
        progress();
        row
    };
    sets.par_iter().enumerate().map(of_set).collect()
}

/// Every contact node, or about a dozen of many.
pub fn sampled_nodes(finger: &Finger) -> Vec<NodeId> {
    let nodes = finger.contact_nodes();
    let every = nodes.len().div_ceil(MOST_NODES);
    nodes.step_by(every).collect()
}

/// Every node alone.
pub fn singles(nodes: &[NodeId]) -> Vec<Vec<NodeId>> {
    nodes.iter().map(|&node| vec![node]).collect()
}

/// Every pair of nodes.
pub fn pairs(nodes: &[NodeId]) -> Vec<Vec<NodeId>> {
    let from = |i: usize| nodes[i + 1..].iter().map(|&second| vec![nodes[i], second]).collect::<Vec<_>>();
    (0..nodes.len()).flat_map(from).collect()
}

/// Sums over the cases of one quantity.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    error: f64,
    bound: f64,
    standardised: f64,
    squared: f64,
    one_sigma: usize,
    two_sigma: usize,
}

impl Sums {
    fn add(&mut self, truth: f64, sensed: f64, bound: f64, stated_sigma: f64) {
        let error = sensed - truth;
        self.error += (error / truth).abs();
        self.bound += MEAN_ABSOLUTE * bound / truth;
        self.standardised += error / bound;
        self.squared += (error / bound).powi(2);
        self.one_sigma += usize::from(error.abs() <= stated_sigma);
        self.two_sigma += usize::from(error.abs() <= TWO_SIDED_95 * stated_sigma);
    }

    fn over(&self, cases: usize) -> Scatter {
        let cases = cases as f64;
        Scatter {
            mean_error: self.error / cases,
            mean_error_bound: self.bound / cases,
            over_bound: (self.squared / cases).sqrt(),
            bias_over_bound: self.standardised / cases,
            covered_by_one_sigma: self.one_sigma as f64 / cases,
            covered_by_two_sigma: self.two_sigma as f64 / cases,
        }
    }
}

fn row(request: &ScatterRequest, nodes: &[NodeId], range_n: [f64; 2], stream: u64) -> Result<ScatterRow, SensingError> {
    let contacts: Vec<Contact> =
        nodes.iter().map(|&node| Contact { place: ContactPlace::Node(node), angle_deg: 0.0 }).collect();
    let questions: Vec<_> = contacts.iter().map(|&contact| contact.into()).collect();
    let mut estimator = NonlinearEstimator::new(request.model, &questions)?;
    let mut finger = TrueFinger {
        mesh: request.truth,
        statics: Statics::ladder(request.truth, Kinematics::Corotational),
        contacts,
        not_carried: 0,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(request.seed);
    rng.set_stream(stream);
    let (mut cases, mut refused) = (0, 0);
    let mut forces = vec![Sums::default(); nodes.len()];
    let mut sum = Sums::default();
    for _ in 0..request.cases {
        let Some((forces_n, clean)) = finger.bent_at_random(range_n, &mut rng) else { break };
        let mut noisy = clean.clone();
        noisy.add_noise(request.noise_mm, || StandardNormal.sample(&mut rng));
        // A stream's start from the last frame would be too easy.
        estimator.reset();
        let sensed = estimator.estimate(&noisy, Some(request.noise_mm));
        let bound = estimator.estimate(&clean, Some(request.noise_mm));
        let (Ok(sensed), Ok(bound)) = (sensed, bound) else {
            refused += 1;
            continue;
        };
        cases += 1;
        for (i, sums) in forces.iter_mut().enumerate() {
            let (stated, bound) = (sensed.forces.sigmas_n[i], bound.forces.sigmas_n[i]);
            sums.add(forces_n[i], sensed.forces.forces_n[i], bound, stated);
        }
        let [stated, bound] = [&sensed, &bound].map(|estimate| estimate.covariance_n2.sum().sqrt());
        sum.add(forces_n.iter().sum(), sensed.forces.forces_n.iter().sum(), bound, stated);
    }
    Ok(ScatterRow {
        nodes: nodes.iter().map(|node| node.0).collect(),
        cases,
        not_carried: finger.not_carried,
        refused,
        forces: forces.iter().map(|sums| sums.over(cases)).collect(),
        sum: sum.over(cases),
    })
}

/// A finger that random forces bend.
struct TrueFinger<'m> {
    mesh: &'m Mesh,
    statics: Statics<finray_model::statics::Ladder<'m>>,
    contacts: Vec<Contact>,
    not_carried: usize,
}

impl TrueFinger<'_> {
    /// Forces that the finger carries and what the camera sees of them; `None` if none are found.
    fn bent_at_random(&mut self, range_n: [f64; 2], rng: &mut impl Rng) -> Option<(Vec<f64>, Measurement)> {
        let finger = self.mesh.finger();
        for _ in 0..MOST_DRAWS {
            let forces_n: Vec<f64> = self.contacts.iter().map(|_| rng.random_range(range_n[0]..range_n[1])).collect();
            let loads = self.contacts.iter().zip(&forces_n).map(|(c, f)| self.mesh.frame_load(&c.load(finger, *f)));
            let loads = loads.collect::<Result<Vec<_>, _>>().ok()?;
            if let Ok(equilibrium) = self.statics.equilibrium(&loads) {
                let seen = Measurement::of_shape(finger, &self.mesh.shape(&equilibrium.motion));
                return Some((forces_n, seen));
            }
            self.not_carried += 1;
        }
        None
    }
}
