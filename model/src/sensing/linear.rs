//! Linear estimators: least squares, without and with a prior on the forces (ridge).

use super::linearisation::{LinearModel, Linearisation, weighted};
use super::residual_test::{ResidualTest, noise_of, unstated_noise_mm};
use super::{Contact, Estimate, LARGEST_SPAN, SensingError, Warning, check_contacts};
use crate::compliance::{Compliance, NodalCompliance};
use crate::finger::Finger;
use crate::measurement::Measurement;
use crate::mesh::Load;
use crate::optimise::SingularParts;
use crate::statics::StaticsError;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// A measurement is attributed to a linear finger if the linear finger's sum of squared residuals is clearly smaller than the co-rotational finger's.
/// The difference must exceed this number of noise variances. Nine variances correspond to three standard deviations.
const FAVOURED: f64 = 9.0;

/// Without a stated noise, the linear finger is assumed to explain a measurement if the residual is at most this share of the displacements. The
/// limit applies only if no forces on the co-rotational finger reproduce the linear estimate. If this limit applies, the displacements are so large
/// that the camera noise is below this share of them. If a co-rotational finger caused the displacements, the residual of the linear finger would be
/// about ten times this share.
const EXPLAINED_SHARE: f64 = 0.01;

/// Number of steps per factor of two to which an estimated noise is rounded.
const STEPS_PER_OCTAVE: f64 = 16.0;

/// Prior distribution of the forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ForcePrior {
    /// No prior: least squares.
    None,
    /// Normal distribution about zero: ridge regression.
    Gaussian {
        /// Standard deviation of a force, N.
        force_n: f64,
    },
}

impl ForcePrior {
    /// Prior for the forces of Xu et al. (2021, sec. IV-A), which are drawn from 0 to 5 N per node. The standard deviation of the prior is the root
    /// mean square of these forces, 5 / sqrt(3) = 2.9 N.
    pub const PAPER: ForcePrior = ForcePrior::Gaussian { force_n: 2.886_751_345_948_129 };
}

/// Weighted linear least squares on the linear finger, for contacts of known position and direction.
///
/// # Requirements
/// There must be at least as many measured coordinates as contacts. The ratio of the largest to the smallest singular value must be at most
/// [`LARGEST_SPAN`].
///
/// # Reference
/// Minimises |W (u - C f)|^2 with the measured displacements u and the weights W. C is the compliance of eq. (5) of Xu et al. (2021) at the markers
/// and contacts. A prior of standard deviation p adds the term |f|^2 s^2 / p^2, where s is the noise (Hoerl and Kennard 1970). If s is estimated from the
/// residual, it is rounded to within 2.2 % in this term. With a prior, the standard deviations refer to the posterior distribution.
#[derive(Debug, Clone)]
pub struct LinearEstimator {
    /// Weighted compliance W C, mm/N: two rows (x, y) per marker, one column per contact.
    compliance: DMatrix<f64>,
    least_squares: Inverse,
    singular_values: Vec<f64>,
}

impl LinearEstimator {
    /// Prepares the problem for the nodes and weights of a measurement's markers. The displacements of the markers are not used yet.
    ///
    /// # Errors
    /// [`SensingError`] if a contact is wrong or the forces are not identifiable.
    pub fn new(finger: &Finger, contacts: &[Contact], markers: &Measurement) -> Result<LinearEstimator, SensingError> {
        LinearEstimator::prepared(finger, contacts, markers, |loads| Compliance::new(finger, loads))
    }

    /// Like [`LinearEstimator::new`], but with the compliance of `solved`, an already solved finger. Results agree up to rounding.
    ///
    /// # Errors
    /// [`SensingError`] if a contact is wrong or the forces are not identifiable.
    pub fn on(
        solved: &NodalCompliance,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<LinearEstimator, SensingError> {
        LinearEstimator::prepared(solved.finger(), contacts, markers, |loads| solved.columns(loads))
    }

    fn prepared(
        finger: &Finger,
        contacts: &[Contact],
        markers: &Measurement,
        compliance: impl FnOnce(&[Load]) -> Result<Compliance, StaticsError>,
    ) -> Result<LinearEstimator, SensingError> {
        check_contacts(finger, contacts)?;
        let (unknowns, coordinates) = (contacts.len(), markers.coordinate_count());
        if unknowns > coordinates {
            return Err(SensingError::TooFewMarkers { unknowns, coordinates });
        }
        let unit_loads: Vec<Load> = contacts.iter().map(|contact| contact.unit_load(finger)).collect();
        let compliance = compliance(&unit_loads)?;
        let matrix = DMatrix::from_fn(coordinates, unknowns, |row, column| {
            let marker = &markers.markers()[row / 2];
            marker.weight * compliance.displacement(marker.node, column)[row % 2]
        });
        let singular_values = identifiable(&matrix)?;
        let least_squares = Inverse::of(&matrix, 0.0);
        Ok(LinearEstimator { compliance: matrix, least_squares, singular_values })
    }

    /// Singular values of the weighted compliance, mm/N, in descending order.
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// Least-squares inverse. The inverse maps displacements to forces, and the noise to standard deviations of the forces.
    pub fn inverse(&self) -> &Inverse {
        &self.least_squares
    }

    /// Estimates the forces from the displacements of the markers for which the estimator is prepared.
    ///
    /// `marker_noise_mm` is the standard deviation of one coordinate, mm. If `marker_noise_mm` is `None` or zero, the noise is estimated from the
    /// residual. If the residual contradicts the stated noise, the estimate contains a warning, and its standard deviations follow from the residual.
    /// Only [`estimate_on`](LinearEstimator::estimate_on) includes the error of linearisation.
    pub fn estimate(&self, measurement: &Measurement, marker_noise_mm: Option<f64>, prior: ForcePrior) -> Estimate {
        self.solve(measurement, marker_noise_mm, prior).0
    }

    /// Like [`estimate`](LinearEstimator::estimate), but for a co-rotational finger. The standard deviations include the error of linearisation at
    /// the estimated forces, unless a linear finger explains the measurement clearly better.
    ///
    /// # Errors
    /// [`SensingError::NotLinearised`] if the error of linearisation cannot be computed and the linear finger does not explain the measurement.
    pub fn estimate_on(
        &self,
        linearisation: &mut Linearisation,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        prior: ForcePrior,
    ) -> Result<Estimate, SensingError> {
        let (mut estimate, inverse) = self.solve(measurement, marker_noise_mm, prior);
        let (coordinates, unknowns) = self.compliance.shape();
        let degrees_of_freedom = coordinates - unknowns;
        if estimate.trusted_noise_mm.is_infinite() {
            // Unknown noise makes all standard deviations infinite, so the error of linearisation has no effect.
            return Ok(estimate);
        }
        let model = LinearModel { gain: &inverse.gain, compliance: &self.compliance };
        let stated_mm = marker_noise_mm.filter(|noise_mm| *noise_mm > 0.0);
        let linear_mm2 = estimate.residual_rms_mm.powi(2) * coordinates as f64;
        let error = match linearisation.error(model, measurement, &estimate.forces_n) {
            // A linear finger has an equilibrium under any force, and the measurement does not contradict the linear finger.
            Err(SensingError::NotLinearised) if estimate.warning.is_none() => {
                let moved_mm2 = weighted(measurement, |marker| marker.displacement).norm_squared();
                if marker_noise_mm.is_none() && linear_mm2 > EXPLAINED_SHARE.powi(2) * moved_mm2 {
                    return Err(SensingError::NotLinearised);
                }
                estimate.warning = Some(Warning::UnknownLinearisation);
                return Ok(estimate);
            }
            error => error?,
        };
        // Without a stated noise, the noise is estimated from the residual of the linear finger.
        let noise_mm2 = stated_mm.map_or(linear_mm2 / degrees_of_freedom.max(1) as f64, |noise_mm| noise_mm.powi(2));
        let favoured_mm2 = FAVOURED * noise_mm2;
        if degrees_of_freedom > 0 && linear_mm2 + favoured_mm2 < error.sum_of_squares_mm2 {
            // If neither the linear nor the co-rotational finger explains the measurement, the finger may have buckled. The error of the force is
            // then unknown and can exceed the force.
            estimate.widen_for_misfit();
            return Ok(estimate);
        }
        // A residual that linearisation does not explain is due to noise or to another error of the model.
        let test = ResidualTest::of_measurement(measurement, stated_mm, error.sum_of_squares_mm2, degrees_of_freedom);
        let residual_mm = || unstated_noise_mm(error.sum_of_squares_mm2, degrees_of_freedom);
        let trusted_mm = test.map(|test| test.trusted_noise_mm());
        estimate.trusted_noise_mm = trusted_mm.or(stated_mm).or_else(residual_mm).unwrap_or(estimate.trusted_noise_mm);
        estimate.sigmas_n = inverse.sigmas_n(estimate.trusted_noise_mm);
        estimate.covariance_n2 = inverse.covariance_n2(estimate.trusted_noise_mm);
        if let Some(test) = test.filter(ResidualTest::contradicts) {
            estimate.warning = Some(Warning::Residual(test));
            estimate.widen_for_misfit();
        }
        estimate.add_method_error(error.error_n, Warning::Linearisation);
        Ok(estimate)
    }

    /// An estimate, and the inverse from which the estimate follows.
    fn solve(
        &self,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        prior: ForcePrior,
    ) -> (Estimate, Cow<'_, Inverse>) {
        let displacements = weighted(measurement, |marker| marker.displacement);
        let (coordinates, unknowns) = self.compliance.shape();
        let degrees_of_freedom = coordinates - unknowns;
        let sum_of_squares = |forces: &DVector<f64>| {
            let explained = |row| (0..unknowns).map(|k| self.compliance[(row, k)] * forces[k]).sum::<f64>();
            (0..coordinates).map(|row| (displacements[row] - explained(row)).powi(2)).sum::<f64>()
        };
        let unbiased = &self.least_squares.gain * &displacements;
        // The test uses the residual of the least-squares forces, without the prior, because no other forces have a smaller residual.
        let least_mm2 = sum_of_squares(&unbiased);
        let test = ResidualTest::of_measurement(measurement, marker_noise_mm, least_mm2, degrees_of_freedom);
        let trusted_noise_mm = noise_of(test, marker_noise_mm, least_mm2, degrees_of_freedom);
        let (forces, inverse) = match prior {
            ForcePrior::Gaussian { force_n } if trusted_noise_mm > 0.0 && trusted_noise_mm.is_finite() => {
                let ridge_mm = if marker_noise_mm == Some(trusted_noise_mm) {
                    trusted_noise_mm
                } else {
                    rounded_noise_mm(trusted_noise_mm)
                };
                let ridge = Inverse::of(&self.compliance, ridge_mm / force_n);
                (&ridge.gain * &displacements, Cow::Owned(ridge))
            }
            _ => (unbiased, Cow::Borrowed(&self.least_squares)),
        };
        let estimate = Estimate {
            residual_rms_mm: (sum_of_squares(&forces) / coordinates as f64).sqrt(),
            forces_n: forces.iter().copied().collect(),
            sigmas_n: inverse.sigmas_n(trusted_noise_mm),
            covariance_n2: inverse.covariance_n2(trusted_noise_mm),
            sides_n: None,
            method_error_n: vec![0.0; unknowns],
            measured: None,
            alternatives: Vec::new(),
            trusted_noise_mm,
            warning: test.filter(ResidualTest::contradicts).map(Warning::Residual),
            singular_values: self.singular_values.clone(),
        };
        (estimate, inverse)
    }
}

/// Rounds a noise that is estimated from a residual, so that samples of similar noise have the same ridge, and thus the same error of linearisation. The
/// noise changes by at most 2.2 %. With 46 coordinates, the estimate of the noise from the residual has a standard deviation of 10 %.
fn rounded_noise_mm(noise_mm: f64) -> f64 {
    ((noise_mm.log2() * STEPS_PER_OCTAVE).round() / STEPS_PER_OCTAVE).exp2()
}

/// Least-squares inverse of a linear problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverse {
    /// Matrix from weighted displacements (two per marker, mm) to forces (N), N/mm: one row per force.
    pub gain: DMatrix<f64>,
    /// Standard deviation of each force per mm of noise, N/mm: the square roots of the diagonal of `covariance_per_noise2`.
    pub sigmas_per_noise: Vec<f64>,
    /// Covariance of the forces per squared noise, N^2/mm^2: (C^T W^2 C + ridge^2)^-1.
    pub covariance_per_noise2: DMatrix<f64>,
}

impl Inverse {
    /// Standard deviation of each force, N, under noise of `noise_mm`.
    fn sigmas_n(&self, noise_mm: f64) -> Vec<f64> {
        self.sigmas_per_noise.iter().map(|per_mm| per_mm * noise_mm).collect()
    }

    /// Covariance of the forces, N^2, under noise of `noise_mm`.
    fn covariance_n2(&self, noise_mm: f64) -> DMatrix<f64> {
        &self.covariance_per_noise2 * (noise_mm * noise_mm)
    }

    /// Computes the inverse by QR decomposition of a matrix: the compliance, and below it `ridge` (mm/N) times the identity. The columns of this matrix are
    /// scaled to unit length.
    pub(super) fn of(compliance: &DMatrix<f64>, ridge: f64) -> Inverse {
        let (rows, columns) = compliance.shape();
        if columns == 1 {
            // For a single column, the QR factor Q is the unit vector along the column, and R is the column's length.
            let norm = compliance.norm();
            let length = norm.hypot(ridge);
            return Inverse {
                gain: (compliance / norm).transpose() * (norm / length / length),
                sigmas_per_noise: vec![1.0 / length],
                covariance_per_noise2: DMatrix::from_element(1, 1, (1.0 / length).powi(2)),
            };
        }
        let mut stacked = compliance.clone().resize_vertically(rows + if ridge > 0.0 { columns } else { 0 }, 0.0);
        for k in 0..stacked.nrows() - rows {
            stacked[(rows + k, k)] = ridge;
        }
        let scales: Vec<f64> = stacked.column_iter().map(|column| column.norm()).collect();
        for (mut column, scale) in stacked.column_iter_mut().zip(&scales) {
            column /= *scale;
        }
        let qr = stacked.qr();
        let mut inverse_triangle = DMatrix::identity(columns, columns);
        // The test of the singular values has ensured full rank, and the rows of the prior do not reduce the rank.
        qr.r().solve_upper_triangular_mut(&mut inverse_triangle);
        for (mut row, scale) in inverse_triangle.row_iter_mut().zip(&scales) {
            row /= *scale;
        }
        Inverse {
            gain: &inverse_triangle * qr.q().rows(0, rows).transpose(),
            sigmas_per_noise: inverse_triangle.row_iter().map(|row| row.norm()).collect(),
            covariance_per_noise2: &inverse_triangle * inverse_triangle.transpose(),
        }
    }
}

/// Singular values of the weighted compliance, mm/N, in descending order. Returns [`SensingError::IllConditioned`] if the forces are not
/// identifiable. All unknowns are forces in N and all rows have the same noise, so no scaling is needed. For twelve normal forces on the paper's
/// finger, the largest singular value is 363 times the smallest.
fn identifiable(compliance: &DMatrix<f64>) -> Result<Vec<f64>, SensingError> {
    if compliance.ncols() == 1 {
        // A matrix with a single column has one singular value: the length of the column.
        let length = compliance.norm();
        return match length > 0.0 && length.is_finite() {
            true => Ok(vec![length]),
            false => Err(SensingError::IllConditioned { span: f64::INFINITY, limit: LARGEST_SPAN, weakest: 1 }),
        };
    }
    let parts = SingularParts::of(compliance.clone());
    let span = parts.span();
    if span <= LARGEST_SPAN {
        return Ok(parts.descending());
    }
    // If a force moves no marker, the ratio of the singular values is infinite.
    let span = if span.is_nan() { f64::INFINITY } else { span };
    Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest: parts.weakest().iamax() + 1 })
}
