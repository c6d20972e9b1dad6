//! Time against error: every model of the finger and every estimator.
//!
//! Each point is timed where it is computed, on one core, as the median and the 95th percentile of its answers. Preparing for a finger or a
//! mesh is not counted: a stream of frames, or a sweep, pays for it once; preparing for a contact is given apart. Results of
//! [criterion] and of [other programs](peers) join them where they were handed over.

pub mod criterion;
pub mod file;
pub mod peers;
pub mod recommendation;
mod run;
pub mod sensing;

pub use run::run;

use crate::check::worst;
use crate::estimators::{EstimatorError, EstimatorId};
use crate::lattice::accuracy::{CONVERGED_ELEMENTS, difference};
use crate::lattice::{Lattice, LatticeError};
use finray_model::mesh::{FingerShape, Load};
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Finger, Kinematics, Mesh, NodeId};
use sensing::{SENSED_N, neighbours, percentile, singles};
use serde::Serialize;
use std::fmt;
use std::time::Instant;

/// Task of a timed point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// The shape under a load.
    Solve,
    /// One force from a noisy frame.
    SenseOne,
    /// Two forces at neighbouring nodes from a noisy frame.
    SenseNeighbours,
}

impl Task {
    /// All of them.
    pub const ALL: [Task; 3] = [Task::Solve, Task::SenseOne, Task::SenseNeighbours];

    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Task::Solve => "solve",
            Task::SenseOne => "sense-one",
            Task::SenseNeighbours => "sense-neighbours",
        }
    }
}

/// Source of a time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum TimedBy {
    /// The report itself, where it computed the point.
    Report,
    /// Criterion, in the project's benches.
    Criterion,
    /// A script that ran another program.
    OtherProgram {
        /// Its name.
        program: String,
        /// Its version.
        version: String,
    },
}

impl fmt::Display for TimedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TimedBy::Report => f.write_str("timed here"),
            TimedBy::Criterion => f.write_str("criterion"),
            TimedBy::OtherProgram { program, version } => write!(f, "{program} {version}"),
        }
    }
}

impl From<TimedBy> for String {
    fn from(timed_by: TimedBy) -> String {
        timed_by.to_string()
    }
}

/// Start of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// Nothing: the answer is found without iteration, or from rest.
    None,
    /// Least squares on the linear finger, as for an unrelated measurement.
    Cold,
    /// The answer to the frame before.
    Warm,
}

impl Start {
    /// As it ends a setting in words.
    pub fn suffix(self) -> &'static str {
        match self {
            Start::None => "",
            Start::Cold => ", cold start",
            Start::Warm => ", warm start",
        }
    }
}

/// One way to answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedErrorPoint {
    /// The task.
    pub task: Task,
    /// The model or estimator.
    pub model: String,
    /// Which estimator, if it is one of ours.
    #[serde(skip)]
    pub estimator: Option<EstimatorId>,
    /// Its setting, the start included.
    pub setting: String,
    /// Start of each answer.
    pub start: Start,
    /// Median time of an answer, s.
    pub seconds: f64,
    /// 95th percentile of the time of an answer, s; `None` where only a median was handed over.
    pub seconds_95: Option<f64>,
    /// Median time of preparing for a new contact, s, of ways to sense that were timed here.
    pub preparation_seconds: Option<f64>,
    /// Of shapes the worst difference from the reference, as a share of the largest displacement; of forces the mean
    /// |sensed / true - 1|.
    pub error: f64,
    /// Largest error where frames carry no noise, in standard deviations of the noise alone: what the model and its mesh are off.
    pub bias_sigmas: Option<f64>,
    /// Answers that were refused, or had no equilibrium; they count nowhere else.
    pub failed: usize,
    /// Answers asked for.
    pub asked: usize,
    /// Whether no other point of the task is both faster and nearer; points of other programs take no part.
    pub on_front: bool,
    /// Source of the time.
    pub timed_by: TimedBy,
}

impl SpeedErrorPoint {
    /// The setting without its start.
    pub fn mesh(&self) -> &str {
        self.setting.trim_end_matches(self.start.suffix())
    }
}

/// Nodes along the front plate that forces are asked for at; all of the paper's finger that it loads, and fewer where it has fewer.
pub const ASKED_NODES: usize = 11;

/// Requirements of a task on a finger.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    /// The loaded nodes, as `14-24`, or one by one.
    pub nodes: String,
    /// The sizes of the forces, N, as `3` or `0.3-3`.
    pub forces_n: String,
}

/// The load cases of a task's points.
pub fn asked(finger: &Finger, task: Task) -> Asked {
    let sets = match task {
        Task::SenseNeighbours => neighbours(finger),
        Task::Solve | Task::SenseOne => singles(finger, ASKED_NODES),
    };
    let nodes: Vec<usize> = sets.into_iter().flatten().map(|node| node.0).collect();
    let nodes = match nodes[..] {
        [first, .., last] if last - first + 1 == nodes.len() => format!("{first}-{last}"),
        _ => nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(" "),
    };
    let forces_n = match task {
        Task::Solve => SOLVED_N.to_string(),
        Task::SenseOne | Task::SenseNeighbours => format!("{}-{}", SENSED_N[0], SENSED_N[1]),
    };
    Asked { nodes, forces_n }
}

/// Force of the loads that shapes are solved for, N.
pub const SOLVED_N: f64 = 3.0;
const SOLVED_ANGLES_DEG: [f64; 3] = [-40.0, 0.0, 40.0];

/// Why no points were computed.
#[derive(Debug, thiserror::Error)]
pub enum SpeedErrorError {
    /// The reference has no equilibrium.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// A lattice was not built.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// An estimator is not made for the contacts.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
}

/// Loads, with the reference's shapes.
struct Solved {
    loads: Vec<Load>,
    reference: Vec<FingerShape>,
}

impl Solved {
    /// A point from a way to solve.
    fn point(
        &self,
        model: &str,
        setting: String,
        mut shape: impl FnMut(&Load) -> Option<FingerShape>,
    ) -> SpeedErrorPoint {
        let (mut seconds, mut errors) = (Vec::new(), Vec::new());
        for (load, reference) in self.loads.iter().zip(&self.reference) {
            let start = Instant::now();
            let shape = shape(load);
            let elapsed = start.elapsed().as_secs_f64();
            if let Some(shape) = shape {
                seconds.push(elapsed);
                errors.push(difference(reference, &shape));
            }
        }
        solved_point(model, setting, seconds, worst(errors), self.loads.len())
    }
}

/// The point of a way to solve that took these times for the loads that it carried of so many; without any it has no error.
pub fn solved_point(model: &str, setting: String, mut seconds: Vec<f64>, error: f64, asked: usize) -> SpeedErrorPoint {
    SpeedErrorPoint {
        task: Task::Solve,
        model: model.to_owned(),
        estimator: None,
        setting,
        start: Start::None,
        seconds: percentile(&mut seconds, 50.0),
        seconds_95: Some(percentile(&mut seconds, 95.0)),
        preparation_seconds: None,
        error: if seconds.is_empty() { f64::NAN } else { error },
        bias_sigmas: None,
        failed: asked - seconds.len(),
        asked,
        on_front: false,
        timed_by: TimedBy::Report,
    }
}

/// Marks the points of each task that no other beats in both time and error.
fn mark_fronts(points: &mut [SpeedErrorPoint]) {
    let ours = |point: &SpeedErrorPoint| !matches!(point.timed_by, TimedBy::OtherProgram { .. });
    let beaten = |point: &SpeedErrorPoint, by: &SpeedErrorPoint| {
        ours(by)
            && by.task == point.task
            && by.seconds <= point.seconds
            && by.error <= point.error
            && (by.seconds < point.seconds || by.error < point.error)
    };
    for i in 0..points.len() {
        let point = &points[i];
        let answers = ours(point) && point.seconds.is_finite() && point.error.is_finite();
        points[i].on_front = answers && !points.iter().any(|by| beaten(point, by));
    }
}

/// Beams on several meshes and lattices of several finenesses, each under [`SOLVED_N`] on `nodes` nodes of the finger, spread over the front
/// plate, in three directions; errors against beams of [`CONVERGED_ELEMENTS`] elements a member. Nothing for a finger without such nodes.
///
/// # Errors
/// [`SpeedErrorError`] if the reference has no equilibrium or a lattice cannot be built.
pub fn solving(finger: &Finger, nodes: usize) -> Result<Vec<SpeedErrorPoint>, SpeedErrorError> {
    let loads = solved_loads(finger, nodes);
    if loads.is_empty() {
        return Ok(Vec::new());
    }
    let fine = Mesh::with_elements_per_member(finger, CONVERGED_ELEMENTS);
    let solve = |mesh: &Mesh, kinematics, load: &Load| -> Result<FingerShape, StaticsError> {
        finray_model::statics::solve(mesh, &[*load], kinematics)
    };
    let reference = loads.iter().map(|load| solve(&fine, Kinematics::Corotational, load)).collect::<Result<_, _>>()?;
    let solved = Solved { loads, reference };
    let mut points = Vec::new();
    for Beams { model, setting, kinematics, mesh } in beams(finger) {
        let mut statics = Statics::ladder(&mesh, kinematics);
        points.push(solved.point(model, setting, |load| {
            let load = mesh.frame_load(load).ok()?;
            Some(mesh.shape(&statics.equilibrium(&[load]).ok()?.motion))
        }));
    }
    for (setting, lattice) in lattices(finger)? {
        points.push(solved.point(LATTICE, setting, |load| lattice.equilibrium(&[*load]).ok()));
    }
    // Settling takes a hundred times longer: one load is enough.
    let one = Solved {
        loads: solved.loads.into_iter().take(1).collect(),
        reference: solved.reference.into_iter().take(1).collect(),
    };
    for fineness in [1, 2] {
        let lattice = Lattice::new(finger, fineness)?;
        let setting = bodies(&lattice);
        points.push(one.point("spring lattice, rapier", setting, |load| Some(lattice.settle(&[*load]).ok()?.shape)));
    }
    mark_fronts(&mut points);
    Ok(points)
}

/// Beams as they are timed.
pub struct Beams {
    /// Name of the model.
    pub model: &'static str,
    /// The mesh in words.
    pub setting: String,
    /// Theory.
    pub kinematics: Kinematics,
    /// The mesh.
    pub mesh: Mesh,
}

/// Every theory on every mesh that is timed.
pub fn beams(finger: &Finger) -> Vec<Beams> {
    let theories = [
        (Kinematics::Linear, "linear beams"),
        (Kinematics::CorotationalChord, "co-rotational, strain of the chord"),
        (Kinematics::Corotational, "co-rotational"),
    ];
    let on_meshes = |(kinematics, model)| {
        // Linear frames are exact at the nodes: other meshes only cost more.
        let elements: &[usize] = if kinematics == Kinematics::Linear { &[1] } else { &[1, 2, 4, 8] };
        elements.iter().map(move |&elements| {
            let mesh = Mesh::with_elements_per_member(finger, elements);
            Beams { model, setting: format!("{} nodes", mesh.node_count()), kinematics, mesh }
        })
    };
    theories.into_iter().flat_map(on_meshes).collect()
}

/// Name of the lattices that Newton's method solves.
pub const LATTICE: &str = "spring lattice, Newton";

/// Every lattice whose equilibrium is timed, after its setting in words.
///
/// # Errors
/// [`LatticeError`] if one cannot be built.
pub fn lattices(finger: &Finger) -> Result<Vec<(String, Lattice)>, LatticeError> {
    let build = |fineness| Lattice::new(finger, fineness).map(|lattice| (bodies(&lattice), lattice));
    [1, 2, 3, 4].into_iter().map(build).collect()
}

fn bodies(lattice: &Lattice) -> String {
    format!("{} bodies", lattice.assembly().bodies.len())
}

/// The loads that shapes are timed under: [`SOLVED_N`] on `nodes` nodes along the front plate, in three directions.
pub fn solved_loads(finger: &Finger, nodes: usize) -> Vec<Load> {
    let directions =
        |node| SOLVED_ANGLES_DEG.map(|angle_deg| Load::at_node(node, finger.direction(angle_deg) * SOLVED_N));
    spread(finger, nodes).flat_map(directions).collect()
}

/// This number of contact nodes, evenly spaced, without the tip.
fn spread(finger: &Finger, nodes: usize) -> impl Iterator<Item = NodeId> {
    let contact: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    let every = contact.len().div_ceil(nodes.max(1)).max(1);
    contact.into_iter().step_by(every)
}
