//! Observations of a finger in an image, a table or a simulation, and their conversion to measurements.
//!
//! An [`Observation`] is independent of the scene: it contains positions or displacements of markers, the standard deviations of the markers, and the
//! pose of the base. [`Observation::for_sensing`] and [`Observation::for_calibration`] convert an observation to a [`Measurement`] of a scene's
//! finger.

mod clamped;
mod located_with;
mod pose_errors;

pub use clamped::LargestClampedMotion;
pub use located_with::{LocatedWith, LocatedWithError, SceneChange, StaleCause, StaleError};

use crate::Vector;
use crate::camera::Pixel;
use crate::finger::{Finger, NodeId, Plate};
use crate::measurement::{BaseUncertainty, Marker, MarkerErrors, Measurement, MeasurementError};
use crate::mesh::FingerShape;
use crate::scene::{Base, Scene, marker_offset};
use nalgebra::{Isometry2, Point2, UnitComplex};

/// Observed markers and base of a finger in one image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    /// Name of the image; empty if the image has no name.
    pub image: String,
    /// The observed markers; markers of hidden nodes are omitted.
    pub markers: Vec<ObservedMarker>,
    /// Pose of the base. `None` if the base coincides exactly with the reference frame of the camera's pose.
    pub base: Option<ObservedBase>,
    /// How well the standard deviations of the markers are known. `None` if they are exact, and the errors of the markers independent.
    pub noise: Option<EstimatedNoise>,
    /// The scene with which the markers were located. `None` if it is unknown, or if the observation is not from an image.
    pub located_with: Option<LocatedWith>,
}

/// Noise of an image that was estimated from the image, such as that of compression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedNoise {
    /// Degrees of freedom from which the standard deviations of the markers were estimated, as in [`Measurement::noise_degrees_of_freedom`].
    pub degrees_of_freedom: f64,
    /// Standard deviation of an error that each coordinate shares with those of all other markers, mm. It is no part of the standard deviations of the
    /// markers.
    pub shared_sd_mm: f64,
}

impl EstimatedNoise {
    /// Noise of the difference between two images, each with its noise and the mean square of its standard deviations, mm^2. The estimates err alike, as
    /// for two images of one camera and encoder, so that their standard deviations add. `None` if the standard deviations of both images are exact.
    pub fn of_difference(images: [(Option<EstimatedNoise>, f64); 2]) -> Option<EstimatedNoise> {
        let total_mm2: f64 = images.iter().map(|(_, variance_mm2)| variance_mm2).sum();
        let estimated =
            || images.iter().filter_map(|(noise, variance_mm2)| Some((noise.as_ref()?, variance_mm2 / total_mm2)));
        let relative: f64 = estimated().map(|(noise, share)| share / noise.degrees_of_freedom.sqrt()).sum();
        estimated().next().is_some().then(|| EstimatedNoise {
            degrees_of_freedom: relative.powi(-2),
            shared_sd_mm: estimated().map(|(noise, _)| noise.shared_sd_mm).fold(0.0, f64::hypot),
        })
    }
}

/// One observed marker. The marker's vectors are expressed in the finger frame at the time of the image. This frame moves with the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedMarker {
    /// Node of the marker.
    pub node: NodeId,
    /// Centre of the marker in the image, px, if known.
    pub pixel: Option<Pixel>,
    /// Position of the marker, mm, if known.
    pub position: Option<Vector>,
    /// Displacement from the unloaded position, mm, if known. The unloaded position comes from an image of the unloaded finger or from the scene.
    pub displacement: Option<Vector>,
    /// Standard deviation of one coordinate, mm, including all errors. `None` if unknown.
    pub sd_mm: Option<f64>,
    /// Standard deviation of one coordinate, mm, without the error of the base's pose, which all markers of an image share. `None` if unknown.
    pub own_sd_mm: Option<f64>,
}

/// Pose of the finger's base in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedBase {
    /// Transformation from the finger frame to the reference frame of the camera's pose, mm and rad.
    pub pose: Isometry2<f64>,
    /// Standard deviations of the pose at the origin of the finger frame. `None` if unknown.
    pub uncertainty: Option<BaseUncertainty>,
    /// Whether base references or the camera's pose determine the pose of the base. If `false`, the pose is approximate and follows from the markers.
    pub is_known: bool,
}

/// An observation converted to a measurement of a scene's finger.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedMeasurement {
    /// The displacements. Weights follow from the markers' standard deviations.
    pub measurement: Measurement,
    /// Standard deviation of a coordinate of weight 1, mm: the stated noise, or the root mean square of the markers' standard deviations. `None` without
    /// a stated noise, unless each marker has a standard deviation.
    pub marker_noise_mm: Option<f64>,
    /// Transformation from the frame in which displacements are expressed to the reference frame of the camera's pose, mm and rad.
    pub frame: Isometry2<f64>,
}

/// Reason for which an observation does not fit the scene's finger.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ObservationError {
    /// A marker does not fit the finger.
    #[error("{reason}")]
    Marker {
        /// Index of the marker in the observation, from 0.
        index: usize,
        /// Reason for which the marker does not fit.
        reason: MarkerError,
    },
    /// The standard deviations of the base's pose are negative.
    #[error("each standard deviation of the base's pose must be zero or positive")]
    Base,
    /// The markers were located with another scene.
    #[error(transparent)]
    Stale(#[from] StaleError),
    /// Neither the markers nor the scene state a standard deviation.
    #[error(
        "the noise is unknown: expected a standard deviation for each marker, or noise_mm in [camera] of the scene"
    )]
    NoNoise,
}

/// Reason for which a marker does not fit the finger.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MarkerError {
    /// The node or the displacement is wrong.
    #[error(transparent)]
    Measurement(#[from] MeasurementError),
    /// The marker has neither position nor displacement.
    #[error("node {node}: expected a position or a displacement")]
    NoCoordinates {
        /// Node of the marker.
        node: NodeId,
    },
    /// The standard deviation is not a positive number.
    #[error("expected a length in mm above zero, found {sd_mm}")]
    Deviation {
        /// The standard deviation, mm.
        sd_mm: f64,
        /// Whether `sd_mm` excludes the error of the base.
        is_own: bool,
    },
    /// A marker on a clamped node moved farther than noise explains.
    #[error(
        "node {node} is clamped, so its displacement must be zero within noise: found {moved_mm:.3} mm, expected at most {largest_mm:.3} mm; are the \
         nodes numbered as in the scene, from the back base over the tip to the front base?"
    )]
    ClampedMoves {
        /// The clamped node.
        node: NodeId,
        /// Displacement of the marker, mm.
        moved_mm: f64,
        /// Largest displacement that noise explains, mm.
        largest_mm: f64,
    },
}

/// Standard deviations of position (mm) and rotation (rad) of a base that counts as exact. These values are far below the accuracy of an image.
const EXACT: (f64, f64) = (1e-4, 1e-6);

impl ObservedMarker {
    /// A marker of which only the displacement, mm, is known.
    pub fn displaced(node: NodeId, displacement: Vector) -> ObservedMarker {
        ObservedMarker {
            node,
            pixel: None,
            position: None,
            displacement: Some(displacement),
            sd_mm: None,
            own_sd_mm: None,
        }
    }
}

impl Observation {
    /// All markers of a computed shape, without noise and without stated standard deviations.
    pub fn of_shape(finger: &Finger, shape: &FingerShape) -> Observation {
        Observation::of_displacements(&Measurement::of_shape(finger, shape))
    }

    /// Markers with displacements only, without stated standard deviations.
    pub fn of_displacements(measurement: &Measurement) -> Observation {
        let markers = measurement.markers().iter();
        let markers = markers.map(|marker| ObservedMarker::displaced(marker.node, marker.displacement)).collect();
        Observation { markers, ..Observation::default() }
    }

    /// The same displacements, of markers that are centred on the nodes of the unloaded finger.
    pub fn on_nodes(mut self, finger: &Finger) -> Observation {
        for marker in self.markers.iter_mut().filter(|marker| exists(finger, marker.node)) {
            let moved = marker.displacement.map(|moved| finger.marker_position(marker.node) + moved);
            marker.position = moved.or(marker.position);
        }
        self
    }

    /// Converts the observation to a measurement for sensing forces. `stated_noise_mm`, the standard deviation of one coordinate in mm, applies to
    /// all markers; without it, the standard deviations of the observation apply. Both are multiplied by the scene's noise factor, and its
    /// calibration error is added. `base_is_sought` states whether the base is estimated together with the forces. If it is, the uncertainty of the
    /// base is separate from the uncertainty of the markers.
    ///
    /// # Errors
    /// [`ObservationError`] for the first marker that does not fit the finger, or for a base with negative standard deviations.
    pub fn for_sensing(
        &self,
        scene: &Scene,
        base_is_sought: bool,
        stated_noise_mm: Option<f64>,
    ) -> Result<ObservedMeasurement, ObservationError> {
        let noise_mm = stated_noise_mm.or_else(|| self.noise_mm());
        let errors = noise_mm.map_or(scene.marker_errors, |noise_mm| scene.marker_errors.of_image(noise_mm));
        let reading = Reading { errors, base_is_sought, by_position: false, stated_noise_mm, fallback_noise_mm: None };
        let found = reading.of(self, scene)?;
        let shared = if base_is_sought { self.pose_errors(scene) } else { Vec::new() };
        Ok(ObservedMeasurement { measurement: found.measurement.with_shared_errors(shared), ..found })
    }

    /// Converts the observation to a measurement for calibrating the scene. Uses the stated standard deviations and the positions of the markers.
    /// Positions do not depend on the scene that was used to locate the markers. Also returns the uncertainty of the base relative to its pose in the
    /// image.
    ///
    /// # Errors
    /// [`ObservationError`] for the first marker that does not fit the finger, or if no standard deviation is known.
    pub fn for_calibration(&self, scene: &Scene) -> Result<(ObservedMeasurement, BaseUncertainty), ObservationError> {
        let reading = Reading {
            errors: MarkerErrors::default(),
            base_is_sought: true,
            by_position: true,
            stated_noise_mm: None,
            fallback_noise_mm: scene.noise_mm,
        };
        let found = reading.of(self.renewed(scene)?.as_ref(), scene)?;
        let marker_noise_mm = found.marker_noise_mm.or(scene.noise_mm).ok_or(ObservationError::NoNoise)?;
        let known = found.measurement.base().unwrap_or_default();
        let base = BaseUncertainty { sd_mm: known.sd_mm.max(EXACT.0), sd_rad: known.sd_rad.max(EXACT.1), ..known };
        Ok((ObservedMeasurement { marker_noise_mm: Some(marker_noise_mm), ..found }, base))
    }

    /// Noise of the image, mm: root mean square of the markers' standard deviations, without the error of the base where it is apart. `None` if a
    /// standard deviation is unknown.
    pub fn noise_mm(&self) -> Option<f64> {
        let sds: Option<Vec<f64>> = self.markers.iter().map(|marker| marker.own_sd_mm.or(marker.sd_mm)).collect();
        sds.filter(|sds| !sds.is_empty()).map(|sds| root_mean_square(&sds))
    }

    /// Whether displacements refer to an image of the unloaded finger. If they do, their reference positions differ from the unloaded marker
    /// positions of `finger`.
    pub(crate) fn counts_from_rest(&self, finger: &Finger) -> bool {
        let from = |marker: &ObservedMarker| Some(marker.position? - marker.displacement?);
        let is_elsewhere = |marker: &ObservedMarker| {
            exists(finger, marker.node)
                && from(marker).is_some_and(|from| (from - finger.marker_position(marker.node)).norm() > EXACT.0)
        };
        self.markers.iter().any(is_elsewhere)
    }

    /// Transformation from the frame in which forces are sensed to the reference frame of the camera's pose, mm and rad. The transformation is the
    /// observed pose of the base. If the scene states an uncertainty of the base but no reference marks, the transformation is the identity, because
    /// the base is near the reference frame.
    pub fn frame(&self, scene: &Scene) -> Isometry2<f64> {
        match scene.base.as_ref().is_some_and(Base::is_of_pose) {
            true => Isometry2::identity(),
            false => self.base_pose(),
        }
    }

    /// Transformation from the finger frame to the reference frame of the camera's pose, mm and rad.
    fn base_pose(&self) -> Isometry2<f64> {
        self.base.map_or_else(Isometry2::identity, |base| base.pose)
    }
}

/// Options for the conversion of an observation, for sensing and for calibration. The problem of a calibration (`sensing::force::pressed`) has the
/// unknowns force, position, direction and base only. Uncertainties of other unknowns are added in `for_sensing`, not in `Reading::of`.
struct Reading {
    /// Factor on the standard deviations of the markers, and calibration error.
    errors: MarkerErrors,
    /// Whether the base is estimated. If the base is estimated, the errors of the markers exclude the error of the base, which all markers share.
    base_is_sought: bool,
    /// Whether positions have priority over displacements.
    by_position: bool,
    /// Standard deviation of one coordinate, mm, that replaces those of the observation.
    stated_noise_mm: Option<f64>,
    /// Standard deviation of one coordinate, mm, of an observation without standard deviations.
    fallback_noise_mm: Option<f64>,
}

impl Reading {
    fn of(&self, seen: &Observation, scene: &Scene) -> Result<ObservedMeasurement, ObservationError> {
        let finger = &scene.finger;
        // If the camera's pose determines the base, displacements refer to the reference frame of this pose.
        let is_of_pose = scene.base.as_ref().is_some_and(Base::is_of_pose);
        let pose = seen.base_pose();
        let frame = seen.frame(scene);
        let stated_base = seen.base.and_then(|base| base.uncertainty).filter(|_| self.base_is_sought);
        let own_sds = stated_base.is_some();
        let mut rows = Vec::with_capacity(seen.markers.len());
        let is_used = |marker: &ObservedMarker| !scene.missing_markers.contains(&marker.node);
        for (index, marker) in seen.markers.iter().enumerate().filter(|(_, marker)| is_used(marker)) {
            let row = self.displacement(finger, marker).and_then(|displacement| {
                let displacement =
                    if is_of_pose { placed(finger, &pose, marker.node, displacement) } else { displacement };
                Ok((displacement, self.sd_mm(marker, own_sds)?))
            });
            let (displacement, sd_mm) = row.map_err(|reason| ObservationError::Marker { index, reason })?;
            rows.push((index, Marker { node: marker.node, displacement, weight: 1.0 }, sd_mm));
        }
        self.without_clamped(finger, seen, &mut rows)?;
        let stated_mm = self.stated_noise_mm.map(|noise_mm| self.errors.sd_mm(noise_mm));
        let sds: Option<Vec<f64>> = rows.iter().map(|(.., sd_mm)| *sd_mm).collect();
        let of_markers_mm = sds.filter(|sds| !sds.is_empty()).map(|sds| root_mean_square(&sds));
        let marker_noise_mm = stated_mm.or(of_markers_mm);
        let mut measurement = Measurement::empty();
        for (index, marker, sd_mm) in rows {
            // A stated noise applies to all markers, and may be zero.
            let of_marker = marker_noise_mm.zip(sd_mm).filter(|_| stated_mm.is_none());
            let weight = of_marker.map_or(1.0, |(noise_mm, sd_mm)| noise_mm / sd_mm);
            let wrong = |error: MeasurementError| ObservationError::Marker { index, reason: error.into() };
            measurement.add(finger, Marker { weight, ..marker }).map_err(wrong)?;
        }
        let estimated = seen.noise.zip(marker_noise_mm).filter(|_| self.stated_noise_mm.is_none());
        let is_shared = |(noise, _): &(EstimatedNoise, f64)| self.base_is_sought && noise.shared_sd_mm > 0.0;
        let shared = estimated.filter(is_shared).map(|(noise, _)| shared_error(&measurement, finger, noise));
        let base = self.base(stated_base.filter(|_| !is_of_pose), scene)?;
        if let Some(base) = base.map(|base| shared.map_or(base, |shared| base.and(shared))).or(shared) {
            measurement = measurement.with_base(base);
        }
        if let Some((EstimatedNoise { degrees_of_freedom, .. }, noise_mm)) = estimated {
            let known_mm = self.errors.calibration_error_mm.min(noise_mm);
            let own_mm = (noise_mm * noise_mm - known_mm * known_mm).sqrt();
            measurement =
                measurement.with_noise_degrees_of_freedom(degrees_of_freedom).with_known_error(own_mm, noise_mm);
        }
        Ok(ObservedMeasurement { measurement, marker_noise_mm, frame })
    }

    /// Displacement of a marker, mm.
    fn displacement(&self, finger: &Finger, marker: &ObservedMarker) -> Result<Vector, MarkerError> {
        // If the node does not exist, the returned displacement is arbitrary, because the measurement refuses this node later.
        let from_scene = |position: Vector| match exists(finger, marker.node) {
            true => position - finger.marker_position(marker.node),
            false => position,
        };
        let by_position = marker.position.map(from_scene);
        let displacement = match self.by_position {
            true => by_position.or(marker.displacement),
            false => marker.displacement.or(by_position),
        };
        displacement.ok_or(MarkerError::NoCoordinates { node: marker.node })
    }

    /// Standard deviation of a marker's coordinate, mm, including the errors of the scene. `None` if neither the observation nor the caller states
    /// one.
    fn sd_mm(&self, marker: &ObservedMarker, is_own: bool) -> Result<Option<f64>, MarkerError> {
        let observed = if is_own { marker.own_sd_mm } else { marker.sd_mm };
        match observed {
            Some(sd_mm) if !(sd_mm > 0.0 && sd_mm.is_normal()) => Err(MarkerError::Deviation { sd_mm, is_own }),
            observed => Ok(self.stated_noise_mm.or(observed).map(|sd_mm| self.errors.sd_mm(sd_mm))),
        }
    }

    /// Removes clamped markers, which show only noise. Refuses a clamped marker that moves farther than noise explains.
    fn without_clamped(
        &self,
        finger: &Finger,
        seen: &Observation,
        rows: &mut Vec<(usize, Marker, Option<f64>)>,
    ) -> Result<(), ObservationError> {
        let of_all = LargestClampedMotion::of(self.fallback_noise_mm, rows.iter().map(|(_, it, _)| it.displacement));
        for (index, marker, sd_mm) in rows.iter() {
            // The motion of a clamped marker includes the error of the base, even if the base is estimated or the noise is stated.
            let ObservedMarker { sd_mm: all_mm, own_sd_mm: own_mm, .. } = seen.markers[*index];
            let sd_mm = match self.stated_noise_mm {
                Some(noise_mm) => {
                    let of_base_mm2 =
                        all_mm.zip(own_mm).map_or(0.0, |(all_mm, own_mm)| all_mm.powi(2) - own_mm.powi(2));
                    Some(self.errors.sd_mm(noise_mm).hypot(of_base_mm2.max(0.0).sqrt()))
                }
                None => all_mm.map(|all_mm| self.errors.sd_mm(all_mm)).or(*sd_mm),
            };
            let largest = sd_mm.map_or(of_all, |sd_mm| LargestClampedMotion::of(Some(sd_mm), []));
            largest.check(finger, marker).map_err(|reason| ObservationError::Marker { index: *index, reason })?;
        }
        rows.retain(|(_, marker, _)| !finger.is_clamped(marker.node));
        Ok(())
    }

    /// Uncertainty of the base from the observation and the scene. `None` if the base is not estimated or is exact.
    fn base(
        &self,
        stated: Option<BaseUncertainty>,
        scene: &Scene,
    ) -> Result<Option<BaseUncertainty>, ObservationError> {
        if stated.is_some_and(|base| base.sd_mm < 0.0 || base.sd_rad < 0.0) {
            return Err(ObservationError::Base);
        }
        let of_scene = scene.base.as_ref().and_then(|base| base.uncertainty);
        let base = match (stated.filter(|base| base.sd_mm > 0.0 || base.sd_rad > 0.0), of_scene) {
            // The pose from the base references already includes the rotation of the base under force, so no further rotation is expected.
            (Some(one), Some(other)) => {
                Some(one.and(BaseUncertainty { sd_mm: other.sd_mm, sd_rad: other.sd_rad, ..one }))
            }
            (one, other) => one.or(other),
        };
        Ok(base.filter(|_| self.base_is_sought))
    }
}

/// Error of the rotation of a chord as the rotation of the node at its middle, relative to the root mean square rotation of all markers: 0.15 on the paper's
/// finger under 3 N, rounded up.
const CHORD_ERROR: f64 = 0.2;

/// Positions of nodes from the positions of their markers, mm, each with the standard deviation that the conversion adds to a coordinate, mm. `offsets` are
/// those of [`Scene::marker_offsets`]. An offset turns with the plate, as the chord between the neighbouring markers does.
pub fn nodes_of_markers(finger: &Finger, offsets: &[Vector], located: &[(NodeId, Vector)]) -> Vec<(Vector, f64)> {
    if offsets.is_empty() {
        return located.iter().map(|(_, at)| (*at, 0.0)).collect();
    }
    let turns = plate_turns(finger, offsets, located);
    let angles: Vec<f64> = turns.iter().map(UnitComplex::angle).collect();
    let turn_sd_rad = CHORD_ERROR * root_mean_square(&angles);
    let node = |((node, at), turn): (&(NodeId, Vector), &UnitComplex<f64>)| {
        let offset = marker_offset(offsets, *node);
        (at - turn * offset, turn_sd_rad * offset.norm())
    };
    located.iter().zip(&turns).map(node).collect()
}

/// Rotation of the plate at each located marker: that of the chord between the neighbouring markers.
fn plate_turns(finger: &Finger, offsets: &[Vector], located: &[(NodeId, Vector)]) -> Vec<UnitComplex<f64>> {
    let plates = [Plate::Front, Plate::Back].map(|plate| finger.plate_nodes(plate));
    let rest = |node: NodeId| finger.marker_position(node) + marker_offset(offsets, node);
    let turn = |(node, _): &(NodeId, Vector)| {
        let plate = plates.iter().find(|plate| plate.contains(node)).filter(|_| !finger.is_clamped(*node));
        let on_plate = |node: &NodeId| located.iter().find(|(other, _)| other == node);
        let found: Vec<_> = plate.into_iter().flatten().filter_map(on_plate).collect();
        let Some(index) = found.iter().position(|(other, _)| other == node) else { return UnitComplex::identity() };
        let [first, last] = [found[index.saturating_sub(1)], found[(index + 1).min(found.len() - 1)]];
        UnitComplex::rotation_between(&(rest(last.0) - rest(first.0)), &(last.1 - first.1))
    };
    located.iter().map(turn).collect()
}

/// Whether the finger has a key node of this number.
pub(crate) fn exists(finger: &Finger, node: NodeId) -> bool {
    (1..=finger.key_node_count()).contains(&node.0)
}

/// Converts a displacement relative to the observed base to a displacement relative to the reference frame of the camera's pose, mm.
fn placed(finger: &Finger, base: &Isometry2<f64>, node: NodeId, displacement: Vector) -> Vector {
    if !exists(finger, node) {
        return displacement;
    }
    let rest = finger.marker_position(node);
    (base * Point2::from(rest + displacement)).coords - rest
}

/// The error that all markers share, as an error of the base: of each coordinate, and as large at the markers by a rotation.
fn shared_error(measurement: &Measurement, finger: &Finger, noise: EstimatedNoise) -> BaseUncertainty {
    let distances: Vec<f64> =
        measurement.markers().iter().map(|marker| finger.marker_position(marker.node).norm()).collect();
    let sd_mm = noise.shared_sd_mm;
    BaseUncertainty {
        sd_mm,
        sd_rad: sd_mm / root_mean_square(&distances).max(f64::MIN_POSITIVE),
        ..BaseUncertainty::default()
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}
