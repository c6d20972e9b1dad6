//! Imports shared by all studies: fingers, meshes, contacts and estimators of the model, the lattice, checks, settings, parallel iterators.

pub(crate) use crate::check::{Check, Comparison, Kind, worst};
pub(crate) use crate::settings::{
    CAMERA_NOISE_MM, Effort, LEAST_STATED_MM, Progress, ReportForces, TWO_SIDED_95, is_papers_finger,
};
pub(crate) use crate::statistics::{mean, rms};
pub(crate) use finray_lattice::{Lattice, LatticeError};
pub(crate) use finray_model::camera::Camera;
pub(crate) use finray_model::estimators::network::Networks;
pub(crate) use finray_model::estimators::{ELEMENTS, EstimatorId};
pub(crate) use finray_model::finger::Plate;
pub(crate) use finray_model::frame::{FrameLoad, FrameMotion};
pub(crate) use finray_model::gripper::{Gripper, Placement};
pub(crate) use finray_model::measurement::{Marker, Measurement};
pub(crate) use finray_model::mesh::{FingerShape, LoadError, MeshSizeError};
pub(crate) use finray_model::observation::Observation;
pub(crate) use finray_model::scene::{Markers, ObjectDescription, SceneError};
pub(crate) use finray_model::sensing::{
    Contact, ContactPosition, ContactQuestion, Direction, LinearEstimator, NonlinearEstimator, SensingError,
};
pub(crate) use finray_model::sensor::{PreparedScene, Refusal, SensedForces, Sensor, SensorContacts, SensorOptions};
pub(crate) use finray_model::statics::{Statics, StaticsError};
pub(crate) use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};
pub(crate) use nalgebra::{DMatrix, DVector};
pub(crate) use rayon::prelude::*;
pub(crate) use serde::{Deserialize, Serialize};
pub(crate) use std::time::Instant;
