//! Estimated forces and their known errors.

use super::ResidualTest;
use nalgebra::{DMatrix, DVector};

/// Half the width of a two-sided 95 % interval of a normal distribution, in standard deviations.
pub const TWO_SIDED_95: f64 = 1.96;

/// An error of the method up to this share of the largest force causes no warning. Noise alone causes an error of at least 0.13 % of a force of 3 N.
const NEGLIGIBLE: f64 = 1e-3;
/// A prior counts as the main source of a force if the posterior standard deviation exceeds this share of the prior's. The prior then pulls the
/// estimate by a quarter of the force towards zero.
const OF_PRIOR: f64 = 0.5;

/// Reason why an estimate is less accurate than noise alone implies. The standard deviations of the estimate include the known error of the method.
/// The standard deviations exclude other errors, such as a wrong contact or a finger that differs from the scene.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The residual exceeds the stated noise significantly.
    #[error(
        "the measurement contradicts the model: {} (chi-squared test, {} degrees of freedom, {})",
        .0.sizes_in_words(), .0.degrees_of_freedom, .0.p_in_words()
    )]
    Residual(ResidualTest),
    /// The error of linearisation exceeds the error due to noise.
    #[error(
        "the linear model causes an error of about {:.3} N at contact {} (difference from the co-rotational finger under the sensed forces); noise \
         alone causes a standard deviation of {:.3} N",
        .0.error_n, .0.contact, .0.sigma_n
    )]
    Linearisation(MethodError),
    /// The error of linearisation is unknown and not included in the standard deviations.
    #[error(
        "the linear model explains the measurement, but no forces on the co-rotational finger reproduce the linear \
            estimate; if the finger does not bend linearly, the error of linearisation is unknown"
    )]
    UnknownLinearisation,
    /// The error of the mesh exceeds the error due to noise.
    #[error(
        "the mesh causes an error of about {:.3} N at contact {} (difference from a mesh twice as fine); noise alone causes a standard deviation of \
         {:.3} N; use more mesh nodes",
        .0.error_n, .0.contact, .0.sigma_n
    )]
    Discretisation(MethodError),
    /// The prior, not the measurement, determines a force.
    #[error(
        "the measurement barely determines the force at contact {contact}: the estimate follows the assumed range of forces, whose standard deviation \
         about zero is {prior_n:.3} N"
    )]
    Prior {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Standard deviation of the prior, N.
        prior_n: f64,
    },
}

/// Error of the method at one contact. Among all contacts, this contact has the largest ratio of the method's error to the error due to noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodError {
    /// Position of the contact in the list, from 1.
    pub contact: usize,
    /// Error of the method, N.
    pub error_n: f64,
    /// Standard deviation of the force due to noise, N.
    pub sigma_n: f64,
}

/// Estimated forces with their known errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Force of each contact along the contact's direction, N, in the order of the contacts. A force may be negative.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N, including the known error of the method. Infinite if no noise is stated and no degree of freedom remains
    /// to estimate the noise from the residual.
    pub sigmas_n: Vec<f64>,
    /// Distances of the lower and the upper limit of each force's 95 % interval from the force, N, divided by [`TWO_SIDED_95`]. `None` if the
    /// intervals are symmetric, with `sigmas_n` on either side.
    pub(super) sides_n: Option<Vec<[f64; 2]>>,
    /// Covariance of the forces, N^2, in the order of the contacts. Its diagonal contains the squares of `sigmas_n`.
    pub covariance_n2: DMatrix<f64>,
    /// Error of each force due to linearisation, mesh, or training of a network, in N. Each standard deviation includes this error of the method. The
    /// error is signed if its sign is known.
    pub method_error_n: Vec<f64>,
    /// Standard deviation of one measured coordinate, mm, from which `sigmas_n` follow: the stated noise, or the residual standard deviation. Without
    /// a stated noise, the residual standard deviation is widened to account for few degrees of freedom.
    pub trusted_noise_mm: f64,
    /// Forces along and across measured normals. `None` unless a normal is measured.
    pub measured: Option<MeasuredForces>,
    /// Reason why the estimate is less accurate than noise alone implies, if any.
    pub warning: Option<Warning>,
    /// The answer in each separate range of positions that explains the measurement, the best first. Empty with fewer than two ranges.
    pub alternatives: Vec<Alternative>,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// Singular values of the weighted compliance, mm/N, in descending order.
    pub singular_values: Vec<f64>,
}

/// Forces across the directions of contacts, with the covariance of all forces. A force across is zero unless the contact's normal is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredForces {
    /// Force across the direction of each contact, positive towards the tip, N.
    pub across_n: Vec<f64>,
    /// Covariance, N^2, of all forces along the directions, followed by all forces across the directions.
    pub covariance_n2: DMatrix<f64>,
}

/// The answer in one of several ranges of positions that explain a measurement about equally well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternative {
    /// Index of the contact at an unknown position, from 0.
    pub contact: usize,
    /// Position with the smallest misfit, mm from the base.
    pub position_mm: f64,
    /// 95 % interval of the position within the range, mm from the base.
    pub position_interval_mm: [f64; 2],
    /// Direction of the force at this position, degrees from the undeformed inward normal.
    pub angle_deg: f64,
    /// Force at this position, N.
    pub force_n: f64,
    /// 95 % interval of the force within the range, N. Excludes the error of the mesh, which is the coarsest of the refinement.
    pub interval_n: [f64; 2],
    /// Excess of the misfit over the smallest misfit of all ranges, in variances of the noise: 2 ln of the ratio of the likelihoods. At most 9.
    pub excess: f64,
}

impl Alternative {
    /// Widens the interval by a relative error of the force, whose standard deviation is the dimensionless `share`.
    pub(crate) fn widen_by(&mut self, share: f64) {
        let (force_n, error_n) = (self.force_n, TWO_SIDED_95 * share * self.force_n);
        for limit_n in &mut self.interval_n {
            *limit_n = force_n + (*limit_n - force_n).hypot(error_n).copysign(*limit_n - force_n);
        }
    }
}

impl Estimate {
    /// Lower and upper limit of the 95 % interval of a force (by index), N. If the position of the contact is unknown and only weakly determined, the
    /// interval is asymmetric.
    pub fn interval_n(&self, contact: usize) -> [f64; 2] {
        let (force_n, sigma_n) = (self.forces_n[contact], self.sigmas_n[contact]);
        let [below_n, above_n] = self.sides_n.as_ref().map_or([sigma_n; 2], |sides_n| sides_n[contact]);
        [force_n - TWO_SIDED_95 * below_n, force_n + TWO_SIDED_95 * above_n]
    }

    /// Widens the interval of one force to include `interval_n`, N, and its standard deviation to at least `sd_n`, N. 1.96 times the standard deviation
    /// then reaches both limits of the interval.
    pub(super) fn widen_to(&mut self, contact: usize, sd_n: f64, interval_n: [f64; 2]) {
        let (force_n, sigma_n) = (self.forces_n[contact], self.sigmas_n[contact]);
        let sides_n =
            [force_n - interval_n[0], interval_n[1] - force_n].map(|side_n| (side_n / TWO_SIDED_95).max(sigma_n));
        let symmetric_n = || self.sigmas_n.iter().map(|sigma_n| [*sigma_n; 2]).collect();
        let all_n = self.sides_n.take().unwrap_or_else(symmetric_n);
        let needed_n = sides_n.into_iter().fold(sd_n, f64::max);
        self.add_variance(contact, needed_n.powi(2) - sigma_n.powi(2));
        self.sides_n.insert(all_n)[contact] = sides_n;
    }

    /// Widens the standard deviation of a force by an independent error, N.
    fn widen_by(&mut self, contact: usize, error_n: f64) {
        self.sigmas_n[contact] = self.sigmas_n[contact].hypot(error_n);
        let sides_n = self.sides_n.as_mut().map(|sides_n| &mut sides_n[contact]);
        sides_n.into_iter().flatten().for_each(|side_n| *side_n = side_n.hypot(error_n));
    }

    /// Widens each standard deviation by an error of `share` times the force, which all forces share. The dimensionless `share` is a result of a
    /// calibration.
    pub fn add_force_error(&mut self, share: f64) {
        if share > 0.0 {
            let errors_n: Vec<f64> = self.forces_n.iter().map(|force_n| share * force_n).collect();
            self.add_common_error(&errors_n);
            self.alternatives.iter_mut().for_each(|alternative| alternative.widen_by(share));
            if let Some(MeasuredForces { across_n, covariance_n2 }) = &mut self.measured {
                // The forces across have the same error, and its correlation with the forces along, which are in the covariance already.
                let count = across_n.len();
                let all_n: Vec<f64> = self.forces_n.iter().chain(&*across_n).map(|force_n| share * force_n).collect();
                for i in 0..2 * count {
                    for j in 0..2 * count {
                        if i >= count || j >= count {
                            covariance_n2[(i, j)] += all_n[i] * all_n[j];
                        }
                    }
                }
            }
        }
    }

    /// Warns of the force whose standard deviation is nearest to that of a prior of `prior_n`, N, if the measurement barely reduces it.
    pub(crate) fn warn_of_prior(&mut self, prior_n: f64) {
        let least_known = self.sigmas_n.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let Some((contact, sigma_n)) = least_known.filter(|(_, sigma_n)| sigma_n.is_finite()) else { return };
        if *sigma_n > OF_PRIOR * prior_n {
            self.warning = self.warning.or(Some(Warning::Prior { contact: contact + 1, prior_n }));
        }
    }

    /// Adds an error of each force, N, with one cause, so that the errors of all forces are fully correlated.
    pub(super) fn add_common_error(&mut self, errors_n: &[f64]) {
        errors_n.iter().enumerate().for_each(|(contact, error_n)| self.widen_by(contact, *error_n));
        let errors = DVector::from_column_slice(errors_n);
        self.add_covariance(&(&errors * errors.transpose()));
    }

    /// Adds a covariance of the forces along their directions, N^2, without changing the standard deviations.
    pub(super) fn add_covariance(&mut self, covariance_n2: &DMatrix<f64>) {
        self.covariance_n2 += covariance_n2;
        if let Some(measured) = &mut self.measured {
            let mut along = measured.covariance_n2.view_mut((0, 0), covariance_n2.shape());
            along += covariance_n2;
        }
    }

    /// Adds a variance, N^2, to that of one force along its direction.
    pub(crate) fn add_variance(&mut self, contact: usize, variance_n2: f64) {
        let count = self.covariance_n2.nrows();
        let mut covariance_n2 = DMatrix::zeros(count, count);
        covariance_n2[(contact, contact)] = variance_n2;
        self.add_covariance(&covariance_n2);
        self.widen_by(contact, variance_n2.sqrt());
    }

    /// If noise does not explain the residual, the finger or its contacts differ from the scene, so the standard deviations are widened.
    pub(crate) fn widen_for_misfit(&mut self) {
        if let Some(Warning::Residual(test)) = self.warning {
            let wider = test.widening_of_misfit();
            self.sigmas_n
                .iter_mut()
                .chain(self.sides_n.iter_mut().flatten().flatten())
                .for_each(|side_n| *side_n *= wider);
            self.covariance_n2 *= wider * wider;
            self.measured.iter_mut().for_each(|measured| measured.covariance_n2 *= wider * wider);
        }
    }

    /// Widens each force's standard deviation by the method's error of this force, in N. Sets a warning if such an error exceeds the standard
    /// deviation so far and is not negligible.
    pub(super) fn add_method_error(&mut self, error_n: Vec<f64>, warning: fn(MethodError) -> Warning) {
        let largest_n = self.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let over = |i: usize| error_n[i].abs() / self.sigmas_n[i];
        let counts = |i: &usize| over(*i) > 1.0 && error_n[*i].abs() > NEGLIGIBLE * largest_n;
        let worst = (0..error_n.len()).filter(counts).max_by(|&i, &j| over(i).total_cmp(&over(j)));
        let of = |i: usize| MethodError { contact: i + 1, error_n: error_n[i], sigma_n: self.sigmas_n[i] };
        self.warning = self.warning.or(worst.map(|i| warning(of(i))));
        self.add_common_error(&error_n);
        self.method_error_n = error_n;
    }
}
