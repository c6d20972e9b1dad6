//! Views of a finger, and the reasons to refuse them.

use crate::calibration::CalibrationError;
use crate::measurement::{BaseUncertainty, Measurement};
use crate::observation::{Observation, ObservationError};
use crate::sensing::SensingError;
use crate::{NodeId, Scene, Vector};
use nalgebra::{Isometry2, Point2};

/// One image of the finger, located with the scene's rig.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Name of the view (its image) in messages.
    pub name: String,
    /// Displacements of markers from the scene's undeformed finger, mm, in the frame of the view. The frame of the view is the frame of the base as
    /// seen in the image.
    pub measurement: Measurement,
    /// Standard deviation of a coordinate of weight 1, mm.
    pub noise_mm: f64,
    /// Uncertainty of the base in the frame of the view.
    pub base: BaseUncertainty,
    /// Position (x, y) of the camera in the frame of the view, mm.
    pub eye: Vector,
    /// Measured contact force in the frame of the view, N. `None` if no force was measured.
    pub force: Option<Vector>,
    /// Measured position of the contact along the front plate, and its standard deviation, mm. `None` if the position was not measured.
    pub position: Option<[f64; 2]>,
}

/// An observation for the calibration of a scene, and the view to which the observation is converted.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedView {
    /// The observation.
    pub observation: Observation,
    /// Transformation from the frame of the view to the reference frame of the camera's pose, mm and rad.
    pub base: Isometry2<f64>,
    /// The view.
    pub view: View,
    /// Name of the object that pressed the finger, if known.
    pub object: Option<String>,
}

impl LocatedView {
    /// Converts an observation to a view. `force` is the measured force, N, in the reference frame of the camera's pose.
    ///
    /// # Errors
    /// [`ObservationError`] if the observation does not fit the scene's finger or states no standard deviations.
    pub fn new(
        observation: Observation,
        scene: &Scene,
        force: Option<Vector>,
    ) -> Result<LocatedView, ObservationError> {
        let (measured, uncertainty) = observation.for_calibration(scene)?;
        let base = measured.frame;
        // The camera's position is given in the reference frame of the camera's pose. If the scene states no pose of a camera, the camera's position
        // may be arbitrary.
        let eye = scene.camera.and_then(|camera| camera.pose).map_or(Vector::zeros(), |pose| pose.eye().xy());
        let view = View {
            name: observation.image.clone(),
            measurement: measured.measurement,
            noise_mm: measured.marker_noise_mm.unwrap_or(f64::NAN),
            base: uncertainty,
            eye: (base.inverse() * Point2::from(eye)).coords,
            force: force.map(|force| base.rotation.inverse() * force),
            position: None,
        };
        Ok(LocatedView { observation, base, view, object: None })
    }
}

impl View {
    pub(super) fn wrong(&self, error: ViewError) -> CalibrationError {
        CalibrationError::View { name: self.name.clone(), error }
    }
}

/// Reason to refuse a view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ViewError {
    /// The scene's finger does not explain the view, so a search has no starting point.
    #[error("no starting point, because the scene's finger does not fit this image: {0}")]
    Start(#[from] SensingError),
    /// The scene's finger has no equilibrium under the measured force at any position along its plate.
    #[error(
        "the scene's finger has no equilibrium under {force_n:.3} N at any position along its plate: check the unit of the force and the moduli"
    )]
    NotCarried {
        /// The measured force, N.
        force_n: f64,
    },
    /// The measured force contradicts the markers.
    #[error(
        "the measured force is {times:.3} times the force that the markers show, expected {usual:.3} (median of all images): check its sign, unit, \
         frame and row"
    )]
    Force {
        /// Ratio of measured force to the force that the markers show, dimensionless.
        times: f64,
        /// Median over all views of the ratio of measured force to the force that the markers show, dimensionless.
        usual: f64,
    },
    /// A marker is at the computed position of another node.
    #[error(
        "the marker of node {node} is {away_mm:.1} mm from that node's position on the finger, and near to node {other}: check the node numbers of \
         this image"
    )]
    Name {
        /// Node number of the marker.
        node: NodeId,
        /// Node with a computed position near the marker.
        other: NodeId,
        /// Distance of the marker from the computed position of the node `node`, mm.
        away_mm: f64,
    },
    /// The calibrated finger would sense forces too inaccurately for use. The measured force of this view deviates most from the force that the
    /// markers show.
    #[error(
        "forces sensed with this calibration would have a relative standard deviation of {share:.2}, so that every \
            95 % interval would include zero. The measured force of this image deviates most: it is {times:.3} times \
            the force that the markers show; check its sign, unit, frame and row, and the node numbers, or measure \
            more forces"
    )]
    ForceErrors {
        /// Relative standard deviation of a force in a new image, dimensionless.
        share: f64,
        /// Ratio of measured force to the force that the markers show, dimensionless.
        times: f64,
    },
    /// Markers deviate too far from the calibrated finger. The marker with the largest deviation is in this view.
    #[error(
        "the calibrated finger deviates from the markers by {missed_mm:.2} mm rms, although the markers move by only {moved_mm:.2} mm rms: check the \
         finger of the scene and the node numbers. In this image node {node} deviates most, by {away_mm:.1} mm"
    )]
    MarkerErrors {
        /// Node of the marker.
        node: NodeId,
        /// Distance of the marker from its computed position, mm.
        away_mm: f64,
        /// Root mean square distance of all markers from their computed positions, mm.
        missed_mm: f64,
        /// Root mean square of all marker displacements, mm.
        moved_mm: f64,
    },
}
