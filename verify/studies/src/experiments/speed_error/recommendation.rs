//! Recommendation of a method for sensing.

use super::{SpeedErrorPoint, Start, Task, TimedBy};
use finray_model::estimators::EstimatorId;

/// A recommended setting has at most this model error, in standard deviations of the noise. At 0.4, the interval of 1.96 standard deviations covers
/// Phi(1.96 - 0.4) - Phi(-1.96 - 0.4) = 93 % instead of 95 %. Checks of coverage have the lower limit 93 %.
pub const LARGEST_BIAS_SIGMAS: f64 = 0.4;
/// The error of a recommended setting is at most this multiple of the best error. The mean error over about a hundred noisy frames has a standard
/// error of 10 %.
const NEAR_BEST: f64 = 1.25;

/// A sensing method with all its timed points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recommendation<'p> {
    /// Point for one force. Each answer starts from the previous answer if the method iterates from a starting point.
    pub one: &'p SpeedErrorPoint,
    /// Point for one force from a cold start; `None` if the method does not iterate from a starting point.
    pub cold: Option<&'p SpeedErrorPoint>,
    /// Point for two neighbouring forces.
    pub neighbours: Option<&'p SpeedErrorPoint>,
}

impl Recommendation<'_> {
    /// Largest model error over both tasks, in standard deviations of the noise; `None` if the error of a task is unknown.
    pub fn bias_sigmas(&self) -> Option<f64> {
        let two = self.neighbours.map_or(Some(0.0), |two| two.bias_sigmas);
        Some(self.one.bias_sigmas?.max(two?))
    }

    /// Whether the model error is small against the noise and the method answers every frame.
    pub fn holds(&self) -> bool {
        let answers = self.one.failed == 0 && self.neighbours.is_none_or(|two| two.failed == 0);
        answers && self.bias_sigmas().is_some_and(|bias| bias <= LARGEST_BIAS_SIGMAS)
    }
}

/// Every method that finray timed for sensing one force.
pub fn ways(points: &[SpeedErrorPoint]) -> Vec<Recommendation<'_>> {
    let ours = |point: &&SpeedErrorPoint| {
        !matches!(point.timed_by, TimedBy::OtherProgram { .. }) && point.error.is_finite() && point.seconds.is_finite()
    };
    let find = |task: Task, start: Start, one: &SpeedErrorPoint| {
        let same = |point: &&SpeedErrorPoint| {
            point.task == task && point.start == start && point.model == one.model && point.mesh() == one.mesh()
        };
        points.iter().filter(ours).find(same)
    };
    let ones = points.iter().filter(ours).filter(|point| point.task == Task::SenseOne && point.start != Start::Cold);
    ones.map(|one| Recommendation {
        one,
        cold: find(Task::SenseOne, Start::Cold, one),
        neighbours: find(Task::SenseNeighbours, one.start, one),
    })
    .collect()
}

/// The fastest method that supports any contact, [holds](Recommendation::holds), and has nearly the smallest error. Networks are excluded, because
/// they support only the contacts for which they were trained.
pub fn recommended(points: &[SpeedErrorPoint]) -> Option<Recommendation<'_>> {
    let hold: Vec<Recommendation> =
        ways(points).into_iter().filter(|way| way.one.estimator != Some(EstimatorId::Network) && way.holds()).collect();
    let error = |way: &Recommendation| way.neighbours.map_or(way.one.error, |two| two.error.max(way.one.error));
    let best = hold.iter().map(error).reduce(f64::min)?;
    let near = hold.into_iter().filter(|way| error(way) <= NEAR_BEST * best);
    near.min_by(|a, b| a.one.seconds.total_cmp(&b.one.seconds))
}
