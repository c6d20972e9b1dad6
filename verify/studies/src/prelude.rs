//! What studies are written with: the model's fingers, meshes, contacts and estimators, checks, and work in parallel.

pub(crate) use crate::check::{Check, Comparison, Kind, worst};
pub(crate) use crate::settings::Effort;
pub(crate) use crate::statistics::{mean, rms};
pub(crate) use finray_model::estimators::{Estimator, EstimatorError, EstimatorId};
pub(crate) use finray_model::finger::Plate;
pub(crate) use finray_model::measurement::Measurement;
pub(crate) use finray_model::mesh::FingerShape;
pub(crate) use finray_model::sensing::{Contact, ContactPosition};
pub(crate) use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector};
pub(crate) use rayon::prelude::*;
pub(crate) use serde::Serialize;
