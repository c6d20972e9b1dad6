//! A grasp as an animated drawing.

use super::drawings::{arrows, bent, keys, object, support};
use finray_figures::{FigureError, Film, Frame, Series, Shot};
use finray_studies::experiments::grasp::{GraspScene, GraspStep, Phase, finger_name};

/// Largest number of shots. If a grasp has more steps than this, only every n-th step is shown.
const MOST_SHOTS: usize = 60;
/// Duration of a shot, s.
const SHOT_S: f64 = 0.2;

/// A grasp step by step, as one animated drawing without scripts.
///
/// # Errors
/// [`FigureError`] if there is nothing to draw.
pub fn grasp_animation_svg(name: &str, scene: &GraspScene, steps: &[GraspStep]) -> Result<String, FigureError> {
    // The last step is always shown, with every n-th step before it.
    let every = steps.len().div_ceil(MOST_SHOTS).max(1);
    let mut shown: Vec<&GraspStep> = steps.iter().rev().step_by(every).collect();
    shown.reverse();
    let largest_n = steps.iter().flat_map(|step| &step.fingers).flat_map(|of| &of.contacts);
    let largest_n = largest_n.map(|seen| seen.force.norm()).fold(0.0, f64::max);
    // The still drawing shows the last shot of carrying. Without carrying it shows the last shot of lifting, and without lifting the last shot of
    // closing.
    let phase = |phase: Phase| shown.iter().rposition(|step| step.phase == phase);
    let still = phase(Phase::Carry).or(phase(Phase::Lift)).or(phase(Phase::Close)).unwrap_or(0);
    let shot = |step: &&GraspStep| {
        let mut series = bent(scene, step);
        series.extend(object(scene, step));
        series.extend(arrows(scene, step, largest_n).into_iter().map(|arrow| Series { labels: Vec::new(), ..arrow }));
        let totals = step.fingers.iter().enumerate().map(|(finger, of)| {
            let sensed =
                of.sensed_total_n().map_or("not sensed".to_owned(), |sensed_n| format!("sensed {sensed_n:.2} N"));
            format!("{}: true {:.2} N, {sensed}", finger_name(finger), of.total_n)
        });
        let first = format!("phase: {}, motor at {:.1} deg", step.phase, step.motor_deg);
        Shot { words: std::iter::once(first).chain(totals).collect(), series }
    };
    let mut fixed = support(scene, steps);
    let at = steps.first().map_or([0.0; 2], |step| [step.object[0], -step.object[1]]);
    fixed.extend(keys(at));
    let title = format!("{name}: the whole grasp");
    let alt = format!("{title} as an animation of {} frames: fingers, object, true and sensed forces.", shown.len());
    let frame = Frame::half(title, alt).with_plot_height(560.0);
    let shots = shown.iter().map(shot).collect();
    let labels = ["across the gripper, mm", "up, mm"];
    Film { frame, labels, fixed, shots, still, shot_s: SHOT_S }.svg()
}
