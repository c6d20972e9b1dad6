//! Sensing of forces at contacts that a camera sees: the contacts are treated either as measured with errors or as exact.

use super::LEAST_STATED_MM;
use super::{SeenContact, SensedContact, SensedForce, SensedStep, read_contact};
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::observation::Observation;
use finray_model::sensing::MeasuredContact;
use finray_model::sensor::{Refusal, Sensor, SensorContacts, SensorOptions};
use finray_model::{Scene, Vector};

/// Reason why no force is sensed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotSensed {
    /// The object touches a rib.
    #[error("forces are sensed only if the object touches nothing but the plates: it touches {name}")]
    Elsewhere {
        /// Name of the contact in tables.
        name: String,
    },
    /// The sensor refuses to estimate a force.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Prior knowledge for sensing forces at contacts that a camera sees.
#[derive(Debug, Clone, Copy)]
pub struct OutlineEstimator<'s> {
    /// The scene, with finger and contact properties.
    pub scene: &'s Scene,
    /// Upper bound of the friction coefficient, dimensionless.
    pub friction: f64,
    /// Standard deviation of a marker's coordinate, mm; `None` if the observations state this value.
    pub marker_noise_mm: Option<f64>,
    /// Standard deviation of a coordinate of an outline point, mm.
    pub outline_noise_mm: f64,
    /// An estimator that treats the contacts read by the camera as exact, and the networks available to this estimator. The estimator's standard
    /// deviations exclude friction and the uncertainty of contacts. The standard deviation of the total is the sum of the contacts' standard
    /// deviations, which is an upper bound. An estimator that supports only forces along the normal assumes the normal as direction. `None` for
    /// sensing with measured contacts.
    pub estimator: Option<(EstimatorId, &'s Networks)>,
}

impl OutlineEstimator<'_> {
    /// Senses the forces (N) of contacts that are not clamped, from markers and from the camera's readings of the contacts. Also returns the sum of
    /// the forces along the unit vector `along`.
    ///
    /// # Errors
    /// [`NotSensed`] if a contact is not on a plate, or if the forces are not identifiable.
    pub fn sense(
        &self,
        felt: &[SeenContact],
        seen: &Observation,
        along: Vector,
        mut standard_normal: impl FnMut() -> f64,
    ) -> Result<SensedStep, NotSensed> {
        if let Some(elsewhere) = felt.iter().find(|seen| seen.wall.plate().is_none()) {
            return Err(NotSensed::Elsewhere { name: elsewhere.name() });
        }
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
                (options.estimator, options.networks) = (estimator, networks.clone());
                SensorContacts::Asked(read.iter().map(|read| read.contact.into()).collect())
            }
        };
        let sensed = Sensor::new(self.scene.clone(), contacts, options)?.sense(seen)?;
        let force = |(i, (seen, read)): (usize, (&SeenContact, MeasuredContact))| SensedContact {
            read,
            force: SensedForce {
                true_n: seen.normal_n,
                sensed_n: sensed.forces[i].force_n,
                sigma_n: sensed.forces[i].sigma_n,
            },
        };
        let [sensed_n, sigma_n] = sensed.sum_along(finger, along);
        let total = SensedForce { true_n: felt.iter().map(|seen| seen.force.dot(&along)).sum(), sensed_n, sigma_n };
        Ok(SensedStep { contacts: felt.iter().zip(read).enumerate().map(force).collect(), total })
    }
}
