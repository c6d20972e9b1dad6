//! Contacts that come and go in a stream of observations.

use super::{Refusal, SensedForces, Sensor, SensorContacts, SensorOptions, SensorWarning};
use crate::estimators::EstimatorError;
use crate::observation::{Observation, ObservedMarker};
use crate::scene::Scene;
use crate::sensing::{ContactQuestion, Refinement, ResidualTest, SensingError, Warning};
use crate::{NodeId, Vector};
use nalgebra::{Matrix3, Vector3};

/// Probability per frame of a false alarm: noise alone makes the frame appear to show a force, or to contradict its contacts. For the many frames of
/// a stream, the false-alarm probability of a single measurement, 1 %, would be too large.
const FALSE_ALARM: f64 = 1e-4;

/// Senses the forces in each observation of a stream, and determines how many contacts the observation shows.
///
/// Contacts at given positions are sensed as [`Sensor`] senses them. For a single contact of unknown position, a second contact of the same kind is
/// added if the markers contradict the first contact alone.
#[derive(Debug, Clone)]
pub struct StreamSensor<'s> {
    scene: &'s Scene,
    options: SensorOptions<'s>,
    /// A sensor for the requested contacts and, if a second contact may be added, a sensor for two contacts. Each sensor is stored with the meshes
    /// and shapes that its estimator keeps from one observation to the next.
    sensors: Vec<(Sensor<'s>, Option<Refinement<'s>>)>,
}

impl<'s> StreamSensor<'s> {
    /// Combines a scene with contacts and options.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts, as for [`Sensor::new`].
    pub fn new(
        scene: &'s Scene,
        contacts: SensorContacts,
        options: SensorOptions<'s>,
    ) -> Result<StreamSensor<'s>, Refusal> {
        let one_more = match &contacts {
            SensorContacts::Asked(questions) => match questions[..] {
                [question @ ContactQuestion { position: None, .. }] => {
                    Sensor::new(scene, SensorContacts::Asked(vec![question; 2]), options).ok()
                }
                _ => None,
            },
            SensorContacts::Measured { .. } => None,
        };
        let sensors = [Sensor::new(scene, contacts, options)?].into_iter().chain(one_more);
        let sensors = sensors.map(|sensor| {
            let refinement = sensor.refinement();
            (sensor, refinement)
        });
        Ok(StreamSensor { scene, options, sensors: sensors.collect() })
    }

    /// The forces that an observation shows. The number of contacts is the smallest that explains the markers. `None` if the markers show no force:
    /// noise alone explains their displacements, or the interval of a single force contains zero. The search starts from `before`, the forces of the
    /// previous observation, if that observation showed any. If `before` is an estimate of this sensor, the search starts from the shapes of that
    /// estimate.
    ///
    /// # Errors
    /// [`Refusal`] as for [`Sensor::sense`], or if the markers contradict the contacts.
    pub fn sense(
        &mut self,
        seen: &Observation,
        before: Option<&SensedForces>,
    ) -> Result<Option<SensedForces>, Refusal> {
        if self.is_noise(seen)? {
            return Ok(None);
        }
        let mut refusal = None;
        for (sensor, kept) in &mut self.sensors {
            let sensed =
                sensor.sense_keeping(seen, before, kept.as_mut()).and_then(|sensed| match contradiction(&sensed) {
                    Some(warning) => Err(Refusal::Contradicted { contacts: sensed.contacts.len(), warning }),
                    None => Ok(sensed),
                });
            match sensed {
                Ok(sensed) if sensed.warnings.contains(&SensorWarning::NoResidual) => {
                    return Err(SensingError::NoiseNotStated.into());
                }
                Ok(sensed) => {
                    // The intervals of correlated forces may each include zero although the interval of their sum does not.
                    let [low_n, high_n] = sensed.interval_n(0);
                    let shows = sensed.contacts.len() > 1 || !(low_n..=high_n).contains(&0.0);
                    return Ok(shows.then_some(sensed));
                }
                // The refusal for the smallest number of contacts is the most informative.
                Err(reason) if is_contradiction(&reason) => refusal = refusal.or(Some(reason)),
                Err(reason) => return Err(refusal.unwrap_or(reason)),
            }
        }
        Err(refusal.unwrap_or_else(|| SensingError::NoContact.into()))
    }

    /// Whether the noise of the markers and the uncertainty of the base explain all displacements. False if the noise is unknown.
    ///
    /// # Reference
    /// Chi-squared test of d^T S^-1 d for the displacements d. The covariance S of the displacements is the sum of the covariances of the noise and
    /// of a rigid motion of the base (Woodbury identity).
    fn is_noise(&self, seen: &Observation) -> Result<bool, Refusal> {
        let stated_mm = self.options.noise_mm.or(self.scene.noise_mm);
        let found = seen.for_sensing(self.scene, self.options.estimator.searches(), stated_mm)?;
        let stated_mm = stated_mm.map(|noise_mm| self.scene.marker_errors.sd_mm(noise_mm));
        let Some(noise_mm) = stated_mm.or(found.noise_mm) else { return Ok(false) };
        let base = found.measurement.base().unwrap_or_default();
        let (mut squares, mut along, mut normal) = (0.0, Vector3::zeros(), Matrix3::identity());
        for marker in found.measurement.markers() {
            let sd_mm = noise_mm / if stated_mm.is_some() { 1.0 } else { marker.weight };
            let at = self.scene.finger.marker_position(marker.node);
            let by_base = [[base.sd_mm, 0.0, -at.y * base.sd_rad], [0.0, base.sd_mm, at.x * base.sd_rad]];
            for (by_base, moved_mm) in by_base.into_iter().zip(&marker.displacement) {
                let (by_base, moved) = (Vector3::from(by_base) / sd_mm, moved_mm / sd_mm);
                squares += moved * moved;
                along += by_base * moved;
                normal += by_base * by_base.transpose();
            }
        }
        let of_base = normal.cholesky().map_or(0.0, |normal| along.dot(&normal.solve(&along)));
        let test = ResidualTest::new(Some(1.0), squares - of_base, found.measurement.coordinate_count());
        Ok(test.is_some_and(|test| test.p_value() >= FALSE_ALARM))
    }
}

/// Whether the markers contradict the number of contacts, so that one contact more may explain them.
fn is_contradiction(reason: &Refusal) -> bool {
    use SensingError::{NotConverged, Unexplained};
    matches!(
        reason,
        Refusal::Contradicted { .. }
            | Refusal::Estimator(EstimatorError::Sensing(Unexplained { .. } | NotConverged { .. }))
    )
}

/// The warning that the markers contradict the sensed forces.
fn contradiction(sensed: &SensedForces) -> Option<Warning> {
    sensed.warnings.iter().find_map(|warning| match warning {
        SensorWarning::Model { warning: Warning::Residual(test), .. } if test.p_value() < FALSE_ALARM => {
            Some(Warning::Residual(*test))
        }
        _ => None,
    })
}

/// Mean positions of the markers in observations of the unloaded finger. Later displacements are measured from these positions.
#[derive(Debug, Clone, Default)]
pub struct RestPositions {
    /// Each entry contains a marker's node, the sum of the marker's positions (mm), the sum of their variances (mm^2) and the number of observations.
    markers: Vec<(NodeId, Vector, f64, usize)>,
}

impl RestPositions {
    /// Adds an observation of the unloaded finger.
    pub fn add(&mut self, seen: &Observation) {
        for marker in &seen.markers {
            let Some(position) = marker.position else { continue };
            let variance_mm2 = marker.sd_mm.unwrap_or(0.0).powi(2);
            match self.markers.iter_mut().find(|(node, ..)| *node == marker.node) {
                Some((_, sum, variances_mm2, count)) => {
                    *sum += position;
                    *variances_mm2 += variance_mm2;
                    *count += 1;
                }
                None => self.markers.push((marker.node, position, variance_mm2, 1)),
            }
        }
    }

    /// The observation with displacements from the mean positions. Markers that were never seen at rest are left out. The standard deviations include
    /// the uncertainty of the mean positions.
    pub fn displaced(&self, seen: &Observation) -> Observation {
        let displaced = |marker: &ObservedMarker| {
            let (_, sum, variances_mm2, count) = self.markers.iter().find(|(node, ..)| *node == marker.node)?;
            let count = *count as f64;
            let of_mean_mm = variances_mm2.sqrt() / count;
            let wider = |sd_mm: Option<f64>| sd_mm.map(|sd_mm| sd_mm.hypot(of_mean_mm));
            Some(ObservedMarker {
                displacement: Some(marker.position? - sum / count),
                sd_mm: wider(marker.sd_mm),
                own_sd_mm: wider(marker.own_sd_mm),
                ..*marker
            })
        };
        Observation { markers: seen.markers.iter().filter_map(displaced).collect(), ..seen.clone() }
    }
}
