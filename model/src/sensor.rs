//! From what was seen of a finger to the forces on it: observations in, forces with intervals out.
//!
//! A [`Sensor`] is a scene with a question: which contacts, which estimator, which noise. Every [`Observation`] that it is given, from an image, a
//! table or a simulation, becomes forces with standard deviations and warnings, or is refused with the reason.

mod unloaded;

use crate::Vector;
use crate::estimators::network::Networks;
use crate::estimators::{EstimatorError, EstimatorId, Question};
use crate::finger::Finger;
use crate::measurement::{BaseUncertainty, Measurement};
use crate::mesh::Mesh;
use crate::observation::{Observation, ObservationError, ObservedMeasurement};
use crate::scene::Scene;
use crate::sensing::{
    Contact, ContactKnowledge, ContactQuestion, Direction, Lean, MeasuredContact, MeasuredContactForces, Normal,
    SensingError, Warning, sense_measured_contacts,
};
use crate::statics::StaticsError;
use crate::validity::{Doubt, Validity};

/// Standard deviations on each side of a force that 95 % of all normally distributed errors stay within.
pub const TWO_SIDED_95: f64 = 1.96;
/// Elements a member of the finger that senses measured contacts: objects bend it farther than single forces of the same size, and with four,
/// 0.1 % of the force would be left of the mesh.
const ELEMENTS_UNDER_OBJECTS: usize = 8;

/// The contacts whose forces are sought.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorContacts {
    /// Positions and directions that are known exactly, or sought with the forces.
    Asked(Vec<ContactQuestion>),
    /// Positions and directions that were measured. Sensed by least squares with errors in all variables.
    Measured {
        /// The contacts.
        contacts: Vec<MeasuredContact>,
        /// Largest coefficient of friction: a force may lie anywhere in its cone.
        friction: f64,
    },
}

/// How forces are sensed.
#[derive(Debug, Clone, Copy)]
pub struct SensorOptions<'n> {
    /// The estimator.
    pub estimator: EstimatorId,
    /// Networks to choose from, for [`EstimatorId::Network`].
    pub networks: &'n Networks,
    /// Standard deviation of one coordinate, mm, in place of the scene's and of those that observations state.
    pub noise_mm: Option<f64>,
    /// Nodes of the mesh, where the estimator lets one choose; `None`: as many as are needed.
    pub mesh_nodes: Option<usize>,
}

impl Default for SensorOptions<'_> {
    /// The nonlinear estimator, with the noise of scene or observation.
    fn default() -> Self {
        SensorOptions {
            estimator: EstimatorId::Nonlinear,
            networks: Networks::none(),
            noise_mm: None,
            mesh_nodes: None,
        }
    }
}

/// Senses forces on the finger of a scene.
///
/// ```
/// use finray_model::observation::Observation;
/// use finray_model::sensing::{Contact, Direction, ContactQuestion};
/// use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
/// use finray_model::{Kinematics, Mesh, NodeId, Scene, statics};
///
/// let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE)?;
/// // What a camera sees of the finger under 2 N at node 19, here without noise.
/// let contact = Contact::at_node(NodeId(19));
/// let mesh = Mesh::with_elements_per_member(&scene.finger, 16);
/// let bent = statics::solve(&mesh, &[contact.load(&scene.finger, 2.0)], Kinematics::Corotational)?;
/// let seen = Observation::of_shape(&scene.finger, &bent);
///
/// // Its position is sought with the force, along the normal of the undeformed plate.
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

/// Sensed forces, in the order of the contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct SensedForces {
    /// Position and direction of each contact, as given or found.
    pub contacts: Vec<Contact>,
    /// Force of each contact along its direction, N.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N: of the noise, and of the model's error as far as it is known.
    pub sigmas_n: Vec<f64>,
    /// Reasons to trust the forces less than their standard deviations say, or to state more.
    pub warnings: Vec<SensorWarning>,
    /// The same forces with the components across, where the contacts were measured.
    measured: Option<MeasuredContactForces>,
}

/// A reason to trust forces less, or to state more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorWarning {
    /// The measurement contradicts the model, or the model errs by more than noise does.
    Model {
        /// The contradiction.
        warning: Warning,
        /// Whether the estimator is linear.
        is_linear: bool,
    },
    /// The standard deviation is infinite: nothing is left to estimate the noise from.
    NoResidual,
}

impl std::fmt::Display for SensorWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let SensorWarning::Model { warning, is_linear } = self else {
            return f.write_str(
                "as many unknowns as measured coordinates leave no residual to estimate the noise from; give --noise-mm for a finite sigma_n",
            );
        };
        let advice = match warning {
            Warning::UnknownLinearisation => "sigma_n does not hold it",
            _ if *is_linear => {
                "sigma_n holds the error of linearisation; --estimator nonlinear does without linearisation, where it answers"
            }
            Warning::Residual(_) => {
                "sigma_n rests on the residual and does not hold what a wrong model does; check the contacts, their directions, the \
                 finger's dimensions and the noise"
            }
            _ => "sigma_n holds that error",
        };
        write!(f, "{warning}; {advice}")
    }
}

/// Why no forces are sensed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The observation is none of the finger.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// The estimator does not answer.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// A force is infinite or not a number.
    #[error(
        "not identifiable: a force at contact {contact} hardly moves the measured nodes, or the displacements are not those of a finger in mm"
    )]
    NotFinite {
        /// Position of the contact in the list, from 1.
        contact: usize,
    },
    /// Measured contacts are sensed on a known base, without a pad, by the nonlinear estimator.
    #[error("contacts with standard deviations: expected {0}")]
    MeasuredContacts(&'static str),
}

impl From<SensingError> for Refusal {
    fn from(error: SensingError) -> Refusal {
        EstimatorError::from(error).into()
    }
}

impl<'s> Sensor<'s> {
    /// Checks contacts and options against a scene.
    ///
    /// # Errors
    /// [`Refusal`] of contacts that the estimator cannot sense, whatever is observed.
    pub fn new(scene: &'s Scene, contacts: SensorContacts, options: SensorOptions<'s>) -> Result<Sensor<'s>, Refusal> {
        match &contacts {
            SensorContacts::Asked(questions) => options.estimator.admits(&scene.finger, questions, options.networks)?,
            SensorContacts::Measured { contacts, .. } => {
                if options.estimator != EstimatorId::Nonlinear {
                    return Err(Refusal::MeasuredContacts("the nonlinear estimator"));
                }
                if !scene.contact.pad.is_none() {
                    return Err(Refusal::MeasuredContacts("a scene whose contacts have no pad"));
                }
                let contacts: Vec<Contact> = contacts.iter().map(|measured| measured.contact).collect();
                crate::sensing::check_contacts(&scene.finger, &contacts)?;
            }
        }
        Ok(Sensor { scene, contacts, options })
    }

    /// Forces of one observation. Every observation counts by itself: the order in which they come does not matter.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn sense(&self, seen: &Observation) -> Result<SensedForces, Refusal> {
        let (scene, SensorOptions { estimator, noise_mm, .. }) = (self.scene, self.options);
        let noise_mm = noise_mm.or(scene.noise_mm);
        let found = seen.for_sensing(scene, estimator.searches(), noise_mm)?;
        // A stated noise holds for all nodes alike, and networks are trained on nodes that are measured alike.
        let stated_mm = noise_mm.map(|noise_mm| scene.marker_errors.sd_mm(noise_mm));
        let is_uniform = stated_mm.is_some() || estimator == EstimatorId::Network;
        let ObservedMeasurement { measurement, noise_mm, frame } = found;
        let noise_mm = stated_mm.or(noise_mm);
        let measurement = if is_uniform { measurement.of_equal_weight() } else { measurement };
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
                };
                self.answered(&question)?
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

    fn answered(&self, question: &Question) -> Result<SensedForces, Refusal> {
        let estimator = self.options.estimator;
        let at_once = question.unloaded.and_then(|unloaded| self.all_at_once(question, unloaded));
        let (contacts, mut estimate) = at_once.unwrap_or_else(|| estimator.answer(&self.scene.finger, question))?;
        estimate.add_force_error(self.scene.contact.force_error);
        let is_linear = estimator.is_linear();
        let of_model = estimate.warning.map(|warning| SensorWarning::Model { warning, is_linear });
        let no_residual = estimate.noise_mm.is_infinite().then_some(SensorWarning::NoResidual);
        Ok(SensedForces {
            contacts,
            forces_n: estimate.forces_n,
            sigmas_n: estimate.sigmas_n,
            warnings: of_model.into_iter().chain(no_residual).collect(),
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
        let measured = sense_measured_contacts(&mesh, contacts, measurement, knowledge)?;
        Ok(SensedForces {
            contacts: measured.contacts.clone(),
            forces_n: measured.along_n.clone(),
            sigmas_n: measured.sigmas_n.clone(),
            warnings: Vec::new(),
            measured: Some(measured),
        })
    }

    /// Where the beam model does not hold under sensed forces: strains that are not small, thick members.
    ///
    /// # Errors
    /// [`StaticsError`] where the finger has no equilibrium under them.
    pub fn doubts(&self, sensed: &SensedForces) -> Result<Vec<Doubt>, StaticsError> {
        let finger = &self.scene.finger;
        let forces = sensed.contacts.iter().zip(&sensed.forces_n);
        let validity = Validity::under(finger, forces.map(|(contact, &force_n)| contact.load(finger, force_n)))?;
        Ok(validity.doubts(&self.scene.strain_limits))
    }
}

impl SensedForces {
    /// Interval of a contact's force, N, that holds the true one in 95 % of all cases.
    pub fn interval_n(&self, contact: usize) -> [f64; 2] {
        let reach_n = TWO_SIDED_95 * self.sigmas_n[contact];
        [self.forces_n[contact] - reach_n, self.forces_n[contact] + reach_n]
    }

    /// Sum of all forces along a unit vector of the finger frame, and its standard deviation, N. Where the contacts were not measured, the deviation is the
    /// most that those of the contacts can add up to.
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

/// Direction of a force as a user asks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AskedDirection {
    /// A direction, whatever the scene has.
    Itself(Direction),
    /// Leaning from the plate's normal by the friction of the scene's table `contact`.
    Friction,
    /// The same from the normal of the scene's table `contact.object`.
    Object,
    /// As the force of the image was measured.
    Measured,
}

/// A direction needs what the scene does not have, or a measured force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MissingInScene {
    /// The friction.
    #[error("a direction is `friction`: expected friction or friction_range in the scene's table contact")]
    Friction,
    /// The object.
    #[error("a direction is `object`: expected a table contact.object in the scene")]
    Object,
    /// The measured force.
    #[error("a direction is `measured`: expected the measured force of the image (--forces)")]
    Measured,
}

impl AskedDirection {
    /// The direction with what a scene knows of friction and object; `measured_deg` is that of the measured force, degrees.
    ///
    /// # Errors
    /// [`MissingInScene`].
    pub fn of_scene(self, scene: &Scene, measured_deg: Option<f64>) -> Result<Direction, MissingInScene> {
        let friction = scene.contact.lean;
        match self {
            AskedDirection::Itself(direction) => Ok(direction),
            AskedDirection::Measured => measured_deg.map(Direction::Angle).ok_or(MissingInScene::Measured),
            AskedDirection::Friction => friction.map(Direction::Leaning).ok_or(MissingInScene::Friction),
            AskedDirection::Object => {
                let object = scene.touched.as_ref().ok_or(MissingInScene::Object)?;
                // Without a known place of the object, only tangency of plate and outline is known.
                let from = match object.place {
                    Some(_) => Normal::Object,
                    None => Normal::Deformed { over_mm: 0.0 },
                };
                Ok(Direction::Leaning(Lean { from, ..friction.unwrap_or(Lean::NONE) }))
            }
        }
    }
}
