//! What a camera sees of a deformed finger: displacements of the key nodes' markers, without rotations.

use crate::Vector;
use crate::finger::{Finger, NodeId};
use crate::mesh::FingerShape;

pub mod noise;

pub use noise::DisplacementNoise;

/// One measured node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// The node.
    pub node: NodeId,
    /// Measured displacement, mm, finger frame.
    pub displacement: Vector,
    /// How much the marker counts: its coordinates have the standard deviation noise / weight. 1 for all alike.
    pub weight: f64,
}

/// How well the base is known from which displacements count: standard deviations of an error that all markers share, and how it gives way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BaseUncertainty {
    /// Of each coordinate of the origin, mm.
    pub sd_mm: f64,
    /// Of the turn about it, rad.
    pub sd_rad: f64,
    /// The turn that is expected, from x to y, rad a newton of all forces together: zero of a base that is measured under them.
    pub turn_rad_per_n: f64,
    /// Standard deviation of that turn, rad a newton: it counts the more the larger the forces are.
    pub turn_sd_rad_per_n: f64,
}

impl BaseUncertainty {
    /// That of the difference of two images.
    pub(crate) fn of_two_images(self) -> BaseUncertainty {
        let both = std::f64::consts::SQRT_2;
        BaseUncertainty { sd_mm: both * self.sd_mm, sd_rad: both * self.sd_rad, ..self }
    }

    /// Standard deviation of the turn under forces of a sum, rad.
    pub fn sd_rad_under(&self, force_n: f64) -> f64 {
        self.sd_rad.hypot(self.turn_sd_rad_per_n * force_n)
    }
}

/// Measured displacements of some of a finger's free key nodes, each at most once; of nodes at one point, that of their junction.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    markers: Vec<Marker>,
    base: Option<BaseUncertainty>,
    shared_errors: Vec<SharedError>,
}

/// An error that all markers share: by how much one standard deviation of it displaces each key node's marker, mm.
pub type SharedError = Vec<Vector>;

/// A measurement that does not belong to the finger.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MeasurementError {
    /// No such node.
    #[error("node {node} does not exist: the finger has the key nodes 1 to {key_nodes}")]
    UnknownNode {
        /// The node named.
        node: NodeId,
        /// Number of key nodes.
        key_nodes: usize,
    },
    /// A node stands there twice.
    #[error("node {node} is listed twice")]
    Repeated {
        /// The node named.
        node: NodeId,
    },
    /// A coordinate or weight is not a finite number.
    #[error("node {node}: expected finite numbers")]
    NotFinite {
        /// The node named.
        node: NodeId,
    },
    /// Nodes at one point of a plate have different displacements.
    #[error(
        "node {node} is at the same point of the plate as another node listed, which has moved differently: list one of them"
    )]
    SharedMoves {
        /// The node named.
        node: NodeId,
    },
    /// A clamped node moved.
    #[error("node {node} is clamped, so its displacement must be zero: are the rows numbered in another way?")]
    ClampedMoves {
        /// The node named.
        node: NodeId,
    },
}

/// Errors of a finger's markers beside what is stated of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkerErrors {
    /// Their own, against what is stated: below one where part of that is the same in all images, and so is in what was calibrated.
    pub noise_factor: f64,
    /// By how much the finger that is described misses them, mm: standard deviation of one coordinate.
    pub model_mm: f64,
}

impl Default for MarkerErrors {
    /// As stated.
    fn default() -> MarkerErrors {
        MarkerErrors { noise_factor: 1.0, model_mm: 0.0 }
    }
}

impl MarkerErrors {
    /// Standard deviation of a coordinate of which one is stated, mm.
    pub fn sd_mm(&self, stated_mm: f64) -> f64 {
        (self.noise_factor * stated_mm).hypot(self.model_mm)
    }
}

impl Measurement {
    /// Checks markers against a finger. Clamped nodes at zero are left out.
    ///
    /// # Errors
    /// [`MeasurementError`] for the first marker that is unknown, repeated, not finite, or clamped and yet moving.
    pub fn new(finger: &Finger, markers: impl IntoIterator<Item = Marker>) -> Result<Measurement, MeasurementError> {
        let mut measurement = Measurement::empty();
        for marker in markers {
            measurement.add(finger, marker)?;
        }
        Ok(measurement)
    }

    /// A measurement in which no node is seen yet.
    pub fn empty() -> Measurement {
        Measurement { markers: Vec::new(), base: None, shared_errors: Vec::new() }
    }

    /// Adds one marker; see [`Measurement::new`]. Nodes at one point have one marker: rows of both count once.
    ///
    /// # Errors
    /// [`MeasurementError`], with the measurement unchanged.
    pub fn add(&mut self, finger: &Finger, marker: Marker) -> Result<(), MeasurementError> {
        let node = marker.node;
        let key_nodes = finger.key_node_count();
        if !(1..=key_nodes).contains(&node.0) {
            return Err(MeasurementError::UnknownNode { node, key_nodes });
        }
        let finite = marker.displacement.iter().all(|u| u.is_finite()) && marker.weight.is_finite();
        if !finite || marker.weight <= 0.0 {
            return Err(MeasurementError::NotFinite { node });
        }
        if finger.is_clamped(node) {
            return match marker.displacement == Vector::zeros() {
                true => Ok(()),
                false => Err(MeasurementError::ClampedMoves { node }),
            };
        }
        let junction = finger.junction(node);
        let Some(other) = self.markers.iter().find(|other| other.node == junction) else {
            self.markers.push(Marker { node: junction, ..marker });
            return Ok(());
        };
        let is_shared =
            junction != node || finger.free_nodes().any(|free| free != node && finger.junction(free) == node);
        match is_shared {
            false => Err(MeasurementError::Repeated { node }),
            true if other.displacement == marker.displacement => Ok(()),
            true => Err(MeasurementError::SharedMoves { node }),
        }
    }

    /// All markers of a computed shape, as a camera without noise would see them.
    pub fn of_shape(finger: &Finger, shape: &FingerShape) -> Measurement {
        let marker = |node| Marker { node, displacement: shape.motion(node).marker_displacement(finger), weight: 1.0 };
        Measurement { markers: finger.marked_nodes().map(marker).collect(), ..Measurement::empty() }
    }

    /// All markers of a finger that nothing bends.
    pub fn at_rest(finger: &Finger) -> Measurement {
        let marker = |node| Marker { node, displacement: Vector::zeros(), weight: 1.0 };
        Measurement { markers: finger.marked_nodes().map(marker).collect(), ..Measurement::empty() }
    }

    /// The same measurement from a base not known exactly, which the nonlinear estimator seeks with the forces; others do not.
    pub fn with_uncertain_base(self, base: BaseUncertainty) -> Measurement {
        self.with_base(Some(base))
    }

    /// The same measurement from another base: `None` if it is known exactly.
    pub(crate) fn with_base(mut self, base: Option<BaseUncertainty>) -> Measurement {
        self.base = base;
        self
    }

    /// How well the base is known; `None` if exactly.
    pub fn base(&self) -> Option<BaseUncertainty> {
        self.base
    }

    /// The same measurement with further errors that markers share, independent of each other, which the nonlinear estimator seeks with the forces;
    /// others do not.
    pub fn with_shared_errors(mut self, errors: Vec<SharedError>) -> Measurement {
        self.shared_errors = errors;
        self
    }

    /// Errors that markers share, beside that of the base.
    pub fn shared_errors(&self) -> &[SharedError] {
        &self.shared_errors
    }

    /// The same measurement with other displacements.
    pub(crate) fn displaced(mut self, displacement: impl Fn(&Marker) -> Vector) -> Measurement {
        for marker in &mut self.markers {
            marker.displacement = displacement(marker);
        }
        self
    }

    /// The same measurement with every weight times a share.
    pub(crate) fn reweighted(&self, mut share: impl FnMut(&Marker) -> f64) -> Measurement {
        let mut measurement = self.clone();
        for marker in &mut measurement.markers {
            marker.weight *= share(marker);
        }
        measurement
    }

    /// The same measurement with every marker as good as the others.
    pub fn of_equal_weight(mut self) -> Measurement {
        for marker in &mut self.markers {
            marker.weight = 1.0;
        }
        self
    }

    /// The same measurement without the markers of hidden nodes.
    pub fn without(mut self, hidden: &[NodeId]) -> Measurement {
        self.markers.retain(|marker| !hidden.contains(&marker.node));
        self
    }

    /// Adds noise to every coordinate: `standard_normal` is called for each and scaled with `noise_mm` / weight.
    pub fn add_noise(&mut self, noise_mm: f64, mut standard_normal: impl FnMut() -> f64) {
        for marker in &mut self.markers {
            marker.displacement += Vector::new(standard_normal(), standard_normal()) * (noise_mm / marker.weight);
        }
    }

    /// The markers.
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// Number of measured coordinates, two a marker.
    pub fn coordinate_count(&self) -> usize {
        2 * self.markers.len()
    }
}
