//! Control quality of a closed force loop.

use super::{GraspStep, Phase};
use serde::Serialize;

/// Figures of a closed force loop. The force is the true force across the gripper, averaged over both fingers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Target force, N.
    pub target_n: f64,
    /// Rise time from 10 % to 90 % of the target, s; `None` if the steps have no times.
    pub rise_s: Option<f64>,
    /// Overshoot until the gripper opens: excess of the largest force over the target, relative to the target.
    pub overshoot: f64,
    /// Mean difference of force and target in the second half of holding and carrying, relative to the target.
    pub steady_error: f64,
    /// Largest absolute difference of force and target in the second half of holding and carrying, relative to the target.
    pub largest_error: f64,
}

/// Mean of both fingers' true forces across the gripper, N.
fn force_n(step: &GraspStep) -> f64 {
    0.5 * step.fingers.iter().map(|finger| finger.total_n).sum::<f64>()
}

/// Motor angle at which the force first reaches a level (N), degrees, interpolated linearly between steps.
fn reached_deg(steps: &[GraspStep], level_n: f64) -> Option<f64> {
    let end = steps.iter().position(|step| force_n(step) >= level_n)?;
    let [from, to] = [&steps[end.checked_sub(1)?], &steps[end]];
    let share = (level_n - force_n(from)) / (force_n(to) - force_n(from));
    Some(from.motor_deg + share * (to.motor_deg - from.motor_deg))
}

/// Figures of a closed loop from its steps. `motor_deg_per_s` is the motor's speed, if steps have times. `None` if the loop never held the object.
pub fn loop_figures(steps: &[GraspStep], target_n: f64, motor_deg_per_s: Option<f64>) -> Option<LoopFigures> {
    let [tenth_deg, most_deg] = [reached_deg(steps, 0.1 * target_n)?, reached_deg(steps, 0.9 * target_n)?];
    let held: Vec<f64> = steps
        .iter()
        .filter(|step| matches!(step.phase, Phase::Hold | Phase::Lift | Phase::Carry | Phase::Place))
        .map(force_n)
        .collect();
    let late = &held[held.len() / 2..];
    if late.is_empty() {
        return None;
    }
    let closed = steps.iter().filter(|step| step.phase != Phase::Open).map(force_n);
    let share = |force_n: f64| force_n / target_n - 1.0;
    Some(LoopFigures {
        target_n,
        rise_s: motor_deg_per_s.map(|speed| (most_deg - tenth_deg).abs() / speed),
        overshoot: closed.map(share).fold(0.0, f64::max),
        steady_error: share(late.iter().sum::<f64>() / late.len() as f64),
        largest_error: late.iter().map(|force_n| share(*force_n).abs()).fold(0.0, f64::max),
    })
}
