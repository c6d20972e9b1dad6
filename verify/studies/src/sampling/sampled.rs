//! Sensors whose answers are sampled.

use crate::prelude::*;
use crate::sampling::situation::Situation;

/// A sensor of maps and sweeps, which is asked at many contacts.
#[derive(Debug, Clone)]
pub struct SampledSensor {
    /// Estimator and networks. The noise of each measurement replaces the noise of the options.
    pub options: SensorOptions,
    /// What the sensor knows and sees.
    pub situation: Situation,
}

impl SampledSensor {
    /// An estimator that knows the contact and sees all markers.
    pub fn new(estimator: EstimatorId, networks: &Networks) -> SampledSensor {
        let options = SensorOptions { networks: networks.clone(), ..SensorOptions::of(estimator) };
        SampledSensor { options, situation: Situation::default() }
    }

    /// The sensor for each question that users ask about a true contact.
    ///
    /// # Errors
    /// [`Refusal`] of the first question that the estimator does not support.
    pub fn at(&self, scene: &PreparedScene, contact: Contact) -> Result<Vec<Sensor>, Refusal> {
        let questions = self.situation.contact.questions(scene, contact).into_iter();
        let sensor = |question: ContactQuestion| {
            Sensor::new(scene.clone(), SensorContacts::Asked(vec![question]), self.options.clone())
        };
        questions.map(sensor).collect()
    }

    /// The visible markers of a finger that is touched at a position on the front plate, mm from the base.
    pub fn sees(&self, finger: &Finger, shape: &FingerShape, s_mm: f64) -> Measurement {
        Measurement::of_shape(finger, shape).without(&self.situation.hidden.nodes(finger, s_mm))
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
