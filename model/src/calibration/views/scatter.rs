//! By which share measured forces scatter about those that images show, and what that leaves of a force that is sensed.

use nalgebra::{DMatrix, DVector};
use statrs::function::erf::erfc;

/// Shares by which forces may scatter: from none that counts to all of them, in so many steps that are alike as ratios.
const LEAST: f64 = 1e-5;
const LARGEST: f64 = 1.0;
const STEPS: usize = 400;
/// Halvings of a step for the scatter that is most likely.
const HALVINGS: usize = 50;
/// Half of a 95 % interval, in standard deviations.
pub(super) const TWO_SIDED_95: f64 = 1.959_964;
/// The chance outside it.
const OUTSIDE: f64 = 0.05;
/// A new force may be off by so many times [`LARGEST`].
const FARTHEST: f64 = 10.0;
/// Rounds of the search for two variances: enough for three digits where both count; one that is nothing falls only as 1 / rounds.
const ROUNDS: usize = 1000;

/// An independent combination of the shares by which images show forces off the measured ones.
#[derive(Debug, Clone, PartialEq)]
struct Combination {
    /// 1 / its variance without any scatter: zero of a common factor on all forces where a modulus is sought.
    precision: f64,
    /// What was seen of it, times the precision.
    seen: f64,
    /// Squares of what it moves the force in each new image by.
    carried: Vec<f64>,
}

/// The force in an image by itself, as a share of it, if that image were new: as those that a finger is calibrated on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NewImage {
    /// Its change with each of the unknowns that all images share.
    pub by_shared: DVector<f64>,
    /// Variance that the image's own noise and base leave of it.
    pub variance: f64,
    /// The part of it that is of the markers' noise.
    pub of_markers: f64,
}

/// What a calibrated finger adds to the error of a force that is sensed in a new image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AddedForceError {
    /// A share of the force: standard deviation, of which 1.96 are half of a 95 % interval.
    pub share: f64,
    /// A share of the variances of the image's markers.
    pub of_markers: f64,
}

/// Images and measured forces, against each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scatter {
    combinations: Vec<Combination>,
    /// Variances that the finger's parameters leave of the force in each new image if measured forces were exact.
    of_parameters: Vec<f64>,
    /// And those that the noise of its own markers leaves.
    of_markers: Vec<f64>,
}

impl Scatter {
    /// From the normal equations of a fit without what was measured of its forces: matrix and gradient, of which the first `shared` unknowns belong
    /// to all images and the last ones, as many as `off` has, are the forces, as shares. `off` is by how much they are off the measured ones.
    ///
    /// `None` if even exact forces would not show all unknowns.
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
        // All else follows the forces.
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
        };
        Some(Scatter {
            combinations: (0..forces).map(combination).collect(),
            of_parameters: new.iter().map(|new| new.by_shared.dot(&(&left * &new.by_shared))).collect(),
            of_markers: new.iter().map(|new| new.of_markers).collect(),
        })
    }

    /// Logarithm of the restricted likelihood of a variance.
    fn log_likelihood(&self, variance: f64) -> f64 {
        let of = |it: &Combination| {
            let wider = 1.0 + variance * it.precision;
            wider.ln() - variance * it.seen.powi(2) / wider
        };
        -0.5 * self.combinations.iter().map(of).sum::<f64>()
    }

    /// Its derivative.
    fn score(&self, variance: f64) -> f64 {
        let of = |it: &Combination| {
            let wider = 1.0 + variance * it.precision;
            (it.seen / wider).powi(2) - it.precision / wider
        };
        0.5 * self.combinations.iter().map(of).sum::<f64>()
    }

    /// How many independent differences of forces are shown.
    fn differences(&self) -> usize {
        self.combinations.iter().filter(|it| it.precision * LARGEST * LARGEST > 1.0).count()
    }

    /// The standard deviation that is most likely; zero where noise and base explain all. `None` where there is nothing to compare.
    ///
    /// # Reference
    /// Restricted maximum likelihood (Patterson and Thompson, Biometrika 58, 1971) of a variance, of independent values with known further
    /// variances.
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

    /// The scatter of a new force: a standard deviation, of which 1.96 are half of a 95 % interval. Few differences, or noise as large as they are, leave
    /// it open; it is taken for anything from [`LEAST`] to [`LARGEST`], each ratio as likely as another before, and the interval is that of all of them.
    /// `None` where there is nothing to compare.
    ///
    /// # Reference
    /// Posterior predictive distribution of a normal value with an unknown variance (Gelman et al., Bayesian Data Analysis, 3rd ed., sec. 3.2); where
    /// noise is small it is Student's.
    fn of_new_force(&self) -> Option<f64> {
        if self.differences() == 0 {
            return None;
        }
        let likelihoods: Vec<f64> = variances().map(|variance| self.log_likelihood(variance)).collect();
        let largest = likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let likely: Vec<f64> = likelihoods.iter().map(|of| (of - largest).exp()).collect();
        let all: f64 = likely.iter().sum();
        if !all.is_finite() {
            return None;
        }
        let (mut low, mut high) = (LEAST, FARTHEST * LARGEST);
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            let beyond = |variance: f64| erfc(TWO_SIDED_95 * middle / (2.0 * variance).sqrt());
            let chance =
                likely.iter().zip(variances()).map(|(likely, variance)| likely * beyond(variance)).sum::<f64>();
            if chance > OUTSIDE * all { low = middle } else { high = middle }
        }
        Some(low)
    }

    /// Variance that the calibrated finger leaves of the force in a new image, as a share, beside the image's own noise and base.
    fn of_finger(&self, image: usize, scatter: f64) -> f64 {
        let carried = |it: &Combination| it.carried[image] / (scatter.powi(-2) + it.precision);
        self.of_parameters[image] + self.combinations.iter().map(carried).sum::<f64>()
    }

    /// By what a force errs that the calibrated finger senses in a new image, beyond what the image's own noise and base leave. It holds what
    /// is open of the finger, and a scatter of measured forces, which is `assumed` where nothing shows it.
    ///
    /// What is open of a modulus is a share of every force. What is open of the geometry moves markers, as noise does, and counts where
    /// noise does: of a small force, or one whose place is hardly seen, it is a larger share. Images in which noise counts differently show which is
    /// which; where it counts alike, each has half.
    pub fn of_new(&self, assumed: f64) -> AddedForceError {
        let scatter = self.of_new_force().unwrap_or(assumed);
        let of_finger: Vec<f64> = (0..self.of_markers.len()).map(|image| self.of_finger(image, scatter)).collect();
        let [of_all, of_markers] = shares(&of_finger, &self.of_markers);
        AddedForceError { share: scatter.hypot(of_all.sqrt()), of_markers }
    }
}

/// The part of variances that is the same in all, and their part that grows with others, as a share of these: those by which normal errors of
/// the given variances would be likeliest.
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

/// Variances that are tried.
fn variances() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|i| LEAST * (LARGEST / LEAST).powf(i as f64 / STEPS as f64)).map(|share| share * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Combinations that noise makes so uncertain, with values in its standard deviations.
    fn scatter(noise: f64, values: &[f64]) -> Scatter {
        let precision = 1.0 / (noise * noise);
        let combination = |value: &f64| Combination { precision, seen: precision * noise * value, carried: vec![0.0] };
        Scatter {
            combinations: values.iter().map(combination).collect(),
            of_parameters: vec![0.0],
            of_markers: vec![noise * noise],
        }
    }

    /// Balanced one-way random effects: mean square less the variance within, and nothing where that is negative (Searle, Casella and McCulloch,
    /// Variance Components, 1992, sec. 3.8).
    #[test]
    fn a_balanced_variance_component_has_its_closed_form() {
        let noise = 0.01;
        for values in [vec![3.0, -2.0, 1.0, -2.0], vec![1.1, -0.9, 1.2, -0.9], vec![0.5, -0.2, 0.4, 0.1]] {
            let mean_square =
                noise * noise * values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
            let closed = (mean_square - noise * noise).max(0.0).sqrt();
            let found = scatter(noise, &values).most_likely().unwrap();
            assert!((found - closed).abs() < 1e-9, "{found} for {closed}");
        }
    }

    /// From matrices: forces that images show to a share `noise` each, up to a factor that they share.
    #[test]
    fn normal_equations_show_differences_of_forces() {
        let (noise, off) = (0.01_f64, [0.03, -0.01, 0.02, 0.0]);
        let forces = off.len();
        // Rows (factor + force) / noise: what images show is off by nothing at a factor of 0.
        let by = DMatrix::from_fn(forces, 1 + forces, |i, j| if j == 0 || j == 1 + i { 1.0 / noise } else { 0.0 });
        let new =
            NewImage { by_shared: DVector::from_element(1, -1.0), variance: noise * noise, of_markers: noise * noise };
        let (off, none) = (DVector::from_row_slice(&off), DVector::zeros(1 + forces));
        let found = Scatter::new(&by.tr_mul(&by), &none, 1, &off, &[new]).unwrap();
        // Variance of four about their mean.
        let variance = off.map(|value| (value - off.mean()).powi(2)).sum() / 3.0;
        let closed = (variance - noise * noise).sqrt();
        assert!((found.most_likely().unwrap() / closed - 1.0).abs() < 1e-6, "{found:?}");
        // A new force errs with the factor, by a fourth of the variance of one, beside its own scatter.
        assert!((found.of_finger(0, 1.0) - 0.25).abs() < 1e-3, "{found:?}");
        assert!((found.of_parameters[0] - noise * noise / 4.0).abs() < 1e-9, "{found:?}");
    }

    /// Without noise an interval is Student's: 2.571 and 2.228 standard deviations for 5 and 10 degrees of freedom (Abramowitz and Stegun, table
    /// 26.10).
    #[test]
    fn few_forces_leave_the_scatter_open_as_students_t_has_it() {
        for (degrees_of_freedom, point) in [(5, 2.5706), (10, 2.2281)] {
            let many = scatter(1e-6, &vec![1e4; degrees_of_freedom]);
            let found = many.of_new(f64::NAN).share;
            assert!((found / 0.01 * 1.959_964 / point - 1.0).abs() < 1e-4, "{found}");
        }
    }

    /// Ten forces, of which images show some ten times as well as others, over many draws: 95 % intervals of a new one hold it in 91 to 98.5 %, whether
    /// forces scatter by nothing, by as much as noise, or by far more.
    #[test]
    fn intervals_hold_whatever_the_scatter() {
        const DRAWS: usize = 200;
        let chance = &mut ChaCha8Rng::seed_from_u64(1);
        for true_scatter in [0.0_f64, 3e-4, 8e-4, 3e-3] {
            let mut within = 0.0;
            for _ in 0..DRAWS {
                let combinations = (0..9).map(|_| {
                    let noise = 2.5e-4 * 10.0_f64.powf(chance.random());
                    let normal: f64 = StandardNormal.sample(chance);
                    let precision = noise.powi(-2);
                    Combination { precision, seen: precision * noise.hypot(true_scatter) * normal, carried: vec![0.0] }
                });
                let combinations = combinations.collect();
                let found = Scatter { combinations, of_parameters: vec![0.0], of_markers: vec![1.0] }.of_new_force();
                let noise = 2.5e-4 * 4.0_f64.powf(chance.random());
                let stated = found.expect("nine differences").hypot(noise);
                within +=
                    (1.0 - erfc(TWO_SIDED_95 * stated / (2.0_f64.sqrt() * true_scatter.hypot(noise)))) / DRAWS as f64;
            }
            assert!((0.91..0.985).contains(&within), "{within} of {true_scatter}");
        }
    }

    #[test]
    fn one_force_has_nothing_to_be_compared_with() {
        let one = scatter(1e3, &[1.0]);
        assert_eq!((one.most_likely(), one.of_new(0.01)), (None, AddedForceError { share: 0.01, of_markers: 0.0 }));
    }

    /// Variances that are made of both parts lead back to both; where all are alike, or fall with noise, none of it grows.
    #[test]
    fn what_grows_with_noise_is_told_from_a_share_of_the_force() {
        let noise = [1e-4, 4e-4, 9e-4, 16e-4];
        let both = noise.map(|noise| 2e-6 + 0.05 * noise);
        let [of_all, of_noise] = shares(&both, &noise);
        assert!((of_all / 2e-6 - 1.0).abs() < 0.01 && (of_noise / 0.05 - 1.0).abs() < 0.01, "{of_all} {of_noise}");
        for alike in [[3e-6; 4], [4e-6, 3e-6, 2e-6, 1e-6]] {
            let [of_all, of_noise] = shares(&alike, &noise);
            let mean = alike.iter().sum::<f64>() / 4.0;
            assert!((of_all / mean - 1.0).abs() < 0.05 && of_noise * noise[3] < 0.05 * of_all, "{of_all} {of_noise}");
        }
        // Where noise counts alike in all, nothing tells them apart.
        let [of_all, of_noise] = shares(&[3e-6; 4], &[1e-4; 4]);
        assert!((of_all / 1.5e-6 - 1.0).abs() < 1e-9 && (of_noise / 1.5e-2 - 1.0).abs() < 1e-9, "{of_all} {of_noise}");
        assert_eq!(shares(&[0.0; 4], &noise), [0.0; 2]);
    }
}
