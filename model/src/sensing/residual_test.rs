//! Chi-squared test of goodness of fit: whether the stated noise explains a residual.

use crate::measurement::Measurement;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// A noise with more degrees of freedom counts as known.
const KNOWN: f64 = 1e6;
/// Beyond this number of degrees of freedom, Student's quantile follows from its expansion (Abramowitz and Stegun, 26.7.5), with errors below 1e-8.
const MANY: f64 = 1e4;
/// Probability that a measurement with the stated noise fails the test. One false warning in a hundred frames is acceptable.
pub const SIGNIFICANCE: f64 = 0.01;

/// A p-value below this limit is a misfit: noise does not explain the residual, so the finger or its contacts differ from the scene.
const MISFIT: f64 = 1e-7;
/// A [misfit](MISFIT) counts as an error that all coordinates share. This factor multiplies the standard deviation that a shared error of the
/// residual's size would cause in a force. The fingers in the test `misfit` differ from their scene in base, zones, preload, ribs or scale, and need
/// factors of 0.1 to 5.
const MISFIT_SHARE: f64 = 2.5;

/// Comparison of a residual with the stated noise.
///
/// # Reference
/// If the model and the stated noise are correct, the sum of squared residuals divided by the variance of a coordinate follows the chi-squared
/// distribution. The degrees of freedom of the chi-squared distribution are the number of coordinates minus the number of unknowns (Press et al.,
/// Numerical Recipes, sec. 15.1). If the stated variance is itself an estimate, the ratio of the two variances follows the F distribution (sec. 14.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualTest {
    /// Standard deviation of one coordinate of weight 1, mm: the noise that the markers are expected to have.
    pub marker_noise_mm: f64,
    /// Residual standard deviation, mm: square root of the weighted sum of squares divided by the degrees of freedom.
    pub residual_sd_mm: f64,
    /// Number of measured coordinates and priors minus number of unknowns.
    pub degrees_of_freedom: usize,
    /// Degrees of freedom from which the noise was estimated, see [`Measurement::noise_degrees_of_freedom`]; infinite for a known noise.
    pub noise_degrees_of_freedom: f64,
}

impl ResidualTest {
    /// Test of a weighted sum of squared residuals, mm^2, against a known noise. `None` if the noise is not stated or zero, or if no degree of freedom
    /// remains.
    pub fn new(
        marker_noise_mm: Option<f64>,
        sum_of_squares_mm2: f64,
        degrees_of_freedom: usize,
    ) -> Option<ResidualTest> {
        let marker_noise_mm = marker_noise_mm.filter(|marker_noise_mm| *marker_noise_mm > 0.0)?;
        let residual_sd_mm = residual_sd_mm(sum_of_squares_mm2, degrees_of_freedom)?;
        Some(ResidualTest {
            marker_noise_mm,
            residual_sd_mm,
            degrees_of_freedom,
            noise_degrees_of_freedom: f64::INFINITY,
        })
    }

    /// Test of the residual of a measurement, whose noise may itself be an estimate.
    pub fn of_measurement(
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        sum_of_squares_mm2: f64,
        degrees_of_freedom: usize,
    ) -> Option<ResidualTest> {
        let test = ResidualTest::new(marker_noise_mm, sum_of_squares_mm2, degrees_of_freedom)?;
        Some(test.of_estimated_noise(measurement.noise_degrees_of_freedom()))
    }

    /// This test against a noise that was estimated from `noise_degrees_of_freedom` degrees of freedom.
    pub fn of_estimated_noise(self, noise_degrees_of_freedom: f64) -> ResidualTest {
        let is_known = noise_degrees_of_freedom > KNOWN;
        ResidualTest {
            noise_degrees_of_freedom: if is_known { f64::INFINITY } else { noise_degrees_of_freedom },
            ..self
        }
    }

    /// Probability, 0 to 1, that the stated noise causes a residual at least as large as this one.
    pub fn p_value(&self) -> f64 {
        let (degrees_of_freedom, ratio) =
            (self.degrees_of_freedom as f64, (self.residual_sd_mm / self.marker_noise_mm).powi(2));
        // There is at least one degree of freedom, so the distributions exist.
        if self.noise_degrees_of_freedom.is_finite() {
            let variance_ratio = FisherSnedecor::new(degrees_of_freedom, self.noise_degrees_of_freedom);
            return variance_ratio.map_or(f64::NAN, |variance_ratio| variance_ratio.sf(ratio));
        }
        ChiSquared::new(degrees_of_freedom).map_or(f64::NAN, |chi_squared| chi_squared.sf(degrees_of_freedom * ratio))
    }

    /// Probability, 0 to 1, that `unknowns` further unknowns reduce a residual of noise at least to `relative_residual`, the root mean square over the
    /// coordinates divided by the stated noise.
    ///
    /// # Reference
    /// F test of nested models (Draper and Smith, Applied Regression Analysis, sec. 6.1), with the noise estimated from the smaller residual and the
    /// degrees of freedom of the stated noise.
    pub fn p_value_of_reduction(&self, relative_residual: f64, unknowns: usize) -> f64 {
        let (own, stated) = (self.degrees_of_freedom as f64, self.noise_degrees_of_freedom);
        let [before, after] =
            [self.residual_sd_mm / self.marker_noise_mm, relative_residual].map(|ratio| own * ratio * ratio);
        let left = (own - unknowns as f64).max(0.0) + stated;
        let ratio = ((before - after) / unknowns as f64) / ((after + stated) / left);
        FisherSnedecor::new(unknowns as f64, left).map_or(f64::NAN, |reduction| reduction.sf(ratio.max(0.0)))
    }

    /// Residual and noise in words, with at least three decimals, so that the difference between the two has two digits.
    pub(super) fn sizes_in_words(&self) -> String {
        let [residual_mm, marker_noise_mm] = [self.residual_sd_mm, self.marker_noise_mm];
        let digits = (1.0 - (residual_mm - marker_noise_mm).abs().log10().floor()).clamp(3.0, 17.0) as usize;
        format!(
            "a residual standard deviation of {residual_mm:.digits$} mm, where {marker_noise_mm:.digits$} mm of noise is expected"
        )
    }

    /// The p-value in words. A p-value below the rounding error is stated as an upper bound.
    pub(super) fn p_in_words(&self) -> String {
        match self.p_value() {
            p if p < f64::EPSILON => format!("p < {:.0e}", f64::EPSILON),
            p => format!("p = {p:.1e}"),
        }
    }

    /// Whether the measurement contradicts the model or the stated noise.
    pub fn contradicts(&self) -> bool {
        let squared = (self.residual_sd_mm / self.marker_noise_mm).powi(2);
        // Clear cases need no gamma function. A residual below the noise has p > 0.3 for any number of degrees of freedom. The ratio of chi-squared
        // to degrees of freedom at p = 0.01 is largest for one degree of freedom: 6.63.
        (squared > 7.0 && self.noise_degrees_of_freedom.is_infinite())
            || (squared > 1.0 && self.p_value() < SIGNIFICANCE)
    }

    /// Standard deviation of a coordinate, mm, from which the standard deviations of forces follow. The result is the stated noise, or the residual
    /// standard deviation if the residual contradicts the noise. An estimated noise and the residual are pooled, and widened so that 1.96 times the
    /// result is half the width of a 95 % interval. The result is at least the stated noise, because priors are scaled by the stated noise: a smaller
    /// result would make them narrower than stated.
    ///
    /// # Reference
    /// Gelman et al., Bayesian Data Analysis, sec. 2.6: a scaled inverse chi-squared prior of a variance, and the marginal Student's t distribution.
    pub fn trusted_noise_mm(&self) -> f64 {
        if self.contradicts() {
            return self.residual_sd_mm;
        }
        let (own, stated) = (self.degrees_of_freedom as f64, self.noise_degrees_of_freedom);
        if stated.is_infinite() {
            return self.marker_noise_mm;
        }
        let pooled_mm2 = (own * self.residual_sd_mm.powi(2) + stated * self.marker_noise_mm.powi(2)) / (own + stated);
        pooled_mm2.sqrt().max(self.marker_noise_mm) * widening_by_student(own + stated)
    }

    /// Factor by which a misfit widens standard deviations that follow from [`trusted_noise_mm`](Self::trusted_noise_mm). A misfit counts as an error
    /// that all coordinates share. In contrast to the effect of noise, the effect of a shared error does not decrease with the number of coordinates.
    /// The factor is 1 without a misfit.
    pub(super) fn widening_of_misfit(&self) -> f64 {
        if !self.contradicts() || self.p_value() > MISFIT {
            return 1.0;
        }
        let misfit_mm2 = self.residual_sd_mm.powi(2) - self.marker_noise_mm.powi(2);
        let shared_mm2 = MISFIT_SHARE.powi(2) * self.degrees_of_freedom as f64 * misfit_mm2;
        (self.marker_noise_mm.powi(2) + shared_mm2).sqrt() / self.residual_sd_mm
    }
}

/// Residual standard deviation, mm; `None` without a degree of freedom.
pub(super) fn residual_sd_mm(sum_of_squares_mm2: f64, degrees_of_freedom: usize) -> Option<f64> {
    (degrees_of_freedom > 0).then(|| (sum_of_squares_mm2 / degrees_of_freedom as f64).sqrt())
}

/// Cumulative probability at the upper end of a 95 % interval.
const UPPER: f64 = 0.975;

/// Standard deviation of one coordinate, mm, if no noise is stated. The result is the residual standard deviation, widened so that 1.96 times the
/// result is half the width of a 95 % interval. `None` without a degree of freedom.
///
/// # Reference
/// A normally distributed error, divided by a standard deviation estimated from a residual, follows Student's t distribution with the residual's
/// degrees of freedom (Press et al., Numerical Recipes, sec. 15.6). The 95 % interval of Student's t distribution is wider than that of the normal
/// distribution, by a factor of 6.5 for 1 degree of freedom, 1.14 for 10, and 1.03 for 45.
pub(super) fn unstated_noise_mm(sum_of_squares_mm2: f64, degrees_of_freedom: usize) -> Option<f64> {
    Some(residual_sd_mm(sum_of_squares_mm2, degrees_of_freedom)? * widening_by_student(degrees_of_freedom as f64))
}

/// Ratio of the 95 % interval of Student's t distribution to that of the normal distribution. NaN without a degree of freedom.
fn widening_by_student(degrees_of_freedom: f64) -> f64 {
    let normal = Normal::standard().inverse_cdf(UPPER);
    // The quantile of the library does not converge for very many degrees of freedom.
    if degrees_of_freedom > MANY {
        return 1.0 + (normal * normal + 1.0) / (4.0 * degrees_of_freedom);
    }
    let student = StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::NAN, |student| student.inverse_cdf(UPPER));
    student / normal
}

/// Standard deviation of a coordinate, mm, from which the standard deviations of forces follow. The result is the stated noise, or the residual
/// standard deviation if the residual contradicts the noise. Without a stated noise, the standard deviation is [estimated from the
/// residual](unstated_noise_mm), and infinite if no degree of freedom remains.
pub(crate) fn noise_of(
    test: Option<ResidualTest>,
    stated_mm: Option<f64>,
    sum_of_squares_mm2: f64,
    degrees_of_freedom: usize,
) -> f64 {
    match (test, stated_mm) {
        (Some(test), _) => test.trusted_noise_mm(),
        (None, Some(noise_mm)) if degrees_of_freedom == 0 => noise_mm,
        // A residual cannot be tested against a noise of zero.
        (None, _) => unstated_noise_mm(sum_of_squares_mm2, degrees_of_freedom).unwrap_or(f64::INFINITY),
    }
}

#[cfg(test)]
#[path = "../../tests/units/residual_test.rs"]
mod tests;
