//! Sensed forces, and what is known of their error.

use super::ResidualTest;

/// Share of the largest force up to which a model error is no reason to warn: noise leaves 0.13 % of 3 N at best.
const NEGLIGIBLE: f64 = 1e-3;

/// Why an estimate is worth less than noise alone would leave it. Its standard deviations are widened by what is known of the
/// model's error; what else may be wrong (a contact elsewhere, another finger) is in none of them.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The residual is larger than the stated noise leaves.
    #[error(
        "the measurement contradicts the model: {} (chi-squared test, {} degrees of freedom, {})",
        .0.sizes_in_words(), .0.degrees_of_freedom, .0.p_in_words()
    )]
    Residual(ResidualTest),
    /// The linear finger's own error is larger than the noise's.
    #[error(
        "the linear model errs by about {:.3} N at contact {}, as a co-rotational finger under the sensed forces shows; noise \
         alone would be {:.3} N (one standard deviation)",
        .0.error_n, .0.contact, .0.sigma_n
    )]
    Linearisation(ModelError),
    /// The mesh's own error is larger than the noise's.
    #[error(
        "the mesh errs by about {:.3} N at contact {}, as one twice as fine shows; noise alone would be {:.3} N (one standard \
         deviation): use more nodes",
        .0.error_n, .0.contact, .0.sigma_n
    )]
    Discretisation(ModelError),
}

/// The error of a model where it is largest against that of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelError {
    /// Position of the contact in the list, from 1.
    pub contact: usize,
    /// The model's error, N.
    pub error_n: f64,
    /// Standard deviation that the noise gives the force, N.
    pub sigma_n: f64,
}

/// Sensed forces with what is known of their error.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Force of each contact along its direction, N, in the order of the contacts; may be negative.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N, with the model's known error. Infinite without noise and residual.
    pub sigmas_n: Vec<f64>,
    /// The model's own error in each standard deviation (linearisation, mesh, training), N; signed where that is known.
    pub model_error_n: Vec<f64>,
    /// Standard deviation of one measured coordinate that the sigmas rest on, mm: as stated, or the residual's (wider for few degrees of
    /// freedom where nothing was stated).
    pub noise_mm: f64,
    /// Why the estimate is worth less than noise alone would leave it, if so.
    pub warning: Option<Warning>,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// Singular values of the weighted compliance, mm/N, in falling order.
    pub singular_values: Vec<f64>,
}

impl Estimate {
    /// Adds to the standard deviations an error that is a share of each force, as a calibration leaves it.
    pub fn add_force_error(&mut self, share: f64) {
        for (sigma_n, force_n) in self.sigmas_n.iter_mut().zip(&self.forces_n) {
            *sigma_n = sigma_n.hypot(share * force_n);
        }
    }

    /// Adds an error of the model, N, to the noise's standard deviations; warns where it is the larger and not negligible.
    pub(super) fn add_model_error(&mut self, error_n: Vec<f64>, warning: fn(ModelError) -> Warning) {
        let largest_n = self.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let over = |i: usize| error_n[i].abs() / self.sigmas_n[i];
        let counts = |i: &usize| over(*i) > 1.0 && error_n[*i].abs() > NEGLIGIBLE * largest_n;
        let worst = (0..error_n.len()).filter(counts).max_by(|&i, &j| over(i).total_cmp(&over(j)));
        let of = |i: usize| ModelError { contact: i + 1, error_n: error_n[i], sigma_n: self.sigmas_n[i] };
        self.warning = self.warning.or(worst.map(|i| warning(of(i))));
        for (sigma, error) in self.sigmas_n.iter_mut().zip(&error_n) {
            *sigma = sigma.hypot(*error);
        }
        self.model_error_n = error_n;
    }
}
