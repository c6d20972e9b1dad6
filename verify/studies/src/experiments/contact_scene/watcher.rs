//! Who senses the forces of contacts that a camera sees: with errors in all variables, or by an estimator that knows its contacts.

use super::sensing::{self, Knowledge};
use super::{CameraContact, SeenContact, SensedContact, SensedForce, SensedStep, read_contact};
use crate::estimators::network::Networks;
use crate::estimators::{EstimatorError, EstimatorId, Question};
use crate::settings::LEAST_STATED_MM;
use finray_model::measurement::Measurement;
use finray_model::sensing::{ContactQuestion, Pad, SensingError};
use finray_model::{Finger, Mesh, Vector};
use nalgebra::DVector;

/// Elements a member of the finger that senses: objects bend it farther than single forces of the same size, and with four, 0.1 %
/// of the force would be left of the mesh.
const ELEMENTS: usize = 8;

/// What is known to who senses the forces of contacts that a camera sees.
#[derive(Debug, Clone, Copy)]
pub struct OutlineEstimator<'f> {
    /// The finger.
    pub finger: &'f Finger,
    /// Radius of its rods, mm.
    pub rod_radius_mm: f64,
    /// Bound of the coefficient of friction.
    pub friction: f64,
    /// Standard deviation of a marker's coordinate, mm.
    pub marker_noise_mm: f64,
    /// Standard deviation of a coordinate of a point of an outline, mm.
    pub outline_noise_mm: f64,
}

impl OutlineEstimator<'_> {
    /// Senses the forces of one or more contacts, none of them clamped, from measured displacements and from the contacts as the camera reads
    /// them; and their sum along a unit vector.
    ///
    /// # Errors
    /// [`SensingError`] if they are not identifiable.
    pub fn sense(
        &self,
        felt: &[SeenContact],
        seen: &Measurement,
        along: Vector,
        standard_normal: impl FnMut() -> f64,
    ) -> Result<SensedStep, SensingError> {
        let contacts = self.read(felt, standard_normal);
        let mesh = Mesh::with_elements_per_member(self.finger, ELEMENTS);
        let knowledge = Knowledge {
            noise_mm: self.marker_noise_mm.max(LEAST_STATED_MM),
            friction: self.friction,
            rod_radius_mm: self.rod_radius_mm,
        };
        let solution = sensing::sense(&mesh, &contacts, seen, knowledge)?;
        let count = felt.len();
        // A force along the normal as it was read is off that along the true one by what friction adds where the normal is turned. How much friction
        // there is may be badly known: it counts with no less than its bound, as an estimate that noise has made small would make sigma small too.
        let variance_n2 = |i: usize| {
            let across_n2 = solution.across_n[i].powi(2) + solution.covariance_n2[(count + i, count + i)];
            let most_n = self.friction * solution.along_n[i];
            solution.covariance_n2[(i, i)] + contacts[i].direction_sd_rad.powi(2) * across_n2.max(most_n.powi(2))
        };
        let force = |(i, (seen, read)): (usize, (&SeenContact, &CameraContact))| SensedContact {
            read: *read,
            force: SensedForce { true_n: seen.normal_n, sensed_n: solution.along_n[i], sigma_n: variance_n2(i).sqrt() },
        };
        // The sum takes of every force, along and across its contact, what lies along the direction asked for.
        let shares = (0..2 * count).map(|i| {
            let turned_deg = if i < count { 0.0 } else { 90.0 };
            self.share(contacts[i % count].contact.angle_deg + turned_deg, along)
        });
        let shares = DVector::from_iterator(2 * count, shares);
        let all_n = DVector::from_iterator(2 * count, solution.along_n.iter().chain(&solution.across_n).copied());
        let total = SensedForce {
            true_n: true_total_n(felt, along),
            sensed_n: shares.dot(&all_n),
            sigma_n: shares.dot(&(&solution.covariance_n2 * &shares)).sqrt(),
        };
        Ok(SensedStep { contacts: felt.iter().zip(&contacts).enumerate().map(force).collect(), total })
    }

    /// The same by an estimator that takes contacts for what they are read as, with forces along their directions: friction and what is unsure of
    /// a contact are not in its standard deviations, and those of the total are the most that the contacts' can add up to. One that knows the
    /// plate's normal alone takes that for the direction.
    ///
    /// # Errors
    /// [`EstimatorError`] if it refuses.
    pub fn sense_by(
        &self,
        (estimator, networks): (EstimatorId, &Networks),
        felt: &[SeenContact],
        seen: &Measurement,
        along: Vector,
        standard_normal: impl FnMut() -> f64,
    ) -> Result<SensedStep, EstimatorError> {
        let mut contacts = self.read(felt, standard_normal);
        if estimator.at_nodes() {
            contacts.iter_mut().for_each(|read| read.contact.angle_deg = 0.0);
        }
        let questions: Vec<ContactQuestion> = contacts.iter().map(|read| read.contact.into()).collect();
        let (_, estimate) = estimator.answer(
            self.finger,
            &Question {
                contacts: &questions,
                pad: Pad::default(),
                object: None,
                measurement: seen,
                noise_mm: Some(self.marker_noise_mm.max(LEAST_STATED_MM)),
                mesh_nodes: None,
                networks,
            },
        )?;
        let shares: Vec<f64> = contacts.iter().map(|read| self.share(read.contact.angle_deg, along)).collect();
        let sum = |values: &[f64], share: fn(f64) -> f64| -> f64 {
            shares.iter().zip(values).map(|(of, value)| share(*of) * value).sum()
        };
        let total = SensedForce {
            true_n: true_total_n(felt, along),
            sensed_n: sum(&estimate.forces_n, |share| share),
            sigma_n: sum(&estimate.sigmas_n, f64::abs),
        };
        let force = |(i, (seen, read)): (usize, (&SeenContact, CameraContact))| SensedContact {
            read,
            force: SensedForce { true_n: seen.normal_n, sensed_n: estimate.forces_n[i], sigma_n: estimate.sigmas_n[i] },
        };
        Ok(SensedStep { contacts: felt.iter().zip(contacts).enumerate().map(force).collect(), total })
    }

    /// Contacts as the camera reads them.
    fn read(&self, felt: &[SeenContact], mut standard_normal: impl FnMut() -> f64) -> Vec<CameraContact> {
        let read =
            |contact: &SeenContact| read_contact(self.finger, contact, self.outline_noise_mm, &mut standard_normal);
        felt.iter().map(read).collect()
    }

    /// Share of a force in a direction, degrees, along a unit vector.
    fn share(&self, angle_deg: f64, along: Vector) -> f64 {
        self.finger.direction(angle_deg).dot(&along)
    }
}

/// Sum of the true forces along a unit vector, N.
fn true_total_n(felt: &[SeenContact], along: Vector) -> f64 {
    felt.iter().map(|seen| seen.force.dot(&along)).sum()
}
