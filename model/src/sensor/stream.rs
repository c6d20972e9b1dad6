//! Contacts that come and go in a stream of observations.

use super::{PreparedScene, Refusal, SensedForce, SensedForces, Sensor, SensorContacts, SensorOptions, SensorWarning};
use crate::Vector;
use crate::estimators::EstimatorError;
use crate::measurement::BaseUncertainty;
use crate::observation::{Observation, ObservationError};
use crate::sensing::{ContactQuestion, ResidualTest, SensingError, Warning};
use nalgebra::{Matrix3, Vector3};

/// Probability per frame of a false alarm: noise alone makes the frame appear to show a force, or to contradict its contacts. For the many frames of
/// a stream, the false-alarm probability of a single measurement, 1 %, would be too large.
pub(super) const FALSE_ALARM: f64 = 1e-4;
/// Largest number of unknowns of a contact: force, position and direction.
const CONTACT_UNKNOWNS: usize = 3;

/// Senses the forces in each observation of a stream, and determines how many contacts the observation shows.
///
/// ```
/// use finray_model::Scene;
/// use finray_model::observation::Observation;
/// use finray_model::measurement::Measurement;
/// use finray_model::sensor::{ContactSpec, SensorContacts, SensorOptions, StreamSensor};
///
/// let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
/// let at_rest = Observation::of_displacements(&Measurement::at_rest(&scene.finger));
/// let contacts = SensorContacts::from_specs(&[ContactSpec::at_position("auto")?], &scene, 0.0, None)?;
/// let options = SensorOptions { noise_mm: Some(0.02), ..SensorOptions::default() };
/// let sensor = StreamSensor::new(scene, contacts, options)?;
/// assert_eq!(sensor.sense(&at_rest, None)?, None); // no force
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Contacts at given positions are sensed as [`Sensor`] senses them. For a single contact of unknown position, a second contact of the same kind is
/// added if the markers contradict the first contact alone.
#[derive(Debug, Clone)]
pub struct StreamSensor {
    /// A sensor for the requested contacts and, if a second contact may be added, a sensor for two contacts.
    sensors: Vec<Sensor>,
}

impl StreamSensor {
    /// Combines a scene with contacts and options.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts, as for [`Sensor::new`].
    pub fn new(
        scene: impl Into<PreparedScene>,
        contacts: SensorContacts,
        options: SensorOptions,
    ) -> Result<StreamSensor, Refusal> {
        let sensor = Sensor::new(scene, contacts, options)?;
        let one_more = match sensor.contacts[..] {
            [question @ ContactQuestion { position: None, .. }] => {
                let two = SensorContacts::Asked(vec![question; 2]);
                Sensor::new(sensor.prepared.clone(), two, sensor.options.clone()).ok()
            }
            _ => None,
        };
        Ok(StreamSensor { sensors: [sensor].into_iter().chain(one_more).collect() })
    }

    /// The forces that an observation shows. The number of contacts is the smallest that explains the markers. `None` if the markers show no force:
    /// noise alone explains their displacements, or the interval of a single force contains zero. The search starts from `before`, the forces of the
    /// previous observation, if that observation showed any. If `before` is an estimate of this sensor, the search starts from the shapes of that
    /// estimate.
    ///
    /// # Errors
    /// [`Refusal`] as for [`Sensor::sense`], or if the markers contradict the contacts.
    pub fn sense(&self, seen: &Observation, before: Option<&SensedForces>) -> Result<Option<SensedForces>, Refusal> {
        let seen = &*seen.renewed(self.sensors[0].scene()).map_err(ObservationError::from)?;
        let no_force = self.no_force(seen)?;
        let is_noise = |test: ResidualTest| test.p_value() >= FALSE_ALARM;
        if no_force.is_some_and(|test| is_noise(test.of_estimated_noise(f64::INFINITY))) {
            return Ok(None);
        }
        let mut refusal = None;
        for sensor in &self.sensors {
            let sensed = sensor.sense_near(seen, before).and_then(|sensed| match contradiction(&sensed) {
                Some(warning) => Err(Refusal::Contradicted { contacts: sensed.forces.len(), warning }),
                None => Ok(sensed),
            });
            match sensed {
                Ok(sensed) if sensed.warnings.contains(&SensorWarning::NoResidual) => {
                    return Err(SensingError::NoiseNotStated.into());
                }
                Ok(sensed) => {
                    let includes_zero = |force: &SensedForce| {
                        let [least_n, most_n] = force.interval_n();
                        (least_n..=most_n).contains(&0.0)
                    };
                    // The intervals of correlated forces may each include zero although the markers show a force.
                    let are_asked = sensed.forces.len() > 1 && refusal.is_none();
                    if are_asked || !sensed.forces.iter().all(includes_zero) {
                        let is_noise = no_force.is_some_and(|test| is_reduced_by_noise(test, &sensed));
                        return Ok(Some(sensed).filter(|_| !is_noise));
                    }
                    // A second contact that may carry no force does not explain what the first alone leaves unexplained.
                    let large = sensed.warnings.iter().find(|it| matches!(it, SensorWarning::LargeResidual { .. }));
                    return refusal.or_else(|| large.copied().map(Refusal::Unexplained)).map_or(Ok(None), Err);
                }
                // The refusal for the smallest number of contacts is the most informative.
                Err(reason) if is_contradiction(&reason) => refusal = refusal.or(Some(reason)),
                // Markers that show no force do not determine a contact.
                Err(_) if no_force.is_some_and(is_noise) => return Ok(None),
                Err(reason) => return Err(refusal.unwrap_or(reason)),
            }
        }
        Err(refusal.unwrap_or_else(|| SensingError::NoContact.into()))
    }

    /// Warnings about the sensed forces as those of [`Sensor::validity_warnings`].
    pub fn validity_warnings(&self, sensed: &SensedForces) -> Vec<String> {
        self.sensors[0].validity_warnings(sensed)
    }

    /// Test whether the noise of the markers and the uncertainty of the base explain all displacements. `None` if the noise is unknown.
    fn no_force(&self, seen: &Observation) -> Result<Option<ResidualTest>, Refusal> {
        let Sensor { prepared: scene, options, .. } = &self.sensors[0];
        let stated_noise_mm = options.noise_mm.or(scene.noise_mm);
        let found = seen.for_sensing(scene, options.estimator.searches(), stated_noise_mm)?;
        let Some(marker_noise_mm) = found.marker_noise_mm else { return Ok(None) };
        let markers = found.measurement.markers().iter().map(|marker| {
            (scene.finger.marker_position(marker.node), marker.displacement, marker_noise_mm / marker.weight)
        });
        let test = noise_test(markers, found.measurement.base().unwrap_or_default());
        Ok(test.map(|test| test.of_estimated_noise(found.measurement.noise_degrees_of_freedom())))
    }
}

/// Whether noise, of a level that was estimated, may reduce the residual without forces to that of the sensed forces. Never for a known noise, which alone
/// decides whether there is a force.
fn is_reduced_by_noise(no_force: ResidualTest, sensed: &SensedForces) -> bool {
    no_force.noise_degrees_of_freedom.is_finite()
        && no_force.p_value_of_reduction(sensed.relative_residual, CONTACT_UNKNOWNS * sensed.forces.len())
            >= FALSE_ALARM
}

/// Test whether noise and a rigid motion of the base explain displacements. Each marker has a position, a displacement and a standard deviation of one
/// coordinate, mm. The noise of the test is 1, because the residual is relative to the standard deviations. `None` without markers.
///
/// # Reference
/// Chi-squared test of d^T S^-1 d for the displacements d. The covariance S of the displacements is the sum of the covariances of the noise and
/// of a rigid motion of the base (Woodbury identity).
pub(super) fn noise_test(
    markers: impl Iterator<Item = (Vector, Vector, f64)>,
    base: BaseUncertainty,
) -> Option<ResidualTest> {
    let (mut squares, mut along, mut normal, mut coordinates) = (0.0, Vector3::zeros(), Matrix3::identity(), 0);
    for (at, moved_mm, sd_mm) in markers {
        let by_base = [[base.sd_mm, 0.0, -at.y * base.sd_rad], [0.0, base.sd_mm, at.x * base.sd_rad]];
        for (by_base, moved_mm) in by_base.into_iter().zip(&moved_mm) {
            let (by_base, moved) = (Vector3::from(by_base) / sd_mm, moved_mm / sd_mm);
            squares += moved * moved;
            along += by_base * moved;
            normal += by_base * by_base.transpose();
            coordinates += 1;
        }
    }
    let of_base = normal.cholesky().map_or(0.0, |normal| along.dot(&normal.solve(&along)));
    ResidualTest::new(Some(1.0), squares - of_base, coordinates)
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
