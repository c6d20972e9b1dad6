//! Other programs on the same tasks, timed and compared by `bench/peers`.

use super::{Asked, SpeedErrorPoint, Start, Task, TimedBy};

/// One program on one task.
#[derive(Debug, Clone, PartialEq)]
pub struct Peer {
    /// The task.
    pub task: Task,
    /// At which nodes and forces; only points of the same stand beside each other.
    pub asked: Asked,
    /// The model or estimator.
    pub model: String,
    /// Its setting.
    pub setting: String,
    /// Median time of an answer, s.
    pub seconds: f64,
    /// As of a [`SpeedErrorPoint`]; `None` where only the time was asked for.
    pub error: Option<f64>,
    /// Name of the program.
    pub program: String,
    /// Its version.
    pub version: String,
}

/// A table of other programs.
#[derive(Debug, Clone, PartialEq)]
pub struct Peers {
    /// The rows.
    pub peers: Vec<Peer>,
    /// The machine that they ran on, in words; empty where the file does not say.
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
