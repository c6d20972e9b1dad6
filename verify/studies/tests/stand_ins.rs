//! Simple estimators that replace real ones in tests.

use finray_model::estimators::{BeamEstimator, Estimator, EstimatorError, EstimatorId, PreparedEstimator, Sensed};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, SensingError};

/// An estimator without a model of the finger and without standard deviations. It answers every measurement with 1 N, or refuses every measurement.
/// `Constant` uses the name of the network, because the tests with it have no network.
pub struct Constant {
    pub refuses: bool,
}

impl Estimator for Constant {
    fn id(&self) -> EstimatorId {
        EstimatorId::Network
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        _: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        Ok(Box::new(PreparedConstant { refuses: self.refuses, contacts: contacts.len() }))
    }
}

struct PreparedConstant {
    refuses: bool,
    contacts: usize,
}

impl PreparedEstimator for PreparedConstant {
    fn estimate(&mut self, _: &Measurement, _: Option<f64>) -> Result<Sensed, EstimatorError> {
        if self.refuses {
            return Err(SensingError::NoContact.into());
        }
        Ok(Sensed { forces_n: vec![1.0; self.contacts], sigmas_n: None, sum_sigma_n: None, warned: false })
    }
}

/// A real estimator with additional errors: its measurement is changed by `sees`, and its force is multiplied by `force_factor`.
pub struct Worse<'m> {
    pub estimator: BeamEstimator<'m>,
    pub sees: fn(&Measurement) -> Measurement,
    pub force_factor: f64,
}

impl Estimator for Worse<'_> {
    fn id(&self) -> EstimatorId {
        self.estimator.id()
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        let estimator = self.estimator.prepare(contacts, markers)?;
        Ok(Box::new(PreparedWorse { estimator, sees: self.sees, force_factor: self.force_factor }))
    }
}

struct PreparedWorse<'m> {
    estimator: Box<dyn PreparedEstimator + 'm>,
    sees: fn(&Measurement) -> Measurement,
    force_factor: f64,
}

impl PreparedEstimator for PreparedWorse<'_> {
    fn estimate(&mut self, seen: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let mut sensed = self.estimator.estimate(&(self.sees)(seen), noise_mm)?;
        sensed.forces_n.iter_mut().for_each(|force_n| *force_n *= self.force_factor);
        Ok(sensed)
    }
}
