//! Sensors whose answers are sampled.

use crate::prelude::*;

/// A sensor of maps and sweeps, which is asked at many contacts.
#[derive(Debug, Clone)]
pub struct SampledSensor {
    /// Estimator and networks. The noise of each measurement replaces the noise of the options.
    pub options: SensorOptions,
    /// The contacts that a user states for a true contact. Successive samples take them in turn.
    pub stated: fn(&Finger, Contact) -> Vec<Contact>,
}

impl SampledSensor {
    /// An estimator that knows the contact.
    pub fn new(estimator: EstimatorId, networks: &Networks) -> SampledSensor {
        let options = SensorOptions { networks: networks.clone(), ..SensorOptions::of(estimator) };
        SampledSensor { options, stated: |_, contact| vec![contact] }
    }

    /// The sensor for each stated contact.
    ///
    /// # Errors
    /// [`Refusal`] of the first stated contact that the estimator does not support.
    pub fn at(&self, scene: &PreparedScene, contact: Contact) -> Result<Vec<Sensor>, Refusal> {
        let sensor =
            |contact: Contact| Sensor::new(scene.clone(), SensorContacts::known(&[contact]), self.options.clone());
        (self.stated)(&scene.finger, contact).into_iter().map(sensor).collect()
    }
}

/// Senses noisy samples of one measurement. The search starts from the forces of the measurement without noise, if the finger explains
/// that measurement.
pub struct SampledForces<'s> {
    sensor: &'s Sensor,
    noise_mm: f64,
    noise_free: Option<SensedForces>,
}

impl<'s> SampledForces<'s> {
    /// Expects `samples` samples of `noise_free` with noise of standard deviation `noise_mm` (mm).
    pub fn new(sensor: &'s Sensor, noise_free: &Measurement, noise_mm: f64, samples: usize) -> SampledForces<'s> {
        // For a single sample, a search on the noise-free measurement would cost more time than it saves. If the measurement
        // contradicts the model, there may be several minima, and a common starting point would select one of them.
        let helps = sensor.estimator().searches() && samples > 1;
        let sense = || sensor.sense_displacements(noise_free, Some(noise_mm), None).ok();
        let noise_free = if helps { sense().filter(|sensed| sensed.warnings.is_empty()) } else { None };
        SampledForces { sensor, noise_mm, noise_free }
    }

    /// Senses one sample.
    ///
    /// # Errors
    /// [`Refusal`] as for [`Sensor::sense`].
    pub fn sense(&self, sample: &Measurement) -> Result<SensedForces, Refusal> {
        self.sensor.sense_displacements(sample, Some(self.noise_mm), self.noise_free.as_ref())
    }
}
