//! Linear estimators: least squares, and least squares with a prior on the forces (ridge).

use super::{Contact, Estimate, LARGEST_SPAN, SensingError, check_contacts};
use crate::compliance::{Compliance, NodalCompliance};
use crate::finger::Finger;
use crate::measurement::Measurement;
use crate::mesh::Load;
use crate::statics::StaticsError;
use nalgebra::{DMatrix, DVector};

/// What is assumed of the forces before measuring.
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
        LinearEstimator::from_compliance(&compliance(&unit_loads)?, markers)
    }

    /// As [`LinearEstimator::new`], with a compliance that is already there: a load for each unknown force.
    ///
    /// # Errors
    /// [`SensingError`] when the problem has no unique answer.
    pub fn from_compliance(compliance: &Compliance, markers: &Measurement) -> Result<LinearEstimator, SensingError> {
        let (unknowns, coordinates) = (compliance.load_count(), markers.coordinate_count());
        if unknowns > coordinates {
            return Err(SensingError::TooFewMarkers { unknowns, coordinates });
        }
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
    /// `noise_mm` is the standard deviation of one coordinate; without it, it is estimated from the residual.
    pub fn estimate(&self, measurement: &Measurement, noise_mm: Option<f64>, prior: Prior) -> Estimate {
        let displacements = weighted_displacements(measurement);
        let (coordinates, unknowns) = self.compliance.shape();
        let residual = |forces: &DVector<f64>| {
            let explained = |row| (0..unknowns).map(|k| self.compliance[(row, k)] * forces[k]).sum::<f64>();
            (0..coordinates).map(|row| (displacements[row] - explained(row)).powi(2)).sum::<f64>()
        };
        let unbiased = &self.least_squares.gain * &displacements;
        let noise_mm = noise_mm.unwrap_or_else(|| match coordinates - unknowns {
            // As many numbers as unknowns leave no residual: the noise could be anything.
            0 => f64::INFINITY,
            freedoms => (residual(&unbiased) / freedoms as f64).sqrt(),
        });
        let (forces, sigmas_per_noise) = match prior {
            Prior::Gaussian { force_n } if noise_mm > 0.0 && noise_mm.is_finite() => {
                let ridge = Inverse::of(&self.compliance, noise_mm / force_n);
                (&ridge.gain * &displacements, ridge.sigmas_per_noise)
            }
            _ => (unbiased, self.least_squares.sigmas_per_noise.clone()),
        };
        Estimate {
            residual_rms_mm: (residual(&forces) / coordinates as f64).sqrt(),
            forces_n: forces.iter().copied().collect(),
            sigmas_n: sigmas_per_noise.iter().map(|sigma| sigma * noise_mm).collect(),
            noise_mm,
            singular_values: self.singular_values.clone(),
        }
    }
}

/// Inverse of a linear problem in the sense of least squares.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverse {
    /// Turns weighted displacements (2 a marker, mm) into forces (N): a row a force, N/mm.
    pub gain: DMatrix<f64>,
    /// Standard deviation of each force per standard deviation of a coordinate, N/mm: square roots of the diagonal of
    /// (C^T W^2 C + ridge^2)^-1.
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

fn weighted_displacements(measurement: &Measurement) -> DVector<f64> {
    let coordinates =
        measurement.markers().iter().flat_map(|m| [m.weight * m.displacement.x, m.weight * m.displacement.y]);
    DVector::from_iterator(measurement.coordinate_count(), coordinates)
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
    let svd = compliance.clone().svd(false, true);
    let mut values: Vec<f64> = svd.singular_values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let (largest, smallest) = (values[0], values[values.len() - 1]);
    if smallest > 0.0 && largest / smallest <= LARGEST_SPAN {
        return Ok(values);
    }
    // A force that moves no marker at all spans infinitely much, also if it is the only one.
    let span = if smallest > 0.0 { largest / smallest } else { f64::INFINITY };
    let weakest = svd.v_t.map_or(0, |v_t| v_t.row(svd.singular_values.imin()).iamax_full().1);
    Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest: weakest + 1 })
}
