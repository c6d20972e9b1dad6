//! Random cases: forces that bend the true finger, pictures of it, and what every estimator makes of the same pictures.

use super::ScatterRequest;
use crate::estimators::{BeamEstimator, Estimator, EstimatorError, EstimatorKind, PreparedEstimator, Sensed};
use finray_model::frame::FrameMotion;
use finray_model::measurement::Measurement;
use finray_model::sensing::Contact;
use finray_model::statics::{Ladder, Statics};
use finray_model::{Finger, Kinematics, Mesh};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// A finger that carries none of so many draws in a row carries no force of the range.
const MOST_DRAWS: usize = 100;
/// Cases that share prepared estimators; threads take turns by as many.
const BLOCK: u64 = 25;
/// Noise that estimators are told of where there is none, mm: no model is exact, and to the nonlinear estimator what its
/// mesh gets wrong by some micrometres would be wild markers.
const LEAST_STATED_MM: f64 = 0.01;
/// Words of the random stream for each case: more than its draws and its noise take, so that cases do not depend on each
/// other.
const WORDS: u128 = 1 << 24;

/// One case, seen with every level of noise by every estimator.
pub(super) struct Case {
    /// True forces, N.
    pub forces_n: Vec<f64>,
    /// By level of noise.
    pictures: Vec<Picture>,
    /// Draws that were repeated because the finger does not carry them.
    pub not_carried: usize,
}

/// What is made of one picture.
struct Picture {
    /// The bound: what an estimator of the true finger states at the true shape; `None` without noise, and where the noise
    /// leaves the forces open.
    bound: Option<Sensed>,
    /// By estimator; `None` where it refused.
    sensed: Vec<Option<Sensed>>,
}

/// What one estimator makes of one picture.
pub(super) struct Look<'c> {
    /// The case.
    pub case: &'c Case,
    /// The bound of this picture.
    pub bound: Option<&'c Sensed>,
    /// What is sensed; `None` where it refused.
    pub sensed: Option<&'c Sensed>,
}

impl Case {
    /// Estimator number `estimator` at level of noise number `level`.
    pub fn look(&self, level: usize, estimator: usize) -> Look<'_> {
        let picture = &self.pictures[level];
        Look { case: self, bound: picture.bound.as_ref(), sensed: picture.sensed[estimator].as_ref() }
    }
}

/// All cases of one set of contacts in their order; none for a finger that carries no force of the range.
pub(super) fn cases(
    request: &ScatterRequest,
    estimators: &[&dyn Estimator],
    contacts: &[Contact],
    range_n: [f64; 2],
    stream: u64,
) -> Result<Vec<Case>, EstimatorError> {
    let count = request.cases as u64;
    let kind = match request.kinematics {
        Kinematics::Linear => EstimatorKind::LeastSquares,
        _ => EstimatorKind::Nonlinear,
    };
    let bound = BeamEstimator { kind, mesh: request.model };
    let run = |numbers: std::ops::Range<u64>| -> Result<Vec<Case>, EstimatorError> {
        let mut bench = Bench::new(request, &bound, estimators, contacts)?;
        Ok(numbers.filter_map(|number| bench.case(request, range_n, stream, number)).collect())
    };
    // Wrong contacts, and fingers that carry nothing, show in the first case.
    let mut all = run(0..count.min(1))?;
    if all.is_empty() {
        return Ok(all);
    }
    let blocks: Vec<u64> = (1..count).step_by(BLOCK as usize).collect();
    let rest: Result<Vec<_>, _> = blocks.into_par_iter().map(|first| run(first..(first + BLOCK).min(count))).collect();
    all.extend(rest?.into_iter().flatten());
    Ok(all)
}

/// The true finger and everything that looks at it.
struct Bench<'a> {
    finger: &'a Finger,
    mesh: &'a Mesh,
    contacts: &'a [Contact],
    statics: Statics<Ladder<'a>>,
    bound: Box<dyn PreparedEstimator + 'a>,
    estimators: Vec<Box<dyn PreparedEstimator + 'a>>,
}

impl<'a> Bench<'a> {
    fn new(
        request: &ScatterRequest<'a>,
        bound: &'a dyn Estimator,
        estimators: &[&'a dyn Estimator],
        contacts: &'a [Contact],
    ) -> Result<Bench<'a>, EstimatorError> {
        let mesh = request.truth;
        let finger = mesh.finger();
        let markers = Measurement::of_shape(finger, &mesh.shape(&FrameMotion::at_rest(mesh.frame())));
        let prepared = estimators.iter().map(|estimator| estimator.prepare(contacts, &markers));
        Ok(Bench {
            finger,
            mesh,
            contacts,
            statics: Statics::ladder(mesh, request.kinematics),
            bound: bound.prepare(contacts, &markers)?,
            estimators: prepared.collect::<Result<_, _>>()?,
        })
    }

    /// Case number `number` of the stream: its forces and noise are the same whoever looks.
    fn case(&mut self, request: &ScatterRequest, range_n: [f64; 2], stream: u64, number: u64) -> Option<Case> {
        let mut rng = ChaCha8Rng::seed_from_u64(request.seed);
        rng.set_stream(stream);
        rng.set_word_pos(WORDS * u128::from(number));
        let noise: Vec<f64> =
            (0..2 * self.finger.free_nodes().len()).map(|_| StandardNormal.sample(&mut rng)).collect();
        let (forces_n, clean, not_carried) = self.bent_at_random(range_n, &mut rng)?;
        let picture = |&noise_mm: &f64| {
            let mut seen = clean.clone();
            let mut coordinates = noise.iter();
            seen.add_noise(noise_mm, || coordinates.next().copied().unwrap_or(0.0));
            let sense = |estimator: &mut Box<dyn PreparedEstimator + 'a>| {
                estimator.estimate(&seen, Some(noise_mm.max(LEAST_STATED_MM))).ok()
            };
            let sensed = self.estimators.iter_mut().map(sense).collect();
            let bound = if noise_mm > 0.0 { self.bound.estimate(&clean, Some(noise_mm)).ok() } else { None };
            Picture { bound, sensed }
        };
        let pictures = request.noise_levels_mm.iter().map(picture).collect();
        Some(Case { forces_n, pictures, not_carried })
    }

    /// Forces that the finger carries, what the camera sees of them without noise, and how many draws it did not carry;
    /// `None` if it carries none.
    fn bent_at_random(&mut self, range_n: [f64; 2], rng: &mut impl Rng) -> Option<(Vec<f64>, Measurement, usize)> {
        for not_carried in 0..MOST_DRAWS {
            let forces_n: Vec<f64> = self.contacts.iter().map(|_| rng.random_range(range_n[0]..range_n[1])).collect();
            let load = |(c, f): (&Contact, &f64)| self.mesh.frame_load(&c.load(self.finger, *f));
            let loads = self.contacts.iter().zip(&forces_n).map(load).collect::<Result<Vec<_>, _>>().ok()?;
            if let Ok(equilibrium) = self.statics.equilibrium(&loads) {
                let seen = Measurement::of_shape(self.finger, &self.mesh.shape(&equilibrium.motion));
                return Some((forces_n, seen, not_carried));
            }
        }
        None
    }
}
