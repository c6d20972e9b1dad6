//! Effect of the camera's frame rate on the closed loop: overshoot, steady error and rise time, with two noise levels and two delays.
//!
//! The scene is `loop.toml` without its path: the gripper closes until the target force is sensed, then holds this force. Up to 90 % of the target
//! force, the camera's frames do not affect the loops. All loops therefore share the closing motion up to 90 % of the target force, which has steps
//! of the motor angle and no noise. Above 90 % of the target force, each step is one frame of the camera. Until the target is reached, the motor
//! turns regardless of the sensed force, so a slower camera sees a subset of the fastest camera's frames.

use super::course::Course;
use super::{Eyes, GraspEnd, GraspError, GraspScene, GraspStep, LoopFigures, loop_figures};
use crate::experiments::{Context, Evidence, ExperimentError};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use finray_model::scene::GraspDescription;
use image::RgbImage;
use std::ops::ControlFlow;

const FRAMES_PER_S: [f64; 7] = [2.0, 5.0, 10.0, 25.0, 50.0, 100.0, 200.0];
/// Frame rate of the paper's camera, 1/s, at which the loop is checked.
const CHECKED_PER_S: f64 = 25.0;
/// Delays of sensing, in frames.
pub const DELAYS: [usize; 2] = [0, 2];
/// Number of elements of each member. With one element, the finger differs by about 1 % from its beam model, which does not affect the
/// controller.
const FINENESS: usize = 1;
/// A frame counts as a step if its force exceeds this share of the target force.
const FRAMES_FROM: f64 = 0.9;
const REALISATIONS: u64 = 3;
/// Tolerance of the difference from the target while the loop holds, relative to the target.
const HELD_TOLERANCE: f64 = 0.05;

/// Setting of a closed force loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopSetting {
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Delay of sensing, in frames.
    pub delay_frames: usize,
    /// Frame rate, 1/s.
    pub frames_per_s: f64,
    /// Number of noise realisations.
    pub realisations: u64,
}

/// Results of a closed force loop with one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopRun {
    /// Setting of the loop.
    pub setting: LoopSetting,
    /// Figures by noise realisation; `None` if the loop never held the object.
    pub figures: Vec<Option<LoopFigures>>,
}

/// Mean and range of a figure over the noise realisations of a loop, in the unit of the figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Mean value, in the unit of the figure.
    pub mean: f64,
    /// Smallest value, in the unit of the figure.
    pub least: f64,
    /// Largest value, in the unit of the figure.
    pub most: f64,
}

impl LoopRun {
    /// Mean and range of a figure over all realisations; `None` if any realisation never held the object.
    pub fn over(&self, figure: impl Fn(&LoopFigures) -> f64) -> Option<Spread> {
        let values: Vec<f64> = self.figures.iter().map(|of| of.as_ref().map(&figure)).collect::<Option<_>>()?;
        let of = |fold: fn(f64, f64) -> f64| values.iter().copied().reduce(fold);
        Some(Spread {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            least: of(f64::min)?,
            most: of(f64::max)?,
        })
    }
}

/// Results of closed force loops with all settings.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopStudy {
    /// Target force of a finger, N.
    pub target_n: f64,
    /// Speed of the motor, degrees/s.
    pub motor_deg_per_s: f64,
    /// Loops by noise level, delay, then frame rate.
    pub runs: Vec<LoopRun>,
}

/// Runs all loops for the paper's finger under noise; `None` for another finger, without noise, or in a quick study.
pub(crate) fn run(context: &Context) -> Result<Option<LoopStudy>, ExperimentError> {
    if !context.is_paper || context.effort == Effort::Quick || context.noise_mm == 0.0 {
        return Ok(None);
    }
    context.progress.part("closed loop", 1);
    // At the smallest noise all realisations have the same overshoot up to 25 frames per second. Above that rate, overshoots differ by less than 0.2
    // % of the target.
    let levels = [(LEAST_STATED_MM, 1), (context.noise_mm, REALISATIONS)];
    let all = levels.iter().flat_map(|level| DELAYS.iter().map(move |delay_frames| (*level, *delay_frames)));
    let all = all.flat_map(|((noise_mm, realisations), delay_frames)| {
        FRAMES_PER_S.map(|frames_per_s| LoopSetting { noise_mm, delay_frames, frames_per_s, realisations })
    });
    let study = closed_loops(&all.collect::<Vec<_>>())?;
    context.progress.step();
    Ok(Some(study))
}

/// Runs the shipped scene `loop.toml`, without its path, with every setting.
///
/// # Errors
/// [`ExperimentError`] if the scene cannot be grasped.
pub fn closed_loops(settings: &[LoopSetting]) -> Result<LoopStudy, ExperimentError> {
    let mut scene = Scene::from_toml(finray_fixtures::GRASP_LOOP_SCENE)?;
    let of = |scene: &Scene| Ok::<_, GraspError>(GraspScene::new(scene, &[])?.with_fineness(FINENESS));
    let grasp = of(&scene)?.grasp().clone();
    let (target_n, motor_deg_per_s) = (grasp.until_force_n.unwrap_or_default(), grasp.motor_deg_per_s);
    // All loops share their beginning, because frames have no effect up to 90 % of the target force.
    let mut closing = |changed: GraspDescription| {
        scene.grasp = Some(GraspDescription { path_mm: Vec::new(), ..changed });
        of(&scene)
    };
    let until_force_n = Some(FRAMES_FROM * target_n);
    let coarse = closing(GraspDescription { until_force_n, holds: false, frames_per_s: None, ..grasp.clone() })?;
    let at_rates = settings.iter().map(|LoopSetting { delay_frames, frames_per_s, .. }| {
        closing(GraspDescription { frames_per_s: Some(*frames_per_s), delay_frames: *delay_frames, ..grasp.clone() })
    });
    let at_rates = at_rates.collect::<Result<Vec<_>, _>>()?;
    let mesh = Mesh::with_elements_per_member(coarse.finger(), FINENESS);
    let mut begun: Vec<GraspStep> = Vec::new();
    let mut course = Course::new(&coarse, &mesh)?;
    coarse.go_on(&mut course, &Eyes::Noise(0.0), &mut Noise::new(0), &mut |step, _| {
        begun.push(step.clone());
        ControlFlow::Continue(())
    });
    let fastest = at_rates.iter().max_by(|a, b| frames_per_s(a).total_cmp(&frames_per_s(b))).unwrap_or(&coarse);
    let frames = closing_frames(course.closing_on(fastest), target_n);
    let run = |(of, seed): (usize, u64)| {
        let (setting, scene) = (&settings[of], &at_rates[of]);
        let (mut steps, mut noise, eyes) = (begun.clone(), Noise::new(seed), Eyes::Noise(setting.noise_mm));
        let (mut course, mut ended) = (course.closing_on(scene), None);
        let mut each = |step: &GraspStep, _: [Option<RgbImage>; 2]| {
            steps.push(step.clone());
            ControlFlow::Continue(())
        };
        let every = frames_per_s(fastest) / setting.frames_per_s;
        let shared = if every.fract() == 0.0 { &frames[..] } else { &[] };
        for frame in shared.iter().skip(every as usize - 1).step_by(every as usize) {
            if ended.is_some() || !course.closes() {
                break;
            }
            course.follow(frame);
            ended = scene.look(&mut course, &eyes, &mut noise, &mut each);
        }
        let ended = ended.unwrap_or_else(|| scene.go_on(&mut course, &eyes, &mut noise, &mut each));
        loop_figures(&steps, target_n, Some(motor_deg_per_s)).filter(|_| ended == GraspEnd::Done)
    };
    let seeds = |of: usize| (1..=settings[of].realisations).map(move |seed| (of, seed));
    let all: Vec<_> = (0..settings.len()).flat_map(seeds).collect();
    let figures: Vec<Option<LoopFigures>> = all.par_iter().with_max_len(1).copied().map(run).collect();
    let of_setting = |of: usize| all.iter().zip(&figures).filter(move |((other, _), _)| *other == of);
    let run = |(of, setting): (usize, &LoopSetting)| LoopRun {
        setting: *setting,
        figures: of_setting(of).map(|(_, figures)| *figures).collect(),
    };
    Ok(LoopStudy { target_n, motor_deg_per_s, runs: settings.iter().enumerate().map(run).collect() })
}

fn frames_per_s(scene: &GraspScene) -> f64 {
    scene.grasp().frames_per_s.unwrap_or_default()
}

/// States of the grasp at the camera's frames, until the true force reaches `until_n` (N), or the motor is at its end.
fn closing_frames<'s, 'm>(mut course: Course<'s, 'm>, until_n: f64) -> Vec<Course<'s, 'm>> {
    let mut frames = Vec::new();
    while course.force_n() < until_n && !course.is_at_end() && course.advance().is_ok() {
        frames.push(course.clone());
    }
    frames
}

impl LoopStudy {
    /// Checks that the force is held within the tolerance at the frame rate of the paper's camera.
    pub fn held(&self) -> Check {
        let held = self.runs.iter().filter(|run| run.setting.frames_per_s == CHECKED_PER_S);
        // For a loop that never held the object, the value is NaN, and the check fails.
        let largest = worst(held.map(|run| run.over(|of| of.largest_error).map_or(f64::NAN, |errors| errors.most)));
        Check::new(
            Kind::Internal,
            format!("{} N held by the closed loop at {CHECKED_PER_S} frames per second", self.target_n),
            "target",
            "largest difference from the target once the force is held / target, over levels of noise, delays and \
                realisations",
            0.0,
            largest,
            HELD_TOLERANCE,
        )
    }
}

impl Evidence for LoopStudy {
    fn checks(&self, _: &Context) -> Vec<Check> {
        vec![self.held()]
    }
}
