//! The generator of noise and other chance: ChaCha8, in streams and samples that do not depend on each other.

use finray_model::measurement::Measurement;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Words of the random stream for each sample: more than one takes.
const WORDS: u128 = 1 << 24;

/// A measurement with a noise sample in units of the noise, two numbers a marker; without more numbers none.
pub fn with_sample(exact: &Measurement, sample: &[f64], noise_mm: f64) -> Measurement {
    let (mut noisy, mut coordinates) = (exact.clone(), sample.iter());
    noisy.add_noise(noise_mm, || coordinates.next().copied().unwrap_or(0.0));
    noisy
}

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// The first stream of a seed.
    pub fn new(seed: u64) -> Noise {
        Noise(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Another stream of a seed.
    pub fn of_stream(seed: u64, stream: u64) -> Noise {
        let mut noise = Noise::new(seed);
        noise.0.set_stream(stream);
        noise
    }

    /// Goes to a sample of the stream, which begins alike whatever was drawn before.
    pub fn go_to(&mut self, sample: u64) {
        self.0.set_word_pos(WORDS * u128::from(sample));
    }

    /// A number of mean 0 and standard deviation 1, normally distributed.
    pub fn standard_normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Standard normal numbers, `count` of them.
    pub fn standard_normals(&mut self, count: usize) -> impl Iterator<Item = f64> {
        (0..count).map(|_| self.standard_normal())
    }

    /// A number that is evenly distributed between two others.
    pub fn evenly(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.0.random_range(low..high)
    }

    /// The measurement with noise of a standard deviation (mm) on each coordinate.
    pub fn on(&mut self, exact: &Measurement, noise_mm: f64) -> Measurement {
        let mut noisy = exact.clone();
        noisy.add_noise(noise_mm, || self.standard_normal());
        noisy
    }
}
