//! All results of the report, computed for one scene. [`Study`] lists the experiments, one row each.

use crate::check::{Check, Comparison};
use crate::experiments::contact_scene::objects;
use crate::experiments::contact_scene::study::{SceneStudy, SceneWithOutline};
use crate::experiments::grasp::{modules, rates, study as grasp_study};
use crate::experiments::networks::accuracy;
use crate::experiments::{
    Context, Evidence, camera, changes, continuum, coverage, explain, maps, measured, noise, recorded, shapes,
    situations,
};
use crate::problems;
use crate::sampling::map::AccuracyMap;
use crate::sampling::situation::Situation;
use crate::settings::{CAMERA_NOISE_MM, Effort, Progress, ReportForces, is_papers_finger};
use crate::truths::{MeshTruth, TruthId, fine_mesh};
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::finger::StiffnessError;
use finray_model::validity::StrainLimits;
use finray_model::{Finger, Kinematics};
use serde::Serialize;
use std::time::Instant;

/// Why a study could not be completed: the part that failed, and its error.
#[derive(Debug, thiserror::Error)]
#[error("{part}: {reason}")]
pub struct StudyError {
    part: &'static str,
    reason: Box<dyn std::error::Error + Send + Sync>,
}

fn within<E: std::error::Error + Send + Sync + 'static>(part: &'static str) -> impl FnOnce(E) -> StudyError {
    move |error| StudyError { part, reason: Box::new(error) }
}

/// Computation time of one part of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartTime {
    /// Name of the part.
    pub part: &'static str,
    /// Wall-clock time, s. A part may use all cores.
    pub seconds: f64,
}

impl PartTime {
    fn since(part: &'static str, started: Instant) -> PartTime {
        PartTime { part, seconds: started.elapsed().as_secs_f64() }
    }
}

/// Declares [`Study`] from rows. Each row states the name of a part, its result fields, and the expression that computes these fields from the
/// context and earlier results.
macro_rules! study {
    (|$context:ident| $($part:literal: $($(#[$about:meta])* $field:ident: $type:ty),+ = $run:expr;)+) => {
        /// All results for one scene.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Study {
            /// Name of the scene.
            pub scene: String,
            /// Text of the scene's file.
            pub scene_text: String,
            /// The finger of the scene.
            pub finger: Finger,
            /// Largest admissible strains of the finger's materials.
            pub strain_limits: StrainLimits,
            /// Whether the finger is the paper's finger. Only this finger has reference values from the paper.
            pub is_paper: bool,
            /// Standard deviation of the camera noise of one coordinate, mm.
            pub noise_mm: f64,
            /// Uncertainty of the finger's moduli and depth.
            pub stiffness_error: StiffnessError,
            /// Forces for which maps, drawings and their explanations are computed.
            pub forces: ReportForces,
            /// Checks of figures against references.
            pub checks: Vec<Check>,
            /// Figures that are expected to differ from their references.
            pub comparisons: Vec<Comparison>,
            /// Computation time of each part.
            pub parts: Vec<PartTime>,
            /// Results on images with measured forces, if images were given.
            pub measured: Option<measured::MeasuredStudy>,
            $($($(#[$about])* pub $field: $type,)+)+
        }

        impl Study {
            #[expect(unused_parens, reason = "results of one type are no tuple")]
            fn of($context: &Context) -> Result<Study, StudyError> {
                $context.progress.part("problems", 1);
                let mut parts = Vec::new();
                let started = Instant::now();
                let solved = problems::solve_all($context.finger, $context.checked_forces()).map_err(within("problems"))?;
                $context.progress.step();
                let problems::ProblemResults { mut checks, mut comparisons } = solved;
                let recorded = recorded::results($context);
                checks.extend(recorded.checks);
                comparisons.extend(recorded.comparisons);
                parts.push(PartTime::since("problems", started));
                $(
                    let started = Instant::now();
                    let ($($field),+) = $run.map_err(within($part))?;
                    parts.push(PartTime::since($part, started));
                )+
                $($(
                    checks.extend(Evidence::checks(&$field, $context));
                    comparisons.extend(Evidence::comparisons(&$field));
                )+)+
                Ok(Study {
                    scene: $context.given.scene.name.clone(),
                    scene_text: $context.given.text.clone(),
                    finger: $context.finger.clone(),
                    strain_limits: $context.given.scene.strain_limits,
                    is_paper: $context.is_paper,
                    noise_mm: $context.noise_mm,
                    stiffness_error: $context.given.scene.stiffness_error,
                    forces: $context.forces,
                    checks,
                    comparisons,
                    parts,
                    measured: None,
                    $($($field,)+)+
                })
            }
        }
    };
}

study! { |context|
    "maps":
        /// Maps by true finger and estimator, with and without noise.
        maps: Vec<AccuracyMap> = maps::run(context);
    "unknown contacts":
        /// Maps of the nonlinear estimator for contacts that are not known exactly, and for hidden markers; empty without noise.
        situations: Vec<AccuracyMap> = situations::run(context);
    "changes":
        /// Trusted share of an unknown contact after one change at a time; empty without noise.
        changes: Vec<changes::Change> = changes::run(context, &situations);
    "limits of sensing":
        /// Limits of sensing on the co-rotational finger by cell (position, direction), for the force at which maps are drawn.
        explanations: explain::ExplanationMap = explain::run(context);
    "continuum":
        /// Results on the finger as a plane continuum; empty unless CalculiX solved the finger.
        continuum: continuum::ContinuumStudy = continuum::run(context);
    "coverage":
        /// Share of stated 95 % intervals that contain the true force, by finger and estimator.
        coverage: Vec<coverage::CoverageRow> = coverage::run(context, &maps, &situations);
    "noise":
        /// Errors of the nonlinear estimator under camera noise.
        noise: Option<noise::NoiseStudy> = noise::run(context);
    "camera":
        /// Results of sensing from images; only for scenes with a camera and coloured markers, or for the paper's finger.
        camera: Option<camera::CameraStudy> = camera::run(context);
    "networks":
        /// Accuracy of the shipped networks; only for the paper's finger with noise.
        networks: Option<accuracy::NetworkStudy> = accuracy::run(context);
    "objects":
        /// Results of contact scenes: the shipped scenes for the paper's finger, otherwise the scene's own object.
        contact_scenes: Vec<SceneStudy> = objects::run(context);
    "grasp":
        /// Results of objects grasped by two fingers; only for the paper's finger in a full study.
        grasps: Vec<grasp_study::GraspStudy> = grasp_study::run(context);
    "closed loop":
        /// Results of closed-loop force control at each frame rate of the camera; only for the paper's finger in a full study.
        closed_loop: Option<rates::LoopStudy> = rates::run(context);
    "sensor modules":
        /// Results for the paper's Table II on the moving gripper; only for the paper's finger in a full study.
        modules: Option<modules::ModuleStudy> = modules::run(context);
    "shapes":
        /// Example shapes of bent fingers.
        bent: Vec<shapes::BentFinger> = shapes::run(context);
    "touched":
        /// Shapes of the finger under a force at each contact node.
        touched: Vec<shapes::TouchedFinger> = shapes::touched(context);
}

impl Study {
    /// Computes all results for a scene under the given forces. Parts that have fixed reference values use the [paper's](ReportForces::PAPER) forces
    /// for the paper's finger.
    ///
    /// # Errors
    /// [`StudyError`] if a part fails, for example a reference problem or the finger at rest. Loads without equilibrium are no error: their results
    /// are missing.
    pub fn run(
        given: &SceneWithOutline,
        forces: ReportForces,
        effort: Effort,
        progress: &dyn Progress,
    ) -> Result<Study, StudyError> {
        let scene = &given.scene;
        let finger = &scene.finger;
        let fine = fine_mesh(finger).map_err(within("mesh"))?;
        let corotational = MeshTruth::new(TruthId::Corotational, &fine, Kinematics::Corotational);
        let networks = Networks::read(&finray_fixtures::NETWORKS).map_err(within("shipped network"))?;
        Study::of(&Context {
            given,
            finger,
            is_paper: is_papers_finger(finger),
            noise_mm: scene.noise_mm.unwrap_or(CAMERA_NOISE_MM),
            forces,
            effort,
            fine: &fine,
            corotational: &corotational.map_err(within("finger at rest"))?,
            networks: &networks,
            progress,
        })
    }

    /// Forces of the parts that have fixed reference values.
    pub fn checked_forces(&self) -> ReportForces {
        self.forces.checked(self.is_paper)
    }

    /// The map of one true finger by linear least squares, with or without noise.
    pub fn map(&self, truth: TruthId, noisy: bool) -> Option<&AccuracyMap> {
        self.map_by(truth, EstimatorId::LeastSquares, noisy)
    }

    /// The map of the co-rotational finger in a situation other than a known contact.
    pub fn situation(&self, situation: Situation) -> Option<&AccuracyMap> {
        self.situations.iter().find(|map| map.situation == situation)
    }

    /// The map of one true finger and estimator, with or without noise.
    pub fn map_by(&self, truth: TruthId, estimator: EstimatorId, noisy: bool) -> Option<&AccuracyMap> {
        let wanted = |map: &&AccuracyMap| map.truth == truth && map.estimator == estimator;
        self.maps.iter().filter(wanted).find(|map| (map.noise_mm > 0.0) == noisy)
    }
}
