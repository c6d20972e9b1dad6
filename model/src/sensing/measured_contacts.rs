//! Estimates forces from markers and measured contacts by least squares with errors in all variables.
//!
//! Each contact has two unknowns: the force f along its measured normal, and the tangent a of the angle between force and normal. A contact between
//! rods has a third unknown, the shift d of its position. The data are the displacements of the markers. The priors of the tangent a and of the shift
//! d have mean zero. The standard deviations of the priors follow from the accuracy of the measured contacts and from friction. The estimate
//! minimises the sum of all squared residuals, each divided by its variance. [`LevenbergMarquardt`] searches for the estimate, and the co-rotational
//! finger gives the computed displacements. The stated covariance is the inverse of the information matrix. The stated covariance includes the
//! uncertainty of position, direction and friction that remains after the fit.

use super::{
    Contact, ContactForce, ContactPosition, LARGEST_SPAN, NonlinearEstimator, ResidualTest, RespondingFinger, Response,
    SensingError,
};
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::optimise::{Fit, LeastSquaresProblem, LevenbergMarquardt, Prior, Refusal, StepBounds, covariance};
use crate::statics::StaticsError;
use crate::{Finger, Mesh, Vector};
use nalgebra::{DMatrix, DVector};

/// A search that stops before convergence is accepted if its next step would change each force by at most this share of the force's standard
/// deviation.
const NEGLIGIBLE: f64 = 0.01;
/// A chi-squared value counts as significant if it exceeds the mean of its distribution by more than this number of standard deviations. For 20 to
/// 100 degrees of freedom, noise alone exceeds this limit with a probability of 1 in 1000 to 1 in 4000.
const UNEXPLAINED_DEVIATIONS: f64 = 4.0;

/// A contact with measured position and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredContact {
    /// Measured position of the contact, and measured direction of the surface's normal.
    pub contact: Contact,
    /// Standard deviation of the direction, rad.
    pub direction_sd_rad: f64,
    /// Standard deviation of the position along the plate, mm. Zero for a contact at a rod.
    pub position_sd_mm: f64,
}

/// Noise of the markers, and friction and geometry of the contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactKnowledge {
    /// Standard deviation of one displacement coordinate, mm.
    pub noise_mm: f64,
    /// Upper bound of the coefficient of friction, dimensionless: tangent of the largest angle between force and normal.
    pub friction: f64,
    /// Radius of the rods, mm. Friction acts on the surface of the rods.
    pub rod_radius_mm: f64,
}

/// Forces of measured contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredContactForces {
    /// Force along the measured normal of each contact, N.
    pub along_n: Vec<f64>,
    /// Standard deviation of each contact's force along its true normal, N.
    pub sigmas_n: Vec<f64>,
    /// Force across the measured normal of each contact, positive towards the tip, N.
    pub across_n: Vec<f64>,
    /// The contacts, as measured.
    pub contacts: Vec<Contact>,
    /// Covariance, N^2, of all forces along the contacts, followed by all forces across the contacts.
    pub covariance_n2: DMatrix<f64>,
    /// The residual, if neither the noise nor the uncertainty of the contacts explains it. The standard deviations are then widened.
    pub unexplained: Option<ResidualTest>,
}

/// Least-squares problem. The unknowns are, in this order, the forces (N), the tangents of the angles between force and normal, and the shifts (mm).
struct Problem<'a> {
    contacts: &'a [MeasuredContact],
    knowledge: ContactKnowledge,
    /// Standard deviations of the priors: first for the tangent of each angle (dimensionless), then for the shift of each position (mm). All priors
    /// have mean 0. A standard deviation of zero fixes the unknown at 0.
    own_sds: Vec<f64>,
    /// Measured displacements, mm, two coordinates per marked node. Zero for a hidden node.
    measured_mm: DVector<f64>,
    /// Weight of each coordinate, dimensionless. Zero for a hidden node.
    weights: DVector<f64>,
    coordinates: usize,
    length_mm: f64,
    finger: RespondingFinger<'a>,
    /// Response of the finger for the values of the unknowns that were evaluated last.
    response: Option<Response>,
}

/// Estimates the forces of measured contacts on `mesh`. The pose of the base is assumed to be exact.
///
/// # Errors
/// [`SensingError`] if the forces are not identifiable, no equilibrium explains the displacements, or the search does not converge.
pub fn sense_measured_contacts(
    mesh: &Mesh,
    contacts: &[MeasuredContact],
    measurement: &Measurement,
    knowledge: ContactKnowledge,
) -> Result<MeasuredContactForces, SensingError> {
    let questions: Vec<_> = contacts.iter().map(|contact| contact.contact.into()).collect();
    let start = NonlinearEstimator::new(mesh, &questions)?.estimate(measurement, Some(knowledge.noise_mm))?;
    // Friction of a sliding object acts in the same direction at all k contacts. For k contacts, the standard deviation of each tangent's prior is
    // the upper bound of the coefficient of friction times sqrt(k). If the tangents at all k contacts equal the upper bound of the coefficient of
    // friction, they are together one standard deviation from zero.
    let friction = knowledge.friction * (contacts.len() as f64).sqrt();
    let [measured_mm, weights] = of_marked_nodes(mesh.finger(), measurement);
    let count = contacts.len();
    let tangent_sds = contacts.iter().map(|contact| contact.direction_sd_rad.hypot(friction));
    let mut problem = Problem {
        contacts,
        knowledge,
        own_sds: tangent_sds.chain(contacts.iter().map(|contact| contact.position_sd_mm)).collect(),
        measured_mm,
        weights,
        coordinates: measurement.coordinate_count(),
        length_mm: mesh.finger().plate_length_mm(Plate::Front),
        finger: RespondingFinger::new(mesh),
        response: None,
    };
    let start = DVector::from_vec(start.forces.forces_n).resize_vertically(3 * count, 0.0);
    let fit = LevenbergMarquardt::default().minimise(&mut problem, start).map_err(Refusal::into_error)?;
    let solution = problem.solution(&fit)?;
    if !fit.has_converged() {
        let next_step = inverse(&fit.jacobian)? * fit.jacobian.tr_mul(&fit.residual);
        let changes_n = next_step.rows(0, count).abs();
        if (0..count).any(|i| changes_n[i] > NEGLIGIBLE * solution.covariance_n2[(i, i)].sqrt()) {
            return Err(SensingError::NotConverged { iterations: fit.iterations, change_n: changes_n.amax() });
        }
    }
    Ok(solution)
}

impl LeastSquaresProblem for Problem<'_> {
    type Point = DVector<f64>;
    type Error = SensingError;

    /// Computed displacements minus measured displacements, weighted and divided by the noise.
    fn residual(&mut self, point: &DVector<f64>) -> Result<DVector<f64>, Refusal<SensingError>> {
        let count = self.contacts.len();
        let force = |(i, seen): (usize, &MeasuredContact)| {
            let mut contact = seen.contact;
            if let ContactPosition::At(s_mm) = &mut contact.position {
                *s_mm += point[2 * count + i];
            }
            // Friction acts on the surface of the rod or, between rods, of the plate.
            let lever_mm = match contact.position {
                ContactPosition::Node(_) => self.knowledge.rod_radius_mm,
                ContactPosition::At(s_mm) => 0.5 * self.finger.finger().thickness_mm(Plate::Front, s_mm),
            };
            ContactForce { contact, along_n: point[i], across_n: point[i] * point[count + i], lever_mm }
        };
        let forces: Vec<ContactForce> = self.contacts.iter().enumerate().map(force).collect();
        let none = StaticsError::NoEquilibrium { converged_fraction: 0.0 };
        let bent = self.finger.under(&forces).map_err(|error| Refusal::Altogether(error.into()))?;
        let response = self.response.insert(bent.ok_or(Refusal::Here(none.into()))?);
        Ok((&response.displacements_mm - &self.measured_mm).component_mul(&self.weights) / self.knowledge.noise_mm)
    }

    fn jacobian(&mut self, point: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<SensingError>> {
        Ok(self.columns(point, &point.as_slice()[..self.contacts.len()]))
    }

    fn moved(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        point + step
    }

    /// Priors of tangents and shifts. For an unknown whose standard deviation is zero, all derivatives are set to zero, so its prior keeps the
    /// unknown at zero.
    fn priors(&self, point: &DVector<f64>) -> Vec<Prior> {
        let own = (self.contacts.len()..).zip(&self.own_sds);
        own.map(|(unknown, &sd)| Prior::on(unknown, point[unknown], 0.0, if sd > 0.0 { sd } else { 1.0 })).collect()
    }

    /// Bounds of a step that keep the positions of contacts on the plate.
    fn step_bounds(&self, point: &DVector<f64>) -> StepBounds {
        let shifts = (2 * self.contacts.len()..).zip(self.contacts);
        shifts.fold(StepBounds::default(), |bounds, (unknown, seen)| match seen.contact.position {
            ContactPosition::At(s_mm) => bounds.and(unknown, point[unknown], [-0.5 * s_mm, self.length_mm - s_mm]),
            ContactPosition::Node(_) => bounds,
        })
    }
}

impl Problem<'_> {
    /// Derivatives of the weighted displacements, divided by the noise: one row per coordinate, one column per unknown. The derivative with respect
    /// to a tangent equals the force `effective_n`, N, times the derivative with respect to the force across the normal.
    fn columns(&self, point: &DVector<f64>, effective_n: &[f64]) -> DMatrix<f64> {
        let count = self.contacts.len();
        let mut columns = DMatrix::zeros(self.measured_mm.len(), 3 * count);
        let Some(response) = &self.response else { return columns };
        for i in 0..count {
            columns.set_column(i, &(&response.along[i] + &response.across[i] * point[count + i]));
            if self.own_sds[i] > 0.0 {
                columns.set_column(count + i, &(&response.across[i] * effective_n[i]));
            }
            if self.own_sds[count + i] > 0.0 {
                columns.set_column(2 * count + i, &response.moved[i]);
            }
        }
        for mut column in columns.column_iter_mut() {
            column.component_mul_assign(&self.weights);
        }
        columns / self.knowledge.noise_mm
    }

    /// Forces along and across the contacts, with their covariance. The effect of a tangent on the markers is proportional to the force. In the
    /// covariance, the root mean square of the force replaces the estimated force; the difference matters for small forces. The root mean square is
    /// the square root of the sum of the squared estimate and the variance.
    fn solution(&mut self, fit: &Fit<DVector<f64>>) -> Result<MeasuredContactForces, SensingError> {
        let count = self.contacts.len();
        let (forces_n, tangents) = (&fit.point.as_slice()[..count], &fit.point.as_slice()[count..2 * count]);
        let first = inverse(&fit.jacobian)?;
        let effective_n: Vec<f64> =
            (0..count).map(|i| forces_n[i].hypot(first[(i, i)].sqrt()).copysign(forces_n[i])).collect();
        // The stored response may belong to a rejected step, so it is computed again at the solution.
        self.residual(&fit.point).map_err(Refusal::into_error)?;
        let mut jacobian = fit.jacobian.clone();
        jacobian.rows_mut(0, self.measured_mm.len()).copy_from(&self.columns(&fit.point, &effective_n));
        let covariance = inverse(&jacobian)?;
        // Force across = force along x tangent.
        let turned = DMatrix::from_fn(2 * count, 3 * count, |row, column| match (row < count, column) {
            (true, column) => f64::from(u8::from(row == column)),
            (false, column) if column == row - count => tangents[row - count],
            (false, column) if column == row && self.own_sds[row - count] > 0.0 => effective_n[row - count],
            _ => 0.0,
        });
        let degrees_of_freedom = (self.coordinates as f64 - count as f64).max(1.0);
        let chance = degrees_of_freedom + UNEXPLAINED_DEVIATIONS * (2.0 * degrees_of_freedom).sqrt();
        // A residual that neither noise nor contacts explain widens the covariance.
        let widened = if fit.squares > chance { fit.squares / degrees_of_freedom } else { 1.0 };
        let noise_mm = self.knowledge.noise_mm;
        let unexplained = (widened > 1.0).then(|| ResidualTest {
            noise_mm,
            residual_sd_mm: noise_mm * widened.sqrt(),
            degrees_of_freedom: degrees_of_freedom as usize,
        });
        let covariance_n2 = &turned * covariance * turned.transpose() * widened;
        let across_n: Vec<f64> = (0..count).map(|i| forces_n[i] * tangents[i]).collect();
        // If the measured normal is wrong, a share of the friction force counts as force along the normal. The share is computed from at least the
        // upper bound of the friction force. Noise could make the estimated friction force too small, and a standard deviation computed from this
        // estimate would then be too small.
        let variance_n2 = |i: usize| {
            let across_n2 = across_n[i].powi(2) + covariance_n2[(count + i, count + i)];
            let most_n = self.knowledge.friction * forces_n[i];
            covariance_n2[(i, i)] + self.contacts[i].direction_sd_rad.powi(2) * across_n2.max(most_n.powi(2))
        };
        Ok(MeasuredContactForces {
            contacts: self.contacts.iter().map(|measured| measured.contact).collect(),
            along_n: forces_n.to_vec(),
            sigmas_n: (0..count).map(|i| variance_n2(i).sqrt()).collect(),
            across_n,
            covariance_n2,
            unexplained,
        })
    }
}

/// Covariance of all unknowns, or [`SensingError::IllConditioned`] if the unknowns are not identifiable.
fn inverse(jacobian: &DMatrix<f64>) -> Result<DMatrix<f64>, SensingError> {
    covariance(jacobian).ok_or(SensingError::IllConditioned { span: f64::INFINITY, limit: LARGEST_SPAN, weakest: 1 })
}

impl MeasuredContactForces {
    /// Widens the standard deviations and the covariance by an error of `share` (dimensionless) of all forces. The error is a common factor of all
    /// forces, as the error of a modulus is.
    pub(crate) fn add_force_error(&mut self, share: f64) {
        for (sigma_n, force_n) in self.sigmas_n.iter_mut().zip(&self.along_n) {
            *sigma_n = sigma_n.hypot(share * force_n);
        }
        let forces_n = self.along_n.iter().chain(&self.across_n).copied();
        let errors_n = DVector::from_iterator(2 * self.along_n.len(), forces_n) * share;
        self.covariance_n2 += &errors_n * errors_n.transpose();
    }

    /// Sum of all forces along the unit vector `along` (finger frame) and its standard deviation, both N.
    pub fn sum_along(&self, finger: &Finger, along: Vector) -> [f64; 2] {
        let count = self.along_n.len();
        // Component along `along` of a unit force, first for a force along each contact, then for a force across each contact.
        let shares = (0..2 * count).map(|i| {
            let turned_deg = if i < count { 0.0 } else { 90.0 };
            finger.direction(self.contacts[i % count].angle_deg + turned_deg).dot(&along)
        });
        let shares = DVector::from_iterator(2 * count, shares);
        let all_n = DVector::from_iterator(2 * count, self.along_n.iter().chain(&self.across_n).copied());
        [shares.dot(&all_n), shares.dot(&(&self.covariance_n2 * &shares)).sqrt()]
    }
}

/// Displacements, mm, and weights (dimensionless) of a measurement, two coordinates per marked node. Displacements and weights are zero for a hidden
/// node.
fn of_marked_nodes(finger: &Finger, measurement: &Measurement) -> [DVector<f64>; 2] {
    let nodes = finger.marked_nodes();
    let mut displacements_mm = DVector::zeros(2 * nodes.len());
    let mut weights = displacements_mm.clone();
    for (i, node) in nodes.enumerate() {
        if let Some(marker) = measurement.markers().iter().find(|marker| marker.node == node) {
            displacements_mm.fixed_rows_mut::<2>(2 * i).copy_from(&marker.displacement);
            weights.fixed_rows_mut::<2>(2 * i).fill(marker.weight);
        }
    }
    [displacements_mm, weights]
}
