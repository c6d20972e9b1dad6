//! Linear estimators: least squares, and least squares with a prior on the forces (ridge).

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

/// A measurement that the linear finger explains better than the co-rotational one by more than this, in squared standard
/// deviations of the noise, is of a finger that bends linearly: a difference of three standard deviations.
const FAVOURED: f64 = 9.0;

/// Prior of the forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Nothing: least squares.
    None,
    /// Forces scatter about zero with this standard deviation, N: ridge regression.
    Gaussian {
        /// Standard deviation of a force, N.
        force_n: f64,
    },
}

impl Prior {
    /// The paper draws its forces from 0 to 5 N a node (sec. IV-A): their root mean square is 5 / sqrt(3) = 2.9 N.
    pub const PAPER: Prior = Prior::Gaussian { force_n: 2.886_751_345_948_129 };
}

/// Weighted linear least squares for known contacts and directions on the linear finger.
///
/// # Requirements
/// As many measured coordinates as contacts, and singular values that span at most [`LARGEST_SPAN`].
///
/// # Reference
/// Minimises |W (u - C f)|^2, with u the measured displacements, C the compliance of eq. (5) of Xu et al. (2021) at the
/// markers and contacts, W the weights. With a prior of standard deviation p and noise s, |f|^2 s^2 / p^2 is added
/// (Hoerl and Kennard 1970); the sigmas are then those of the posterior.
#[derive(Debug, Clone)]
pub struct LinearEstimator {
    /// Weighted compliance W C, 2 rows (x, y) a marker, a column a contact, mm/N.
    compliance: DMatrix<f64>,
    least_squares: Inverse,
    singular_values: Vec<f64>,
}

impl LinearEstimator {
    /// Prepares the problem for the markers of a measurement; their displacements are not used yet.
    ///
    /// # Errors
    /// [`SensingError`] when a contact is wrong or the problem has no unique answer.
    pub fn new(finger: &Finger, contacts: &[Contact], markers: &Measurement) -> Result<LinearEstimator, SensingError> {
        LinearEstimator::prepared(finger, contacts, markers, |loads| Compliance::new(finger, loads))
    }

    /// As [`LinearEstimator::new`], to rounding, on a finger that is solved already.
    ///
    /// # Errors
    /// [`SensingError`] when a contact is wrong or the problem has no unique answer.
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

    /// Singular values of the weighted compliance, mm/N, in falling order.
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// The least-squares inverse: what turns displacements into forces, and noise into their errors.
    pub fn inverse(&self) -> &Inverse {
        &self.least_squares
    }

    /// Estimates the forces from the displacements of the markers that the estimator was prepared for.
    ///
    /// `noise_mm` is the standard deviation of one coordinate; without it (or if it is zero), it is estimated from the
    /// residual. Where the residual contradicts it, the estimate warns, and its standard deviations rest on the residual.
    /// Errors of the linear finger are [`estimate_on`](LinearEstimator::estimate_on)'s.
    pub fn estimate(&self, measurement: &Measurement, noise_mm: Option<f64>, prior: Prior) -> Estimate {
        self.solve(measurement, noise_mm, prior).0
    }

    /// As [`estimate`](LinearEstimator::estimate), of a co-rotational finger: the error of linearisation is found from the
    /// estimated forces and added to their standard deviations, unless the measurement shows a finger that bends linearly.
    ///
    /// # Errors
    /// [`SensingError::NotLinearised`] where that error cannot be found and nothing shows that the finger is linear.
    pub fn estimate_on(
        &self,
        linearisation: &mut Linearisation,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        prior: Prior,
    ) -> Result<Estimate, SensingError> {
        let (mut estimate, inverse) = self.solve(measurement, noise_mm, prior);
        let (coordinates, unknowns) = self.compliance.shape();
        let degrees_of_freedom = coordinates - unknowns;
        if estimate.noise_mm.is_infinite() {
            // Nothing is known of the noise, so of the forces neither.
            return Ok(estimate);
        }
        let model = LinearModel { gain: &inverse.gain, compliance: &self.compliance };
        let error = match linearisation.error(model, measurement, &estimate.forces_n) {
            // Nothing speaks against the linear finger, which carries any force.
            Err(SensingError::NotLinearised) if estimate.warning.is_none() && noise_mm.is_some() => {
                return Ok(estimate);
            }
            error => error?,
        };
        let stated_mm = noise_mm.filter(|noise_mm| *noise_mm > 0.0);
        let linear_mm2 = estimate.residual_rms_mm.powi(2) * coordinates as f64;
        // Where no noise is stated, the residual of the linear finger is it, if this finger is the true one.
        let noise_mm2 = stated_mm.map_or(linear_mm2 / degrees_of_freedom.max(1) as f64, |noise_mm| noise_mm.powi(2));
        let favoured_mm2 = FAVOURED * noise_mm2;
        if degrees_of_freedom > 0 && linear_mm2 + favoured_mm2 < error.sum_of_squares_mm2 {
            return Ok(estimate);
        }
        // What linearisation leaves unexplained of the residual is noise, or something else that is wrong.
        let test = ResidualTest::new(stated_mm, error.sum_of_squares_mm2, degrees_of_freedom);
        let residual_mm = || unstated_noise_mm(error.sum_of_squares_mm2, degrees_of_freedom);
        let trusted_mm = test.map(|test| test.trusted_noise_mm());
        estimate.noise_mm = trusted_mm.or(stated_mm).or_else(residual_mm).unwrap_or(estimate.noise_mm);
        estimate.sigmas_n = inverse.sigmas_per_noise.iter().map(|per_mm| per_mm * estimate.noise_mm).collect();
        estimate.add_model_error(error.error_n, Warning::Linearisation);
        Ok(estimate)
    }

    /// An estimate, and the inverse that it was made with.
    fn solve(&self, measurement: &Measurement, noise_mm: Option<f64>, prior: Prior) -> (Estimate, Cow<'_, Inverse>) {
        let displacements = weighted(measurement, |marker| marker.displacement);
        let (coordinates, unknowns) = self.compliance.shape();
        let degrees_of_freedom = coordinates - unknowns;
        let sum_of_squares = |forces: &DVector<f64>| {
            let explained = |row| (0..unknowns).map(|k| self.compliance[(row, k)] * forces[k]).sum::<f64>();
            (0..coordinates).map(|row| (displacements[row] - explained(row)).powi(2)).sum::<f64>()
        };
        let unbiased = &self.least_squares.gain * &displacements;
        // What least squares leaves is the least that any forces leave, so a prior takes no part in the test.
        let least_mm2 = sum_of_squares(&unbiased);
        let test = ResidualTest::new(noise_mm, least_mm2, degrees_of_freedom);
        let noise_mm = noise_of(test, noise_mm, least_mm2, degrees_of_freedom);
        let (forces, inverse) = match prior {
            Prior::Gaussian { force_n } if noise_mm > 0.0 && noise_mm.is_finite() => {
                let ridge = Inverse::of(&self.compliance, noise_mm / force_n);
                (&ridge.gain * &displacements, Cow::Owned(ridge))
            }
            _ => (unbiased, Cow::Borrowed(&self.least_squares)),
        };
        let estimate = Estimate {
            residual_rms_mm: (sum_of_squares(&forces) / coordinates as f64).sqrt(),
            forces_n: forces.iter().copied().collect(),
            sigmas_n: inverse.sigmas_per_noise.iter().map(|sigma| sigma * noise_mm).collect(),
            model_error_n: vec![0.0; unknowns],
            noise_mm,
            warning: test.filter(ResidualTest::contradicts).map(Warning::Residual),
            singular_values: self.singular_values.clone(),
        };
        (estimate, inverse)
    }
}

/// Inverse of a linear problem in the sense of least squares.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverse {
    /// Turns weighted displacements (2 a marker, mm) into forces (N): a row a force, N/mm.
    pub gain: DMatrix<f64>,
    /// Standard deviation of each force over a coordinate's, N/mm: roots of the diagonal of (C^T W^2 C + ridge^2)^-1.
    pub sigmas_per_noise: Vec<f64>,
}

impl Inverse {
    /// By QR of the compliance stacked on `ridge` times the identity, columns scaled to unit length.
    pub(super) fn of(compliance: &DMatrix<f64>, ridge: f64) -> Inverse {
        let (rows, columns) = compliance.shape();
        if columns == 1 {
            // The unit vector along the only column is its Q, its length its R.
            let norm = compliance.norm();
            let length = norm.hypot(ridge);
            return Inverse {
                gain: (compliance / norm).transpose() * (norm / length / length),
                sigmas_per_noise: vec![1.0 / length],
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
        // Full rank was made sure of by the singular values; the prior only adds to it.
        qr.r().solve_upper_triangular_mut(&mut inverse_triangle);
        for (mut row, scale) in inverse_triangle.row_iter_mut().zip(&scales) {
            row /= *scale;
        }
        Inverse {
            gain: &inverse_triangle * qr.q().rows(0, rows).transpose(),
            sigmas_per_noise: inverse_triangle.row_iter().map(|row| row.norm()).collect(),
        }
    }
}

/// Singular values of the problem, if they leave a unique answer. All unknowns are forces in N and all rows share one
/// noise, so nothing is left to scale: twelve normal forces on the paper's finger span 363.
fn identifiable(compliance: &DMatrix<f64>) -> Result<Vec<f64>, SensingError> {
    if compliance.ncols() == 1 {
        // The singular value of one column is its length.
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
    // A force that moves no marker at all spans infinitely much.
    let span = if span.is_nan() { f64::INFINITY } else { span };
    Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest: parts.weakest().iamax() + 1 })
}
