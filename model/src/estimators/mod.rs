//! Every way to sense forces, one file and one row of [`EstimatorId`] each: maps, scatter and tables put them all to the same test.
//!
//! An [`Estimator`] is shared by threads; each thread prepares its own [`PreparedEstimator`] for the contacts and markers of
//! a question. Every estimate starts afresh: what was sensed before does not count.

mod beam;
mod linear;
pub mod network;
mod nonlinear;

pub use beam::BeamEstimator;

use crate::measurement::Measurement;
use crate::mesh::MeshSizeError;
use crate::registry;
use crate::sensing::network::NetworkError;
use crate::sensing::{
    Contact, ContactQuestion, Estimate, Pad, SensingError, TouchedObject, UnloadedFinger, check_contacts,
};
use crate::{Finger, Mesh};
use network::{Networks, NoNetwork};

/// Elements a member on which the nonlinear estimator works: the error of this mesh is small beside the noise.
pub const ELEMENTS: usize = 4;

registry! {
    /// A way to sense forces.
    EstimatorId: EstimatorRow {
        /// Linear least squares.
        LeastSquares => linear::LEAST_SQUARES,
        /// Linear least squares with the paper's range of forces as a prior.
        Ridge => linear::RIDGE,
        /// Gauss-Newton on the co-rotational finger.
        Nonlinear => nonlinear::ROW,
        /// A trained network.
        Network => network::ROW,
    }
}

/// Properties of a kind of estimator: see the methods of [`EstimatorId`].
struct EstimatorRow {
    name: &'static str,
    label: &'static str,
    help: &'static str,
    is_linear: bool,
    searches: bool,
    at_nodes: bool,
    needs: &'static str,
    refuses: &'static str,
    unseen_contacts: &'static str,
    mesh: fn(&Finger) -> Mesh,
    on: for<'m> fn(&'m Mesh, &'m Networks) -> Box<dyn Estimator + 'm>,
    admits: fn(&Finger, &[ContactQuestion], &Networks) -> Result<(), EstimatorError>,
    answer: fn(&Finger, &Question) -> Result<Answer, EstimatorError>,
}

impl EstimatorId {
    /// Whether the forces are a linear function of the displacements, so that it answers whatever it is shown.
    pub fn is_linear(self) -> bool {
        self.row().is_linear
    }

    /// Whether it searches for the shape of the co-rotational finger that fits: one that does not costs it a hundred times as much.
    pub fn searches(self) -> bool {
        self.row().searches
    }

    /// Whether it answers at the contact nodes and along the normal alone, as networks that ship do.
    pub fn at_nodes(self) -> bool {
        self.row().at_nodes
    }

    /// What it must be given, beside the displacements.
    pub fn needs(self) -> &'static str {
        self.row().needs
    }

    /// What it does not answer.
    pub fn refuses(self) -> &'static str {
        self.row().refuses
    }

    /// Which contacts it senses without having seen them before.
    pub fn unseen_contacts(self) -> &'static str {
        self.row().unseen_contacts
    }

    /// The mesh of a finger that it works on.
    pub fn mesh(self, finger: &Finger) -> Mesh {
        (self.row().mesh)(finger)
    }

    /// The estimator on its [mesh](EstimatorId::mesh), with networks to choose from.
    pub fn on<'m>(self, mesh: &'m Mesh, networks: &'m Networks) -> Box<dyn Estimator + 'm> {
        (self.row().on)(mesh, networks)
    }

    /// Refuses contacts that it cannot sense, whatever is measured.
    ///
    /// # Errors
    /// [`EstimatorError`] for wrong contacts, or such as the estimator is not made for.
    pub fn admits(
        self,
        finger: &Finger,
        contacts: &[ContactQuestion],
        networks: &Networks,
    ) -> Result<(), EstimatorError> {
        (self.row().admits)(finger, contacts, networks)
    }

    /// One answer with all that the estimator states, as `finray sense` gives it.
    ///
    /// # Errors
    /// [`EstimatorError`] for wrong contacts, or if the estimator refuses to answer.
    pub fn answer(self, finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
        if !question.pad.is_none() && !self.searches() {
            return Err(EstimatorError::NoPad);
        }
        if question.unloaded.is_some() && !self.searches() {
            return Err(EstimatorError::NoAssembly);
        }
        (self.row().answer)(finger, question)
    }
}

/// Request to an estimator, prepared once.
#[derive(Debug, Clone, Copy)]
pub struct Question<'q> {
    /// The contacts.
    pub contacts: &'q [ContactQuestion],
    /// What lies between objects and the plate; estimators that do not search refuse a pad.
    pub pad: Pad,
    /// The object that contacts touch, where its shape and pose are known.
    pub object: Option<&'q TouchedObject>,
    /// The measurement.
    pub measurement: &'q Measurement,
    /// Standard deviation of one coordinate, mm; `None` if unknown.
    pub noise_mm: Option<f64>,
    /// Nodes of the mesh, where the estimator lets one choose; `None`: as many as are needed.
    pub mesh_nodes: Option<usize>,
    /// Networks to choose from.
    pub networks: &'q Networks,
    /// How the unloaded finger may differ from the scene's; estimators that do not search refuse it.
    pub unloaded: Option<&'q UnloadedFinger>,
}

/// Contacts whose position and direction are now known, and their forces.
pub type Answer = (Vec<Contact>, Estimate);

/// Contacts of known position and direction: all that most estimators can sense.
fn known_contacts(finger: &Finger, contacts: &[ContactQuestion]) -> Result<Vec<Contact>, EstimatorError> {
    let known: Option<Vec<Contact>> = contacts.iter().map(|question| question.known()).collect();
    let contacts = known.ok_or(EstimatorError::NotKnown)?;
    check_contacts(finger, &contacts)?;
    Ok(contacts)
}

/// A way to sense forces of known position and direction.
pub trait Estimator: Sync {
    /// Which estimator it is.
    fn id(&self) -> EstimatorId;

    /// Prepares for contacts, and for the markers of a measurement; their displacements are not used yet.
    ///
    /// # Errors
    /// [`EstimatorError`] when a contact is wrong, the problem has no unique answer or the estimator is not made for it.
    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError>;

    /// The same estimator, to rounding, with what all contacts have in common worked out once; `None` where that gains
    /// nothing. If the true finger is linear, a linear estimator seeks no error of linearisation.
    fn for_many(&self, _finger_is_linear: bool) -> Option<Box<dyn Estimator + '_>> {
        None
    }
}

/// An estimator that is ready to sense, measurement by measurement.
pub trait PreparedEstimator {
    /// Senses the forces from its markers' displacements. `noise_mm`: standard deviation of a coordinate, if known.
    ///
    /// # Errors
    /// [`EstimatorError`] when the estimator refuses to answer.
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError>;

    /// Announces that the next `samples` measurements are `noise_free` plus noise: a search may start from there.
    fn expect_samples_of(&mut self, _noise_free: &Measurement, _noise_mm: f64, _samples: usize) {}

    /// Says near which forces (N) the next measurement's are, for a search to start. For bounds, at the true forces, alone.
    fn expect_forces(&mut self, _forces_n: &[f64]) {}
}

/// Sensed forces, with as much as the estimator states of their errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensed {
    /// Force of each contact along its direction, N, in the order of the contacts.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N.
    pub sigmas_n: Option<Vec<f64>>,
    /// Standard deviation of the sum of the forces, N.
    pub sum_sigma_n: Option<f64>,
    /// Whether the estimator warns: the measurement contradicts its model, or the model errs by more than noise does.
    pub warned: bool,
}

/// Why an estimator does not answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// The forces are not identifiable, or the contacts are wrong.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// A network refuses.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// No network is made for the contacts.
    #[error(transparent)]
    NoNetwork(#[from] NoNetwork),
    /// The mesh that was asked for cannot be made.
    #[error("--mesh-nodes: {0}")]
    Mesh(#[from] MeshSizeError),
    /// Positions and directions that are sought with the forces.
    #[error("a position or direction that is `normal`, `friction`, `object` or `auto` needs --estimator {name}", name = EstimatorId::Nonlinear)]
    NotKnown,
    /// A pad between object and plate.
    #[error("a scene whose contacts have a pad (pad_mm, pad_length_mm) needs --estimator {name}", name = EstimatorId::Nonlinear)]
    NoPad,
    /// A finger that may have been assembled otherwise.
    #[error("a scene with the table assembly needs --estimator {name}", name = EstimatorId::Nonlinear)]
    NoAssembly,
}
