//! Computation time against error, for every model of the finger and every estimator.
//!
//! Each point is timed on one core while it is computed. Its times are the median and the 95th percentile over its answers. Preparation for a finger
//! or mesh is excluded, because a stream of frames or a sweep needs it only once. Preparation for a contact is stated separately. Results of
//! [criterion] and of [other programs](peers) are added if given.

pub mod criterion;
pub mod file;
pub mod peers;
pub mod recommendation;
mod run;
pub mod sensing;
mod solving;

pub use run::run;
pub use solving::{Beams, LATTICE, beams, lattices, solved_loads, solved_point, solving};

use crate::experiments::ExperimentError;
use crate::prelude::*;
use crate::settings::TWO_FORCES_N;
use sensing::{neighbours, singles};
use std::fmt;

/// Task whose time and error a point states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// Computing the shape under a load.
    Solve,
    /// Sensing one force from a noisy frame.
    SenseOne,
    /// Sensing two forces at neighbouring nodes from a noisy frame.
    SenseNeighbours,
}

impl Task {
    /// All tasks.
    pub const ALL: [Task; 3] = [Task::Solve, Task::SenseOne, Task::SenseNeighbours];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Task::Solve => "solve",
            Task::SenseOne => "sense-one",
            Task::SenseNeighbours => "sense-neighbours",
        }
    }
}

/// Source of a time measurement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum TimedBy {
    /// The report, which also computes the point.
    Report,
    /// Criterion, with the project's benches.
    Criterion,
    /// A script that runs another program.
    OtherProgram {
        /// Name of the program.
        program: String,
        /// Version of the program.
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

/// Starting point of an iterative solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// No earlier solution: a direct solution, or iterations that start from rest.
    None,
    /// The least-squares solution on the linear finger, as for a frame that is unrelated to the previous frame.
    Cold,
    /// The answer for the previous frame.
    Warm,
}

impl Start {
    /// Suffix that states the starting point in a setting.
    pub fn suffix(self) -> &'static str {
        match self {
            Start::None => "",
            Start::Cold => ", cold start",
            Start::Warm => ", warm start",
        }
    }
}

/// Time and error of one method for one task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedErrorPoint {
    /// Task of the point.
    pub task: Task,
    /// Name of the model or estimator.
    pub model: String,
    /// The estimator; `None` for other programs and for models.
    #[serde(skip)]
    pub estimator: Option<EstimatorId>,
    /// Setting in words, including the starting point.
    pub setting: String,
    /// Starting point of each answer.
    pub start: Start,
    /// Median computation time per answer, s.
    pub seconds: f64,
    /// 95th percentile of the computation time per answer, s; `None` if only a median is given.
    pub seconds_95: Option<f64>,
    /// Median time of the first answer for a new contact, s; only for sensing that was timed by the report.
    pub preparation_seconds: Option<f64>,
    /// Relative error. For shapes: worst difference from the reference, divided by the largest displacement. For forces: mean of |sensed / true - 1|.
    pub error: f64,
    /// Largest error for frames without noise, in standard deviations of the noise: the error of the model and its mesh.
    pub bias_sigmas: Option<f64>,
    /// Number of answers that were refused or had no equilibrium. All other figures exclude these answers.
    pub failed: usize,
    /// Number of requested answers.
    pub asked: usize,
    /// Whether the point is on the Pareto front of its task: no other point is at least as good in time and error, and better in one. Points of other
    /// programs are excluded.
    pub on_front: bool,
    /// Source of the time.
    pub timed_by: TimedBy,
}

impl SpeedErrorPoint {
    /// The setting without the starting point.
    pub fn mesh(&self) -> &str {
        self.setting.trim_end_matches(self.start.suffix())
    }
}

/// Largest number of front nodes at which load cases apply forces; 11 includes all nodes that the paper loads on its finger.
pub const ASKED_NODES: usize = 11;

/// Load cases of a task on a finger: nodes and forces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    /// Loaded nodes, as a range `14-24`, or separated by spaces.
    pub nodes: String,
    /// Forces, N, as `3` or as a range `0.3-3`.
    pub forces_n: String,
}

/// Load cases (nodes and forces) for which the points of a task are computed.
pub fn asked(finger: &Finger, forces: ReportForces, task: Task) -> Asked {
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
        Task::Solve => forces.drawn_n().to_string(),
        Task::SenseOne | Task::SenseNeighbours => {
            let [least_n, most_n] = forces.scaled(TWO_FORCES_N);
            format!("{least_n}-{most_n}")
        }
    };
    Asked { nodes, forces_n }
}

/// Marks the Pareto front of each task. A point is on the front unless another point is at least as good in time and error, and better in one.
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

/// At most `nodes` contact nodes, evenly spaced, without the tip.
fn spread(finger: &Finger, nodes: usize) -> impl Iterator<Item = NodeId> {
    let contact: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    let every = contact.len().div_ceil(nodes.max(1)).max(1);
    contact.into_iter().step_by(every)
}
