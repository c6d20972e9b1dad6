//! How well a closed loop keeps its force.

use super::{GraspStep, Phase};
use serde::Serialize;

/// A closed loop in figures, of the true force of both fingers (their mean, across the gripper).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopFigures {
    /// Target, N.
    pub target_n: f64,
    /// Time from the first touch to nine tenths of the target, s; none where steps have no time.
    pub rise_s: Option<f64>,
    /// By which share of the target the largest force is above it, until the gripper opens.
    pub overshoot: f64,
    /// Mean of the force less the target in the second half of holding and carrying, as a share of the target.
    pub steady_error: f64,
    /// Largest difference from the target there, as a share of it.
    pub largest_error: f64,
}

/// Figures of a loop from its steps; none where it never held.
pub fn loop_figures(steps: &[GraspStep], target_n: f64, frames_per_s: Option<f64>) -> Option<LoopFigures> {
    let force_n = |step: &GraspStep| 0.5 * step.fingers.iter().map(|finger| finger.total_n).sum::<f64>();
    let touched = steps.iter().position(|step| force_n(step) > 0.0)?;
    let reached = steps.iter().position(|step| force_n(step) >= 0.9 * target_n)?;
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
        rise_s: frames_per_s.map(|rate| (reached - touched) as f64 / rate),
        overshoot: closed.map(share).fold(0.0, f64::max),
        steady_error: share(late.iter().sum::<f64>() / late.len() as f64),
        largest_error: late.iter().map(|force_n| share(*force_n).abs()).fold(0.0, f64::max),
    })
}
