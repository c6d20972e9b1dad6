//! Number and seeds of random cases, and tolerances for random deviations.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub use finray_fixtures::CAMERA_NOISE_MM;

/// Half width of the interval that contains 95 % of a normal distribution, in standard deviations.
pub const TWO_SIDED_95: f64 = 1.96;

/// Tolerance of random deviations, in standard errors. If a run checks some hundred figures, one of them exceeds the tolerance by chance in about one
/// of a hundred runs.
pub const STANDARD_ERRORS: f64 = 4.0;

fn from_environment<T: std::str::FromStr>(name: &str, otherwise: T) -> T {
    std::env::var(name).ok().and_then(|number| number.parse().ok()).unwrap_or(otherwise)
}

/// Settings of the property tests: the same random cases on every run, or other cases with `FINRAY_TEST_SEED=<number>`. A case that
/// shows nothing, for instance because the finger cannot carry the load, is rejected, and another case is drawn. A test that rejects more than
/// `count` cases fails, because it would test little.
pub fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        cases: count,
        max_global_rejects: count,
        rng_seed: RngSeed::Fixed(from_environment("FINRAY_TEST_SEED", 2021)),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Number of cases of a statistical test: by default `few`, enough to show the fault that the test names. The environment variable
/// `FINRAY_TEST_CASES` sets another number; `FINRAY_TEST_CASES=full` means `full`.
pub fn case_count(few: usize, full: usize) -> usize {
    match std::env::var("FINRAY_TEST_CASES").as_deref() {
        Err(_) => few,
        Ok("full") => full,
        Ok(number) => number.parse().expect("FINRAY_TEST_CASES: a number, or full"),
    }
}

/// A study with at least this number of cases counts as full.
const FULL_STUDY: usize = 1000;

/// Whether `FINRAY_TEST_CASES` asks for the full study.
pub fn is_full_study() -> bool {
    case_count(0, FULL_STUDY) >= FULL_STUDY
}

/// Number of repetitions of a slow computation: `few`, or `all` in the full study.
pub fn repetitions(few: u64, all: u64) -> u64 {
    if is_full_study() { all } else { few }
}

/// Standard error of a share that is estimated from `cases` independent cases.
pub fn share_error(share: f64, cases: usize) -> f64 {
    (share * (1.0 - share) / cases as f64).sqrt()
}

/// Random numbers of one stream of a seed. The streams of a seed are independent of each other.
pub fn random_stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}
