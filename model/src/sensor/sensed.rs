//! Sensed forces, with their intervals and warnings.

use crate::Vector;
use crate::finger::Finger;
use crate::sensing::{Alternative, Contact, ContactUncertainty, Estimate, MeasuredForces, Warning};
use nalgebra::{DMatrix, DVector};

/// Estimated force at a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedForce {
    /// Position and direction, given or estimated.
    pub contact: Contact,
    /// Force along the direction, N.
    pub force_n: f64,
    /// Standard deviation of the force, N, including the noise and the known error of the model. 1.96 times this value reaches both ends of the
    /// 95 % interval.
    pub sigma_n: f64,
    /// Uncertainty of an estimated position or direction.
    pub uncertainty: ContactUncertainty,
    /// Lower and upper limit of the 95 % interval, N.
    limits_n: [f64; 2],
}

/// Estimated forces, in the order of the contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedForces {
    /// The force of each contact.
    pub forces: Vec<SensedForce>,
    /// Reasons why the forces may be less accurate than their standard deviations, or requests to state the noise. Empty without warnings.
    pub warnings: Vec<SensorWarning>,
    /// Covariance of the forces, N^2, in the order of the contacts.
    pub(super) covariance_n2: DMatrix<f64>,
    /// Root mean square residual of a coordinate, divided by the stated noise of the markers; zero without a stated noise.
    pub(super) relative_residual: f64,
    /// Forces along and across the direction of each contact. `None` unless the contacts were measured.
    measured: Option<MeasuredForces>,
    /// The answer in each range of positions. Empty with fewer than two ranges.
    alternatives: Vec<Alternative>,
}

impl SensedForce {
    /// Lower and upper limit of the 95 % interval of the force, N. Asymmetric about the force if the position of the contact is unknown and the markers
    /// determine it only weakly.
    pub fn interval_n(&self) -> [f64; 2] {
        self.limits_n
    }
}

impl SensedForces {
    /// Estimated forces at contacts, with warnings.
    pub(super) fn new(
        contacts: &[(Contact, ContactUncertainty)],
        estimate: Estimate,
        warnings: Vec<SensorWarning>,
        relative_residual: f64,
    ) -> SensedForces {
        let force = |(i, &(contact, uncertainty)): (usize, &(Contact, ContactUncertainty))| SensedForce {
            contact,
            force_n: estimate.forces_n[i],
            sigma_n: estimate.sigmas_n[i],
            uncertainty,
            limits_n: estimate.interval_n(i),
        };
        let forces = contacts.iter().enumerate().map(force).collect();
        let Estimate { covariance_n2, measured, alternatives, .. } = estimate;
        SensedForces { forces, warnings, covariance_n2, relative_residual, measured, alternatives }
    }

    /// The answer in each range of positions that explains the markers, the best first. With one range, the sensed force of each contact at an unknown
    /// position.
    pub(super) fn alternatives(&self, finger: &Finger) -> Vec<Alternative> {
        if !self.alternatives.is_empty() {
            return self.alternatives.clone();
        }
        let own = |(contact, sensed): (usize, &SensedForce)| {
            Some(Alternative {
                contact,
                position_mm: sensed.contact.position_mm(finger)?,
                position_interval_mm: sensed.uncertainty.position_interval_mm?,
                angle_deg: sensed.contact.angle_deg,
                force_n: sensed.force_n,
                interval_n: sensed.interval_n(),
                excess: 0.0,
            })
        };
        self.forces.iter().enumerate().filter_map(own).collect()
    }

    /// Sum of all forces, each along the direction of its contact, and the standard deviation of this sum, both N.
    pub fn sum(&self) -> [f64; 2] {
        self.weighted_sum(&DVector::from_element(self.forces.len(), 1.0))
    }

    /// Sum of all forces along the unit vector `along` (finger frame) and its standard deviation, both N.
    pub fn sum_along(&self, finger: &Finger, along: Vector) -> [f64; 2] {
        let share = |sensed: &SensedForce, turned_deg: f64| {
            let Contact { position, angle_deg } = sensed.contact;
            Contact { position, angle_deg: angle_deg + turned_deg }.direction(finger).dot(&along)
        };
        let Some(MeasuredForces { across_n, covariance_n2 }) = &self.measured else {
            let shares = self.forces.iter().map(|sensed| share(sensed, 0.0));
            return self.weighted_sum(&DVector::from_iterator(self.forces.len(), shares));
        };
        let shares = [0.0, 90.0].into_iter().flat_map(|deg| self.forces.iter().map(move |sensed| share(sensed, deg)));
        let shares = DVector::from_iterator(2 * across_n.len(), shares);
        let all_n = self.forces.iter().map(|sensed| sensed.force_n).chain(across_n.iter().copied());
        let all_n = DVector::from_iterator(2 * across_n.len(), all_n);
        [shares.dot(&all_n), shares.dot(&(covariance_n2 * &shares)).sqrt()]
    }

    /// Sum of the forces, each multiplied by its share, and the standard deviation of this sum, both N.
    fn weighted_sum(&self, shares: &DVector<f64>) -> [f64; 2] {
        let sum_n = self.forces.iter().zip(shares).map(|(sensed, share)| share * sensed.force_n).sum();
        // If the noise is unknown, every standard deviation is infinite.
        let is_known = self.forces.iter().all(|sensed| sensed.sigma_n.is_finite());
        let variance_n2 = (&self.covariance_n2 * shares).dot(shares);
        [sum_n, if is_known { variance_n2.max(0.0).sqrt() } else { f64::INFINITY }]
    }
}

/// A reason why the forces may be less accurate than their standard deviations, or a request to state the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SensorWarning {
    /// The measurement contradicts the model, or the error of the model exceeds the noise.
    Model {
        /// The contradiction or the error of the model.
        warning: Warning,
        /// Whether the estimator is linear.
        is_linear: bool,
    },
    /// The standard deviations are infinite, because no residual remains from which to estimate the noise.
    NoResidual,
    /// No noise is stated, and the residual is a large share of the displacements: the contacts or the finger may be wrong.
    LargeResidual {
        /// Root mean square of the residual, mm.
        residual_rms_mm: f64,
        /// Root mean square of the displacements, mm.
        moved_rms_mm: f64,
    },
}

impl std::fmt::Display for SensorWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (warning, is_linear) = match self {
            SensorWarning::Model { warning, is_linear } => (warning, is_linear),
            SensorWarning::NoResidual => {
                return f.write_str(
                    "sigma_n is infinite: no noise is stated, and there are as many unknowns as measured \
                        coordinates, so no residual remains from which the noise could be estimated; state the noise \
                        (noise_mm)",
                );
            }
            SensorWarning::LargeResidual { residual_rms_mm, moved_rms_mm } => {
                return write!(
                    f,
                    "no noise is stated, and the residual is {residual_rms_mm:.3} mm rms (displacement: \
                        {moved_rms_mm:.3} mm rms), so sigma_n is too small unless the noise is as large as the \
                        residual; check the contacts and the finger, or state the noise (noise_mm)"
                );
            }
        };
        let advice = match warning {
            Warning::UnknownLinearisation => "sigma_n does not include this error",
            Warning::Prior { .. } => {
                "sigma_n holds only for forces of this range; the estimator least-squares has no prior"
            }
            Warning::Residual(_) if *is_linear => {
                "sigma_n follows from the residual and includes the error of linearisation; the estimator nonlinear \
                    avoids the error of linearisation, so its warnings have other causes, such as wrong contacts"
            }
            _ if *is_linear => "sigma_n includes the error of linearisation, which the estimator nonlinear avoids",
            Warning::Residual(_) => {
                "sigma_n follows from the residual, which may be smaller than the effect of wrong contacts or a wrong finger; check the contacts, \
                 their directions, the finger's dimensions and the stated noise"
            }
            _ => "sigma_n includes this error",
        };
        write!(f, "{warning}; {advice}")
    }
}
