//! The grasp that the report shows: a disc picked from a table, carried and placed by two of the paper's fingers.

use super::{Ended, Eyes, GraspError, GraspScene, GraspStep, Summary};
use crate::check::{Check, Kind, worst};
use crate::experiments::{Context, Evidence};
use crate::settings::Effort;
use finray_model::Scene;
use finray_model::scene::SceneError;

/// Forces and moments on object and bases from balance, as a share of the largest force: Newton's method leaves rounding, the resistance against an
/// object that has moved up to this.
const BALANCE_TOLERANCE: f64 = 1e-4;
/// Totals of the two fingers while nothing but them holds the object, as a share: balance across the gripper.
const EQUAL_TOLERANCE: f64 = 1e-4;
/// Sensed totals without noise: what a lattice of three segments between rods leaves against converged beams, some 0.1 % of the shape, and the friction of
/// which sensing knows the coefficient alone.
const TOTAL_TOLERANCE: f64 = 0.01;
/// Work of the bases against that of friction over the whole grasp, by the trapezoidal rule over steps of 22.5 degrees.
const WORK_TOLERANCE: f64 = 0.1;
/// Share of totals within their intervals: 95 % less four standard deviations of a share of 78.
const COVERED: f64 = 0.95;
const COVERED_TOLERANCE: f64 = 0.1;

/// A grasp with the camera's noise, and what is sensed of it without.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspStudy {
    /// Name of the scene.
    pub name: String,
    /// The scene.
    pub scene: GraspScene,
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// Steps, sensed with noise.
    pub steps: Vec<GraspStep>,
    /// In figures, with noise.
    pub noisy: Summary,
    /// The same without noise.
    pub clean: Summary,
}

/// Why the grasp was not studied.
#[derive(Debug, thiserror::Error)]
pub enum GraspStudyError {
    /// The scene that ships does not read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It is no grasp.
    #[error(transparent)]
    Grasp(#[from] GraspError),
}

/// Runs the grasp that ships, for the paper's finger under noise, in a full study.
///
/// # Errors
/// [`GraspStudyError`] if the scene is no grasp.
pub fn run(context: &Context) -> Result<Option<GraspStudy>, GraspStudyError> {
    let noise_mm = context.noise_mm;
    if !context.is_paper || context.effort == Effort::Quick || noise_mm == 0.0 {
        return Ok(None);
    }
    context.progress.part("grasp", 1);
    let Scene { name, .. } = Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE)?;
    let scene = GraspScene::new(&Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE)?, &[])?;
    let run = |noise_mm: f64| {
        let mut steps = Vec::new();
        let ended = scene.run(&Eyes::Noise(noise_mm), 1, |step| steps.push(step.clone()))?;
        Ok::<(Vec<GraspStep>, Ended), GraspError>((steps, ended))
    };
    let (noisy, clean) = rayon::join(|| run(noise_mm), || run(0.0));
    let ((steps, ended), (clean, clean_ended)) = (noisy?, clean?);
    context.progress.step();
    let noisy = Summary::new(&name, &scene, &steps, &ended);
    let clean = Summary::new(&name, &scene, &clean, &clean_ended);
    Ok(Some(GraspStudy { name, scene, noise_mm, steps, noisy, clean }))
}

impl Evidence for GraspStudy {
    fn checks(&self, _: &Context) -> Vec<Check> {
        let problem = |what: &str| format!("{} grasped, carried and placed: {what}", self.name);
        let sensed = &self.noisy.sensed;
        let covered = sensed.totals_within_95 as f64 / sensed.asked as f64;
        let work = self.clean.driven_nmm / self.clean.dissipated_nmm;
        let zero = |what: &str, source: &str, quantity: &str, ours: f64, tolerance: f64| {
            Check::new(Kind::Internal, problem(what), source, quantity, 0.0, ours, tolerance)
        };
        vec![
            zero(
                "forces and moments on the object and on the bases",
                "force balance",
                "largest imbalance / largest force",
                self.clean.worst_imbalance,
                BALANCE_TOLERANCE,
            ),
            zero(
                "totals of the two fingers while they alone hold the object",
                "force balance",
                "largest difference / force",
                self.clean.left_right_difference.unwrap_or(f64::NAN),
                EQUAL_TOLERANCE,
            ),
            Check::new(
                Kind::Internal,
                problem("work of the motor over a grasp, which leaves no energy in the fingers"),
                "work of friction",
                "work / work of friction",
                1.0,
                work,
                WORK_TOLERANCE,
            ),
            zero(
                "sensed totals without noise",
                "lattice",
                "largest error / true total, of totals above a tenth of the largest",
                worst(self.clean.sensed.worst_total_error),
                TOTAL_TOLERANCE,
            ),
            Check::new(
                Kind::Internal,
                problem("sensed totals with noise within their 95 % intervals"),
                "stated intervals",
                "share of the totals asked for",
                COVERED,
                covered,
                COVERED_TOLERANCE,
            )
            .with_refused(sensed.refused, sensed.asked),
        ]
    }
}
