//! A view, and what may be wrong with it.

use crate::calibration::CalibrationError;
use crate::measurement::{BaseUncertainty, Measurement};
use crate::observation::{Observation, ObservationError};
use crate::sensing::SensingError;
use crate::{NodeId, Scene, Vector};
use nalgebra::{Isometry2, Point2};

/// One image of the finger, as it was located with the scene's rig.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Its name, as messages have it.
    pub name: String,
    /// Displacements of markers from the scene's undeformed finger, mm, in the frame that the image has of its base.
    pub measurement: Measurement,
    /// Standard deviation of a coordinate of weight 1, mm.
    pub noise_mm: f64,
    /// How far the base may be from there.
    pub base: BaseUncertainty,
    /// Where the camera stands above that frame, mm.
    pub eye: Vector,
    /// The contact force in that frame, N, where it was measured.
    pub force: Option<Vector>,
}

/// An observation that a scene is calibrated with.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedView {
    /// What was seen.
    pub observation: Observation,
    /// From the frame of the view to that of the camera's pose.
    pub base: Isometry2<f64>,
    /// The view.
    pub view: View,
    /// What pressed the finger, where it is known.
    pub object: Option<String>,
}

impl LocatedView {
    /// The view of an observation; `force`, N, where it was measured, in the frame of the camera's pose.
    ///
    /// # Errors
    /// [`ObservationError`] for an observation that is none of the scene's finger, or states no standard deviations.
    pub fn new(
        observation: Observation,
        scene: &Scene,
        force: Option<Vector>,
    ) -> Result<LocatedView, ObservationError> {
        let (measured, uncertainty) = observation.for_calibration(scene)?;
        let base = measured.frame;
        // The camera stands above the frame of its pose; without a camera, nowhere in particular.
        let eye = scene.camera.and_then(|camera| camera.pose).map_or(Vector::zeros(), |pose| pose.eye().xy());
        let view = View {
            name: observation.image.clone(),
            measurement: measured.measurement,
            noise_mm: measured.noise_mm.unwrap_or(f64::NAN),
            base: uncertainty,
            eye: (base.inverse() * Point2::from(eye)).coords,
            force: force.map(|force| base.rotation.inverse() * force),
        };
        Ok(LocatedView { observation, base, view, object: None })
    }
}

impl View {
    pub(super) fn wrong(&self, error: ViewError) -> CalibrationError {
        CalibrationError::View { name: self.name.clone(), error }
    }
}

/// What is wrong with a view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ViewError {
    /// The scene's finger cannot explain it, from where a search could begin.
    #[error("the finger of the scene does not explain it, so that there is nowhere to begin: {0}")]
    Start(#[from] SensingError),
    /// The scene's finger carries its measured force nowhere.
    #[error("the finger of the scene carries {force_n:.3} N nowhere along its plate: are units and modulus right?")]
    NotCarried {
        /// The force, N.
        force_n: f64,
    },
    /// Its measured force is not what its markers show.
    #[error(
        "the measured force is {times:.3} times what its markers show, where {usual:.3} times is usual: check its sign, unit, frame and row"
    )]
    Force {
        /// Measured force over what markers show.
        times: f64,
        /// The median of all views.
        usual: f64,
    },
    /// A marker is where another node is.
    #[error(
        "the marker of node {node} is {away_mm:.1} mm from where the finger has that node, and near to node {other}: check the names of its markers"
    )]
    Name {
        /// The node that it is named.
        node: NodeId,
        /// The node that it is near to.
        other: NodeId,
        /// How far it is from its own, mm.
        away_mm: f64,
    },
    /// Forces that the calibrated finger senses would be of no use, and this view's is furthest off.
    #[error(
        "forces in new images would err by {share:.2} of themselves (standard deviation), so that a 95 % interval would hold zero, and this image's measured \
         force is furthest off, {times:.3} times what its markers show: check its sign, unit, frame and row, and the markers' names; or measure more forces"
    )]
    ForceErrors {
        /// Standard deviation of a force in a new image, as a share of it.
        share: f64,
        /// Measured force over what markers show.
        times: f64,
    },
    /// The calibrated finger does not meet markers, and one of this view is furthest off.
    #[error(
        "the calibrated finger misses markers by {missed_mm:.2} mm rms, which move by {moved_mm:.2} mm: it is another finger, or they have wrong names; furthest off, \
         by {away_mm:.1} mm, is that of node {node} in this image"
    )]
    MarkerErrors {
        /// Its node.
        node: NodeId,
        /// How far it is from where the finger has it, mm.
        away_mm: f64,
        /// Root mean square of all, mm.
        missed_mm: f64,
        /// Root mean square of all displacements, mm.
        moved_mm: f64,
    },
}
