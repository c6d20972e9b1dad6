//! Random load cases of a finger and the resulting shapes, for training sensing networks.
//!
//! Each case has its own stream of random numbers, so samples do not depend on the number of threads.

use finray_model::Kinematics;
use finray_model::finger::{Finger, NodeId};
use finray_model::frame::FrameLoad;
use finray_model::measurement::Measurement;
use finray_model::mesh::Mesh;
use finray_model::sensing::{Contact, SensingError, check_contacts};
use finray_model::statics::equilibria;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

/// Drawing fails if a case has no equilibrium in this number of draws: the finger is too weak for the range of forces.
const MOST_DRAWS: usize = 100;
/// Number of cases that one thread draws together. Their equilibria are computed in groups.
const CASES_A_PIECE: usize = 256;

/// Distribution of load cases.
///
/// # Reference
/// Sec. IV-A of Xu et al. (2021): 20 000 cases, 0 to 5 N per node, 0 to 10 N in total, on the linear finger.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleRecipe {
    /// Contacts whose forces are drawn, with their directions.
    pub contacts: Vec<Contact>,
    /// Whether each case loads only a random subset of the contacts. All subset sizes, from one contact to all, are equally likely.
    pub any_of: bool,
    /// Linear or co-rotational kinematics.
    pub kinematics: Kinematics,
    /// Beam elements per member.
    pub elements: usize,
    /// Largest force of a contact, N. Forces are drawn uniformly between zero and this force.
    pub largest_force_n: f64,
    /// Largest sum of the forces, N. A case with a larger sum is scaled to a sum that is drawn uniformly from zero to `largest_sum_n`.
    pub largest_sum_n: f64,
    /// Standard deviation of each force's direction about the contact's direction, degrees.
    pub direction_spread_deg: f64,
    /// Standard deviation of the logarithm of the finger's modulus, dimensionless: 0.05 means that the modulus varies by 5 % around the scene's
    /// value.
    pub modulus_spread: f64,
    /// Free key nodes whose markers are hidden.
    pub hidden: Vec<NodeId>,
}

impl SampleRecipe {
    /// The ranges of force of Xu et al. (2021, sec. IV-A), for the given contacts.
    pub fn paper(contacts: Vec<Contact>, kinematics: Kinematics) -> SampleRecipe {
        SampleRecipe {
            contacts,
            any_of: false,
            kinematics,
            // Key nodes of the linear finger are exact with one element per member; four co-rotational elements per member have an error of 0.04 %.
            elements: if kinematics == Kinematics::Linear { 1 } else { 4 },
            largest_force_n: 5.0,
            largest_sum_n: 10.0,
            direction_spread_deg: 0.0,
            modulus_spread: 0.0,
            hidden: Vec::new(),
        }
    }

    /// Nodes of the visible markers, in order: all marked nodes except the hidden ones.
    pub fn markers(&self, finger: &Finger) -> Vec<NodeId> {
        finger.marked_nodes().filter(|node| !self.hidden.contains(node)).collect()
    }

    /// Checks each number of the recipe.
    ///
    /// # Errors
    /// [`SamplesError::Recipe`] for the first impossible number.
    pub fn check(&self) -> Result<(), SamplesError> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let not_negative = |x: f64| x.is_finite() && x >= 0.0;
        require(positive(self.largest_force_n), "largest_force_n", "a force in N above zero", &self.largest_force_n)?;
        require(positive(self.largest_sum_n), "largest_sum_n", "a force in N above zero", &self.largest_sum_n)?;
        let spread_deg = self.direction_spread_deg;
        require(not_negative(spread_deg), "direction_spread_deg", "degrees, zero or more", &spread_deg)?;
        require(not_negative(self.modulus_spread), "modulus_spread", "zero or more", &self.modulus_spread)?;
        require(self.elements > 0, "elements", "at least one element per member", &self.elements)
    }

    /// Draws `count` cases from a stream of the seed.
    ///
    /// # Errors
    /// [`SamplesError`] if a number is impossible, a contact is not on the free front plate, or a case has no equilibrium in any of its draws.
    pub fn draw(&self, finger: &Finger, count: usize, seed: u64, stream: Stream) -> Result<Samples, SamplesError> {
        self.check()?;
        check_contacts(finger, &self.contacts)?;
        let markers = self.markers(finger);
        let mesh = Mesh::with_elements_per_member(finger, self.elements);
        let pieces = count.div_ceil(CASES_A_PIECE);
        let piece = |piece: usize| {
            let first = piece * CASES_A_PIECE;
            let rngs = (first..count.min(first + CASES_A_PIECE)).map(|i| stream.rng(seed, i as u64));
            self.carried(&mesh, rngs.collect()).ok_or(SamplesError::NoneCarried { draws: MOST_DRAWS })
        };
        let cases: Vec<Vec<Case>> = (0..pieces).into_par_iter().map(piece).collect::<Result<_, _>>()?;
        let cases: Vec<Case> = cases.into_iter().flatten().collect();
        let (rows, contacts) = (2 * markers.len(), self.contacts.len());
        Ok(Samples {
            displacements: DMatrix::from_iterator(
                rows,
                count,
                cases.iter().flat_map(|case| case.displacements_mm.iter().copied()),
            ),
            forces: DMatrix::from_iterator(
                contacts,
                count,
                cases.iter().flat_map(|case| case.drawn.forces_n.iter().copied()),
            ),
            touching: cases.iter().map(|case| case.drawn.touching.clone()).collect(),
            not_carried: cases.iter().map(|case| case.not_carried).sum(),
            markers,
        })
    }

    /// Draws one case from each generator; repeats a draw until the finger has an equilibrium under the drawn forces. `None` if a case has no
    /// equilibrium in any of its draws.
    fn carried(&self, mesh: &Mesh, rngs: Vec<ChaCha8Rng>) -> Option<Vec<Case>> {
        let mut cases: Vec<Option<Case>> = rngs.iter().map(|_| None).collect();
        let mut waiting: Vec<(usize, ChaCha8Rng)> = rngs.into_iter().enumerate().collect();
        for not_carried in 0..MOST_DRAWS {
            let drawn: Vec<Drawn> = waiting.iter_mut().map(|(_, rng)| Drawn::new(self, rng)).collect();
            let loads = drawn.iter().map(|drawn| drawn.loads(self, mesh).ok()).collect::<Option<Vec<_>>>()?;
            let equilibria = equilibria(mesh, self.kinematics, &loads);
            let mut refused = Vec::new();
            for ((drawn, found), (index, rng)) in drawn.into_iter().zip(equilibria).zip(waiting) {
                match found {
                    Ok(found) => {
                        let shape = Measurement::of_shape(mesh.finger(), &mesh.shape(&found.motion));
                        let seen = shape.without(&self.hidden);
                        let coordinates = seen.markers().iter().flat_map(|m| [m.displacement.x, m.displacement.y]);
                        let displacements_mm = coordinates.collect();
                        cases[index] = Some(Case { drawn, displacements_mm, not_carried });
                    }
                    Err(_) => refused.push((index, rng)),
                }
            }
            waiting = refused;
            if waiting.is_empty() {
                break;
            }
        }
        cases.into_iter().collect()
    }
}

/// Purpose of random numbers. Different purposes use different streams of a seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// Load cases for training.
    Training,
    /// Load cases that decide when training stops.
    Validation,
    /// Load cases for the stated errors.
    Test,
    /// Camera noise in training.
    TrainingNoise,
    /// Camera noise in validation.
    ValidationNoise,
    /// Camera noise in the test.
    TestNoise,
    /// Initial weights of a network, and the order of the training cases.
    Weights,
}

impl Stream {
    /// Random number generator for item `index` (below 2^60) of a purpose.
    pub fn rng(self, seed: u64, index: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(((self as u64) << 60) + index);
        rng
    }
}

/// Reason for which no samples are drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SamplesError {
    /// A value of the recipe is impossible.
    #[error("{key}: expected {expected}, found {found}")]
    Recipe {
        /// Field of the recipe.
        key: &'static str,
        /// Expected value.
        expected: &'static str,
        /// Found value.
        found: String,
    },
    /// A contact is wrong.
    #[error(transparent)]
    Contacts(#[from] SensingError),
    /// For one case, the finger has no equilibrium under the forces of any draw.
    #[error("the finger has no equilibrium under any of {draws} random load cases: train for smaller forces")]
    NoneCarried {
        /// Number of draws of the case.
        draws: usize,
    },
}

/// Returns an error for the value `found` of the field `key` unless `holds` is true.
pub(super) fn require(
    holds: bool,
    key: &'static str,
    expected: &'static str,
    found: &dyn std::fmt::Debug,
) -> Result<(), SamplesError> {
    if holds { Ok(()) } else { Err(SamplesError::Recipe { key, expected, found: format!("{found:?}") }) }
}

/// Load cases and the resulting shapes, one column per case.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Displacements without noise, mm: two rows (x, y) per marker.
    pub displacements: DMatrix<f64>,
    /// Force of each contact along its direction, N: one row per contact. Zero if no force acts there.
    pub forces: DMatrix<f64>,
    /// Whether a force acts at each contact: one vector per case, one entry per contact.
    pub touching: Vec<Vec<bool>>,
    /// Nodes of the markers, in the order of the rows.
    pub markers: Vec<NodeId>,
    /// Number of draws that were repeated because the finger has no equilibrium under their forces.
    pub not_carried: usize,
}

impl Samples {
    /// Number of cases.
    pub fn count(&self) -> usize {
        self.forces.ncols()
    }
}

/// A load case with an equilibrium.
struct Case {
    drawn: Drawn,
    /// Displacements without noise, mm: x and y of each visible marker.
    displacements_mm: Vec<f64>,
    /// Number of earlier draws of this case without equilibrium.
    not_carried: usize,
}

/// One random load case.
struct Drawn {
    touching: Vec<bool>,
    forces_n: Vec<f64>,
    angles_deg: Vec<f64>,
    modulus_factor: f64,
}

impl Drawn {
    fn new(recipe: &SampleRecipe, rng: &mut ChaCha8Rng) -> Drawn {
        let count = recipe.contacts.len();
        let mut touching = vec![!recipe.any_of; count];
        if recipe.any_of {
            let chosen = rng.random_range(1..=count);
            rand::seq::index::sample(rng, count, chosen).iter().for_each(|i| touching[i] = true);
        }
        let mut forces_n: Vec<f64> = touching
            .iter()
            .map(|&touches| if touches { rng.random_range(0.0..recipe.largest_force_n) } else { 0.0 })
            .collect();
        let sum_n: f64 = forces_n.iter().sum();
        if sum_n > recipe.largest_sum_n {
            let share = rng.random_range(0.0..recipe.largest_sum_n) / sum_n;
            forces_n.iter_mut().for_each(|force| *force *= share);
        }
        let mut normal = |spread: f64| if spread > 0.0 { spread * rng.sample::<f64, _>(StandardNormal) } else { 0.0 };
        let angles_deg = recipe.contacts.iter().map(|c| c.angle_deg + normal(recipe.direction_spread_deg)).collect();
        let modulus_factor = normal(recipe.modulus_spread).exp();
        Drawn { touching, forces_n, angles_deg, modulus_factor }
    }

    /// Loads of the case, divided by the modulus factor; the effect is the same as that of a modulus multiplied by the factor.
    fn loads(&self, recipe: &SampleRecipe, mesh: &Mesh) -> Result<Vec<FrameLoad>, finray_model::mesh::LoadError> {
        let touching = (0..self.forces_n.len()).filter(|&i| self.touching[i]);
        let load = |i: usize| {
            let contact = Contact { angle_deg: self.angles_deg[i], ..recipe.contacts[i] };
            mesh.frame_load(&contact.load(mesh.finger(), self.forces_n[i] / self.modulus_factor))
        };
        touching.map(load).collect()
    }
}
