//! By which share measured forces scatter about those that images show, and what that leaves of a force that is sensed.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Shares by which forces may scatter: from none that counts to all of them, in so many steps that are alike as ratios.
const LEAST: f64 = 1e-5;
const LARGEST: f64 = 1.0;
const STEPS: usize = 400;
/// Halvings of a step for the scatter that is most likely.
const HALVINGS: usize = 50;
/// Chance below the upper end of a 95 % interval.
const UPPER: f64 = 0.975;

/// An independent combination of the shares by which images show forces off the measured ones.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Combination {
    /// 1 / its variance without any scatter: zero of a common factor on all forces where a modulus is sought.
    precision: f64,
    /// What was seen of it, times the precision.
    seen: f64,
    /// Mean square of what it moves the force in a new image by.
    carried: f64,
}

/// Images and measured forces, against each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scatter {
    combinations: Vec<Combination>,
    /// Variance that the finger's other parameters leave of the force in a new image, in shares of it, if measured forces were exact.
    of_parameters: f64,
}

impl Scatter {
    /// From the normal equations of a fit without what was measured of its forces: matrix and gradient, of which the first `shared` unknowns belong
    /// to all images and the last ones, as many as `off` has, are the forces, as shares. `off` is by how much they are off the measured ones,
    /// `new` the change of the force in an image by itself with each of the shared unknowns, as a share.
    ///
    /// `None` if even exact forces would not show all unknowns.
    pub fn new(
        normal: &DMatrix<f64>,
        gradient: &DVector<f64>,
        shared: usize,
        off: &DVector<f64>,
        new: &[DVector<f64>],
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
        let mean = |of: &dyn Fn(&DVector<f64>) -> f64| new.iter().map(of).sum::<f64>() / new.len() as f64;
        let combination = |i: usize| Combination {
            precision: independent.eigenvalues[i].max(0.0),
            seen: seen[i],
            carried: mean(&|by_shared| by_shared.dot(&shared_by.column(i)).powi(2)),
        };
        Some(Scatter {
            combinations: (0..forces).map(combination).collect(),
            of_parameters: mean(&|by_shared| by_shared.dot(&(&left * by_shared))),
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

    /// By which share a force errs that the calibrated finger senses in a new image, beyond what the image's own noise and base leave: a standard
    /// deviation, of which 1.96 are half of a 95 % interval. It holds what is open of the finger, and a scatter, wider by as much as the
    /// chance of its own estimate asks for.
    ///
    /// # Reference
    /// A normal error over a standard deviation from so many independent differences follows Student's t distribution (Press et al., Numerical
    /// Recipes, sec. 15.6).
    pub fn of_new(&self, scatter: f64) -> f64 {
        let carried = |it: &Combination| it.carried / (scatter.powi(-2) + it.precision);
        let of_finger = self.of_parameters + self.combinations.iter().map(carried).sum::<f64>();
        // Where nothing was compared, the scatter is no estimate.
        let wider = StudentsT::new(0.0, 1.0, self.differences() as f64)
            .map_or(1.0, |student| student.inverse_cdf(UPPER) / Normal::standard().inverse_cdf(UPPER));
        (wider * scatter).hypot(of_finger.sqrt())
    }
}

/// Variances that are tried.
fn variances() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|i| LEAST * (LARGEST / LEAST).powf(i as f64 / STEPS as f64)).map(|share| share * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Combinations that noise makes so uncertain, with values in its standard deviations.
    fn scatter(noise: f64, values: &[f64]) -> Scatter {
        let precision = 1.0 / (noise * noise);
        let combination = |value: &f64| Combination { precision, seen: precision * noise * value, carried: 0.0 };
        Scatter { combinations: values.iter().map(combination).collect(), of_parameters: 0.0 }
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
        let (precision, forces) = (noise.powi(-2), off.len());
        // Rows (factor + force) / noise: what images show is off by nothing at a factor of 0.
        let by = DMatrix::from_fn(forces, 1 + forces, |i, j| if j == 0 || j == 1 + i { 1.0 / noise } else { 0.0 });
        let new = DVector::from_element(1, -1.0);
        let (off, none) = (DVector::from_row_slice(&off), DVector::zeros(1 + forces));
        let found = Scatter::new(&by.tr_mul(&by), &none, 1, &off, &[new]).unwrap();
        // Variance of four about their mean.
        let variance = off.map(|value| (value - off.mean()).powi(2)).sum() / 3.0;
        let closed = (variance - noise * noise).sqrt();
        assert!((found.most_likely().unwrap() / closed - 1.0).abs() < 1e-6, "{found:?}");
        // A new force errs with the factor, by a fourth of the variance of one, beside its own scatter.
        let carried: f64 = found.combinations.iter().map(|it| it.carried / (1.0 + it.precision)).sum();
        assert!(
            (carried - 0.25).abs() < 1e-3 && (found.of_parameters - noise * noise / 4.0).abs() < 1e-9,
            "{found:?} {precision}"
        );
    }

    /// Without noise an interval is Student's: 2.571 and 2.228 standard deviations for 5 and 10 degrees of freedom (Abramowitz and Stegun, table
    /// 26.10).
    #[test]
    fn few_forces_leave_the_scatter_open_as_students_t_has_it() {
        for (degrees_of_freedom, point) in [(5, 2.5706), (10, 2.2281)] {
            let many = scatter(1e-6, &vec![1e4; degrees_of_freedom]);
            let found = many.of_new(many.most_likely().unwrap());
            assert!((found / 0.01 * 1.959_964 / point - 1.0).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn one_force_has_nothing_to_be_compared_with() {
        let one = scatter(1e3, &[1.0]);
        assert_eq!((one.most_likely(), one.of_new(0.01)), (None, 0.01));
    }
}
