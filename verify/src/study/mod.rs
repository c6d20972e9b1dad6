//! Everything that the report shows, computed: checks, maps, Tables I and II, networks, mesh convergence, the spring lattice, hard cases
//! and example shapes of one scene.

mod causes;
mod coverage;
mod cross_checks;
mod directions;
mod maps;
mod noise;
mod objects;
mod shapes;
mod timing;

pub use noise::NoiseStudy;
pub use shapes::BentFinger;

use objects::Objects;

use crate::check::{Check, Comparison};
use crate::estimators::network::{NetworkSensing, Networks};
use crate::estimators::{EstimatorError, EstimatorKind};
use crate::experiments::causes::{CauseError, CauseMap};
use crate::experiments::contact_scene::study::{SceneStudy, SceneStudyError, SceneWithOutline};
use crate::experiments::convergence::{Convergence, convergence, loaded_nodes};
use crate::experiments::coverage::{self as intervals, CoverageRow};
use crate::experiments::direction::DirectionStudy;
use crate::experiments::displacement_noise::DisplacementNoiseStudy;
use crate::experiments::explain::ExplanationMap;
use crate::experiments::hard_cases::{self, HardCase, hard_cases};
use crate::experiments::lattice::LatticeStudy;
use crate::experiments::networks::accuracy::{self, NetworkStudy};
use crate::experiments::networks::records::Records;
use crate::experiments::speed_error::{SpeedErrorError, SpeedErrorPoint};
use crate::experiments::table_one::{TableOne, TableOneError, table_one};
use crate::experiments::table_two::{self, TableTwo, table_two};
use crate::experiments::twin::study::{TwinStudy, TwinStudyError};
use crate::problems::ProblemError;
use crate::sampling::map::AccuracyMap;
use crate::settings::{CAMERA_NOISE_MM, Effort, Progress, TABLE_ONE_ANGLES_DEG};
use crate::truths::{MeshTruth, NotExported, fine_mesh};
use finray_model::sensing::SensingError;
use finray_model::sensing::network::NetworkError;
use finray_model::statics::StaticsError;
use finray_model::{Finger, Kinematics, Mesh, Scene};

/// All results for one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Name of the scene.
    pub scene: String,
    /// Its finger.
    pub finger: Finger,
    /// Whether it is the paper's finger: only then there are reference values.
    pub is_paper: bool,
    /// Promises, but for those of the hard cases.
    pub checks: Vec<Check>,
    /// Differences that are expected.
    pub comparisons: Vec<Comparison>,
    /// Maps by truth and estimator, without and with noise, but for those of the lattice that need no network.
    pub maps: Vec<AccuracyMap>,
    /// What limits sensing of the drawn force on the large-rotation finger.
    pub explanations: ExplanationMap,
    /// Table I for each assumed direction, for the paper's finger.
    pub tables_one: Vec<TableOne>,
    /// The digital twin of Table I, for the paper's finger under noise.
    pub twin: Option<TwinStudy>,
    /// Stated intervals against the truth, by finger and estimator.
    pub coverage: Vec<CoverageRow>,
    /// What makes sensed forces wrong, by truth and way of sensing.
    pub causes: Vec<CauseMap>,
    /// Error by mesh and load.
    pub convergence: Convergence,
    /// Nonlinear sensing under camera noise.
    pub noise: Option<NoiseStudy>,
    /// Floors by the origin of the undeformed positions, under camera noise.
    pub displacement_noise: Option<DisplacementNoiseStudy>,
    /// Forces of unknown direction under camera noise, in a full study.
    pub directions: Option<DirectionStudy>,
    /// Table II, for the paper's finger.
    pub table_two: Option<TableTwo>,
    /// The networks that ship, for the paper's finger under noise.
    pub networks: Option<NetworkStudy>,
    /// Recorded trainings, for the paper's finger.
    pub records: Records,
    /// Contact scenes: those that ship for the paper's finger, or the scene's own.
    pub contact_scenes: Vec<SceneStudy>,
    /// The paper's finger as a lattice of rigid bodies and springs.
    pub lattice: Option<LatticeStudy>,
    /// Hard cases, variants of the paper's finger.
    pub hard_cases: Vec<HardCase>,
    /// Time and error of models and estimators.
    pub speed_error: Vec<SpeedErrorPoint>,
    /// Where times come from that were not taken here, in sentences.
    pub timing_notes: Vec<String>,
    /// Standard deviation of one coordinate in noisy pictures, mm.
    pub noise_mm: f64,
    /// Example shapes.
    pub bent: Vec<BentFinger>,
}

/// Why a study could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A reference problem failed to compute.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// Table I failed to compute.
    #[error("Table I: {0}")]
    TableOne(#[from] TableOneError),
    /// The finger could not be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// The finger could not be meshed.
    #[error(transparent)]
    Mesh(#[from] finray_model::mesh::MeshSizeError),
    /// The contacts of the noise study are not on the finger, or an estimator is not made for them.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// A network that ships does not read.
    #[error("a network that ships: {0}")]
    Network(#[from] NetworkError),
    /// A model or estimator failed where it was timed.
    #[error("speed and error: {0}")]
    SpeedError(#[from] SpeedErrorError),
    /// A small experiment behind a claim of the paper, or one on unknown directions, failed to compute.
    #[error("sensing: {0}")]
    Sensing(#[from] SensingError),
    /// The causes of errors failed to compute.
    #[error("causes: {0}")]
    Causes(#[from] CauseError),
    /// The digital twin failed to compute.
    #[error("digital twin: {0}")]
    Twin(#[from] TwinStudyError),
    /// A contact scene failed to compute.
    #[error("contact scene: {0}")]
    ContactScene(#[from] SceneStudyError),
    /// Shapes that MuJoCo exported do not read.
    #[error(transparent)]
    Mujoco(#[from] NotExported),
    /// A recorded training does not read.
    #[error("a recorded training: {0}")]
    Record(#[from] csv::Error),
}

impl Study {
    /// Computes everything for a scene.
    ///
    /// # Errors
    /// [`StudyError`] if a reference problem or the finger at rest cannot be solved. Loads that a finger cannot carry
    /// leave gaps in the maps instead.
    pub fn run(given: &SceneWithOutline, effort: Effort, progress: &dyn Progress) -> Result<Study, StudyError> {
        let scene = &given.scene;
        let finger = &scene.finger;
        // Reference values were made for this finger, whatever a scene calls itself.
        let is_paper = Scene::from_toml(finray_fixtures::PAPER_SCENE).is_ok_and(|paper| paper.finger == *finger);
        let noise_mm = scene.camera.map_or(CAMERA_NOISE_MM, |camera| camera.noise_mm);

        progress.part("cross-checks", 1);
        let (mut checks, mut comparisons) = cross_checks::cross_checks(finger, is_paper)?;
        progress.step();

        let (coarse, fine) = (Mesh::key_nodes(finger), fine_mesh(finger)?);
        let corotational = MeshTruth::new("corotational", &fine, Kinematics::Corotational)?;
        // Without noise there is nothing to add.
        let noise_levels_mm = if noise_mm > 0.0 { vec![0.0, noise_mm] } else { vec![0.0] };
        let mapped = maps::Maps {
            finger,
            coarse: &coarse,
            corotational: &corotational,
            noise_levels_mm: &noise_levels_mm,
            effort,
        };
        progress.part("maps", mapped.steps(is_paper));
        let mut maps = mapped.beams(progress)?;
        if is_paper {
            maps.extend(mapped.papers(progress)?);
        }
        let explanations = mapped.explanations()?;

        let mut tables_one = Vec::new();
        if is_paper {
            progress.part("Table I", TABLE_ONE_ANGLES_DEG.len());
            for angle_deg in TABLE_ONE_ANGLES_DEG {
                tables_one.push(table_one(finger, &corotational, angle_deg)?);
                progress.step();
            }
        }
        let mut twin = None;
        if let Some(before) = tables_one.first().filter(|_| noise_mm > 0.0) {
            progress.part("digital twin", TwinStudy::STEPS);
            let study = TwinStudy::run(finger, before, noise_mm, effort.twin(), &|| progress.step())?;
            checks.extend(study.checks());
            comparisons.extend(study.comparisons());
            twin = Some(study);
        }
        let twin_finger = twin.as_ref().map(|twin| &twin.finger);
        let coverage = coverage::run(&corotational, twin_finger, finger, noise_mm, (is_paper, effort), progress)?;
        checks.extend(intervals::checks(&coverage, is_paper));
        let causes = causes::run(finger, twin_finger, noise_mm, effort, progress)?;
        progress.part("convergence", loaded_nodes(finger).len());
        let convergence = convergence(finger, effort, &|| progress.step())?;
        let noise = match noise_mm {
            0.0 => None,
            noise_mm => Some(NoiseStudy::run(finger, &fine, noise_mm, is_paper, effort, progress)?),
        };
        if is_paper {
            checks.extend(noise.iter().flat_map(NoiseStudy::checks));
        }
        let displacement_noise = match noise_mm {
            0.0 => None,
            noise_mm => Some(
                DisplacementNoiseStudy::run(finger, noise_mm, effort.displacement_noise_cases())
                    .map_err(StaticsError::from)?,
            ),
        };
        if is_paper {
            checks.extend(displacement_noise.iter().flat_map(DisplacementNoiseStudy::checks));
        }
        let directions = directions::directions(&corotational, finger, noise_mm, effort, progress)?;
        let mut hard = Vec::new();
        let (mut two, mut networks, mut records) = (None, None, Records::default());
        if is_paper {
            let shipped = Networks::shipped()?;
            let sensing = NetworkSensing { name: accuracy::NAME, networks: &shipped, finger, refuses: true };
            let [cases, network_cases] = effort.sensed_cases();
            progress.part("Table II", table_two::STEPS);
            let table = table_two(&fine, &noise_levels_mm, cases, &[&sensing], &|| progress.step())?;
            if noise_mm > 0.0 {
                let sensed: Vec<_> = table.of("corotational", noise_mm, accuracy::NAME).cloned().collect();
                progress.part("networks", NetworkStudy::steps(&sensed));
                let study = NetworkStudy::run(&fine, &shipped, noise_mm, network_cases, &sensed, &|| progress.step())?;
                checks.extend(study.checks());
                networks = Some(study);
            }
            two = Some(table);
            records = Records::shipped()?;
            checks.extend(convergence.checks());
            progress.part("hard cases", hard_cases::count());
            hard = hard_cases(finger, effort, &|| progress.step());
        }
        let theirs = maps.iter().find(|map| map.truth == "corotational" && map.noise_mm == 0.0).filter(|_| is_paper);
        let objects = Objects::of(given, is_paper, effort)?;
        let lattice_steps = if theirs.is_some() { LatticeStudy::STEPS } else { 0 };
        progress.part("lattice, objects", lattice_steps + objects.steps());
        let settled = |theirs: &AccuracyMap| {
            let noise = (&noise_levels_mm[..], effort.coarse_resolution().2);
            LatticeStudy::run(finger, effort, theirs, noise, &|| progress.step())
        };
        // Each settles for long on a single thread.
        let (lattice, contact_scenes) = rayon::join(|| theirs.map(settled).transpose(), || objects.press(progress));
        let (lattice, contact_scenes) = (lattice?, contact_scenes?);
        checks.extend(lattice.iter().flat_map(LatticeStudy::checks));
        comparisons.extend(lattice.iter().flat_map(|study| study.comparisons.iter().cloned()));
        let shipped = is_paper && scene.object.is_none();
        let scene_checks = if shipped { SceneStudy::shipped_checks } else { SceneStudy::checks };
        checks.extend(contact_scenes.iter().flat_map(scene_checks));
        progress.part("speed and error", 2);
        let speed_error = timing::time_and_compare(finger, &fine, noise_mm, is_paper, effort, progress)?;
        let bent = shapes::bent_fingers(finger, &fine);
        Ok(Study {
            scene: scene.name.clone(),
            finger: finger.clone(),
            is_paper,
            checks,
            comparisons,
            maps,
            explanations,
            tables_one,
            twin,
            coverage,
            causes,
            convergence,
            noise,
            displacement_noise,
            directions,
            table_two: two,
            networks,
            records,
            contact_scenes,
            lattice,
            hard_cases: hard,
            speed_error,
            timing_notes: Vec::new(),
            noise_mm,
            bent,
        })
    }

    /// Every map, those of the lattice last.
    pub fn all_maps(&self) -> impl Iterator<Item = &AccuracyMap> {
        let lattice = self.lattice.iter().flat_map(|lattice| lattice.sensing.all_maps());
        self.maps.iter().chain(lattice)
    }

    /// Every promise, those of the hard cases last.
    pub fn all_checks(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().chain(self.hard_cases.iter().flat_map(|case| &case.checks))
    }

    /// The map of one truth by least squares, without or with noise.
    pub fn map(&self, truth: &str, noisy: bool) -> Option<&AccuracyMap> {
        self.map_by(truth, EstimatorKind::LeastSquares.name(), noisy)
    }

    /// The map of one truth and estimator, without or with noise.
    pub fn map_by(&self, truth: &str, estimator: &str, noisy: bool) -> Option<&AccuracyMap> {
        let wanted = |map: &&AccuracyMap| map.truth == truth && map.estimator == estimator;
        self.all_maps().filter(wanted).find(|map| (map.noise_mm > 0.0) == noisy)
    }
}
