//! Relative scatter of measured forces about the forces estimated from images, and the resulting error of a sensed force.

use nalgebra::{DMatrix, DVector};
use statrs::function::erf::erfc;

/// The search covers relative scatters from `LEAST` to `LARGEST` in `STEPS` geometric steps.
const LEAST: f64 = 1e-5;
const LARGEST: f64 = 1.0;
const STEPS: usize = 400;
/// Number of bisections of each search.
const HALVINGS: usize = 50;
/// Half the width of a 95 % interval, in standard deviations.
const TWO_SIDED_95: f64 = 1.959_964;
/// Probability outside a 95 % interval.
const OUTSIDE: f64 = 0.05;
/// The search covers standard deviations of a new force up to this multiple of [`LARGEST`].
const FARTHEST: f64 = 10.0;
/// Iterations of the search for two variances. This number of iterations determines two variances to three digits if neither is negligible. A
/// variance that tends to zero decreases only in proportion to 1 / (number of iterations).
const ROUNDS: usize = 1000;

/// One of the statistically independent linear combinations of the relative differences between forces estimated from images and measured forces.
#[derive(Debug, Clone, PartialEq)]
struct Combination {
    /// Inverse of the variance without scatter, dimensionless. If a modulus is sought, zero for the combination that represents a common factor on
    /// all forces.
    precision: f64,
    /// Observed value of the combination, multiplied by the precision.
    seen: f64,
    /// Squared change of each new image's relative force per unit of the combination.
    carried: Vec<f64>,
    /// Squared change of each unknown that all images share per unit of the combination.
    shared: Vec<f64>,
}

/// Force estimated from one image alone as if the image were new, relative to the measured force.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NewImage {
    /// Derivative of the relative force with respect to each unknown that all images share.
    pub by_shared: DVector<f64>,
    /// Variance due to the image's own noise and base, dimensionless.
    pub variance: f64,
    /// Part of `variance` due to the noise of the markers, dimensionless.
    pub of_markers: f64,
}

/// Error that a calibrated finger adds to a force sensed in a new image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AddedForceError {
    /// Relative standard deviation of the force, dimensionless. Half of a 95 % interval is 1.96 times this value.
    pub share: f64,
    /// Added variance of the force, as a share of the force's variance due to the noise of the image's markers, dimensionless.
    pub of_markers: f64,
}

/// Comparison of forces estimated from images with measured forces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scatter {
    /// Whether only one force was measured while a modulus is sought.
    is_single: bool,
    combinations: Vec<Combination>,
    /// Variance of the relative force in each new image due to the finger's parameters, if measured forces were exact.
    of_parameters: Vec<f64>,
    /// Variance of the relative force in each new image due to the noise of its markers.
    of_markers: Vec<f64>,
    /// Variance of each unknown that all images share, if measured forces were exact.
    of_shared: Vec<f64>,
}

impl Scatter {
    /// Compares estimated with measured forces by the normal equations of the fit without measured forces, given as matrix `normal` and vector
    /// `gradient`. The first `shared` unknowns belong to all images. The last unknowns are relative forces, one for each entry of `off`. `off` lists
    /// each relative force minus its measured value.
    ///
    /// `None` if even exact forces would not determine all unknowns.
    pub fn new(
        normal: &DMatrix<f64>,
        gradient: &DVector<f64>,
        shared: usize,
        off: &DVector<f64>,
        new: &[NewImage],
    ) -> Option<Scatter> {
        let (forces, others) = (off.len(), normal.nrows() - off.len());
        let to_forces = normal.view((0, others), (others, forces)).clone_owned();
        let exact = normal.view((0, 0), (others, others)).clone_owned().cholesky()?;
        // Changes of all other unknowns per unit change of the relative forces.
        let following = -exact.solve(&to_forces);
        let precision = normal.view((others, others), (forces, forces)) + to_forces.tr_mul(&following);
        let pull = gradient.rows(others, forces) + following.tr_mul(&gradient.rows(0, others));
        let seen = &precision * off - pull;
        let independent = precision.symmetric_eigen();
        let seen = independent.eigenvectors.tr_mul(&seen);
        let shared_by = following.rows(0, shared) * &independent.eigenvectors;
        let left = exact.solve(&DMatrix::identity(others, shared)).rows(0, shared).clone_owned();
        let combination = |i: usize| Combination {
            precision: independent.eigenvalues[i].max(0.0),
            seen: seen[i],
            carried: new.iter().map(|new| new.by_shared.dot(&shared_by.column(i)).powi(2)).collect(),
            shared: shared_by.column(i).iter().map(|change| change * change).collect(),
        };
        Some(Scatter {
            is_single: forces == 1,
            combinations: (0..forces).map(combination).collect(),
            of_parameters: new.iter().map(|new| new.by_shared.dot(&(&left * &new.by_shared))).collect(),
            of_markers: new.iter().map(|new| new.of_markers).collect(),
            of_shared: left.diagonal().iter().copied().collect(),
        })
    }

    /// Logarithm of the restricted likelihood of a relative variance of measured forces.
    fn log_likelihood(&self, variance: f64) -> f64 {
        let of = |it: &Combination| {
            let wider = 1.0 + variance * it.precision;
            wider.ln() - variance * it.seen.powi(2) / wider
        };
        -0.5 * self.combinations.iter().map(of).sum::<f64>()
    }

    /// Derivative of `log_likelihood` with respect to the variance.
    fn score(&self, variance: f64) -> f64 {
        let of = |it: &Combination| {
            let wider = 1.0 + variance * it.precision;
            (it.seen / wider).powi(2) - it.precision / wider
        };
        0.5 * self.combinations.iter().map(of).sum::<f64>()
    }

    /// Number of independent combinations that are precise enough to show a relative scatter of [`LARGEST`]. A single force
    /// has none: its difference from the prior of a modulus is no scatter.
    fn differences(&self) -> usize {
        if self.is_single {
            return 0;
        }
        self.combinations.iter().filter(|it| it.precision * LARGEST * LARGEST > 1.0).count()
    }

    /// Most likely relative standard deviation of the forces; zero if noise and base explain all differences between forces. `None` if no difference
    /// between forces is precise enough to show a scatter.
    ///
    /// # Reference
    /// Restricted maximum likelihood (Patterson and Thompson, Biometrika 58, 1971) estimates the variance that independent values have in addition to
    /// their known variances.
    pub fn most_likely(&self) -> Option<f64> {
        if self.differences() == 0 {
            return None;
        }
        let tried: Vec<f64> = std::iter::once(0.0).chain(variances()).collect();
        let likelihoods: Vec<f64> = tried.iter().map(|variance| self.log_likelihood(*variance)).collect();
        let best = (0..tried.len()).max_by(|&i, &j| likelihoods[i].total_cmp(&likelihoods[j]))?;
        let (mut low, mut high) = (tried[best.saturating_sub(1)], tried[(best + 1).min(tried.len() - 1)]);
        if self.score(low) <= 0.0 {
            return Some(low.sqrt());
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.score(middle) > 0.0 { low = middle } else { high = middle }
        }
        Some((0.5 * (low + high)).sqrt())
    }

    /// Posterior of the scatter: weights and relative variances of measured forces. The prior of the scatter is uniform in the logarithm from [`LEAST`]
    /// to [`LARGEST`]. `None` if there are no differences between forces.
    fn posterior(&self) -> Option<Vec<(f64, f64)>> {
        if self.differences() == 0 {
            return None;
        }
        let likelihoods: Vec<f64> = variances().map(|variance| self.log_likelihood(variance)).collect();
        let largest = likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weighted = likelihoods.iter().zip(variances()).map(|(of, variance)| ((of - largest).exp(), variance));
        let likely: Vec<(f64, f64)> = weighted.collect();
        likely.iter().all(|(weight, _)| weight.is_finite()).then_some(likely)
    }

    /// Relative standard deviation of a new force due to scatter. Half of a 95 % interval is 1.96 times this value. The scatter is uncertain if differences are
    /// few or noise is large, so the interval averages over the posterior of the scatter. `None` if there are no differences.
    ///
    /// # Reference
    /// The result follows from the posterior predictive distribution of a normal value with an unknown variance (Gelman et al., Bayesian Data
    /// Analysis, 3rd ed., sec. 3.2). If noise is small, the posterior predictive distribution is Student's t.
    fn of_new_force(&self) -> Option<f64> {
        self.posterior().map(|likely| predictive_sd(&likely, [LEAST, FARTHEST * LARGEST]))
    }

    /// Standard deviation of an unknown (by index) that all images share, in the unit of the unknown. Half of a 95 % interval is 1.96 times this value,
    /// because the interval averages over the posterior of the scatter, as for a new force. `None` if there are no differences between forces.
    pub fn of_shared(&self, unknown: usize) -> Option<f64> {
        let of = |variance: f64| {
            let carried = |it: &Combination| it.shared[unknown] / (1.0 / variance + it.precision);
            self.of_shared[unknown] + self.combinations.iter().map(carried).sum::<f64>()
        };
        let likely = self.posterior()?.into_iter().map(|(weight, variance)| (weight, of(variance))).collect::<Vec<_>>();
        // The variance grows with the scatter.
        let bounds = [likely.first()?, likely.last()?].map(|(_, variance)| variance.sqrt());
        Some(predictive_sd(&likely, bounds))
    }

    /// Variance of the relative force in a new image due to the calibrated finger, beyond the image's own noise and base.
    fn of_finger(&self, image: usize, scatter: f64) -> f64 {
        let carried = |it: &Combination| it.carried[image] / (scatter.powi(-2) + it.precision);
        self.of_parameters[image] + self.combinations.iter().map(carried).sum::<f64>()
    }

    /// Error of a force that the calibrated finger senses in a new image, beyond the image's own noise and base. The error combines the uncertainty
    /// of the finger with the scatter of measured forces. If the images do not show the scatter, it is
    /// `assumed` for measured forces and `assumed_of_new` for a new force.
    ///
    /// An uncertain modulus changes every force by the same share. Uncertain geometry displaces markers like noise. The relative error due to
    /// geometry is larger for a small force, or for a force whose position has little effect on the markers. The parts due to modulus and geometry
    /// can be separated if images differ in the effect of noise. Otherwise each part gets half.
    pub fn of_new(&self, assumed: f64, assumed_of_new: f64) -> AddedForceError {
        let shown = self.of_new_force();
        let of_finger = |image| self.of_finger(image, shown.unwrap_or(assumed));
        let of_finger: Vec<f64> = (0..self.of_markers.len()).map(of_finger).collect();
        let [of_all, of_markers] = match self.of_shared.len() {
            // A modulus alone has no geometry beside it.
            1 => [of_finger.iter().sum::<f64>() / of_finger.len() as f64, 0.0],
            _ => shares(&of_finger, &self.of_markers),
        };
        AddedForceError { share: shown.unwrap_or(assumed_of_new).hypot(of_all.sqrt()), of_markers }
    }
}

/// Splits variances into a constant and a part proportional to `growing_with`. Returns the constant and the factor of proportionality. The constant
/// and the factor maximise the likelihood of normal errors with the given variances.
///
/// # Reference
/// Zhou, Hu, Zhou and Lange, MM algorithms for variance components models, J. Comput. Graph. Stat. 28, 2019.
fn shares(variances: &[f64], growing_with: &[f64]) -> [f64; 2] {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let mut found = [0.5 * mean(variances), 0.5 * mean(variances) / mean(growing_with)];
    if !found.iter().all(|part| *part > 0.0 && part.is_finite()) {
        return [mean(variances), 0.0];
    }
    for _ in 0..ROUNDS {
        let (mut given, mut expected) = ([0.0; 2], [0.0; 2]);
        for (variance, other) in variances.iter().zip(growing_with) {
            let model = found[0] + found[1] * other;
            for (part, by) in [1.0, *other].into_iter().enumerate() {
                given[part] += by * variance / (model * model);
                expected[part] += by / model;
            }
        }
        found = [0, 1].map(|part| found[part] * (given[part] / expected[part]).sqrt());
    }
    found
}

/// Half of the 95 % interval of a mixture of normal distributions about zero, divided by 1.96. `mixture` lists the weight and the variance of each
/// distribution. The search is confined to the values from `low` to `high`.
pub(super) fn predictive_sd(mixture: &[(f64, f64)], [mut low, mut high]: [f64; 2]) -> f64 {
    let all: f64 = mixture.iter().map(|(weight, _)| weight).sum();
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        let beyond = |variance: f64| erfc(TWO_SIDED_95 * middle / (2.0 * variance).sqrt());
        let chance: f64 = mixture.iter().map(|(weight, variance)| weight * beyond(*variance)).sum();
        if chance > OUTSIDE * all { low = middle } else { high = middle }
    }
    low
}

/// Relative variances of measured forces that a search tries.
fn variances() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|i| LEAST * (LARGEST / LEAST).powf(i as f64 / STEPS as f64)).map(|share| share * share)
}

#[cfg(test)]
#[path = "../../../tests/units/scatter.rs"]
mod tests;
