//! Forces from markers and from contacts that are measured, too: errors in all variables.
//!
//! Unknown are, for each contact, the force f along the normal as the camera reads it, the tangent a of the force's angle from there,
//! and for a contact between rods the shift d of its position. The markers' displacements are data; so are a = 0 and d = 0,
//! with the standard deviations that camera and friction give them. The sum of squares of all, each over its standard deviation, is least
//! (Gauss-Newton on the co-rotational finger), and the inverse of its information matrix is the stated covariance: what noise of
//! position and direction, and unknown friction, do to a force is in it, less what the markers show of them.

use super::{
    Contact, ContactForce, ContactPosition, LARGEST_SPAN, NonlinearEstimator, RespondingFinger, Response, SensingError,
};
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::statics::StaticsError;
use crate::{Finger, Mesh, Vector};
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

/// A contact whose position and direction were measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredContact {
    /// Position and direction of the surface's normal, as measured.
    pub contact: Contact,
    /// Standard deviation of the direction, rad.
    pub direction_sd_rad: f64,
    /// Standard deviation of the position along the plate, mm; 0 at a rod.
    pub position_sd_mm: f64,
}

/// Prior knowledge of contacts and markers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactKnowledge {
    /// Standard deviation of one displacement coordinate, mm.
    pub noise_mm: f64,
    /// Bound of the friction coefficient: the tangent of the largest angle between force and normal.
    pub friction: f64,
    /// Radius of the rods, on whose surface friction acts, mm.
    pub rod_radius_mm: f64,
}

/// Forces of measured contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredContactForces {
    /// Along each contact's normal, as measured, N.
    pub along_n: Vec<f64>,
    /// Standard deviation of the force along the true normal, N.
    pub sigmas_n: Vec<f64>,
    /// Across it, towards the tip, N.
    pub across_n: Vec<f64>,
    /// The contacts, as measured.
    pub contacts: Vec<Contact>,
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
    contacts: &'a [MeasuredContact],
    knowledge: ContactKnowledge,
    /// Standard deviation of each tangent; 0 where it is known to be 0.
    tangent_sds: Vec<f64>,
    /// Displacements, two coordinates a marked node; zero for a node that was not seen.
    measured_mm: DVector<f64>,
    /// Weight of each coordinate: zero for a node that was not seen.
    weights: DVector<f64>,
    coordinates: usize,
    length_mm: f64,
    /// Half the thickness of the front plate, mm.
    half_thickness_mm: f64,
}

/// Senses the forces of measured contacts on `mesh`. The base counts as known.
///
/// # Errors
/// [`SensingError`] if the forces are not identifiable, no equilibrium explains the displacements, or the search does not end.
pub fn sense_measured_contacts(
    mesh: &Mesh,
    contacts: &[MeasuredContact],
    measurement: &Measurement,
    knowledge: ContactKnowledge,
) -> Result<MeasuredContactForces, SensingError> {
    let questions: Vec<_> = contacts.iter().map(|contact| contact.contact.into()).collect();
    let start = NonlinearEstimator::new(mesh, &questions)?.estimate(measurement, Some(knowledge.noise_mm))?;
    // Friction drags all contacts one way where the object slides: k tangents, each as large as its bound, lie one standard deviation from
    // nothing if each has the deviation bound x sqrt(k).
    let friction = knowledge.friction * (contacts.len() as f64).sqrt();
    let [measured_mm, weights] = of_marked_nodes(mesh.finger(), measurement);
    let problem = Problem {
        contacts,
        knowledge,
        tangent_sds: contacts.iter().map(|contact| contact.direction_sd_rad.hypot(friction)).collect(),
        measured_mm,
        weights,
        coordinates: measurement.coordinate_count(),
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
        let force = |(i, seen): (usize, &MeasuredContact)| {
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

    /// Measured less computed displacements, weighted, mm.
    fn residual_mm(&self, response: &Response) -> DVector<f64> {
        (&self.measured_mm - &response.displacements_mm).component_mul(&self.weights)
    }

    /// Squared residuals over their standard deviations, summed.
    fn misfit(&self, state: &State, response: &Response) -> f64 {
        let own = |value: f64, sd: f64| if sd > 0.0 { (value / sd).powi(2) } else { 0.0 };
        let markers = self.residual_mm(response).norm_squared() / self.knowledge.noise_mm.powi(2);
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
        let mut columns = DMatrix::from_columns(&columns) / self.knowledge.noise_mm;
        for mut column in columns.column_iter_mut() {
            column.component_mul_assign(&self.weights);
        }
        columns
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
            limit: LARGEST_SPAN,
            weakest: 1,
        })?;
        Ok(DMatrix::from_fn(scales.len(), scales.len(), |i, j| inverse[(i, j)] / (scales[i] * scales[j])))
    }

    /// The Gauss-Newton step.
    fn step(&self, state: &State, response: &Response) -> Result<DVector<f64>, SensingError> {
        let count = self.contacts.len();
        let mut columns = self.columns(state, response, &state.forces_n);
        let information = self.information(&mut columns);
        let residual = self.residual_mm(response) / self.knowledge.noise_mm;
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
    fn solution(&self, state: &State, response: &Response) -> Result<MeasuredContactForces, SensingError> {
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
        let degrees_of_freedom = (self.coordinates as f64 - count as f64).max(1.0);
        let chi_squared = self.misfit(state, response);
        let chance = degrees_of_freedom + UNEXPLAINED_DEVIATIONS * (2.0 * degrees_of_freedom).sqrt();
        // What neither noise nor contacts explain is uncertainty too.
        let widened = if chi_squared > chance { chi_squared / degrees_of_freedom } else { 1.0 };
        let covariance_n2 = &turned * covariance * turned.transpose() * widened;
        let across_n: Vec<f64> = (0..count).map(|i| state.forces_n[i] * state.tangents[i]).collect();
        // A force along the normal as it was measured is off that along the true one by what friction adds where the normal is turned. How much friction
        // there is may be badly known: it counts with no less than its bound, as an estimate that noise has made small would make sigma small too.
        let variance_n2 = |i: usize| {
            let across_n2 = across_n[i].powi(2) + covariance_n2[(count + i, count + i)];
            let most_n = self.knowledge.friction * state.forces_n[i];
            covariance_n2[(i, i)] + self.contacts[i].direction_sd_rad.powi(2) * across_n2.max(most_n.powi(2))
        };
        Ok(MeasuredContactForces {
            contacts: self.contacts.iter().map(|measured| measured.contact).collect(),
            along_n: state.forces_n.clone(),
            sigmas_n: (0..count).map(|i| variance_n2(i).sqrt()).collect(),
            across_n,
            covariance_n2,
        })
    }
}

impl MeasuredContactForces {
    /// Sum of all forces along a unit vector of the finger frame, and its standard deviation, N.
    pub fn sum_along(&self, finger: &Finger, along: Vector) -> [f64; 2] {
        let count = self.along_n.len();
        // The sum takes of every force, along and across its contact, its component along the direction asked for.
        let shares = (0..2 * count).map(|i| {
            let turned_deg = if i < count { 0.0 } else { 90.0 };
            finger.direction(self.contacts[i % count].angle_deg + turned_deg).dot(&along)
        });
        let shares = DVector::from_iterator(2 * count, shares);
        let all_n = DVector::from_iterator(2 * count, self.along_n.iter().chain(&self.across_n).copied());
        [shares.dot(&all_n), shares.dot(&(&self.covariance_n2 * &shares)).sqrt()]
    }
}

/// Displacements and weights of a measurement by marked node, two coordinates each; zero for a node that was not seen.
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
