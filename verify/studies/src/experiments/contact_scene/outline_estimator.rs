//! Who senses the forces of contacts that a camera sees: from contacts as they were measured, or by an estimator that takes them for exact.

use super::{SeenContact, SensedContact, SensedForce, SensedStep, read_contact};
use crate::prelude::*;
use finray_model::estimators::network::Networks;
use finray_model::sensing::MeasuredContact;
use finray_model::sensor::{Refusal, Sensor, SensorContacts, SensorOptions};

/// Prior knowledge of who senses the forces of contacts that a camera sees.
#[derive(Debug, Clone, Copy)]
pub struct OutlineEstimator<'s> {
    /// The finger, and how objects meet it.
    pub scene: &'s Scene,
    /// Bound of the coefficient of friction.
    pub friction: f64,
    /// Standard deviation of a marker's coordinate, mm; `None` where observations state it.
    pub marker_noise_mm: Option<f64>,
    /// Standard deviation of a coordinate of a point of an outline, mm.
    pub outline_noise_mm: f64,
    /// An estimator that takes contacts for what they are read as, with networks to choose from: friction and the uncertainty of a contact are not in
    /// its standard deviations, and those of the total are the most that the contacts' can add up to. One that knows the plate's normal alone takes that for
    /// the direction. `None`: contacts count as measured.
    pub estimator: Option<(EstimatorId, &'s Networks)>,
}

impl OutlineEstimator<'_> {
    /// Senses forces of contacts, none clamped, from markers and contacts as the camera reads them; and their sum along a vector.
    pub(crate) fn sense(
        &self,
        felt: &[SeenContact],
        seen: &Observation,
        along: Vector,
        mut standard_normal: impl FnMut() -> f64,
    ) -> Result<SensedStep, Refusal> {
        let finger = &self.scene.finger;
        let read = |contact: &SeenContact| read_contact(finger, contact, self.outline_noise_mm, &mut standard_normal);
        let mut read: Vec<MeasuredContact> = felt.iter().map(read).collect();
        let mut options = SensorOptions {
            noise_mm: self.marker_noise_mm.map(|noise_mm| noise_mm.max(LEAST_STATED_MM)),
            ..SensorOptions::default()
        };
        let contacts = match self.estimator {
            None => SensorContacts::Measured { contacts: read.clone(), friction: self.friction },
            Some((estimator, networks)) => {
                if estimator.at_nodes() {
                    read.iter_mut().for_each(|read| read.contact.angle_deg = 0.0);
                }
                (options.estimator, options.networks) = (estimator, networks);
                SensorContacts::Asked(read.iter().map(|read| read.contact.into()).collect())
            }
        };
        let sensed = Sensor::new(self.scene, contacts, options)?.sense(seen)?;
        let force = |(i, (seen, read)): (usize, (&SeenContact, MeasuredContact))| SensedContact {
            read,
            force: SensedForce { true_n: seen.normal_n, sensed_n: sensed.forces_n[i], sigma_n: sensed.sigmas_n[i] },
        };
        let [sensed_n, sigma_n] = sensed.sum_along(finger, along);
        let total = SensedForce { true_n: felt.iter().map(|seen| seen.force.dot(&along)).sum(), sensed_n, sigma_n };
        Ok(SensedStep { contacts: felt.iter().zip(read).enumerate().map(force).collect(), total })
    }
}
