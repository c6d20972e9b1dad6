//! Estimates forces and their standard deviations with a network, in microseconds.

use super::error::require;
use super::forward::{Forward, Instructions};
use super::further::FurtherContact;
use super::hidden::{directions, filling};
use super::prepared::Prepared;
use super::{ContactSet, Fingerprint, Network, NetworkError, Origin, Scaling};
use crate::Kinematics;
use crate::finger::{Finger, NodeId, Plate};
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::sensing::residual_test::noise_of;
use crate::sensing::{
    Contact, Estimate, ResidualTest, SensingError, UNEXPLAINED_SHARE, UNEXPLAINED_SIGMAS, Warning, check_contacts,
};
use crate::statics::Statics;
use nalgebra::{DMatrix, DVector};

/// Largest difference between two contacts that count as equal: in position (as a share of the plate's length) and in angle (in degrees).
const SAME_CONTACT: f64 = 1e-9;
/// An input is refused if it exceeds `RANGE_FACTOR` times the largest input in training, plus `RANGE_SIGMAS` standard deviations of the input's
/// noise. The margin admits extremes that the training samples miss.
const RANGE_FACTOR: f64 = 1.1;
const RANGE_SIGMAS: f64 = 4.0;
/// Ratio of the element counts of the two meshes whose shapes show the error of the training's mesh. The error falls at least with the square of the
/// element length, so the finer mesh has at most a sixteenth of it.
const FINER: usize = 4;
/// The error of the mesh is taken from the largest range of forces divided by 2, 4, ... up to this power of two. A finger that carries none of these
/// forces was not trained.
const MOST_HALVINGS: u32 = 6;

/// Estimates forces with a network, for the contacts and markers for which it is prepared.
///
/// # Requirements
/// Requires the finger for which the network was trained, and all contacts of the training in any order. [`ContactSet::AnyOf`] requires only the
/// contacts at which forces act. Markers may be hidden if the network's inputs are principal directions.
#[derive(Debug, Clone)]
pub struct NetworkEstimator {
    forward: Forward,
    prepared: Prepared,
    markers: Vec<NodeId>,
    /// Mean of each measured coordinate in training, mm.
    mean: DVector<f64>,
    /// Orthonormal columns that span the measured coordinates of the principal directions.
    span: DMatrix<f64>,
    /// Covariance of the inputs due to hidden markers, dimensionless.
    hidden_covariance: DMatrix<f64>,
    /// Largest absolute inputs in training, dimensionless. `input_noise` is the standard deviation of each input per mm of noise, 1/mm.
    largest: Vec<f64>,
    input_noise: Vec<f64>,
    clean_rms_n: Vec<f64>,
    /// Error of each force per N of each force, dimensionless, due to the mesh of the training.
    mesh_error: DMatrix<f64>,
    noise_mm: f64,
    force_range_n: [f64; 2],
    largest_total_n: f64,
    /// For [`ContactSet::AnyOf`], the contacts of the training at which no force is assumed.
    further: Vec<FurtherContact>,
}

impl NetworkEstimator {
    /// Prepares a network for contacts and for the nodes of a measurement's markers. This function uses only the nodes of `markers`, not their
    /// displacements.
    ///
    /// # Errors
    /// [`NetworkError`] for a finger, contacts or markers other than those of the training, or for fewer coordinates than forces.
    pub fn new(
        network: &Network,
        finger: &Finger,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<NetworkEstimator, NetworkError> {
        NetworkEstimator::with_instructions(network, finger, contacts, markers, Instructions::Detected)
    }

    /// Like [`NetworkEstimator::new`], but with a given instruction set.
    ///
    /// # Errors
    /// [`NetworkError`] as from [`NetworkEstimator::new`].
    pub fn with_instructions(
        network: &Network,
        finger: &Finger,
        contacts: &[Contact],
        markers: &Measurement,
        instructions: Instructions,
    ) -> Result<NetworkEstimator, NetworkError> {
        network.check()?;
        check_contacts(finger, contacts)?;
        let selected = selection(network, finger, contacts)?;
        let markers: Vec<NodeId> = markers.markers().iter().map(|marker| marker.node).collect();
        let seen = seen_coordinates(network, &markers)?;
        if contacts.len() > seen.len() {
            let (unknowns, coordinates) = (contacts.len(), seen.len());
            return Err(SensingError::TooFewMarkers { unknowns, coordinates }.into());
        }
        let known = network.card.markers.len();
        let hidden_markers = NetworkError::HiddenMarkers { expected: known, found: markers.len() };
        if markers.len() < known && network.card.scaling != Scaling::Principal {
            return Err(hidden_markers);
        }
        let (matrix, missed) = filling(network, &seen).ok_or(hidden_markers)?;
        let all_mean = DVector::from_column_slice(&network.inputs.mean);
        let mean = all_mean.select_rows(&seen);
        let of_constant = &all_mean - &matrix * &mean;
        let measured = |mut prepared: Prepared| {
            // The inputs are P (mean + F (x_s - mean_s)) + offset for measured coordinates x_s; all terms except P F x_s are constant.
            let constant = &prepared.projection * &of_constant;
            prepared.offset.iter_mut().zip(&constant).for_each(|(offset, constant)| *offset += constant);
            let hidden_covariance = &prepared.projection * &missed * prepared.projection.transpose();
            prepared.projection *= &matrix;
            (prepared, hidden_covariance)
        };
        let (prepared, hidden_covariance) = measured(Prepared::new(network, &selected, &selected));
        let is_any_of = network.card.contact_set == ContactSet::AnyOf && selected.len() < seen.len();
        let others = (0..network.contact_count()).filter(|contact| is_any_of && !selected.contains(contact));
        let further = others.map(|contact| {
            let touching: Vec<usize> = selected.iter().copied().chain([contact]).collect();
            let (prepared, hidden_covariance) = measured(Prepared::new(network, &touching, &[contact]));
            let clean_rms_n = network.card.test_errors[contact].clean_rms_n;
            FurtherContact { contact: network.card.contacts[contact], prepared, hidden_covariance, clean_rms_n }
        });
        let further = further.collect();
        let seen_directions = directions(network).select_columns(&seen).transpose();
        let input_noise = network.inputs.projection.row_iter().map(|row| row.norm()).collect();
        let mut estimator = NetworkEstimator {
            forward: Forward::new(&prepared, instructions),
            prepared,
            markers,
            mean,
            // With at least as many principal directions as measured coordinates, the columns span all measured coordinates.
            span: seen_directions.qr().q(),
            hidden_covariance,
            largest: network.inputs.largest.clone(),
            input_noise,
            clean_rms_n: selected.iter().map(|&k| network.card.test_errors[k].clean_rms_n).collect(),
            mesh_error: DMatrix::zeros(0, 0),
            noise_mm: network.card.noise_mm,
            force_range_n: network.card.origin.force_range_n,
            largest_total_n: network.card.origin.largest_total_n,
            further,
        };
        estimator.mesh_error = estimator.error_of_mesh(&network.card.origin, finger, contacts);
        Ok(estimator)
    }

    /// Change of each force per N of each true force, if the shapes are those of a mesh several times as fine as that of the training. It is taken
    /// from single forces of half the training's range, or the largest smaller force that the finger carries.
    fn error_of_mesh(&mut self, origin: &Origin, finger: &Finger, contacts: &[Contact]) -> DMatrix<f64> {
        let mut error = DMatrix::zeros(contacts.len(), contacts.len());
        if origin.kinematics == Kinematics::Linear {
            // Key nodes of a linear finger do not depend on the mesh.
            return error;
        }
        let meshes = [1, FINER].map(|by| Mesh::with_elements_per_member(finger, by * origin.elements_per_member));
        for (j, contact) in contacts.iter().enumerate() {
            for halvings in 1..=MOST_HALVINGS {
                let force_n = origin.force_range_n[1] / f64::from(1 << halvings);
                let mut sensed = |mesh: &Mesh| {
                    let load = mesh.frame_load(&contact.load(finger, force_n)).ok()?;
                    let motion = Statics::ladder(mesh, origin.kinematics).equilibrium(&[load]).ok()?.motion;
                    let shape = mesh.shape(&motion);
                    let displacement = |node: &NodeId| shape.motion(*node).marker_displacement(finger);
                    let x: Vec<f64> = self.markers.iter().map(displacement).flat_map(|u| [u.x, u.y]).collect();
                    let mut forces_n = vec![0.0; contacts.len()];
                    self.forward.forces(&x, &mut forces_n);
                    Some(DVector::from_vec(forces_n))
                };
                let [coarse, fine] = [&meshes[0], &meshes[1]].map(&mut sensed);
                if let Some((coarse, fine)) = coarse.zip(fine) {
                    error.set_column(j, &((fine - coarse) / force_n));
                    break;
                }
            }
        }
        error
    }

    /// Number of contacts for which the estimator is prepared.
    pub fn contact_count(&self) -> usize {
        self.prepared.outputs()
    }

    /// Estimates the forces of one frame. `displacements` contains ux, uy of each marker in the order of the markers, mm. `forces_n` receives the
    /// forces in the order of the contacts, N. The evaluation allocates no memory and checks no ranges: if displacements are NaN, forces are NaN.
    ///
    /// # Errors
    /// [`NetworkError::Part`] if a slice has the wrong length.
    pub fn forces(&mut self, displacements: &[f64], forces_n: &mut [f64]) -> Result<(), NetworkError> {
        let (coordinates, contacts) = (self.forward.coordinates(), self.prepared.outputs());
        require(displacements.len() == coordinates, "displacements", coordinates, displacements.len())?;
        require(forces_n.len() == contacts, "forces", contacts, forces_n.len())?;
        self.forward.forces(displacements, forces_n);
        Ok(())
    }

    /// Estimates forces with their standard deviations. The standard deviations combine four errors: noise, hidden markers, the network's error on
    /// held-out samples, and the error of the mesh of its training. The network's derivatives linearise the effects of noise and hidden markers.
    /// `marker_noise_mm` is the standard deviation of one coordinate, mm. The noise is estimated from the residual if `marker_noise_mm` is `None` or
    /// contradicts the residual.
    ///
    /// The residual is the part of the displacements outside the principal directions. The singular values of the estimate are the reciprocals of the
    /// singular values of the forces' derivatives with respect to the displacements.
    ///
    /// # Errors
    /// [`NetworkError`] for markers other than the prepared ones, for weights other than 1, for shapes or forces outside the training, and for
    /// [`ContactSet::AnyOf`] if a force acts at another contact of the training.
    pub fn estimate(
        &mut self,
        measurement: &Measurement,
        marker_noise_mm: Option<f64>,
    ) -> Result<Estimate, NetworkError> {
        if !measurement.markers().iter().map(|marker| marker.node).eq(self.markers.iter().copied()) {
            return Err(NetworkError::OtherMarkers);
        }
        if let Some(marker) = measurement.markers().iter().find(|marker| marker.weight != 1.0) {
            return Err(NetworkError::Weighted { node: marker.node, weight: marker.weight });
        }
        let x: Vec<f64> = measurement.markers().iter().flat_map(|m| [m.displacement.x, m.displacement.y]).collect();
        let (trusted_noise_mm, residual_rms_mm, warning) =
            self.residual(&DVector::from_column_slice(&x), marker_noise_mm)?;
        let z = self.prepared.inputs(&x);
        self.require_range(&z, trusted_noise_mm)?;
        let mut forces_n = vec![0.0; self.prepared.outputs()];
        self.forward.forces(&x, &mut forces_n);

        let (_, derivatives) = self.prepared.forces_and_derivatives(&z);
        let gain = &derivatives * &self.prepared.projection;
        // Errors of the network and of its training's mesh count as independent between forces.
        let forces = DVector::from_column_slice(&forces_n);
        let of_mesh_n = &self.mesh_error * &forces;
        let method_error_n: Vec<f64> = self
            .clean_rms_n
            .iter()
            .zip(&of_mesh_n)
            .map(|(clean_rms_n, of_mesh_n)| clean_rms_n.hypot(*of_mesh_n))
            .collect();
        let clean_n2 = method_error_n.iter().map(|error_n| error_n.powi(2));
        let covariance_n2 = &gain * gain.transpose() * trusted_noise_mm.powi(2)
            + &derivatives * &self.hidden_covariance * derivatives.transpose()
            + DMatrix::from_diagonal(&DVector::from_iterator(forces.len(), clean_n2));
        let sigmas_n: Vec<f64> = covariance_n2.diagonal().iter().map(|variance_n2| variance_n2.sqrt()).collect();
        self.require_trained_forces(&forces_n, &sigmas_n)?;
        let further = self.further.iter().map(|contact| contact.force(&x, trusted_noise_mm));
        if let Some((_, Some(refusal))) = further.max_by(|(a, _), (b, _)| a.total_cmp(b)) {
            return Err(refusal);
        }
        let mut singular_values: Vec<f64> = gain.singular_values().iter().map(|value| value.recip()).collect();
        singular_values.sort_by(|a, b| b.total_cmp(a));
        Ok(Estimate {
            forces_n,
            sigmas_n,
            covariance_n2,
            sides_n: None,
            method_error_n,
            measured: None,
            alternatives: Vec::new(),
            trusted_noise_mm,
            warning,
            residual_rms_mm,
            singular_values,
        })
    }

    /// Tests the residual against the stated noise (chi-squared test). The residual is the part of the displacements `x`, mm, outside the principal
    /// directions. For noise-free training shapes, the residual is negligible. Returns the noise (mm), the root mean square of the residual (mm), and
    /// a warning if the residual exceeds the stated noise significantly. The standard deviations of the forces follow from the returned noise.
    fn residual(
        &self,
        x: &DVector<f64>,
        marker_noise_mm: Option<f64>,
    ) -> Result<(f64, f64, Option<Warning>), SensingError> {
        let coordinates = x.len() as f64;
        let from_mean = x - &self.mean;
        let residual = &from_mean - &self.span * self.span.tr_mul(&from_mean);
        let residual_rms_mm = (residual.norm_squared() / coordinates).sqrt();
        let moved_rms_mm = (x.norm_squared() / coordinates).sqrt();
        let explained = |noise_mm: f64| {
            residual_rms_mm <= f64::max(UNEXPLAINED_SIGMAS * noise_mm, UNEXPLAINED_SHARE * moved_rms_mm)
        };
        if marker_noise_mm.is_some_and(|noise_mm| !explained(noise_mm)) {
            return Err(SensingError::Unexplained { residual_rms_mm, moved_rms_mm });
        }
        let degrees_of_freedom = x.len().saturating_sub(self.span.ncols());
        let test = ResidualTest::new(marker_noise_mm, residual.norm_squared(), degrees_of_freedom);
        let trusted_noise_mm = noise_of(test, marker_noise_mm, residual.norm_squared(), degrees_of_freedom);
        Ok((trusted_noise_mm, residual_rms_mm, test.filter(ResidualTest::contradicts).map(Warning::Residual)))
    }

    /// Refuses inputs outside the range of the training.
    fn require_range(&self, z: &[f64], noise_mm: f64) -> Result<(), NetworkError> {
        // If the noise is unknown, the noise of the training widens the range.
        let noise_mm = if noise_mm.is_finite() { noise_mm } else { self.noise_mm };
        for (i, (&largest, per_mm)) in self.largest.iter().zip(&self.input_noise).enumerate() {
            let value = z[i].abs();
            if value > RANGE_FACTOR * largest + RANGE_SIGMAS * noise_mm * per_mm {
                let largest_total_n = self.largest_total_n;
                return Err(NetworkError::OutsideTraining { input: i + 1, value, largest, largest_total_n });
            }
        }
        Ok(())
    }

    /// Refuses forces outside the range of the training. Estimated forces may be outside the range of the training if the true forces act at other
    /// contacts than assumed.
    fn require_trained_forces(&self, forces_n: &[f64], sigmas_n: &[f64]) -> Result<(), NetworkError> {
        let [least_n, largest_n] = self.force_range_n;
        for (i, (&force_n, sigma_n)) in forces_n.iter().zip(sigmas_n).enumerate() {
            let chance_n = RANGE_SIGMAS * sigma_n;
            if force_n < least_n - chance_n || force_n > RANGE_FACTOR * largest_n + chance_n {
                return Err(NetworkError::ForceOutsideTraining { contact: i + 1, force_n, least_n, largest_n });
            }
        }
        Ok(())
    }
}

impl Network {
    /// Checks that the network was trained for `finger` and `contacts`. `contacts` must be all contacts of the network's list in any order. For
    /// [`ContactSet::AnyOf`], `contacts` may also be only some contacts of the list.
    ///
    /// # Errors
    /// [`NetworkError::AnotherFinger`] or [`NetworkError::OtherContacts`] if the network was trained for another finger or other contacts.
    pub fn check_made_for(&self, finger: &Finger, contacts: &[Contact]) -> Result<(), NetworkError> {
        selection(self, finger, contacts).map(|_| ())
    }
}

/// Indices of `contacts` in the network's list of contacts.
fn selection(network: &Network, finger: &Finger, contacts: &[Contact]) -> Result<Vec<usize>, NetworkError> {
    let found = Fingerprint::of(finger);
    if found != network.card.finger {
        let (trained, found) = (network.card.finger.to_string(), found.to_string());
        return Err(NetworkError::AnotherFinger { trained, found });
    }
    let trained = &network.card.contacts;
    let length_mm = finger.plate_length_mm(Plate::Front);
    let same = |a: &Contact, b: &Contact| match (a.position_mm(finger), b.position_mm(finger)) {
        (Some(one_mm), Some(other_mm)) if a.position.plate() == b.position.plate() => {
            (one_mm - other_mm).abs() <= SAME_CONTACT * length_mm && (a.angle_deg - b.angle_deg).abs() <= SAME_CONTACT
        }
        _ => false,
    };
    let positions: Option<Vec<usize>> =
        contacts.iter().map(|contact| trained.iter().position(|other| same(contact, other))).collect();
    let any_of = network.card.contact_set == ContactSet::AnyOf;
    let positions = positions.filter(|positions| {
        let once = positions.iter().enumerate().all(|(k, position)| !positions[..k].contains(position));
        once && (any_of || positions.len() == trained.len())
    });
    positions.ok_or_else(|| NetworkError::OtherContacts {
        trained: format!("{} {}", if any_of { "any of the contacts" } else { "exactly the contacts" }, listed(trained)),
        asked: listed(contacts),
    })
}

fn listed(contacts: &[Contact]) -> String {
    contacts.iter().map(Contact::to_string).collect::<Vec<_>>().join(", ")
}

/// Indices of the measured coordinates among the network's coordinates.
fn seen_coordinates(network: &Network, markers: &[NodeId]) -> Result<Vec<usize>, NetworkError> {
    let known = &network.card.markers;
    let mut seen = Vec::with_capacity(2 * markers.len());
    for &node in markers {
        let position = known.iter().position(|other| *other == node);
        let position = position.ok_or(NetworkError::UnknownMarker { node, known: known.len() })?;
        seen.extend([2 * position, 2 * position + 1]);
    }
    Ok(seen)
}
