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
mod solving;

pub use run::run;
pub use solving::{Beams, LATTICE, beams, lattices, solved_loads, solved_point, solving};

use crate::experiments::ExperimentError;
use crate::prelude::*;
use crate::settings::TWO_FORCES_N;
use sensing::{neighbours, singles};
use std::fmt;

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

/// This number of contact nodes, evenly spaced, without the tip.
fn spread(finger: &Finger, nodes: usize) -> impl Iterator<Item = NodeId> {
    let contact: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    let every = contact.len().div_ceil(nodes.max(1)).max(1);
    contact.into_iter().step_by(every)
}
