//! Generator of noise and other random numbers: ChaCha8, with independent streams and samples.

use finray_model::measurement::Measurement;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Number of 32-bit words of the random stream reserved for each sample, more than any sample needs.
const WORDS: u128 = 1 << 24;

/// `exact` plus noise: `noise_mm` (standard deviation, mm) times `sample`, which contains two standard normal numbers for each marker. Missing
/// numbers count as zero.
pub fn with_sample(exact: &Measurement, sample: &[f64], noise_mm: f64) -> Measurement {
    let (mut noisy, mut coordinates) = (exact.clone(), sample.iter());
    noisy.add_noise(noise_mm, || coordinates.next().copied().unwrap_or(0.0));
    noisy
}

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// The first random stream of a seed.
    pub fn new(seed: u64) -> Noise {
        Noise(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Stream number `stream` of a seed.
    pub fn of_stream(seed: u64, stream: u64) -> Noise {
        let mut noise = Noise::new(seed);
        noise.0.set_stream(stream);
        noise
    }

    /// Moves to sample number `sample` of the stream. The sample does not depend on earlier draws.
    pub fn go_to(&mut self, sample: u64) {
        self.0.set_word_pos(WORDS * u128::from(sample));
    }

    /// A random number from the standard normal distribution.
    pub fn standard_normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// `count` random numbers from the standard normal distribution.
    pub fn standard_normals(&mut self, count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(|_| self.standard_normal())
    }

    /// A random number, uniform between `low` and `high`.
    pub fn evenly(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.0.random_range(low..high)
    }

    /// The measurement plus noise of standard deviation `noise_mm` (mm) on each coordinate.
    pub fn on(&mut self, exact: &Measurement, noise_mm: f64) -> Measurement {
        let mut noisy = exact.clone();
        noisy.add_noise(noise_mm, || self.standard_normal());
        noisy
    }
}
