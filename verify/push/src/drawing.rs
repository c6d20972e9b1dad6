//! The finger as lines along its members.

use crate::{estimators, xy};
use finray_model::finger::Plate;
use finray_model::frame::FrameMotion;
use finray_model::observation::Observation;
use finray_model::{Mesh, Scene};
use serde::Serialize;

/// Points along a member of the finger, mm.
pub type Polyline = Vec<[f64; 2]>;

/// The finger at rest, and the estimators from which a page can choose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drawing {
    /// Name of the scene.
    pub name: String,
    /// The members of the finger at rest.
    pub lines: Vec<Polyline>,
    /// Positions of the markers at rest, mm.
    pub markers: Vec<[f64; 2]>,
    /// Length of the front plate, mm.
    pub front_mm: f64,
    /// Ends of the undeformed front plate, at the base and at the tip, mm.
    pub front: [[f64; 2]; 2],
    /// Inward unit normal of the undeformed front plate.
    pub inward: [f64; 2],
    /// Standard deviation of the marker noise that the scene states, mm.
    pub noise_mm: Option<f64>,
    /// Name and description of each estimator.
    pub estimators: Vec<[&'static str; 2]>,
}

impl Drawing {
    pub(crate) fn new(scene: &Scene, mesh: &Mesh) -> Drawing {
        let finger = &scene.finger;
        let front_mm = finger.plate_length_mm(Plate::Front);
        let marked = Observation::of_shape(finger, &mesh.shape(&FrameMotion::at_rest(mesh.frame())));
        Drawing {
            name: scene.name.clone(),
            lines: lines(mesh, None),
            markers: marked.markers.iter().map(|it| xy(finger.marker_position(it.node))).collect(),
            front_mm,
            front: [0.0, front_mm].map(|s_mm| xy(finger.plate_point(Plate::Front, s_mm))),
            inward: xy(finger.direction(0.0)),
            noise_mm: scene.noise_mm,
            estimators: estimators().map(|estimator| [estimator.name(), estimator.label()]).collect(),
        }
    }
}

/// The members of a finger as lines, at rest or displaced by `motion`.
pub(crate) fn lines(mesh: &Mesh, motion: Option<&FrameMotion>) -> Vec<Polyline> {
    let at = |node: &usize| {
        let rest = mesh.frame().position(*node);
        xy(motion.map_or(rest, |motion| rest + motion.displacements[*node]))
    };
    mesh.lines().iter().map(|line| line.nodes.iter().map(at).collect()).collect()
}
