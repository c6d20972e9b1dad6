//! Forces from markers and from contacts that are themselves measured: errors in all variables.
//!
//! Unknown are, for each contact, the force f along the normal as the camera reads it, the tangent a of the force's angle from there,
//! and for a contact between rods the shift d of its position. The markers' displacements are data; so are a = 0 and d = 0,
//! with the standard deviations that camera and friction give them. The sum of squares of all, each over its standard deviation, is least
//! (Gauss-Newton on the co-rotational finger), and the inverse of its information matrix is the stated covariance: what noise of
//! position and direction, and unknown friction, do to a force is in it, less what the markers show of them.

use super::camera::CameraContact;
use crate::experiments::response::{ContactForce, RespondingFinger, Response};
use finray_model::Mesh;
use finray_model::finger::Plate;
use finray_model::measurement::Measurement;
use finray_model::sensing::{ContactPosition, NonlinearEstimator, SensingError};
use finray_model::statics::StaticsError;
use nalgebra::{DMatrix, DVector};

/// Steps after which a search that has not settled is given up.
const MAX_STEPS: usize = 30;
/// Last change of a force, as a share of the largest: far below any noise.
const SETTLED: f64 = 1e-7;
/// A slow search ends well, too, where its last change of a force is no more than this share of the force's standard deviation.
const NEGLIGIBLE: f64 = 0.01;
/// A step that leads to no equilibrium, or to a worse fit, is halved so often.
const HALVINGS: usize = 12;
/// Chi-squared beyond its mean by this many of its standard deviations is no chance: 1 in 10^4 for the degrees of freedom of a finger.
const UNEXPLAINED_DEVIATIONS: f64 = 4.0;

/// What is known of contacts and markers beside the displacements.
#[derive(Debug, Clone, Copy)]
pub(super) struct Knowledge {
    /// Standard deviation of one displacement coordinate, mm.
    pub noise_mm: f64,
    /// Bound of the friction coefficient: the tangent of the largest angle between force and normal.
    pub friction: f64,
    /// Radius of the rods, on whose surface friction acts, mm.
    pub rod_radius_mm: f64,
}

/// The minimum.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solution {
    /// Along each contact's normal, as read, N.
    pub along_n: Vec<f64>,
    /// Across it, towards the tip, N.
    pub across_n: Vec<f64>,
    /// Covariance of the forces along all contacts, then of those across them, N^2.
    pub covariance_n2: DMatrix<f64>,
}

/// The unknowns and the standard deviations of their own data.
#[derive(Debug, Clone)]
struct State {
    forces_n: Vec<f64>,
    /// Tangents of the angles between force and normal.
    tangents: Vec<f64>,
    shifts_mm: Vec<f64>,
}

struct Problem<'a> {
    contacts: &'a [CameraContact],
    knowledge: Knowledge,
    /// Standard deviation of each tangent; 0 where it is known to be 0.
    tangent_sds: Vec<f64>,
    measured_mm: DVector<f64>,
    length_mm: f64,
    /// Half the thickness of the front plate, mm.
    half_thickness_mm: f64,
}

/// Senses forces on `mesh`.
///
/// # Errors
/// [`SensingError`] if the forces are not identifiable, no equilibrium explains the displacements, or the search does not end.
pub(super) fn sense(
    mesh: &Mesh,
    contacts: &[CameraContact],
    measurement: &Measurement,
    knowledge: Knowledge,
) -> Result<Solution, SensingError> {
    let questions: Vec<_> = contacts.iter().map(|contact| contact.contact.into()).collect();
    let start = NonlinearEstimator::new(mesh, &questions)?.estimate(measurement, Some(knowledge.noise_mm))?;
    // Friction drags all contacts one way where the object slides: k tangents, each as large as its bound, lie one standard deviation from
    // nothing if each has the deviation bound x sqrt(k).
    let friction = knowledge.friction * (contacts.len() as f64).sqrt();
    let problem = Problem {
        contacts,
        knowledge,
        tangent_sds: contacts.iter().map(|contact| contact.direction_sd_rad.hypot(friction)).collect(),
        measured_mm: DVector::from_iterator(
            measurement.coordinate_count(),
            measurement.markers().iter().flat_map(|marker| [marker.displacement.x, marker.displacement.y]),
        ),
        length_mm: mesh.finger().plate_length_mm(Plate::Front),
        half_thickness_mm: 0.5 * mesh.finger().description().front.thickness_mm,
    };
    let mut finger = RespondingFinger::new(mesh);
    let count = contacts.len();
    let mut state = State { forces_n: start.forces.forces_n, tangents: vec![0.0; count], shifts_mm: vec![0.0; count] };
    let none = SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 0.0 });
    let mut response = problem.bent(&mut finger, &state)?.ok_or(none)?;
    let mut changes_n = DVector::zeros(count);
    for iterations in 1..=MAX_STEPS {
        let step = problem.step(&state, &response)?;
        changes_n = step.rows(0, count).abs();
        let change_n = changes_n.amax();
        let before = problem.misfit(&state, &response);
        let mut taken = None;
        for halving in 0..=HALVINGS {
            let trial = problem.moved(&state, &step, 0.5_f64.powi(halving as i32));
            if let Some(found) = problem.bent(&mut finger, &trial)?
                && problem.misfit(&trial, &found) <= before * (1.0 + SETTLED)
            {
                taken = Some((trial, found));
                break;
            }
        }
        let Some((next, found)) = taken else { return Err(SensingError::NotConverged { iterations, change_n }) };
        let largest = next.forces_n.iter().fold(f64::MIN_POSITIVE, |most, force| most.max(force.abs()));
        (state, response) = (next, found);
        if change_n <= SETTLED * largest {
            return problem.solution(&state, &response);
        }
    }
    let solution = problem.solution(&state, &response)?;
    let is_negligible = |i: usize| changes_n[i] <= NEGLIGIBLE * solution.covariance_n2[(i, i)].sqrt();
    if (0..count).all(is_negligible) {
        return Ok(solution);
    }
    Err(SensingError::NotConverged { iterations: MAX_STEPS, change_n: changes_n.amax() })
}

impl Problem<'_> {
    /// Whether the position of a contact is measured, and not that of a node.
    fn slides(&self, i: usize) -> bool {
        self.contacts[i].position_sd_mm > 0.0
    }

    fn bent(&self, finger: &mut RespondingFinger, state: &State) -> Result<Option<Response>, SensingError> {
        let force = |(i, seen): (usize, &CameraContact)| {
            let mut contact = seen.contact;
            if let ContactPosition::At(s_mm) = &mut contact.position {
                *s_mm += state.shifts_mm[i];
            }
            let along_n = state.forces_n[i];
            // Friction acts on the surface of the rod, or of the plate.
            let lever_mm = match contact.position {
                ContactPosition::Node(_) => self.knowledge.rod_radius_mm,
                ContactPosition::At(_) => self.half_thickness_mm,
            };
            ContactForce { contact, along_n, across_n: along_n * state.tangents[i], lever_mm }
        };
        let forces: Vec<ContactForce> = self.contacts.iter().enumerate().map(force).collect();
        Ok(finger.under(&forces)?)
    }

    /// Squared residuals over their standard deviations, summed.
    fn misfit(&self, state: &State, response: &Response) -> f64 {
        let own = |value: f64, sd: f64| if sd > 0.0 { (value / sd).powi(2) } else { 0.0 };
        let markers = (&self.measured_mm - &response.displacements_mm).norm_squared() / self.knowledge.noise_mm.powi(2);
        let of_contact = |i: usize| {
            own(state.tangents[i], self.tangent_sds[i]) + own(state.shifts_mm[i], self.contacts[i].position_sd_mm)
        };
        markers + (0..self.contacts.len()).map(of_contact).sum::<f64>()
    }

    /// Derivatives of the displacements over the noise, by forces, then tangents, then shifts; a tangent moves the markers by
    /// `effective_n` times what 1 N across does.
    fn columns(&self, state: &State, response: &Response, effective_n: &[f64]) -> DMatrix<f64> {
        let count = self.contacts.len();
        let along = (0..count).map(|i| &response.along[i] + &response.across[i] * state.tangents[i]);
        let turned = (0..count).map(|i| &response.across[i] * effective_n[i]);
        let columns: Vec<DVector<f64>> = along.chain(turned).chain(response.moved.iter().cloned()).collect();
        DMatrix::from_columns(&columns) / self.knowledge.noise_mm
    }

    /// Information matrix of the unknowns: of the markers and of the unknowns' own data. Unknowns that are known have no column of the
    /// derivatives, and the information 1, which leaves them where they are.
    fn information(&self, columns: &mut DMatrix<f64>) -> DMatrix<f64> {
        let count = self.contacts.len();
        let mut own = DVector::zeros(3 * count);
        for i in 0..count {
            for (at, sd) in [(count + i, self.tangent_sds[i]), (2 * count + i, self.contacts[i].position_sd_mm)] {
                own[at] = if sd > 0.0 { sd.powi(-2) } else { 1.0 };
                if sd == 0.0 {
                    columns.column_mut(at).fill(0.0);
                }
            }
        }
        columns.transpose() * &*columns + DMatrix::from_diagonal(&own)
    }

    fn inverse(&self, information: DMatrix<f64>) -> Result<DMatrix<f64>, SensingError> {
        let scales = information.diagonal().map(f64::sqrt);
        let scaled = DMatrix::from_fn(scales.len(), scales.len(), |i, j| information[(i, j)] / (scales[i] * scales[j]));
        let inverse = scaled.cholesky().map(|factor| factor.inverse()).ok_or(SensingError::IllConditioned {
            span: f64::INFINITY,
            limit: finray_model::sensing::LARGEST_SPAN,
            weakest: 1,
        })?;
        Ok(DMatrix::from_fn(scales.len(), scales.len(), |i, j| inverse[(i, j)] / (scales[i] * scales[j])))
    }

    /// The Gauss-Newton step.
    fn step(&self, state: &State, response: &Response) -> Result<DVector<f64>, SensingError> {
        let count = self.contacts.len();
        let mut columns = self.columns(state, response, &state.forces_n);
        let information = self.information(&mut columns);
        let residual = (&self.measured_mm - &response.displacements_mm) / self.knowledge.noise_mm;
        let mut right = columns.transpose() * residual;
        for i in 0..count {
            if self.tangent_sds[i] > 0.0 {
                right[count + i] -= state.tangents[i] / self.tangent_sds[i].powi(2);
            }
            if self.slides(i) {
                right[2 * count + i] -= state.shifts_mm[i] / self.contacts[i].position_sd_mm.powi(2);
            }
        }
        Ok(self.inverse(information)? * right)
    }

    /// A share of a step further; positions stay on the plate.
    fn moved(&self, state: &State, step: &DVector<f64>, share: f64) -> State {
        let count = self.contacts.len();
        let added = |values: &[f64], from: usize| -> Vec<f64> {
            values.iter().enumerate().map(|(i, value)| value + share * step[from + i]).collect()
        };
        let mut shifts_mm = added(&state.shifts_mm, 2 * count);
        for (shift_mm, seen) in shifts_mm.iter_mut().zip(self.contacts) {
            if let ContactPosition::At(s_mm) = seen.contact.position {
                *shift_mm = shift_mm.clamp(-0.5 * s_mm, self.length_mm - s_mm);
            }
        }
        State { forces_n: added(&state.forces_n, 0), tangents: added(&state.tangents, count), shifts_mm }
    }

    /// Forces along and across with their covariance. What a tangent does to the markers is in proportion to the force, whose mean square is
    /// that of the estimate and its variance: small forces are known no better than that.
    fn solution(&self, state: &State, response: &Response) -> Result<Solution, SensingError> {
        let count = self.contacts.len();
        let covariance_for = |effective_n: &[f64]| {
            let mut columns = self.columns(state, response, effective_n);
            self.inverse(self.information(&mut columns))
        };
        let first = covariance_for(&state.forces_n)?;
        let effective_n: Vec<f64> =
            (0..count).map(|i| state.forces_n[i].hypot(first[(i, i)].sqrt()).copysign(state.forces_n[i])).collect();
        let covariance = covariance_for(&effective_n)?;
        // Across = force x tangent.
        let turned = DMatrix::from_fn(2 * count, 3 * count, |row, column| match (row < count, column) {
            (true, column) => f64::from(u8::from(row == column)),
            (false, column) if column == row - count => state.tangents[row - count],
            (false, column) if column == row && self.tangent_sds[row - count] > 0.0 => effective_n[row - count],
            _ => 0.0,
        });
        let degrees_of_freedom = (self.measured_mm.len() as f64 - count as f64).max(1.0);
        let chi_squared = self.misfit(state, response);
        let chance = degrees_of_freedom + UNEXPLAINED_DEVIATIONS * (2.0 * degrees_of_freedom).sqrt();
        // What neither noise nor contacts explain is uncertainty too.
        let widened = if chi_squared > chance { chi_squared / degrees_of_freedom } else { 1.0 };
        Ok(Solution {
            along_n: state.forces_n.clone(),
            across_n: (0..count).map(|i| state.forces_n[i] * state.tangents[i]).collect(),
            covariance_n2: &turned * covariance * turned.transpose() * widened,
        })
    }
}
