//! Everything that the report shows, computed for one scene: [`Study`] lists the experiments, each a row.

mod timing;

use crate::check::{Check, Comparison};
use crate::experiments::contact_scene::study::{SceneStudy, SceneWithOutline};
use crate::experiments::grasp::{modules, observations, rates, study as grasp_study};
use crate::experiments::networks::{accuracy, records};
use crate::experiments::twin::study as twin_study;
use crate::experiments::{
    Context, Evidence, assumed, camera, causes, convergence, coverage, direction, displacement_noise, explain,
    hard_cases, lattice, maps, measured, noise, shapes, speed_error, table_one, table_two,
};
use crate::problems;
use crate::sampling::map::AccuracyMap;
use crate::settings::{CAMERA_NOISE_MM, Effort, Progress, ReportForces, is_papers_finger};
use crate::truths::{MeshTruth, TruthId, fine_mesh};
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::validity::StrainLimits;
use finray_model::{Finger, Kinematics};
use serde::Serialize;
use std::time::Instant;

/// Why a study could not be finished.
#[derive(Debug, thiserror::Error)]
#[error("{part}: {reason}")]
pub struct StudyError {
    part: &'static str,
    reason: Box<dyn std::error::Error + Send + Sync>,
}

/// Marks an error with the part of a study that it ended.
fn within<E: std::error::Error + Send + Sync + 'static>(part: &'static str) -> impl FnOnce(E) -> StudyError {
    move |error| StudyError { part, reason: Box::new(error) }
}

/// How long a part of a study took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartTime {
    /// What it is called.
    pub part: &'static str,
    /// Time that passed, on all cores, s.
    pub seconds: f64,
}

impl PartTime {
    fn since(part: &'static str, started: Instant) -> PartTime {
        PartTime { part, seconds: started.elapsed().as_secs_f64() }
    }
}

/// Declares [`Study`] from its rows: name in messages, results, and their computation from the context and results above.
macro_rules! study {
    (|$context:ident| $($part:literal: $($(#[$about:meta])* $field:ident: $type:ty),+ = $run:expr;)+) => {
        /// All results for one scene.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Study {
            /// Name of the scene.
            pub scene: String,
            /// Its finger.
            pub finger: Finger,
            /// Largest strains of its materials.
            pub strain_limits: StrainLimits,
            /// Whether it is the paper's finger: only then there are reference values.
            pub is_paper: bool,
            /// Standard deviation of one coordinate of the camera, mm.
            pub noise_mm: f64,
            /// Forces of maps and drawings, and of what explains them.
            pub forces: ReportForces,
            /// Figures against references, but for those of the hard cases.
            pub checks: Vec<Check>,
            /// Differences that are expected.
            pub comparisons: Vec<Comparison>,
            /// Where times come from that were not taken here, in sentences.
            pub timing_notes: Vec<String>,
            /// How long each part took.
            pub parts: Vec<PartTime>,
            /// Images with measured forces, where they were given.
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
                    finger: $context.finger.clone(),
                    strain_limits: $context.given.scene.strain_limits,
                    is_paper: $context.is_paper,
                    noise_mm: $context.noise_mm,
                    forces: $context.forces,
                    checks,
                    comparisons,
                    timing_notes: Vec::new(),
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
        /// Maps by truth and estimator, without and with noise, but for those of the lattice that need no network.
        maps: Vec<AccuracyMap> = maps::run(context);
    "assumed contacts":
        /// The nonlinear estimator's map where position and direction of the contact are only assumed.
        assumed: Option<AccuracyMap> = assumed::run(context);
    "limits of sensing":
        /// What limits sensing of the drawn force on the co-rotational finger.
        explanations: explain::ExplanationMap = explain::run(context);
    "Table I":
        /// Table I for each assumed direction, for the paper's finger.
        tables_one: Vec<table_one::TableOne> = table_one::run(context);
    "digital twin":
        /// The digital twin of Table I, for the paper's finger under noise.
        twin: Option<twin_study::TwinStudy> = twin_study::run(context, tables_one.first());
    "coverage":
        /// Stated intervals against the truth, by finger and estimator.
        coverage: Vec<coverage::CoverageRow> = coverage::run(context, &maps);
    "causes":
        /// What makes sensed forces wrong, by truth and way of sensing.
        causes: Vec<causes::CauseMap> = causes::run(context, twin.as_ref().map(|twin| &twin.finger));
    "convergence":
        /// Error by mesh and load.
        convergence: convergence::Convergence = convergence::run(context);
    "noise":
        /// Nonlinear sensing under camera noise.
        noise: Option<noise::NoiseStudy> = noise::run(context);
    "noise of displacements":
        /// Floors by the origin of the undeformed positions, under camera noise.
        displacement_noise: Option<displacement_noise::DisplacementNoiseStudy> = displacement_noise::run(context);
    "camera":
        /// From images to forces, for scenes with a camera and for the paper's finger.
        camera: Option<camera::CameraStudy> = camera::run(context);
    "unknown directions":
        /// Forces of unknown direction under camera noise, in a full study.
        directions: Option<direction::DirectionStudy> = direction::run(context);
    "Table II":
        /// Table II, for the paper's finger.
        table_two: Option<table_two::TableTwo> = table_two::run(context);
    "networks":
        /// The networks that ship, for the paper's finger under noise.
        networks: Option<accuracy::NetworkStudy> = accuracy::run(context, table_two.as_ref());
    "a recorded training":
        /// Recorded trainings, for the paper's finger.
        records: records::Records = records::run(context);
    "hard cases":
        /// Hard cases, variants of the paper's finger.
        hard_cases: Vec<hard_cases::HardCase> = hard_cases::run(context);
    "lattice, objects":
        /// The paper's finger as a lattice of rigid bodies and springs.
        lattice: Option<lattice::LatticeStudy>,
        /// Contact scenes: those that ship for the paper's finger, or the scene's own.
        contact_scenes: Vec<SceneStudy> = lattice::run_beside_objects(context, &maps);
    "grasp":
        /// Objects that two fingers grasp, for the paper's finger in a full study.
        grasps: Vec<grasp_study::GraspStudy> = grasp_study::run(context);
    "closed loop":
        /// The closed loop against the camera's rate, likewise.
        closed_loop: Option<rates::LoopStudy> = rates::run(context);
    "sensor modules":
        /// Table II on the moving gripper, likewise.
        modules: Option<modules::ModuleStudy> = modules::run(context);
    "observations":
        /// What the paper observes of grasps, likewise.
        observations: Option<observations::Observations> = observations::run(context, &grasps, modules.as_ref());
    "speed and error":
        /// Time and error of models and estimators.
        speed_error: Vec<speed_error::SpeedErrorPoint> = speed_error::run(context);
    "shapes":
        /// Example shapes.
        bent: Vec<shapes::BentFinger> = shapes::run(context);
    "touched":
        /// Shapes under a force at each contact node.
        touched: Vec<shapes::TouchedFinger> = shapes::touched(context);
}

impl Study {
    /// Computes everything for a scene under these forces. Studies of the paper's finger whose checks and claims hold for fixed forces keep the
    /// [paper's](ReportForces::PAPER).
    ///
    /// # Errors
    /// [`StudyError`] if a reference problem or the finger at rest cannot be solved. Loads not carried leave gaps.
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
        let networks = Networks::read(&finray_fixtures::NETWORKS).map_err(within("a network that ships"))?;
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

    /// Forces of studies whose checks and claims hold for fixed ones.
    pub fn checked_forces(&self) -> ReportForces {
        self.forces.checked(self.is_paper)
    }

    /// Every map, those of the lattice last.
    pub fn all_maps(&self) -> impl Iterator<Item = &AccuracyMap> {
        let lattice = self.lattice.iter().flat_map(|lattice| lattice.sensing.all_maps());
        self.maps.iter().chain(lattice)
    }

    /// Every check, those of the hard cases last.
    pub fn all_checks(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().chain(self.hard_cases.iter().flat_map(|case| &case.checks))
    }

    /// The map of one truth by least squares, without or with noise.
    pub fn map(&self, truth: TruthId, noisy: bool) -> Option<&AccuracyMap> {
        self.map_by(truth, EstimatorId::LeastSquares, noisy)
    }

    /// The map of one truth and estimator, without or with noise.
    pub fn map_by(&self, truth: TruthId, estimator: EstimatorId, noisy: bool) -> Option<&AccuracyMap> {
        let wanted = |map: &&AccuracyMap| map.truth == truth && map.estimator == estimator;
        self.all_maps().filter(wanted).find(|map| (map.noise_mm > 0.0) == noisy)
    }
}
