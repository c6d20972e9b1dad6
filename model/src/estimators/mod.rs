//! All force estimators. Each estimator is one row of [`EstimatorId`], so all studies and tables treat estimators equally. A
//! [`Sensor`](crate::sensor::Sensor) asks them.

mod kept;
mod linear;
pub mod network;
mod nonlinear;

pub(crate) use kept::{Kept, PreparedFinger};

use crate::Finger;
use crate::measurement::Measurement;
use crate::mesh::MeshSizeError;
use crate::registry;
use crate::sensing::network::NetworkError;
use crate::sensing::{
    Contact, ContactQuestion, ContactUncertainty, Direction, Estimate, NearForces, Pad, SensingError, TouchedObject,
    UnloadedFinger, check_contacts,
};
use network::{Networks, NoNetwork};
use std::cell::RefCell;

/// Beam elements per member for the nonlinear estimator: the error of this mesh is small compared with the noise.
pub const ELEMENTS: usize = 4;

registry! {
    /// A force estimator.
    EstimatorId: EstimatorRow {
        /// Linear least squares.
        LeastSquares => linear::LEAST_SQUARES,
        /// Linear least squares with the range of forces of Xu et al. (2021) as a prior.
        Ridge => linear::RIDGE,
        /// Gauss-Newton on the co-rotational finger.
        Nonlinear => nonlinear::ROW,
        /// A trained network.
        Network => network::ROW,
    }
}

/// Properties of an estimator. The methods of [`EstimatorId`] describe them.
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
    admits: fn(&Finger, &[ContactQuestion], &Networks) -> Result<(), EstimatorError>,
    answer: fn(&Finger, &Question) -> Result<Answer, EstimatorError>,
}

impl EstimatorId {
    /// Whether the estimated forces are a linear function of the displacements. A linear estimator returns forces for any measurement.
    pub fn is_linear(self) -> bool {
        self.row().is_linear
    }

    /// Whether the estimator solves iteratively for the shape of the co-rotational finger. If no shape fits a measurement, the iterative solution
    /// takes about 100 times as long.
    pub fn searches(self) -> bool {
        self.row().searches
    }

    /// Whether the estimator supports only forces at contact nodes along the normal, as the shipped networks do.
    pub fn at_nodes(self) -> bool {
        self.row().at_nodes
    }

    /// Phrase for help texts that names the information the estimator needs in addition to the displacements.
    pub fn needs(self) -> &'static str {
        self.row().needs
    }

    /// Phrase for help texts that names the contacts and measurements the estimator refuses.
    pub fn refuses(self) -> &'static str {
        self.row().refuses
    }

    /// Phrase for help texts that names the contacts the estimator senses without training for them.
    pub fn unseen_contacts(self) -> &'static str {
        self.row().unseen_contacts
    }

    /// Checks, without a measurement, that the estimator supports the contacts.
    ///
    /// # Errors
    /// [`EstimatorError`] if a contact is wrong or unsupported.
    pub fn admits(
        self,
        finger: &Finger,
        contacts: &[ContactQuestion],
        networks: &Networks,
    ) -> Result<(), EstimatorError> {
        (self.row().admits)(finger, contacts, networks)
    }

    /// Answers one [`Question`]: estimates the forces, with all errors that the estimator states. The command `finray sense` uses this answer.
    ///
    /// # Errors
    /// [`EstimatorError`] if a contact is wrong, or the estimator refuses to answer.
    pub(crate) fn answer(self, finger: &Finger, question: &Question) -> Result<Answer, EstimatorError> {
        let needs_pad = |contact: &ContactQuestion| match contact.pad {
            // A force along the normal of the bare plate has no moment.
            Some(pad) => pad != Pad::default() || contact.direction != Direction::Angle(0.0),
            None => false,
        };
        if question.contacts.iter().any(needs_pad) && !self.searches() {
            return Err(EstimatorError::NoPad);
        }
        if question.unloaded.is_some() && !self.searches() {
            return Err(EstimatorError::NoAssembly);
        }
        (self.row().answer)(finger, question)
    }
}

/// Input of one estimate: the contacts, the measurement and options.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Question<'q> {
    /// The finger, with its meshes.
    pub prepared: &'q PreparedFinger,
    /// Results of earlier measurements for the same contacts.
    pub kept: &'q RefCell<Box<Kept>>,
    /// Contacts whose forces are estimated. Estimators that do not search refuse a contact with a pad.
    pub contacts: &'q [ContactQuestion],
    /// Object that the contacts touch, if its shape and pose are known.
    pub object: Option<&'q TouchedObject>,
    /// The measurement.
    pub measurement: &'q Measurement,
    /// Standard deviation of one displacement coordinate, mm. `None` if unknown.
    pub marker_noise_mm: Option<f64>,
    /// Number of mesh nodes, for estimators whose mesh can be chosen. `None` refines the mesh as needed.
    pub mesh_nodes: Option<usize>,
    /// Candidate networks for [`EstimatorId::Network`].
    pub networks: &'q Networks,
    /// Possible differences between the unloaded finger and the scene's finger. Estimators that do not search refuse a question with such
    /// differences.
    pub unloaded: Option<&'q UnloadedFinger>,
    /// Forces close to the estimate that the measurement will give, from which a search starts. `None` if no forces close to the estimate are known.
    pub near: Option<NearForces<'q>>,
}

/// Contacts with their given or estimated position and direction, and their forces.
pub(crate) type Answer = (Vec<(Contact, ContactUncertainty)>, Estimate);

/// The contacts, all with known position and direction. Returns [`EstimatorError::NotKnown`] if a position or direction is unknown or measured
/// with an error, because most estimators do not support it.
fn known_contacts(finger: &Finger, contacts: &[ContactQuestion]) -> Result<Vec<Contact>, EstimatorError> {
    let known: Option<Vec<Contact>> = contacts.iter().map(|question| question.known()).collect();
    let contacts = known.ok_or(EstimatorError::NotKnown)?;
    check_contacts(finger, &contacts)?;
    Ok(contacts)
}

/// Contacts whose positions and directions are known.
fn as_stated(contacts: &[Contact]) -> Vec<(Contact, ContactUncertainty)> {
    contacts.iter().map(|contact| (*contact, ContactUncertainty::default())).collect()
}

/// Reason for which an estimator returns no forces.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// The forces are not identifiable, or a contact is wrong.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// A network refuses to answer.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// No network is trained for the contacts.
    #[error(transparent)]
    NoNetwork(#[from] NoNetwork),
    /// No mesh has the requested number of nodes.
    #[error(transparent)]
    Mesh(#[from] MeshSizeError),
    /// The estimator does not support positions or directions that are unknown or have a standard deviation.
    #[error("a standard deviation, or a position or direction that is `normal`, `friction`, `object` or `auto` needs the estimator {name}", name = EstimatorId::Nonlinear)]
    NotKnown,
    /// The estimator does not support a pad between object and plate.
    #[error("a scene whose contacts have a pad (pad_mm, pad_length_mm) needs the estimator {name}", name = EstimatorId::Nonlinear)]
    NoPad,
    /// The estimator does not support a finger that differs from the scene's finger.
    #[error("a scene with the table [assembly] or with thickness_sigma needs the estimator {name}", name = EstimatorId::Nonlinear)]
    NoAssembly,
}
