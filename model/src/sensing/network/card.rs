//! Model card of a network: purpose, training and errors.

use super::error::{NetworkError, require};
use super::fingerprint::Fingerprint;
use crate::Kinematics;
use crate::finger::NodeId;
use crate::sensing::{Contact, ContactPosition};
use serde::{Deserialize, Serialize};

/// The version of the file format. Only this version of the file format is written and read.
pub const FORMAT: u32 = 1;

/// Conversion of displacements to the inputs of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scaling {
    /// Principal directions of the training shapes, each scaled to unit standard deviation.
    Principal,
    /// Displacement coordinates, all divided by one common standard deviation.
    Spread,
    /// Displacement coordinates, all divided by the largest absolute coordinate in training.
    Largest,
}

/// Meaning of a network's list of contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactSet {
    /// A force acts at every contact of the list.
    Fixed,
    /// Forces act at one or more contacts of the list. The caller states these contacts.
    AnyOf,
}

/// Settings of the training samples and of the fit. Training with equal settings on the same machine leads to equal weights.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Kinematics of the finger in the samples.
    pub kinematics: Kinematics,
    /// Beam elements per member of the finger in the samples.
    pub elements_per_member: usize,
    /// Number of training shapes.
    pub samples: usize,
    /// Smallest and largest force of a contact, N.
    pub force_range_n: [f64; 2],
    /// Largest sum of the forces, N.
    pub largest_total_n: f64,
    /// Standard deviation of the angle between a force and the direction of its contact, degrees.
    pub direction_spread_deg: f64,
    /// Relative standard deviation of the moduli, dimensionless.
    pub modulus_spread: f64,
    /// Number of free key nodes that are hidden in all samples.
    pub hidden_markers: usize,
    /// Seed of the samples, of the first weights and of the order of the batches.
    pub seed: u64,
    /// Number of passes through the samples before the stored weights were reached. Training may have continued afterwards.
    pub epochs: usize,
}

/// Errors of one force on samples that training did not use.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestError {
    /// Root mean square error with the noise of [`NetworkCard::noise_mm`], N.
    pub rms_n: f64,
    /// Root mean square error without noise, N: the error of the network itself.
    pub clean_rms_n: f64,
}

/// Purpose of a network, its training samples and its errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkCard {
    /// Version of the file format, [`FORMAT`].
    pub format: u32,
    /// Fingerprint of the finger.
    pub finger: Fingerprint,
    /// Measured nodes in the order of the displacement coordinates: ux and uy of each node, mm.
    pub markers: Vec<NodeId>,
    /// The contacts in the order of the outputs.
    pub contacts: Vec<Contact>,
    /// Whether forces act at all contacts, or at contacts that the caller states.
    pub contact_set: ContactSet,
    /// Conversion of displacements to inputs.
    pub scaling: Scaling,
    /// Standard deviation of the noise of one coordinate in training, mm. Zero without noise.
    pub noise_mm: f64,
    /// Standard deviation of a force, N, that ridge regression assumes as a prior for [`ContactSet::AnyOf`].
    pub prior_n: f64,
    /// Settings of the training samples and of the fit.
    pub origin: Origin,
    /// Errors of each contact's force, in the order of the contacts.
    pub test_errors: Vec<TestError>,
    /// Number of samples that were used to compute `test_errors`.
    pub test_samples: usize,
}

impl NetworkCard {
    /// Checks the values of the card.
    ///
    /// # Errors
    /// [`NetworkError`] naming the first wrong key.
    pub(super) fn check(&self) -> Result<(), NetworkError> {
        if self.format != FORMAT {
            return Err(NetworkError::Format { expected: FORMAT, found: self.format.into() });
        }
        let is_listed_before = |i: &usize| self.markers[..*i].contains(&self.markers[*i]);
        require(!self.markers.is_empty(), "markers", "at least one node", "none")?;
        let twice = (0..self.markers.len()).find(is_listed_before);
        require(twice.is_none(), "markers", "every node once", format!("{:?}", self.markers))?;
        let (contacts, errors) = (self.contacts.len(), self.test_errors.len());
        require(contacts > 0, "contacts", "at least one contact", "none")?;
        require(errors == contacts, "test_errors", "one for each contact", errors)?;
        for contact in &self.contacts {
            let position_mm = if let ContactPosition::At(at) = contact.position { at.s_mm } else { 0.0 };
            let is_finite = contact.angle_deg.is_finite() && position_mm.is_finite();
            require(is_finite, "contacts", "finite positions and angles", format!("{contact:?}"))?;
        }
        let is_positive = self.prior_n.is_finite() && self.prior_n > 0.0;
        require(is_positive, "prior_n", "a positive force", self.prior_n)?;
        let origin = &self.origin;
        let [least_n, largest_n] = origin.force_range_n;
        let is_range = least_n.is_finite() && largest_n.is_finite() && least_n <= largest_n;
        require(is_range, "origin.force_range_n", "least, then largest force", format!("{:?}", origin.force_range_n))?;
        let of_tests = self.test_errors.iter();
        let of_tests =
            of_tests.flat_map(|of| [("test_errors.rms_n", of.rms_n), ("test_errors.clean_rms_n", of.clean_rms_n)]);
        let numbers = [
            ("noise_mm", self.noise_mm),
            ("origin.largest_total_n", origin.largest_total_n),
            ("origin.direction_spread_deg", origin.direction_spread_deg),
            ("origin.modulus_spread", origin.modulus_spread),
        ];
        numbers.into_iter().chain(of_tests).try_for_each(|(key, value)| {
            require(value.is_finite() && value >= 0.0, key, "a number of zero or more", value)
        })
    }
}
