//! Other programs on the tasks of the report: `bench/peers` times them and computes their errors.

use super::{Asked, SpeedErrorPoint, Start, Task, TimedBy};

/// Time and error of one program on one task.
#[derive(Debug, Clone, PartialEq)]
pub struct Peer {
    /// Task of the point.
    pub task: Task,
    /// Nodes and forces of the task. Points are compared only if their nodes and forces are equal.
    pub asked: Asked,
    /// Name of the model or estimator.
    pub model: String,
    /// Setting in words.
    pub setting: String,
    /// Median computation time per answer, s.
    pub seconds: f64,
    /// Relative error, defined as in [`SpeedErrorPoint`]; `None` if only the time was measured.
    pub error: Option<f64>,
    /// Name of the program.
    pub program: String,
    /// Version of the program.
    pub version: String,
}

/// Times and errors of other programs.
#[derive(Debug, Clone, PartialEq)]
pub struct Peers {
    /// One entry for each program, task and setting.
    pub peers: Vec<Peer>,
    /// Description of the machine; empty if the file does not state it.
    pub machine: String,
}

impl From<Peer> for SpeedErrorPoint {
    fn from(peer: Peer) -> SpeedErrorPoint {
        SpeedErrorPoint {
            estimator: None,
            task: peer.task,
            model: peer.model,
            setting: peer.setting,
            start: Start::None,
            seconds: peer.seconds,
            seconds_95: None,
            preparation_seconds: None,
            error: peer.error.unwrap_or(f64::NAN),
            bias_sigmas: None,
            failed: 0,
            asked: 0,
            on_front: false,
            timed_by: TimedBy::OtherProgram { program: peer.program, version: peer.version },
        }
    }
}
