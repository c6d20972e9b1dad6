//! What one image, a table or a simulation shows of a finger, and the measurement that it is for a scene.
//!
//! An [`Observation`] knows nothing of the finger that it is held against: it has positions or displacements of markers, their standard deviations,
//! and where the base is. [`Observation::for_sensing`] and [`Observation::for_calibration`] turn it into a [`Measurement`] of a scene's finger.

mod clamped;

pub use clamped::LargestClampedMotion;

use crate::Vector;
use crate::camera::Pixel;
use crate::finger::{Finger, NodeId};
use crate::measurement::{BaseUncertainty, Marker, MarkerErrors, Measurement, MeasurementError};
use crate::mesh::FingerShape;
use crate::scene::{Base, Scene};
use nalgebra::{Isometry2, Point2};

/// What one image shows of a finger.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    /// Name of the image; empty where there is none.
    pub image: String,
    /// The markers that were seen. Those of hidden nodes are left out.
    pub markers: Vec<ObservedMarker>,
    /// Where the base is; `None` where it stands as the camera's pose has it, exactly.
    pub base: Option<ObservedBase>,
}

/// One marker as it was seen, in the finger frame of its image, which moves with the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedMarker {
    /// Its node.
    pub node: NodeId,
    /// Its centre in the image, if there is one.
    pub pixel: Option<Pixel>,
    /// Its position, mm, if known.
    pub position: Option<Vector>,
    /// Its displacement, mm, from where it is without load, by an image of the unloaded finger or by the scene; if known.
    pub displacement: Option<Vector>,
    /// Standard deviation of one coordinate, mm, all errors included; `None` if unknown.
    pub sd_mm: Option<f64>,
    /// The same without the error of the base's pose, which all markers of an image share; `None` where it is not known apart.
    pub own_sd_mm: Option<f64>,
}

/// Where an image has the base of the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedBase {
    /// From the finger frame to the frame of the camera's pose.
    pub pose: Isometry2<f64>,
    /// Standard deviations of that pose at the origin of the finger frame; `None` if they are not known.
    pub uncertainty: Option<BaseUncertainty>,
    /// Whether references or the camera's pose show it. Otherwise it is only about where the markers have it.
    pub is_known: bool,
}

/// An observation as a measurement of a scene's finger.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedMeasurement {
    /// The displacements; weights follow from the markers' standard deviations.
    pub measurement: Measurement,
    /// Standard deviation of a coordinate of weight 1, mm, if the observation states it.
    pub noise_mm: Option<f64>,
    /// From the frame of the displacements to that of the camera's pose.
    pub frame: Isometry2<f64>,
}

/// An observation that is none of the scene's finger.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ObservationError {
    /// A marker is wrong.
    #[error("{reason}")]
    Marker {
        /// Its index among the observation's markers.
        index: usize,
        /// What is wrong with it.
        reason: MarkerError,
    },
    /// The deviations of the base's pose.
    #[error("standard deviations of the base: expected zero or more")]
    Base,
    /// Neither the markers nor the scene say how large errors are.
    #[error("no standard deviation of the markers is known")]
    NoNoise,
}

/// Why a marker is none of the finger's.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MarkerError {
    /// Its node or its displacement.
    #[error(transparent)]
    Measurement(#[from] MeasurementError),
    /// It has no coordinates of the kind that is needed.
    #[error("node {node}: expected a position or a displacement")]
    NoCoordinates {
        /// The node.
        node: NodeId,
    },
    /// Its standard deviation.
    #[error("expected a length in mm above zero, found {sd_mm}")]
    Deviation {
        /// The standard deviation, mm.
        sd_mm: f64,
        /// Whether it is the marker's own, without the error of the base.
        is_own: bool,
    },
    /// A marker on a clamped node moved.
    #[error(
        "node {node} is clamped, so its displacement must be zero but for noise: found {moved_mm:.3} mm, more than {largest_mm:.3} mm; are the \
         nodes numbered as in the scene, from the back base over the tip to the front base?"
    )]
    ClampedMoves {
        /// The node.
        node: NodeId,
        /// By how much, mm.
        moved_mm: f64,
        /// The most that noise explains, mm.
        largest_mm: f64,
    },
}

/// Standard deviations of a base, mm and rad, that counts as known exactly: far below what an image shows.
const EXACT: (f64, f64) = (1e-4, 1e-6);

impl ObservedMarker {
    /// A marker whose displacement alone is known.
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
    /// All markers of a computed shape, as a camera without noise would see them; no standard deviation is stated.
    pub fn of_shape(finger: &Finger, shape: &FingerShape) -> Observation {
        Observation::of_displacements(&Measurement::of_shape(finger, shape))
    }

    /// Markers of which displacements alone are known; no standard deviation is stated.
    pub fn of_displacements(measurement: &Measurement) -> Observation {
        let markers = measurement.markers().iter();
        let markers = markers.map(|marker| ObservedMarker::displaced(marker.node, marker.displacement)).collect();
        Observation { markers, ..Observation::default() }
    }

    /// As a measurement to sense forces from. `noise_mm`, one for all markers, bounds what clamped ones may seem to move by where the observation
    /// states no standard deviations. Where the base is sought with the forces, its uncertainty stands apart from the markers' own.
    ///
    /// # Errors
    /// [`ObservationError`] naming the first marker that is none of this finger.
    pub fn for_sensing(
        &self,
        scene: &Scene,
        base_is_sought: bool,
        noise_mm: Option<f64>,
    ) -> Result<ObservedMeasurement, ObservationError> {
        Reading { errors: scene.marker_errors, base_is_sought, by_position: false, noise_mm }.of(self, scene)
    }

    /// As a measurement to calibrate the scene with: from the markers' positions, which do not depend on the scene that they were located with, and
    /// with the deviations as stated. The base is sought, about where the image has it, with the uncertainty that stands beside.
    ///
    /// # Errors
    /// [`ObservationError`] naming the first marker that is none of this finger, or where no standard deviation is known.
    pub fn for_calibration(&self, scene: &Scene) -> Result<(ObservedMeasurement, BaseUncertainty), ObservationError> {
        let (errors, noise_mm) = (MarkerErrors::default(), scene.noise_mm);
        let found = Reading { errors, base_is_sought: true, by_position: true, noise_mm }.of(self, scene)?;
        let noise_mm = found.noise_mm.or(noise_mm).ok_or(ObservationError::NoNoise)?;
        let known = found.measurement.base().unwrap_or_default();
        let base = BaseUncertainty { sd_mm: known.sd_mm.max(EXACT.0), sd_rad: known.sd_rad.max(EXACT.1), ..known };
        Ok((ObservedMeasurement { noise_mm: Some(noise_mm), ..found }, base))
    }

    /// Whether displacements count from elsewhere than where a finger's description has its unloaded markers: from an image of the unloaded finger.
    pub(crate) fn counts_from_rest(&self, finger: &Finger) -> bool {
        let from = |marker: &ObservedMarker| Some(marker.position? - marker.displacement?);
        let is_elsewhere = |marker: &ObservedMarker| {
            exists(finger, marker.node)
                && from(marker).is_some_and(|from| (from - finger.marker_position(marker.node)).norm() > EXACT.0)
        };
        self.markers.iter().any(is_elsewhere)
    }

    /// From the frame in which forces are sensed to that of the camera's pose: the base as the observation shows it. A base without references is about
    /// where the camera's pose has it.
    pub fn frame(&self, scene: &Scene) -> Isometry2<f64> {
        match scene.base.as_ref().is_some_and(Base::is_of_pose) {
            true => Isometry2::identity(),
            false => self.base_pose(),
        }
    }

    /// From the finger frame to that of the camera's pose.
    fn base_pose(&self) -> Isometry2<f64> {
        self.base.map_or_else(Isometry2::identity, |base| base.pose)
    }
}

/// How an observation is read.
struct Reading {
    /// Errors of markers beside those that are stated.
    errors: MarkerErrors,
    /// Whether the base is sought: its error, which all markers share, is then not part of theirs.
    base_is_sought: bool,
    /// Whether positions count before displacements.
    by_position: bool,
    /// Standard deviation of one coordinate, mm, where it is stated elsewhere.
    noise_mm: Option<f64>,
}

impl Reading {
    fn of(&self, seen: &Observation, scene: &Scene) -> Result<ObservedMeasurement, ObservationError> {
        let finger = &scene.finger;
        // Displacements then count from the camera's pose.
        let is_of_pose = scene.base.as_ref().is_some_and(Base::is_of_pose);
        let pose = seen.base_pose();
        let frame = seen.frame(scene);
        let stated_base = seen.base.and_then(|base| base.uncertainty).filter(|_| self.base_is_sought);
        let own_sds = stated_base.is_some();
        let mut rows = Vec::with_capacity(seen.markers.len());
        for (index, marker) in seen.markers.iter().enumerate() {
            let row = self.displacement(finger, marker).and_then(|displacement| {
                let displacement =
                    if is_of_pose { placed(finger, &pose, marker.node, displacement) } else { displacement };
                Ok((displacement, self.sd_mm(marker, own_sds)?))
            });
            let (displacement, sd_mm) = row.map_err(|reason| ObservationError::Marker { index, reason })?;
            rows.push((index, Marker { node: marker.node, displacement, weight: 1.0 }, sd_mm));
        }
        self.without_clamped(finger, &mut rows)?;
        let sds: Option<Vec<f64>> = rows.iter().map(|(.., sd_mm)| *sd_mm).collect();
        let noise_mm = sds.filter(|sds| !sds.is_empty()).map(|sds| root_mean_square(&sds));
        let mut measurement = Measurement::empty();
        for (index, marker, sd_mm) in rows {
            let weight = noise_mm.zip(sd_mm).map_or(1.0, |(noise_mm, sd_mm)| noise_mm / sd_mm);
            let wrong = |error: MeasurementError| ObservationError::Marker { index, reason: error.into() };
            measurement.add(finger, Marker { weight, ..marker }).map_err(wrong)?;
        }
        if let Some(base) = self.base(stated_base.filter(|_| !is_of_pose), scene)? {
            measurement = measurement.with_uncertain_base(base);
        }
        Ok(ObservedMeasurement { measurement, noise_mm, frame })
    }

    /// By how much a marker moved, mm.
    fn displacement(&self, finger: &Finger, marker: &ObservedMarker) -> Result<Vector, MarkerError> {
        // A node that does not exist is the measurement's to refuse.
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

    /// Standard deviation of a marker's coordinate, mm, if it is stated.
    fn sd_mm(&self, marker: &ObservedMarker, is_own: bool) -> Result<Option<f64>, MarkerError> {
        let stated = if is_own { marker.own_sd_mm } else { marker.sd_mm };
        match stated {
            Some(sd_mm) if !(sd_mm > 0.0 && sd_mm.is_normal()) => Err(MarkerError::Deviation { sd_mm, is_own }),
            stated => Ok(stated.map(|sd_mm| self.errors.sd_mm(sd_mm))),
        }
    }

    /// Leaves out clamped markers, which carry noise alone.
    fn without_clamped(
        &self,
        finger: &Finger,
        rows: &mut Vec<(usize, Marker, Option<f64>)>,
    ) -> Result<(), ObservationError> {
        let of_all = LargestClampedMotion::of(self.noise_mm, rows.iter().map(|(_, marker, _)| marker.displacement));
        for (index, marker, sd_mm) in rows.iter() {
            let largest = sd_mm.map_or(of_all, |sd_mm| LargestClampedMotion::of(Some(sd_mm), []));
            largest.check(finger, marker).map_err(|reason| ObservationError::Marker { index: *index, reason })?;
        }
        rows.retain(|(_, marker, _)| !finger.is_clamped(marker.node));
        Ok(())
    }

    /// How well the base is known, from what the observation states and from the scene, if it is to be sought.
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
            // References show by how much the base gave way.
            (Some(one), Some(other)) => Some(BaseUncertainty {
                sd_mm: one.sd_mm.hypot(other.sd_mm),
                sd_rad: one.sd_rad.hypot(other.sd_rad),
                ..BaseUncertainty::default()
            }),
            (one, other) => one.or(other),
        };
        Ok(base.filter(|_| self.base_is_sought))
    }
}

fn exists(finger: &Finger, node: NodeId) -> bool {
    (1..=finger.key_node_count()).contains(&node.0)
}

/// A displacement from the base that an image has, as one from the base that the camera's pose has.
fn placed(finger: &Finger, base: &Isometry2<f64>, node: NodeId, displacement: Vector) -> Vector {
    if !exists(finger, node) {
        return displacement;
    }
    let rest = finger.marker_position(node);
    (base * Point2::from(rest + displacement)).coords - rest
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}
