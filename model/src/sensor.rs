//! Estimates contact forces and their intervals from observations of a finger.
//!
//! A [`Sensor`] combines a scene with contacts, an estimator and a noise level. It turns each [`Observation`] into forces with standard deviations and
//! warnings, or refuses it with a reason. An observation comes from an image, a table or a simulation.
//!
//! # From the noise of a marker to the interval of a force
//! The chain for the estimator `nonlinear`, in the order of the computation, from step 1 with every formula. Squares add: `hypot(a, b)` = sqrt(a^2 + b^2).
//! 0. `sigma_mm` of a marker in an image (`finray_imaging::locate`). Coloured markers: `Search::disc` (residuals of the pixels, hypot least values for blur
//!    and size), times the `wider` of its plate, hypot motion blur (`together`), widened where something covers its rim (`UsualCover::widened_mm`). Grey
//!    markers: `RimLocator::named` (one `wider` for all, cover) and `Rim::combined` (both edges), hypot the base that is seen in the image. Then hypot the
//!    image of the unloaded finger (`Observer::marker`; `EstimatedNoise::of_difference` for step 2). A table of `locate` keeps all of it. `marker_sigma_mm` is the same without the error of the base.
//! 1. Stated noise x of one coordinate, mm: [`SensorOptions::noise_mm`] (`--noise-mm`), else `noise_mm` of `[camera]`, for all markers. Without
//!    it, each marker has the standard deviation of the observation: `sigma_mm`, or `marker_sigma_mm` if the base is estimated. With n rest frames, a stated
//!    noise is multiplied by sqrt(1 + 1/n); [`RestPositions::displaced`] adds the error of their mean to unstated noise, or their scatter states the noise.
//! 2. [`Observation::for_sensing`]: m = hypot(a x, `model_error_mm`) with the two keys of `[markers]` (1 and 0 without them), in
//!    `MarkerErrors::sd_mm` of [`measurement`](crate::measurement), the place for a further term of every marker. a is `noise_factor` for images whose
//!    noise is at most `noise_factor_of_mm`, and approaches 1 for noisier images (`MarkerErrors::of_image`). Markers
//!    with own standard deviations m_i have m = their root mean square, and the weight w_i = m / m_i; else w_i = 1.
//!    The noise of compressed images is itself an estimate from k degrees of freedom (`together::located`); errors that are known raise k
//!    ([`Measurement::noise_degrees_of_freedom`]). An error that all markers of such an image share adds to the uncertainty of the base
//!    (`observation::shared_error`). Errors of the camera's pose, and of the offsets that it leads to, become errors that
//!    all markers share (`observation::pose_errors`).
//! 3. `beam_theory`: b = 0.34 `model_error` (largest displacement); m becomes hypot(m, b), and w_i follows. `model_error` is the scene's, see
//!    [`Scene::model_error`](crate::scene::Scene). The result is the `marker_noise_mm` of the estimator, which scales priors and decides which minima explain the markers.
//! 4. [`ResidualTest`](crate::sensing::ResidualTest): r = sqrt(Q / n), with the sum of squares Q of weighted residuals, priors and conditions of
//!    an object, and n = their number less the number of unknowns. A residual d beyond 4.5 m is multiplied by 4.5 m / d, with its derivatives
//!    (`sensing::force::linearised`). The trusted noise t is m, or r if chi-squared rejects m (p < 0.01). If m was
//!    estimated from k degrees of freedom, the F distribution decides, and t^2 = (Q + k m^2) / (n + k), at least m^2, times the square of t_0.975(n + k) / 1.96. Without a
//!    stated noise, or with a zero one, t = r t_0.975(n) / 1.96 with Student's quantile.
//! 5. `sensing::force::assessment`: the covariance of the unknowns is t^2 (A^T A)^-1. A has one row for each coordinate (derivative times w_i), prior and
//!    condition of an object. Poses of base and object, leans, errors of the assembly and
//!    thicknesses (`sensing::assembly`) are unknowns with priors, and widen the forces here. sigma^2 is the force's diagonal entry, plus 0.75 (variance across / F)^2 for an unknown direction of a force F.
//! 6. Widening by what the linearisation does not see (`sensing::force::estimator`), with the growth g of Q / t^2 towards other forces:
//!    - one unknown position: if the position is poorly determined, the forces over all positions are a mixture with weights (length of plate) exp(-g / 2),
//!      and the interval follows from its quantiles, at least the linearised interval (`position`, `position_profile`). While markers are hidden and fewer than
//!      20 are seen, sigma is at least the distance of the farther 99.9 % limit of the mixture, divided by 3.29. Otherwise the other minimum that widens most adds
//!      exp(-g / 2) (change of the force)^2, and other positions with g <= 9 raise sigma^2 to (change)^2 / max(1, g) where that exceeds 1.5^2 sigma^2
//!      (`alternatives`);
//!    - few coordinates and known contacts: sigma^2 along each axis of the covariance times 9 / g at three standard deviations (`linear_range`);
//!    - friction: the mean square change of the force at leans of +-sqrt(3) standard deviations, beyond its linear part (`leaning`);
//!    - mesh: a third of the last change by refinement, or all of it if the mesh has not converged (`refine`).
//! 7. [`Estimate`](crate::sensing::Estimate): a misfit with p < 1e-7 multiplies sigma by sqrt(m^2 + 2.5^2 n (r^2 - m^2)) / r; frames of a stream are refused at p < 1e-4 ([`StreamSensor`]). Then sigma becomes
//!    hypot(sigma, `force_error` F, `model_error` F, `stiffness_error` F) for a force F, with `force_error` of `[contact]`, and the `stiffness_error` of
//!    uncertain moduli and depth, see [`Scene::stiffness_error`](crate::scene::Scene). Forces of estimated direction on fingers without rods have a further error, which is largest
//!    near the base (`beam_theory::widen_unknown_directions`). These errors, except the last, are common to all contacts, so that they add in a sum.
//! 8. [`SensedForce::interval_n`]: F -+ 1.96 sigma, or the quantiles of the mixture, widened as sigma is.

mod beam_theory;
mod contact_spec;
mod drift;
mod expected;
mod means;
mod rest;
mod sensed;
mod stream;
mod tracker;
mod unloaded;

pub use contact_spec::{ContactSpec, ContactSpecError, ContactTextError, DirectionSpec, MissingInScene};
pub use drift::ZeroDrift;
pub use expected::{ExpectedSigma, expected_sigma};
pub use rest::{RestError, RestPositions};
pub use sensed::{SensedForce, SensedForces, SensorWarning};
pub use stream::StreamSensor;
pub use tracker::{FingerResult, FingerTracker, FrameState};

use crate::estimators::network::Networks;
use crate::estimators::{EstimatorError, EstimatorId, Kept, PreparedFinger, Question};
use crate::finger::Plate;
use crate::measurement::{BaseUncertainty, Measurement};
use crate::mesh::Mesh;
use crate::observation::{Observation, ObservationError, ObservedMeasurement};
use crate::scene::Scene;
use crate::sensing::{
    Alternative, Contact, ContactQuestion, Direction, MeasuredContact, NearForces, SensingError, TouchedObject,
    UnloadedFinger, Warning,
};
use crate::statics::StaticsError;
use crate::validity::{Validity, ValidityWarning};
use beam_theory::{widen_unknown_directions, with_beam_theory_error};
use std::cell::RefCell;
use std::sync::{Arc, Mutex};

pub use crate::sensing::TWO_SIDED_95;

/// Contacts whose forces are estimated.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorContacts {
    /// Contacts whose positions and directions are known, measured or estimated together with the forces. Forces act on the surface of the scene's pad
    /// or, without a pad, on the surface of plate or rod if friction turns them, and otherwise on the plate's middle line.
    Asked(Vec<ContactQuestion>),
    /// Contacts whose positions and directions are measured with standard deviations. Friction acts on the surface of the scene's pad or, without a
    /// pad, of a rod or of the plate.
    Measured {
        /// The measured contacts.
        contacts: Vec<MeasuredContact>,
        /// Upper bound of the coefficient of friction, dimensionless. A force may lie anywhere in the friction cone.
        friction: f64,
    },
}

impl SensorContacts {
    /// Contacts whose positions and directions are known exactly.
    pub fn known(contacts: &[Contact]) -> SensorContacts {
        SensorContacts::Asked(contacts.iter().map(|&contact| contact.into()).collect())
    }

    /// The questions for the forces on the finger of a scene, each with the surface on which it acts.
    fn questions(&self, scene: &Scene) -> Vec<ContactQuestion> {
        let pad = scene.contact.pad;
        let surface = |position| pad.unwrap_or_else(|| scene.contact.bare_surface(&scene.finger, position));
        let asked = |asked: &ContactQuestion| {
            let has_friction = matches!(asked.direction, Direction::Leaning(lean) if lean.has_friction());
            ContactQuestion { pad: pad.or_else(|| has_friction.then(|| surface(asked.position))), ..*asked }
        };
        match self {
            SensorContacts::Asked(questions) => questions.iter().map(asked).collect(),
            SensorContacts::Measured { contacts, friction } => {
                let asked = |it: &MeasuredContact| it.question(*friction, surface(Some(it.contact.position)));
                contacts.iter().map(asked).collect()
            }
        }
    }
}

/// Estimator, noise and mesh of a [`Sensor`].
#[derive(Debug, Clone)]
pub struct SensorOptions {
    /// The estimator.
    pub estimator: EstimatorId,
    /// Candidate networks for [`EstimatorId::Network`].
    pub networks: Networks,
    /// Standard deviation of one displacement coordinate, mm. Overrides the noise of the scene and of the observations.
    pub noise_mm: Option<f64>,
    /// Number of mesh nodes, for estimators whose mesh can be chosen. If the number is `None`, the estimator chooses it.
    pub mesh_nodes: Option<usize>,
}

impl SensorOptions {
    /// An estimator with the noise of the scene or the observation, and no networks.
    pub fn of(estimator: EstimatorId) -> SensorOptions {
        SensorOptions { estimator, ..SensorOptions::default() }
    }
}

impl Default for SensorOptions {
    /// The nonlinear estimator with the noise of the scene or the observation.
    fn default() -> SensorOptions {
        SensorOptions {
            estimator: EstimatorId::Nonlinear,
            networks: Networks::none().clone(),
            noise_mm: None,
            mesh_nodes: None,
        }
    }
}

/// Estimates contact forces on the finger of a scene.
///
/// A sensor keeps meshes, compliances and the shapes of its last estimates, so that later observations take less time. An estimate depends on
/// earlier observations within the tolerance of the estimator's search only. Sensors made from one [`PreparedScene`] share the meshes and
/// compliances.
///
/// ```
/// use finray_model::observation::Observation;
/// use finray_model::sensing::{Contact, Direction, ContactQuestion};
/// use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
/// use finray_model::{Kinematics, Mesh, NodeId, Scene, statics};
///
/// let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
/// // A simulated observation, without noise, of the finger under 2 N at node 19.
/// let contact = Contact::at_node(NodeId(19));
/// let mesh = Mesh::with_elements_per_member(&scene.finger, 16);
/// let bent = statics::solve(&mesh, &[contact.load(&scene.finger, 2.0)], Kinematics::Corotational)?;
/// let seen = Observation::of_shape(&scene.finger, &bent);
///
/// // The position is unknown; the force acts along the normal of the undeformed plate.
/// let question = ContactQuestion::new(None, Direction::Angle(0.0));
/// let options = SensorOptions { noise_mm: Some(0.01), ..SensorOptions::default() };
/// let sensor = Sensor::new(scene, SensorContacts::Asked(vec![question]), options)?;
/// let sensed = sensor.sense(&seen)?;
/// let [least_n, most_n] = sensed.forces[0].interval_n();
/// assert!(least_n < 2.0 && 2.0 < most_n);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Sensor {
    prepared: PreparedScene,
    contacts: Vec<ContactQuestion>,
    options: SensorOptions,
    /// `None` until the first estimate, and during an estimate.
    kept: Mutex<Option<Box<Kept>>>,
}

/// A scene with the meshes and compliances of its finger, each computed when a sensor first needs it. Clones share them.
#[derive(Debug, Clone)]
pub struct PreparedScene {
    scene: Arc<Scene>,
    meshed: Arc<PreparedFinger>,
}

impl<S: Into<Arc<Scene>>> From<S> for PreparedScene {
    fn from(scene: S) -> PreparedScene {
        let scene = scene.into();
        PreparedScene { meshed: Arc::new(PreparedFinger::new(&scene.finger)), scene }
    }
}

impl std::ops::Deref for PreparedScene {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.scene
    }
}

impl Clone for Sensor {
    /// A sensor with the same meshes and compliances, without the shapes of earlier estimates.
    fn clone(&self) -> Sensor {
        Sensor {
            prepared: self.prepared.clone(),
            contacts: self.contacts.clone(),
            options: self.options.clone(),
            kept: Mutex::default(),
        }
    }
}

/// Without a stated noise, a residual causes a warning if it exceeds both limits: a share of the displacements, and a share of the front plate's length. With
/// correct contacts, the residual of a real finger is below the first limit. A camera's noise is below the second limit.
const LARGE_RESIDUAL: [f64; 2] = [0.1, 0.002];

/// Reason for which no forces are estimated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The observation does not fit the finger of the scene.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// The estimator returns no forces.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// A force is infinite or not a number.
    #[error(
        "not identifiable: a force at contact {contact} hardly moves the measured nodes; measure other nodes, and check that displacements are in mm"
    )]
    NotFinite {
        /// Position of the contact in the list, counted from 1.
        contact: usize,
    },
    /// The markers contradict the sensed forces, for every number of contacts that was tried.
    #[error("no number of contacts explains the markers; with {contacts} contact(s), {warning}")]
    Contradicted {
        /// Number of contacts to which `warning` applies.
        contacts: usize,
        /// The contradiction.
        warning: Warning,
    },
    /// Without a stated noise, forces that may be zero leave a large part of the displacements unexplained.
    #[error("no force at the contacts explains the markers: {0}")]
    Unexplained(SensorWarning),
}

impl From<SensingError> for Refusal {
    fn from(error: SensingError) -> Refusal {
        EstimatorError::from(error).into()
    }
}

impl Sensor {
    /// Combines a scene with contacts and options.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts, because it would refuse every observation.
    pub fn new(
        scene: impl Into<PreparedScene>,
        contacts: SensorContacts,
        options: SensorOptions,
    ) -> Result<Sensor, Refusal> {
        let scene = scene.into();
        if let Some(nodes) = options.mesh_nodes.filter(|_| options.estimator.searches()) {
            Mesh::with_nodes(&scene.finger, nodes).map_err(EstimatorError::from)?;
        }
        let contacts = contacts.questions(&scene);
        options.estimator.admits(&scene.finger, &contacts, &options.networks)?;
        Ok(Sensor { prepared: scene, contacts, options, kept: Mutex::default() })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.prepared
    }

    /// The estimator.
    pub fn estimator(&self) -> EstimatorId {
        self.options.estimator
    }

    /// Estimates the forces of one observation.
    ///
    /// # Errors
    /// [`Refusal`] if the observation does not fit the finger, the estimator returns no forces, or a force is not finite.
    pub fn sense(&self, seen: &Observation) -> Result<SensedForces, Refusal> {
        self.sense_near(seen, None)
    }

    /// The answer in each range of positions that explains an observation, the best first. [`sense`](Sensor::sense) refuses an observation if the forces
    /// of two ranges differ. With one range, the answer is that of `sense`. Empty if no position is unknown.
    ///
    /// # Errors
    /// [`Refusal`] as for `sense`, for any other reason.
    pub fn alternatives(&self, seen: &Observation) -> Result<Vec<Alternative>, Refusal> {
        match self.sense(seen) {
            Ok(sensed) => Ok(sensed.alternatives(&self.scene().finger)),
            Err(Refusal::Estimator(EstimatorError::Sensing(SensingError::TwoRanges { mut alternatives, .. }))) => {
                alternatives.iter_mut().for_each(|alternative| alternative.widen_by(self.force_error()));
                Ok(alternatives)
            }
            Err(refusal) => Err(refusal),
        }
    }

    /// Estimates the forces of one observation like [`sense`](Sensor::sense). `near` contains the forces of an earlier observation. The search starts
    /// from these forces if the observation has enough markers for a unique minimum near the forces. If the minimum near these forces explains the
    /// observation, no other minimum is sought.
    ///
    /// # Errors
    /// [`Refusal`] as for `sense`.
    pub fn sense_near(&self, seen: &Observation, near: Option<&SensedForces>) -> Result<SensedForces, Refusal> {
        let (scene, estimator) = (self.scene(), self.options.estimator);
        let seen = &*seen.renewed(scene).map_err(ObservationError::from)?;
        let stated_noise_mm = self.options.noise_mm.or(scene.noise_mm);
        let found = seen.for_sensing(scene, estimator.searches(), stated_noise_mm)?;
        let ObservedMeasurement { measurement, marker_noise_mm, frame } = found;
        // Networks are trained on equally accurate nodes.
        let measurement = match estimator {
            EstimatorId::Network => measurement.with_markers(|marker| marker.weight = 1.0),
            _ => measurement,
        };
        let object = scene.touched.as_ref().and_then(|touched| touched.seen_from(&frame));
        let unloaded = self.unloaded(&frame, seen);
        let is_from_rest = unloaded.as_ref().is_some_and(|it| it.measured_in_frame_sd_rad.is_some());
        let measurement = match is_from_rest.then(|| seen.base.and_then(|base| base.uncertainty)) {
            None => measurement,
            Some(stated) => measurement.with_base(stated.map(BaseUncertainty::of_two_images)),
        };
        self.estimate(&measurement, marker_noise_mm, object.as_ref(), unloaded.as_ref(), near)
    }

    /// Estimates the forces of displacements in the finger frame, like [`sense_near`](Sensor::sense_near). `marker_noise_mm` is the standard
    /// deviation of one coordinate of weight 1, mm, before the error of beam theory; `None` if it is unknown. The scene's object and assembly
    /// errors, whose place depends on an image, are left out.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator returns no forces, or a force is not finite.
    pub fn sense_displacements(
        &self,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        near: Option<&SensedForces>,
    ) -> Result<SensedForces, Refusal> {
        self.estimate(measurement, marker_noise_mm, None, self.of_uncertain_thickness().as_ref(), near)
    }

    fn estimate(
        &self,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
        object: Option<&TouchedObject>,
        unloaded: Option<&UnloadedFinger>,
        near: Option<&SensedForces>,
    ) -> Result<SensedForces, Refusal> {
        let (measurement, marker_noise_mm) =
            with_beam_theory_error(self.scene().model_error.share(), measurement, marker_noise_mm);
        let near: Option<(Vec<Contact>, Vec<f64>)> =
            near.map(|near| near.forces.iter().map(|sensed| (sensed.contact, sensed.force_n)).unzip());
        // If another thread uses the kept results, this estimate does without them.
        let kept = RefCell::new(self.kept.try_lock().ok().and_then(|mut kept| kept.take()).unwrap_or_default());
        let question = Question {
            prepared: &self.prepared.meshed,
            kept: &kept,
            contacts: &self.contacts,
            object,
            measurement: &measurement,
            marker_noise_mm,
            mesh_nodes: self.options.mesh_nodes,
            networks: &self.options.networks,
            unloaded,
            near: near.as_ref().map(|(contacts, forces_n)| NearForces { contacts, forces_n, shape: None }),
        };
        let answer = self.answer(&question);
        if let Ok(mut own) = self.kept.try_lock() {
            *own = Some(kept.into_inner());
        }
        let sensed = answer?;
        match sensed.forces.iter().position(|sensed| !sensed.force_n.is_finite()) {
            Some(i) => Err(Refusal::NotFinite { contact: i + 1 }),
            None => Ok(sensed),
        }
    }

    /// Relative standard deviation of all forces of an observation: scatter between images, errors of beam theory, and uncertain stiffness.
    fn force_error(&self) -> f64 {
        let Scene { contact, model_error, stiffness_error, .. } = self.scene();
        contact.force_error.hypot(model_error.share()).hypot(stiffness_error.share())
    }

    fn answer(&self, question: &Question) -> Result<SensedForces, Refusal> {
        let estimator = self.options.estimator;
        let (mut contacts, mut estimate) = estimator.answer(&self.scene().finger, question)?;
        // The residual of a linear model also contains the known error of linearisation, which the standard deviations already include.
        if estimator.searches() {
            estimate.widen_for_misfit();
        }
        estimate.add_force_error(self.force_error());
        widen_unknown_directions(self.scene(), &mut contacts, &mut estimate);
        let is_linear = estimator.is_linear();
        let of_model = estimate.warning.map(|warning| SensorWarning::Model { warning, is_linear });
        let no_residual = estimate.trusted_noise_mm.is_infinite().then_some(SensorWarning::NoResidual);
        let (residual_rms_mm, moved_rms_mm) = (estimate.residual_rms_mm, question.measurement.displacement_rms_mm());
        let limits_mm = [moved_rms_mm, self.scene().finger.plate_length_mm(Plate::Front)];
        let is_beyond = |(share, whole_mm)| residual_rms_mm > share * whole_mm;
        let is_large = question.marker_noise_mm.is_none() && LARGE_RESIDUAL.into_iter().zip(limits_mm).all(is_beyond);
        let large_residual = is_large.then_some(SensorWarning::LargeResidual { residual_rms_mm, moved_rms_mm });
        let warnings = of_model.into_iter().chain(no_residual).chain(large_residual).collect();
        let relative_residual = question.marker_noise_mm.map_or(0.0, |noise_mm| residual_rms_mm / noise_mm);
        Ok(SensedForces::new(&contacts, estimate, warnings, relative_residual))
    }

    /// Assumptions of the beam model that fail under the sensed forces, such as small strains or negligible shear.
    ///
    /// # Errors
    /// [`StaticsError`] if the finger has no equilibrium under the forces.
    pub fn assess_validity(&self, sensed: &SensedForces) -> Result<Vec<ValidityWarning>, StaticsError> {
        let finger = &self.scene().finger;
        let loads = sensed.forces.iter().map(|sensed| sensed.contact.load(finger, sensed.force_n));
        Ok(Validity::under(finger, loads)?.warnings(&self.scene().strain_limits))
    }

    /// Warnings about the sensed forces, in words: assumptions of the beam model that fail, or no equilibrium.
    pub fn validity_warnings(&self, sensed: &SensedForces) -> Vec<String> {
        match self.assess_validity(sensed) {
            Ok(warnings) => warnings.iter().map(ToString::to_string).collect(),
            Err(error) => vec![format!("the finger has no equilibrium under the sensed forces: {error}")],
        }
    }
}
