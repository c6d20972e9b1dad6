//! Measurements of a deformed finger: displacements of the markers on its key nodes, without rotations.

use crate::Vector;
use crate::finger::{Finger, NodeId};
use crate::mesh::FingerShape;

/// Measured displacement of one node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// The node.
    pub node: NodeId,
    /// Measured displacement, mm, finger frame.
    pub displacement: Vector,
    /// Relative accuracy, dimensionless: coordinates have the standard deviation noise / weight. The weight is 1 if all markers are equally accurate.
    pub weight: f64,
}

/// Uncertainty of the base to which displacements refer. This uncertainty consists of the error of the base's pose, which all markers share, and the
/// base's rotation under force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BaseUncertainty {
    /// Standard deviation of each coordinate of the base's origin, mm.
    pub sd_mm: f64,
    /// Standard deviation of the rotation of the base about its origin, rad.
    pub sd_rad: f64,
    /// Expected rotation of the base, positive from x to y, in rad per newton of the sum of all forces. Zero if the base is measured under load.
    pub turn_rad_per_n: f64,
    /// Standard deviation of `turn_rad_per_n`, rad per newton.
    pub turn_sd_rad_per_n: f64,
}

impl BaseUncertainty {
    /// This uncertainty together with an independent error of the pose. The rotation under force stays.
    pub(crate) fn and(self, error: BaseUncertainty) -> BaseUncertainty {
        BaseUncertainty { sd_mm: self.sd_mm.hypot(error.sd_mm), sd_rad: self.sd_rad.hypot(error.sd_rad), ..self }
    }

    /// Uncertainty of the difference between the poses of the base in two images.
    pub(crate) fn of_two_images(self) -> BaseUncertainty {
        let both = std::f64::consts::SQRT_2;
        BaseUncertainty { sd_mm: both * self.sd_mm, sd_rad: both * self.sd_rad, ..self }
    }
}

/// Measured displacements of free key nodes, each node at most once. Nodes at one point of a plate share the displacement of their junction.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    markers: Vec<Marker>,
    base: Option<BaseUncertainty>,
    shared_errors: Vec<SharedError>,
    plate_offsets: Vec<PlateMotion>,
    noise_degrees_of_freedom: f64,
}

/// An error that all markers share.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedError {
    /// Displacement of each key node's marker, mm, for one standard deviation of the error.
    pub pattern_mm: Vec<Vector>,
    /// Motion of the plate at each contact for one standard deviation of the error. Empty if the error displaces only the markers.
    pub plate: Vec<PlateMotion>,
    /// Amplitude at which a search starts, in standard deviations. The expected amplitude is zero.
    pub start: f64,
}

/// Motion of the plate at a contact: the difference between two fingers under the same forces.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlateMotion {
    /// Displacement of the point of the plate's middle line, mm, finger frame.
    pub displacement: Vector,
    /// Rotation of the plate's normal towards the tip, rad.
    pub turn_rad: f64,
}

impl PlateMotion {
    /// Sum of this motion and `times` times the motion `other`.
    pub(crate) fn and(self, times: f64, other: PlateMotion) -> PlateMotion {
        PlateMotion {
            displacement: self.displacement + other.displacement * times,
            turn_rad: self.turn_rad + times * other.turn_rad,
        }
    }
}

/// Reason why a measurement does not fit the finger.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MeasurementError {
    /// The finger has no such node.
    #[error("node {node} does not exist: the finger has nodes 1 to {key_nodes}")]
    UnknownNode {
        /// The node that does not exist.
        node: NodeId,
        /// Number of key nodes.
        key_nodes: usize,
    },
    /// A node is listed twice.
    #[error("node {node} is listed twice")]
    Repeated {
        /// The repeated node.
        node: NodeId,
    },
    /// A coordinate or weight is not finite, or a weight is not positive.
    #[error("node {node}: expected finite displacements and a weight above zero")]
    NotFinite {
        /// The node of the marker.
        node: NodeId,
    },
    /// Nodes at one point of a plate have different displacements.
    #[error(
        "node {node} shares its point of the plate with another listed node, but has another displacement: list only one of these nodes"
    )]
    SharedMoves {
        /// The second of the two nodes.
        node: NodeId,
    },
    /// A clamped node has a displacement.
    #[error("node {node} is clamped, so its displacement must be zero: check the node numbers of the rows")]
    ClampedMoves {
        /// The clamped node.
        node: NodeId,
    },
}

/// Errors of a finger's markers: a factor on their stated standard deviations, and the calibration error that adds to them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkerErrors {
    /// Ratio of actual to stated marker noise, dimensionless. The ratio is below 1 if part of the stated noise is common to all images and absorbed
    /// by calibration.
    pub noise_factor: f64,
    /// Stated noise of the images from which `noise_factor` was estimated, mm: root mean square over the markers of an image, largest of the images.
    /// `None` if it is unknown; the factor then applies to any noise.
    pub noise_factor_of_mm: Option<f64>,
    /// Calibration error, mm: standard deviation of one coordinate of a marker in what the calibrated finger leaves unexplained beside the noise. The
    /// scene's key is `model_error_mm`.
    pub calibration_error_mm: f64,
}

impl Default for MarkerErrors {
    /// Errors as stated: a noise factor of 1 and a calibration error of 0.
    fn default() -> MarkerErrors {
        MarkerErrors { noise_factor: 1.0, noise_factor_of_mm: None, calibration_error_mm: 0.0 }
    }
}

impl MarkerErrors {
    /// The errors for an image of the stated noise `stated_mm`. The variance beyond that of the images from which the noise factor was estimated has
    /// another origin, such as compression, and is not reduced.
    pub fn of_image(self, stated_mm: f64) -> MarkerErrors {
        let known = self.noise_factor_of_mm.map_or(1.0, |known_mm| (known_mm / stated_mm).powi(2).min(1.0));
        let noise_factor = (1.0 - (1.0 - self.noise_factor.powi(2)) * known).sqrt();
        MarkerErrors { noise_factor: if known < 1.0 { noise_factor } else { self.noise_factor }, ..self }
    }

    /// Standard deviation of a coordinate, mm, including both errors, for the stated standard deviation `stated_mm`.
    pub fn sd_mm(&self, stated_mm: f64) -> f64 {
        (self.noise_factor * stated_mm).hypot(self.calibration_error_mm)
    }
}

impl Measurement {
    /// Checks markers against a finger. Omits clamped nodes with zero displacement.
    ///
    /// # Errors
    /// [`MeasurementError`] for the first marker with an unknown or repeated node, with values that are not finite, or with a weight of zero or less.
    /// Two other errors are a displaced marker on a clamped node, and different displacements at one point.
    pub fn new(finger: &Finger, markers: impl IntoIterator<Item = Marker>) -> Result<Measurement, MeasurementError> {
        let mut measurement = Measurement::empty();
        for marker in markers {
            measurement.add(finger, marker)?;
        }
        Ok(measurement)
    }

    /// A measurement without markers.
    pub fn empty() -> Measurement {
        Measurement {
            markers: Vec::new(),
            base: None,
            shared_errors: Vec::new(),
            plate_offsets: Vec::new(),
            noise_degrees_of_freedom: f64::INFINITY,
        }
    }

    /// Adds one marker, with the checks of [`Measurement::new`]. Nodes at one point of a plate share one marker.
    ///
    /// # Errors
    /// [`MeasurementError`] as for [`Measurement::new`]. The measurement is then unchanged.
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

    /// All markers of a computed shape, without noise.
    pub fn of_shape(finger: &Finger, shape: &FingerShape) -> Measurement {
        let marker = |node| Marker { node, displacement: shape.motion(node).marker_displacement(finger), weight: 1.0 };
        Measurement { markers: finger.marked_nodes().map(marker).collect(), ..Measurement::empty() }
    }

    /// All markers of an unloaded finger, with zero displacement.
    pub fn at_rest(finger: &Finger) -> Measurement {
        let marker = |node| Marker { node, displacement: Vector::zeros(), weight: 1.0 };
        Measurement { markers: finger.marked_nodes().map(marker).collect(), ..Measurement::empty() }
    }

    /// Returns this measurement with the uncertainty of its base replaced by `base`. `base` is `None` if the base is known exactly. The nonlinear
    /// estimator estimates the error of the base with the forces; other estimators ignore this error.
    pub fn with_base(mut self, base: impl Into<Option<BaseUncertainty>>) -> Measurement {
        self.base = base.into();
        self
    }

    /// Returns this measurement with the number of degrees of freedom from which the noise of the markers was estimated.
    pub fn with_noise_degrees_of_freedom(mut self, noise_degrees_of_freedom: f64) -> Measurement {
        self.noise_degrees_of_freedom = noise_degrees_of_freedom;
        self
    }

    /// Number of degrees of freedom from which the noise of the markers was estimated: its relative variance is 2 divided by this number. Infinite for a
    /// known noise. All markers share the error of the noise, so that a residual of uniform kind changes the noise before it contradicts the model.
    pub fn noise_degrees_of_freedom(&self) -> f64 {
        self.noise_degrees_of_freedom
    }

    /// Returns this measurement after a known error was added to each marker, with which the noise grows from `from_mm` to `to_mm`.
    ///
    /// # Reference
    /// Satterthwaite, Biometrics Bulletin 2, 1946: degrees of freedom of a sum of variances.
    pub(crate) fn with_known_error(mut self, from_mm: f64, to_mm: f64) -> Measurement {
        self.noise_degrees_of_freedom *= (to_mm / from_mm).powi(4);
        self
    }

    /// Uncertainty of the base. `None` if the base is known exactly.
    pub fn base(&self) -> Option<BaseUncertainty> {
        self.base
    }

    /// Returns this measurement with its list of shared errors replaced: independent errors, each shared by all markers. The nonlinear estimator
    /// estimates these errors with the forces; other estimators ignore the errors.
    pub fn with_shared_errors(mut self, errors: Vec<SharedError>) -> Measurement {
        self.shared_errors = errors;
        self
    }

    /// Errors that all markers share, except the error of the base.
    pub fn shared_errors(&self) -> &[SharedError] {
        &self.shared_errors
    }

    /// Returns this measurement with the motion of the plate at each contact, relative to the scene's finger, while all shared errors are zero.
    pub(crate) fn with_plate_offsets(mut self, offsets: Vec<PlateMotion>) -> Measurement {
        self.plate_offsets = offsets;
        self
    }

    /// Motion of the plate at each contact, relative to the scene's finger, while all shared errors are zero. Empty for no motion.
    pub(crate) fn plate_offsets(&self) -> &[PlateMotion] {
        &self.plate_offsets
    }

    /// Returns this measurement after calling `change` on each marker.
    pub(crate) fn with_markers(mut self, change: impl FnMut(&mut Marker)) -> Measurement {
        self.markers.iter_mut().for_each(change);
        self
    }

    /// This measurement without the markers of hidden nodes.
    pub fn without(mut self, hidden: &[NodeId]) -> Measurement {
        self.markers.retain(|marker| !hidden.contains(&marker.node));
        self
    }

    /// Adds noise to every coordinate, in mm: `noise_mm` / weight times a random number from `standard_normal`.
    pub fn add_noise(&mut self, noise_mm: f64, mut standard_normal: impl FnMut() -> f64) {
        for marker in &mut self.markers {
            marker.displacement += Vector::new(standard_normal(), standard_normal()) * (noise_mm / marker.weight);
        }
    }

    /// The markers.
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// Root mean square of the displacement coordinates of all markers, mm.
    pub fn displacement_rms_mm(&self) -> f64 {
        let squares: f64 = self.markers.iter().map(|marker| marker.displacement.norm_squared()).sum();
        (squares / self.coordinate_count() as f64).sqrt()
    }

    /// Number of measured coordinates: two per marker.
    pub fn coordinate_count(&self) -> usize {
        2 * self.markers.len()
    }
}
