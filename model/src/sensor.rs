//! Estimates contact forces and their intervals from observations of a finger.
//!
//! A [`Sensor`] combines a scene with contacts, an estimator and a noise level. It turns each [`Observation`] into forces with standard deviations and
//! warnings, or refuses it with a reason. An observation comes from an image, a table or a simulation.

mod asked;
mod drift;
mod means;
mod rest;
mod stream;
mod watched;

pub use asked::{AskedContact, AskedContactsError, AskedDirection, MissingInScene};
pub use drift::ZeroDrift;
pub use rest::RestPositions;
pub use stream::StreamSensor;
pub use watched::{FingerResult, FrameState, WatchedFinger};

use crate::Vector;
use crate::estimators::network::Networks;
use crate::estimators::{BeamTheoryError, EstimatorError, EstimatorId, Question};
use crate::finger::{Finger, Plate};
use crate::measurement::{BaseUncertainty, Measurement};
use crate::mesh::Mesh;
use crate::observation::{Observation, ObservationError, ObservedMeasurement};
use crate::scene::Scene;
use crate::sensing::{
    AssemblyErrors, CameraAbove, Contact, ContactKnowledge, ContactQuestion, MeasuredContact, MeasuredContactForces,
    NearForces, Refinement, SensingError, UnloadedFinger, Warning, sense_measured_contacts,
};
use crate::statics::StaticsError;
use crate::validity::{Doubt, Validity};
use nalgebra::{Isometry2, Point2};

/// Half the width of a two-sided 95 % interval of a normal distribution, in standard deviations.
pub const TWO_SIDED_95: f64 = 1.96;
/// Beam elements per member for measured contacts. Objects bend the finger more than single forces of the same size. With four elements per member,
/// the error of the mesh would be 0.1 % of the force.
const ELEMENTS_UNDER_OBJECTS: usize = 8;

/// Contacts whose forces are estimated.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorContacts {
    /// Contacts whose positions and directions are either known exactly or estimated together with the forces.
    Asked(Vec<ContactQuestion>),
    /// Contacts whose positions and directions are measured with standard deviations. The forces follow by least squares with errors in all variables.
    Measured {
        /// The measured contacts.
        contacts: Vec<MeasuredContact>,
        /// Upper bound of the coefficient of friction, dimensionless. A force may lie anywhere in the friction cone.
        friction: f64,
    },
}

/// Estimator, noise and mesh of a [`Sensor`].
#[derive(Debug, Clone, Copy)]
pub struct SensorOptions<'n> {
    /// The estimator.
    pub estimator: EstimatorId,
    /// Candidate networks for [`EstimatorId::Network`].
    pub networks: &'n Networks,
    /// Standard deviation of one displacement coordinate, mm. Overrides the noise of the scene and of the observations.
    pub noise_mm: Option<f64>,
    /// Number of mesh nodes, for estimators whose mesh can be chosen. If the number is `None`, the estimator chooses it.
    pub mesh_nodes: Option<usize>,
}

impl Default for SensorOptions<'_> {
    /// The nonlinear estimator with the noise of the scene or the observation.
    fn default() -> Self {
        SensorOptions {
            estimator: EstimatorId::Nonlinear,
            networks: Networks::none(),
            noise_mm: None,
            mesh_nodes: None,
        }
    }
}

/// Estimates contact forces on the finger of a scene.
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
/// let question = ContactQuestion { position: None, direction: Direction::Angle(0.0) };
/// let options = SensorOptions { noise_mm: Some(0.01), ..SensorOptions::default() };
/// let sensor = Sensor::new(&scene, SensorContacts::Asked(vec![question]), options)?;
/// let sensed = sensor.sense(&seen)?;
/// let [least_n, most_n] = sensed.interval_n(0);
/// assert!(least_n < 2.0 && 2.0 < most_n);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Sensor<'s> {
    scene: &'s Scene,
    contacts: SensorContacts,
    options: SensorOptions<'s>,
}

/// Estimated forces, in the order of the contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedForces {
    /// Position and direction of each contact, given or estimated.
    pub contacts: Vec<Contact>,
    /// Force of each contact along its direction, N.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N, including the noise and the known error of the model.
    pub sigmas_n: Vec<f64>,
    /// Reasons why the forces may be less accurate than their standard deviations, or requests to state the noise. Empty without warnings.
    pub warnings: Vec<SensorWarning>,
    /// Forces along and across the direction of each contact. `None` unless the contacts were measured.
    measured: Option<MeasuredContactForces>,
}

/// Without a stated noise, a residual causes a warning if it exceeds both limits: a share of the displacements, and a share of the front plate's length. With
/// correct contacts, the residual of a real finger is below the first limit. A camera's noise is below the second limit.
const LARGE_RESIDUAL: [f64; 2] = [0.1, 0.002];

/// A reason why the forces may be less accurate than their standard deviations, or a request to state the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorWarning {
    /// The measurement contradicts the model, or the error of the model exceeds the noise.
    Model {
        /// The contradiction or the error of the model.
        warning: Warning,
        /// Whether the estimator is linear.
        is_linear: bool,
    },
    /// The standard deviations are infinite, because no residual remains from which to estimate the noise.
    NoResidual,
    /// No noise is stated, and the residual is a large share of the displacements: the contacts or the finger may be wrong.
    LargeResidual {
        /// Root mean square of the residual, mm.
        residual_rms_mm: f64,
        /// Root mean square of the displacements, mm.
        moved_rms_mm: f64,
    },
}

impl std::fmt::Display for SensorWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (warning, is_linear) = match self {
            SensorWarning::Model { warning, is_linear } => (warning, is_linear),
            SensorWarning::NoResidual => {
                return f.write_str(
                    "sigma_n is infinite: no noise is stated, and there are as many unknowns as measured \
                        coordinates, so no residual remains from which the noise could be estimated; state the noise \
                        (--noise-mm)",
                );
            }
            SensorWarning::LargeResidual { residual_rms_mm, moved_rms_mm } => {
                return write!(
                    f,
                    "no noise is stated, and the residual is {residual_rms_mm:.3} mm rms (displacement: \
                        {moved_rms_mm:.3} mm rms), so sigma_n is too small unless the noise is as large as the \
                        residual; check the contacts and the finger, or state the noise (--noise-mm)"
                );
            }
        };
        let advice = match warning {
            Warning::UnknownLinearisation => "sigma_n does not include this error",
            Warning::Residual(_) if *is_linear => {
                "sigma_n follows from the residual and includes the error of linearisation; --estimator nonlinear \
                    avoids the error of linearisation, so its warnings have other causes, such as wrong contacts"
            }
            _ if *is_linear => "sigma_n includes the error of linearisation, which --estimator nonlinear avoids",
            Warning::Residual(_) => {
                "sigma_n follows from the residual and does not include errors of a wrong model; check the contacts, their directions, the finger's \
                 dimensions and the stated noise"
            }
            _ => "sigma_n includes this error",
        };
        write!(f, "{warning}; {advice}")
    }
}

/// Reason for which no forces are estimated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
    /// Measured contacts require a known base, no pad, and the nonlinear estimator. The text names the unmet condition.
    #[error("contacts with standard deviations need {0}")]
    MeasuredContacts(&'static str),
}

impl From<SensingError> for Refusal {
    fn from(error: SensingError) -> Refusal {
        EstimatorError::from(error).into()
    }
}

impl<'s> Sensor<'s> {
    /// Combines a scene with contacts and options.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts, because it would refuse every observation.
    pub fn new(scene: &'s Scene, contacts: SensorContacts, options: SensorOptions<'s>) -> Result<Sensor<'s>, Refusal> {
        if let Some(nodes) = options.mesh_nodes.filter(|_| options.estimator.searches()) {
            Mesh::with_nodes(&scene.finger, nodes).map_err(EstimatorError::from)?;
        }
        match &contacts {
            SensorContacts::Asked(questions) => options.estimator.admits(&scene.finger, questions, options.networks)?,
            SensorContacts::Measured { contacts, .. } => {
                if options.estimator != EstimatorId::Nonlinear {
                    return Err(Refusal::MeasuredContacts("the nonlinear estimator"));
                }
                if !scene.contact.pad.is_none() {
                    return Err(Refusal::MeasuredContacts("a scene whose contacts have no pad"));
                }
                if scene.assembly.is_some() {
                    return Err(Refusal::MeasuredContacts("a scene without the table [assembly]"));
                }
                let contacts: Vec<Contact> = contacts.iter().map(|measured| measured.contact).collect();
                crate::sensing::check_contacts(&scene.finger, &contacts)?;
            }
        }
        Ok(Sensor { scene, contacts, options })
    }

    /// Estimates the forces of one observation. The result does not depend on earlier observations.
    ///
    /// # Errors
    /// [`Refusal`] if the observation does not fit the finger, the estimator returns no forces, or a force is not finite.
    pub fn sense(&self, seen: &Observation) -> Result<SensedForces, Refusal> {
        self.sense_near(seen, None)
    }

    /// Estimates the forces of one observation like [`sense`](Sensor::sense). `near` contains the forces of an earlier observation. The search starts
    /// from these forces if the observation has enough markers for a unique minimum near the forces. If the minimum near these forces explains the
    /// observation, no other minimum is sought.
    ///
    /// # Errors
    /// [`Refusal`] as for `sense`.
    pub fn sense_near(&self, seen: &Observation, near: Option<&SensedForces>) -> Result<SensedForces, Refusal> {
        self.sense_keeping(seen, near, None)
    }

    /// Meshes and shapes that the estimator keeps from one observation of a stream to the next. `None` for estimators that keep nothing.
    fn refinement(&self) -> Option<Refinement<'s>> {
        let SensorContacts::Asked(questions) = &self.contacts else { return None };
        let keeps = self.options.estimator == EstimatorId::Nonlinear
            && self.options.mesh_nodes.is_none()
            && self.scene.assembly.is_none();
        keeps.then(|| Refinement::new(&self.scene.finger, questions, self.scene.contact.pad))
    }

    /// Estimates the forces like [`sense_near`](Sensor::sense_near). `kept` is this sensor's [`refinement`](Sensor::refinement).
    fn sense_keeping(
        &self,
        seen: &Observation,
        near: Option<&SensedForces>,
        kept: Option<&mut Refinement>,
    ) -> Result<SensedForces, Refusal> {
        let (scene, SensorOptions { estimator, noise_mm, .. }) = (self.scene, self.options);
        let noise_mm = noise_mm.or(scene.noise_mm);
        let found = seen.for_sensing(scene, estimator.searches(), noise_mm)?;
        // Weights are equal if the noise is stated, because it applies to all nodes, and for networks, because they are trained on equally accurate
        // nodes.
        let stated_mm = noise_mm.map(|noise_mm| scene.marker_errors.sd_mm(noise_mm));
        let is_uniform = stated_mm.is_some() || estimator == EstimatorId::Network;
        let ObservedMeasurement { measurement, noise_mm, frame } = found;
        let measurement = if is_uniform { measurement.with_markers(|marker| marker.weight = 1.0) } else { measurement };
        let error = BeamTheoryError(scene.model_error);
        let (measurement, noise_mm) = error.in_markers(measurement, stated_mm.or(noise_mm));
        let sensed = match &self.contacts {
            SensorContacts::Asked(questions) => {
                let object = scene.touched.as_ref().and_then(|touched| touched.seen_from(&frame));
                let unloaded = scene.assembly.clone().map(|assembly| self.unloaded(assembly, &frame, seen));
                let is_from_rest = unloaded.as_ref().is_some_and(|it| it.measured_in_frame_sd_rad.is_some());
                let measurement = match is_from_rest.then(|| seen.base.and_then(|base| base.uncertainty)) {
                    None => measurement,
                    Some(stated) => measurement.with_base(stated.map(BaseUncertainty::of_two_images)),
                };
                let question = Question {
                    contacts: questions,
                    pad: scene.contact.pad,
                    object: object.as_ref(),
                    measurement: &measurement,
                    noise_mm,
                    mesh_nodes: self.options.mesh_nodes,
                    networks: self.options.networks,
                    unloaded: unloaded.as_ref(),
                    near: near.map(|near| NearForces { contacts: &near.contacts, forces_n: &near.forces_n }),
                };
                self.answered(&question, kept)?
            }
            SensorContacts::Measured { contacts, friction } => {
                self.of_measured(contacts, *friction, &measurement, noise_mm)?
            }
        };
        match sensed.forces_n.iter().position(|force| !force.is_finite()) {
            Some(i) => Err(Refusal::NotFinite { contact: i + 1 }),
            None => Ok(sensed),
        }
    }

    /// Possible errors of the unloaded finger, as seen in one observation. `frame` transforms from the finger frame to the reference frame of the
    /// camera's pose.
    fn unloaded(&self, assembly: AssemblyErrors, frame: &Isometry2<f64>, seen: &Observation) -> UnloadedFinger {
        let scene = self.scene;
        let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
        let camera = scene.camera.and_then(|camera| camera.pose).zip(scene.markers).map(|(pose, markers)| {
            let eye = (frame.inverse() * Point2::from(pose.eye().xy())).coords;
            // The camera is assumed to be equally high above base references and markers.
            let middle = match references {
                [] => eye,
                some => some.iter().map(|reference| reference.at).sum::<Vector>() / some.len() as f64,
            };
            CameraAbove { eye, middle, distance_mm: pose.eye().z - markers.height_mm }
        });
        let base_sd_rad = scene.base.as_ref().and_then(|base| base.uncertainty).map_or(0.0, |base| base.sd_rad);
        let measured_in_frame_sd_rad = seen.counts_from_rest(&scene.finger).then_some(base_sd_rad);
        UnloadedFinger { assembly, camera, measured_in_frame_sd_rad }
    }

    /// Relative standard deviation of a force due to scatter between images and the errors of beam theory.
    fn force_error(&self) -> f64 {
        self.scene.contact.force_error.hypot(self.scene.model_error)
    }

    fn answered(&self, question: &Question, kept: Option<&mut Refinement>) -> Result<SensedForces, Refusal> {
        let estimator = self.options.estimator;
        let (contacts, mut estimate) = match kept {
            Some(kept) => {
                let &Question { object, measurement, noise_mm, near, .. } = question;
                let found = kept.sense(object, measurement, noise_mm, near)?;
                (found.contacts, found.forces)
            }
            None => estimator.answer(&self.scene.finger, question)?,
        };
        // The residual of a linear model also contains the known error of linearisation, which the standard deviations already include.
        if estimator.searches() {
            estimate.widen_for_misfit();
        }
        estimate.add_force_error(self.force_error());
        let is_linear = estimator.is_linear();
        let of_model = estimate.warning.map(|warning| SensorWarning::Model { warning, is_linear });
        let no_residual = estimate.noise_mm.is_infinite().then_some(SensorWarning::NoResidual);
        let (residual_rms_mm, moved_rms_mm) = (estimate.residual_rms_mm, question.measurement.displacement_rms_mm());
        let limits_mm = [moved_rms_mm, self.scene.finger.plate_length_mm(Plate::Front)];
        let is_beyond = |(share, whole_mm)| residual_rms_mm > share * whole_mm;
        let is_large = question.noise_mm.is_none() && LARGE_RESIDUAL.into_iter().zip(limits_mm).all(is_beyond);
        let large_residual = is_large.then_some(SensorWarning::LargeResidual { residual_rms_mm, moved_rms_mm });
        Ok(SensedForces {
            contacts,
            forces_n: estimate.forces_n,
            sigmas_n: estimate.sigmas_n,
            warnings: of_model.into_iter().chain(no_residual).chain(large_residual).collect(),
            measured: None,
        })
    }

    fn of_measured(
        &self,
        contacts: &[MeasuredContact],
        friction: f64,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<SensedForces, Refusal> {
        if measurement.base().is_some() {
            return Err(Refusal::MeasuredContacts("a base that is known exactly"));
        }
        let noise_mm = noise_mm.ok_or(SensingError::NoiseNotStated)?;
        let finger = &self.scene.finger;
        let mesh = match self.options.mesh_nodes {
            None => Mesh::with_elements_per_member(finger, ELEMENTS_UNDER_OBJECTS),
            Some(nodes) => Mesh::with_nodes(finger, nodes).map_err(EstimatorError::from)?,
        };
        let knowledge = ContactKnowledge { noise_mm, friction, rod_radius_mm: self.scene.contact.rod_radius_mm };
        let mut measured = sense_measured_contacts(&mesh, contacts, measurement, knowledge)?;
        measured.add_force_error(self.force_error());
        let unexplained = measured.unexplained;
        let warning = |test| SensorWarning::Model { warning: Warning::Residual(test), is_linear: false };
        Ok(SensedForces {
            contacts: measured.contacts.clone(),
            forces_n: measured.along_n.clone(),
            sigmas_n: measured.sigmas_n.clone(),
            warnings: unexplained.map(warning).into_iter().collect(),
            measured: Some(measured),
        })
    }

    /// Assumptions of the beam model that fail under the sensed forces, such as small strains or negligible shear.
    ///
    /// # Errors
    /// [`StaticsError`] if the finger has no equilibrium under the forces.
    pub fn doubts(&self, sensed: &SensedForces) -> Result<Vec<Doubt>, StaticsError> {
        let finger = &self.scene.finger;
        let forces = sensed.contacts.iter().zip(&sensed.forces_n);
        let validity = Validity::under(finger, forces.map(|(contact, &force_n)| contact.load(finger, force_n)))?;
        Ok(validity.doubts(&self.scene.strain_limits))
    }

    /// Warnings about the sensed forces, in words: assumptions of the beam model that fail, or no equilibrium.
    pub fn validity_warnings(&self, sensed: &SensedForces) -> Vec<String> {
        match self.doubts(sensed) {
            Ok(doubts) => doubts.iter().map(ToString::to_string).collect(),
            Err(error) => vec![format!("the finger has no equilibrium under the sensed forces: {error}")],
        }
    }
}

impl SensedForces {
    /// Lower and upper limit of the 95 % interval of a contact's force, N. `contact` counts from 0.
    pub fn interval_n(&self, contact: usize) -> [f64; 2] {
        let reach_n = TWO_SIDED_95 * self.sigmas_n[contact];
        [self.forces_n[contact] - reach_n, self.forces_n[contact] + reach_n]
    }

    /// Sum of all forces along the unit vector `along` (finger frame) and its standard deviation, both N. Unless the contacts were measured, the
    /// standard deviation is an upper bound that holds for any correlation of the forces.
    pub fn sum_along(&self, finger: &Finger, along: Vector) -> [f64; 2] {
        if let Some(measured) = &self.measured {
            return measured.sum_along(finger, along);
        }
        let shares: Vec<f64> =
            self.contacts.iter().map(|contact| finger.direction(contact.angle_deg).dot(&along)).collect();
        let sum = |values: &[f64], share: fn(f64) -> f64| -> f64 {
            shares.iter().zip(values).map(|(of, value)| share(*of) * value).sum()
        };
        [sum(&self.forces_n, |share| share), sum(&self.sigmas_n, f64::abs)]
    }
}
