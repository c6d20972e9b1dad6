//! How well a closed loop keeps its force.

use super::{GraspStep, Phase};
use serde::Serialize;

/// A closed loop in figures, of the true force of both fingers (their mean, across the gripper).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Target, N.
    pub target_n: f64,
    /// Time in which the force rises from a tenth to nine tenths of the target, s; none where steps have no time.
    pub rise_s: Option<f64>,
    /// By which share of the target the largest force is above it, until the gripper opens.
    pub overshoot: f64,
    /// Mean of the force less the target in the second half of holding and carrying, as a share of the target.
    pub steady_error: f64,
    /// Largest difference from the target there, as a share of it.
    pub largest_error: f64,
}

/// True force of a finger across the gripper, the mean of both, N.
fn force_n(step: &GraspStep) -> f64 {
    0.5 * step.fingers.iter().map(|finger| finger.total_n).sum::<f64>()
}

/// Motor angle at which the force first reaches a level, degrees, between two steps in proportion.
fn reached_deg(steps: &[GraspStep], level_n: f64) -> Option<f64> {
    let end = steps.iter().position(|step| force_n(step) >= level_n)?;
    let [from, to] = [&steps[end.checked_sub(1)?], &steps[end]];
    let share = (level_n - force_n(from)) / (force_n(to) - force_n(from));
    Some(from.motor_deg + share * (to.motor_deg - from.motor_deg))
}

/// Figures of a loop from its steps, with the motor's speed where steps have times; none where it never held.
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
