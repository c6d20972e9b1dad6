//! Grasps of the report: a disc and a box picked from a table by the paper's fingers, and a ball between spring-steel fingers.

use super::{Eyes, FINENESS, GraspError, GraspScene, GraspStep, Summary};
use crate::experiments::{Context, Evidence, ExperimentError};
use crate::prelude::*;

/// Tolerance of the imbalance of forces and moments, relative to the largest force. It covers rounding in Newton's method and numerical resistance to
/// the object's motion.
const BALANCE_TOLERANCE: f64 = 1e-4;
/// Relative tolerance of the difference between the two fingers' totals while only the fingers hold the object. In equilibrium, the forces balance
/// across the gripper.
const EQUAL_TOLERANCE: f64 = 1e-4;
/// Tolerance of the relative error of sensed totals without noise. The error has two causes: sensing knows only the coefficient of friction, and
/// both meshes are finite.
const TOTAL_TOLERANCE: f64 = 0.01;
/// Relative tolerance of the difference between the work of the motor and the work of friction over the whole grasp. The trapezoidal rule computes
/// both works.
const WORK_TOLERANCE: f64 = 0.02;
/// Tolerance of unaccounted energy, relative to the largest elastic energy. It covers the error of the trapezoidal rule over increments. Without a
/// snap, the energy imbalance of an increment is at most 1e-4 of the energy that bends a finger by the object's size.
const ENERGY_TOLERANCE: f64 = 0.01;
/// Nominal share of totals within their intervals. The next constant is its tolerance, four standard errors for 78 totals.
const COVERED: f64 = 0.95;
const COVERED_TOLERANCE: f64 = 0.1;

/// A grasp sensed with the camera's noise, and its summary without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspStudy {
    /// Name of the scene.
    pub name: String,
    /// The scene, prepared for grasping.
    pub scene: GraspScene,
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Steps, sensed with noise.
    pub steps: Vec<GraspStep>,
    /// Summary with noise.
    pub noisy: Summary,
    /// Summary without noise, if it was computed.
    pub clean: Option<Summary>,
}

/// A grasp that the report shows.
struct ReportedScene {
    toml: &'static str,
    /// Number of elements of each member.
    fineness: usize,
    /// Step of the motor (degrees) and number of steps on the path, which replace the scene's finer steps to save time.
    coarser: Option<(f64, usize)>,
    /// Whether the grasp also runs without noise.
    clean: bool,
}

/// Grasps of the report: an off-centre object, an object that the fingers rotate, and an object between spring-steel fingers.
const SHOWN: [ReportedScene; 3] = [
    ReportedScene { toml: finray_fixtures::GRASPED_DISC_SCENE, fineness: FINENESS, coarser: None, clean: true },
    ReportedScene { toml: finray_fixtures::GRASPED_BOX_SCENE, fineness: 2, coarser: Some((45.0, 4)), clean: false },
    ReportedScene { toml: finray_fixtures::GRASPED_BALL_SCENE, fineness: FINENESS, coarser: None, clean: false },
];

impl ReportedScene {
    fn scene(&self) -> Result<(String, GraspScene), ExperimentError> {
        let mut scene = Scene::from_toml(self.toml)?;
        if let (Some(grasp), Some((step_deg, path_steps))) = (&mut scene.grasp, self.coarser) {
            (grasp.step_deg, grasp.path_steps) = (step_deg, path_steps);
        }
        let grasp = GraspScene::new(&scene, &[])?.with_fineness(self.fineness);
        Ok((scene.name, grasp))
    }
}

/// Runs the grasps of the report for the paper's finger under noise; empty for another finger, without noise, or in a quick study.
pub(crate) fn run(context: &Context) -> Result<Vec<GraspStudy>, ExperimentError> {
    let noise_mm = context.noise_mm;
    if !context.is_paper || context.effort == Effort::Quick || noise_mm == 0.0 {
        return Ok(Vec::new());
    }
    context.progress.part("grasp", SHOWN.len());
    let of = |shown: &ReportedScene| {
        let (name, scene) = shown.scene()?;
        let run = |noise_mm: f64| {
            let mut steps = Vec::new();
            let ended = scene.run(&Eyes::Noise(noise_mm), 1, |step| steps.push(step.clone()))?;
            let summary = Summary::new(&name, &scene, &steps, &ended);
            Ok::<(Vec<GraspStep>, Summary), GraspError>((steps, summary))
        };
        let (noisy, clean) = rayon::join(|| run(noise_mm), || shown.clean.then(|| run(0.0)).transpose());
        let ((steps, noisy), clean) = (noisy?, clean?.map(|(_, summary)| summary));
        context.progress.step();
        Ok(GraspStudy { name, scene, noise_mm, steps, noisy, clean })
    };
    SHOWN.par_iter().map(of).collect()
}

impl GraspStudy {
    /// Whether the fingers are the paper's.
    pub fn is_paper(&self) -> bool {
        is_papers_finger(self.scene.finger())
    }
}

impl Evidence for GraspStudy {
    fn checks(&self, _: &Context) -> Vec<Check> {
        let problem = |what: &str| format!("{} grasped: {what}", self.name);
        let zero = |what: &str, source: &str, quantity: &str, ours: f64, tolerance: f64| {
            Check::new(Kind::Internal, problem(what), source, quantity, 0.0, ours, tolerance)
        };
        let mut checks = vec![
            zero(
                "forces and moments on the object and on the bases",
                "force balance",
                "largest imbalance / largest force",
                self.noisy.worst_imbalance,
                BALANCE_TOLERANCE,
            ),
            zero(
                "total forces of the two fingers while only the fingers hold the object",
                "force balance",
                "largest difference / force",
                self.noisy.left_right_difference.unwrap_or(f64::NAN),
                EQUAL_TOLERANCE,
            ),
            zero(
                "energy that closing and opening creates",
                "energy balance",
                "largest decrease of (work of the motor - stored energy) / largest elastic energy",
                self.noisy.energy.created_nmm / self.noisy.largest_elastic_nmm,
                ENERGY_TOLERANCE,
            ),
            zero(
                "work of the motor that is neither stored nor lost to friction or the resistance in snaps",
                "energy balance",
                "sum of absolute energy errors / largest elastic energy",
                self.noisy.energy.error_nmm / self.noisy.largest_elastic_nmm,
                ENERGY_TOLERANCE,
            ),
        ];
        let Some(clean) = &self.clean else { return checks };
        let sensed = &self.noisy.sensed;
        checks.extend([
            Check::new(
                Kind::Internal,
                problem("work of the motor over a grasp that leaves no energy in the fingers"),
                "work of friction",
                "work / work of friction",
                1.0,
                clean.energy.driven_nmm / clean.energy.friction_nmm,
                WORK_TOLERANCE,
            ),
            zero(
                "sensed totals without noise",
                "true forces",
                "largest (error / true total), over totals above a tenth of the largest total",
                worst(clean.sensed.worst_total_error),
                TOTAL_TOLERANCE,
            ),
            Check::new(
                Kind::Internal,
                problem("sensed totals with noise within their 95 % intervals"),
                "stated intervals",
                "share of the totals asked for",
                COVERED,
                sensed.totals_within_95 as f64 / sensed.asked as f64,
                COVERED_TOLERANCE,
            )
            .with_refused(sensed.refused, sensed.asked),
        ]);
        checks
    }
}
