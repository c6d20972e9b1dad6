//! Which way of sensing to run.

use super::{SpeedErrorPoint, Start, Task, TimedBy};
use finray_model::estimators::EstimatorId;

/// Largest error of the model itself, in standard deviations of the noise, of a setting that is recommended. With 0.4 the interval of 1.96 standard
/// deviations still holds 93 % of the truths instead of 95 %, the least that coverage may be: Phi(1.96 - 0.4) - Phi(-1.96 - 0.4).
pub const LARGEST_BIAS_SIGMAS: f64 = 0.4;
/// A setting is near enough to the best within a quarter: a mean over some hundred noisy frames scatters by a tenth.
const NEAR_BEST: f64 = 1.25;

/// A way of sensing in all its timings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recommendation<'p> {
    /// One force, from the warm start where there is one.
    pub one: &'p SpeedErrorPoint,
    /// One force from a cold start, where starts differ.
    pub cold: Option<&'p SpeedErrorPoint>,
    /// Two neighbouring forces.
    pub neighbours: Option<&'p SpeedErrorPoint>,
}

impl Recommendation<'_> {
    /// The largest error of the model in standard deviations of the noise, of one force and of two; `None` where none is stated.
    pub fn bias_sigmas(&self) -> Option<f64> {
        let two = self.neighbours.map_or(Some(0.0), |two| two.bias_sigmas);
        Some(self.one.bias_sigmas?.max(two?))
    }

    /// Whether noise covers what its model is off, and it answers every frame.
    pub fn holds(&self) -> bool {
        let answers = self.one.failed == 0 && self.neighbours.is_none_or(|two| two.failed == 0);
        answers && self.bias_sigmas().is_some_and(|bias| bias <= LARGEST_BIAS_SIGMAS)
    }
}

/// Every way of sensing one force that was timed here.
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

/// The fastest way for any contact (networks answer for their own alone) that [holds](Recommendation::holds) and errs hardly more than the best.
pub fn recommended(points: &[SpeedErrorPoint]) -> Option<Recommendation<'_>> {
    let hold: Vec<Recommendation> =
        ways(points).into_iter().filter(|way| way.one.estimator != Some(EstimatorId::Network) && way.holds()).collect();
    let error = |way: &Recommendation| way.neighbours.map_or(way.one.error, |two| two.error.max(way.one.error));
    let best = hold.iter().map(error).reduce(f64::min)?;
    let near = hold.into_iter().filter(|way| error(way) <= NEAR_BEST * best);
    near.min_by(|a, b| a.one.seconds.total_cmp(&b.one.seconds))
}
