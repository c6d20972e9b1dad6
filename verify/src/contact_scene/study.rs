//! A scene run to its end, sensed at every step, and what is promised of it.

use super::{
    ContactScene, FINENESS, ForceRow, OutlineError, SceneStep, SensedForce, SensedStep, force_rows, standard_normal,
};
use crate::check::{Check, EXACT_COUNT, Kind, worst};
use crate::fixtures;
use crate::lattice::LatticeError;
use crate::lattice::accuracy::{CONVERGED_ELEMENTS, difference};
use crate::lattice::skin::{Touch, TouchedPart};
use crate::scatter::TWO_SIDED_95;
use finray_model::finger::Plate;
use finray_model::mesh::{FingerShape, Load};
use finray_model::scene::SceneError;
use finray_model::sensing::SensingError;
use finray_model::statics::{self, StaticsError};
use finray_model::{Finger, Kinematics, Mesh, Scene, Vector};
use rayon::prelude::*;

/// The other party of the rows about sensing.
const SOURCE: &str = "rapier2d lattice";
const DISPLACEMENT: &str = "largest displacement difference / largest displacement";
/// Contact forces against the hand's and the clamps', as a share of their sum: what rapier's sweeps leave over.
pub const BALANCE_TOLERANCE: f64 = 1e-3;
/// Settled shapes against the lattice's equilibrium under the contact forces, as a share of the largest displacement, of any scene and
/// finger. The scenes that ship come within 7e-7; a stiff finger on many segments may rest farther off before its forces are in doubt.
pub const SETTLING_TOLERANCE: f64 = 5e-4;
/// Settled shapes against converged beams under the contact forces, as a share of the largest displacement: what two segments
/// a stretch leave of the box under 5 N spread over its contacts (1.0e-3; a single force at its worst direction leaves four times as much),
/// and a quarter more.
const BEAMS_TOLERANCE: f64 = 1.3e-3;
/// Sensed total against the true one, and each contact's force, without friction and without noise.
const TOTAL_TOLERANCE: f64 = 0.03;
const EACH_TOLERANCE: f64 = 0.10;
/// A contact that carries less than this share of the largest force has only just been made: its own size is no measure of its
/// error.
const SHARES: f64 = 0.1;
/// Chance alone moves the share of 200 pictures within 1.96 standard deviations by 0.015 (one standard deviation); three of these.
const COVERAGE_TOLERANCE: f64 = 0.046;
/// Noisy pictures of the last step, for a promise about stated intervals.
pub const PICTURES: usize = 200;
/// Overlap of object and finger, mm: beyond it the engine's contacts would give way.
const OVERLAP_TOLERANCE_MM: f64 = 1e-3;
/// Force by which a touch may pass its cone of friction, N: rounding.
const CONE_TOLERANCE_N: f64 = 1e-6;

/// One step, sensed.
#[derive(Debug, Clone, PartialEq)]
pub struct StudiedStep {
    /// Finger, object and true forces.
    pub step: SceneStep,
    /// Sensed without noise; `None` where nothing touches.
    pub clean: Result<Option<SensedStep>, SensingError>,
    /// Sensed from one noisy picture.
    pub noisy: Result<Option<SensedStep>, SensingError>,
}

/// Many noisy pictures of one step.
#[derive(Debug, Clone, PartialEq)]
pub struct Pictures {
    /// How many were taken, and how many were answered.
    pub taken: usize,
    /// How many were answered.
    pub answered: usize,
    /// For each contact that is not clamped, and last for the total: the errors, N, picture by picture, with stated sigmas.
    pub sensed: Vec<Vec<SensedForce>>,
}

impl Pictures {
    /// Share of the pictures whose stated interval of 95 % holds the true force: of a contact, or the total (the last).
    pub fn coverage(&self, which: usize) -> f64 {
        let within = self.sensed[which].iter().filter(|force| force.standardised_error().abs() <= TWO_SIDED_95).count();
        within as f64 / self.sensed[which].len() as f64
    }

    /// Root mean square of the errors, N: of a contact, or the total (the last).
    pub fn rms_error_n(&self, which: usize) -> f64 {
        let forces = &self.sensed[which];
        let squares: f64 = forces.iter().map(|force| (force.sensed_n - force.true_n).powi(2)).sum();
        (squares / forces.len() as f64).sqrt()
    }
}

/// A scene run to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneStudy {
    /// Name of the scene.
    pub name: String,
    /// Coefficient of friction.
    pub friction: f64,
    /// Length of the front plate, mm.
    pub length_mm: f64,
    /// Standard deviation of one coordinate in noisy pictures, mm.
    pub noise_mm: f64,
    /// Outline of the object about its own point, closed, mm.
    pub outline: Vec<Vector>,
    /// Steps up to where it ended.
    pub steps: Vec<StudiedStep>,
    /// True forces, and those sensed from one noisy picture a step.
    pub rows: Vec<ForceRow>,
    /// Why it ended early, if it did.
    pub stopped: Option<LatticeError>,
    /// For each step, converged beams under the same contact forces: largest difference of a displacement, as a share of the
    /// largest. `None` where friction turns the rods, or there is nothing to compare.
    pub beams_differences: Vec<Option<f64>>,
    /// Noisy pictures of the last step, if something touches there.
    pub pictures: Option<Pictures>,
}

/// Why a scene was not studied.
#[derive(Debug, thiserror::Error)]
pub enum SceneStudyError {
    /// A scene that ships does not read.
    #[error("a scene that ships: {0}")]
    Scene(#[from] SceneError),
    /// An outline that ships does not read.
    #[error("an outline that ships: {0}")]
    Csv(#[from] csv::Error),
    /// An outline is none.
    #[error(transparent)]
    Outline(#[from] OutlineError),
    /// The beams under the contact forces.
    #[error(transparent)]
    Statics(#[from] StaticsError),
}

/// Runs several scenes in parallel, each with its number of segments in a stretch of plate. Noise is that of each scene's camera, or
/// `noise_mm` for a scene without; `pictures` of it are taken of each last step.
///
/// # Errors
/// [`SceneStudyError`] for an outline that is none, or if beams have no equilibrium under contact forces that the lattice carries.
pub fn run_all(
    scenes: &[(SceneWithOutline, usize)],
    noise_mm: f64,
    pictures: usize,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<SceneStudy>, SceneStudyError> {
    let run = |(SceneWithOutline { scene, corners }, fineness): &(SceneWithOutline, usize)| {
        let Some(object) = &scene.object else { return Ok(None) };
        let prepared = ContactScene::new(scene, object, corners)?.with_fineness(*fineness);
        let noise_mm = scene.camera.map_or(noise_mm, |camera| camera.noise_mm);
        SceneStudy::run(&scene.name, &prepared, noise_mm, pictures, done).map(Some)
    };
    let studies: Vec<Option<SceneStudy>> = scenes.par_iter().map(run).collect::<Result<_, SceneStudyError>>()?;
    Ok(studies.into_iter().flatten().collect())
}

/// A scene with the corners of its outline (mm), if that is a polygon.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneWithOutline {
    /// The scene.
    pub scene: Scene,
    /// Corners of a polygon, mm.
    pub corners: Vec<Vector>,
}

/// Segments in a stretch of plate that are enough where objects bend the finger by some 10 mm.
const COARSE: usize = 2;

/// The contact scenes that ship, the disc first, each with the segments in a stretch of plate that it needs.
///
/// # Errors
/// [`SceneStudyError`] if one does not read.
pub fn shipped() -> Result<Vec<(SceneWithOutline, usize)>, SceneStudyError> {
    let scene = |text: &str, corners: &[Vector], fineness| -> Result<_, SceneStudyError> {
        Ok((SceneWithOutline { scene: Scene::from_toml(text)?, corners: corners.to_vec() }, fineness))
    };
    let mut fork = csv::Reader::from_reader(fixtures::FORK_OUTLINE.as_bytes());
    let fork: Vec<[f64; 2]> = fork.deserialize().collect::<Result<_, _>>()?;
    let fork: Vec<Vector> = fork.into_iter().map(Vector::from).collect();
    Ok(vec![
        scene(fixtures::DISC_SCENE, &[], FINENESS)?,
        scene(fixtures::BOX_SCENE, &[], COARSE)?,
        scene(fixtures::FORK_SCENE, &fork, COARSE)?,
        scene(fixtures::FRICTION_SCENE, &[], COARSE)?,
    ])
}

impl SceneStudy {
    /// Runs a prepared scene, and takes so many noisy pictures of its last step; `done` is told of every step.
    ///
    /// # Errors
    /// [`SceneStudyError::Statics`] if beams have no equilibrium under contact forces that the lattice carries. A step that does not
    /// settle ends the scene instead.
    pub fn run(
        name: &str,
        scene: &ContactScene,
        noise_mm: f64,
        pictures: usize,
        done: &dyn Fn(),
    ) -> Result<SceneStudy, SceneStudyError> {
        let (mut steps, mut rows) = (Vec::new(), Vec::new());
        let mut noise = standard_normal(1);
        let stopped = scene
            .run(|step| {
                let clean = scene.sense(&step, 0.0, || 0.0);
                let noisy = scene.sense(&step, noise_mm, &mut noise);
                rows.extend(force_rows(scene, steps.len() + 1, &step, noisy.as_ref().ok().and_then(Option::as_ref)));
                steps.push(StudiedStep { step, clean, noisy });
                done();
            })
            .err();
        let friction = scene.object().rigid.friction;
        let compared = |studied: &StudiedStep| {
            let touches = &studied.step.pressed.touches;
            if friction > 0.0 || touches.iter().all(|touch| touch.clamped) {
                return Ok(None);
            }
            let beams = beams_under(scene.finger(), touches)?;
            Ok(Some(difference(&beams, &studied.step.pressed.shape)))
        };
        let beams_differences = steps.iter().map(compared).collect::<Result<_, StaticsError>>()?;
        let pictures = match steps.last() {
            Some(StudiedStep { step, clean: Ok(Some(_)), .. }) if noise_mm > 0.0 && pictures > 0 => {
                Some(take_pictures(scene, step, noise_mm, pictures))
            }
            _ => None,
        };
        Ok(SceneStudy {
            name: name.to_owned(),
            friction,
            length_mm: scene.finger().plate_length_mm(Plate::Front),
            noise_mm,
            outline: scene.object().outline.points(),
            steps,
            rows,
            stopped,
            beams_differences,
            pictures,
        })
    }

    /// What is promised of every scene: balance, equilibrium, no overlap, Coulomb's cone.
    pub fn checks(&self) -> Vec<Check> {
        let scene = format!("{} pressed onto the lattice", self.name);
        let touching =
            || self.steps.iter().map(|studied| &studied.step).filter(|step| !step.pressed.touches.is_empty());
        if touching().next().is_none() {
            return Vec::new();
        }
        let over = |figure: &dyn Fn(&SceneStep) -> f64| worst(touching().map(figure));
        let share = |difference: Vector, step: &SceneStep| difference.norm() / step.pressed.contact_force().norm();
        let check = |kind: Kind, what: &str, source: &str, quantity: &str, ours: f64, tolerance: f64| {
            Check::new(kind, format!("{scene}: {what}"), source, quantity, 0.0, ours, tolerance)
        };
        let relative = "largest difference / force";
        vec![
            check(
                Kind::Internal,
                "sum of contact forces against the force of the hand",
                "force balance",
                relative,
                over(&|step| share(step.pressed.contact_force() - step.pressed.hand_force, step)),
                BALANCE_TOLERANCE,
            ),
            check(
                Kind::Internal,
                "sum of contact forces against the force on the clamps",
                "force balance",
                relative,
                over(&|step| share(step.pressed.contact_force() - step.pressed.base_force, step)),
                BALANCE_TOLERANCE,
            ),
            check(
                Kind::Internal,
                "moment of contact forces against that on the clamps",
                "force balance",
                "largest difference / (force x length of the front plate)",
                over(&|step| {
                    let off_nmm = step.pressed.base_moment_nmm - step.pressed.contact_moment_nmm();
                    off_nmm.abs() / (step.pressed.contact_force().norm() * self.length_mm)
                }),
                BALANCE_TOLERANCE,
            ),
            check(
                Kind::External,
                "settled shape against the lattice's equilibrium under the contact forces",
                "Newton on the lattice's energy",
                DISPLACEMENT,
                over(&|step| step.equilibrium_difference.unwrap_or(f64::NAN)),
                SETTLING_TOLERANCE,
            ),
            check(
                Kind::Internal,
                "no overlap and no gap at a contact",
                "geometry",
                "largest overlap or gap, mm",
                over(&|step| worst(step.pressed.touches.iter().map(|touch| touch.overlap_mm.abs()))),
                OVERLAP_TOLERANCE_MM,
            ),
            check(
                Kind::Internal,
                "forces within the cone of friction",
                "Coulomb",
                "largest |tangential| - friction x normal, N",
                over(&|step| worst(step.pressed.touches.iter().map(|touch| self.beyond_cone_n(touch)))),
                CONE_TOLERANCE_N,
            ),
        ]
    }

    /// What is promised of a scene that ships: that it goes to its end, and, without friction, that beams agree and sensing tells the
    /// forces.
    pub fn shipped_checks(&self) -> Vec<Check> {
        let scene = format!("{} pressed onto the lattice", self.name);
        let check = |kind: Kind, what: &str, source: &str, quantity: &str, ours: f64, tolerance: f64| {
            Check::new(kind, format!("{scene}: {what}"), source, quantity, 0.0, ours, tolerance)
        };
        let stopped = f64::from(u8::from(self.stopped.is_some()));
        let mut checks =
            vec![check(Kind::Internal, "goes to its end", SOURCE, "scenes that ended early", stopped, EXACT_COUNT)];
        if self.friction == 0.0 {
            let beams = worst(self.beams_differences.iter().map(|difference| difference.unwrap_or(f64::NAN)));
            checks.push(check(
                Kind::External,
                "settled shape against beams under the contact forces",
                SOURCE,
                DISPLACEMENT,
                beams,
                BEAMS_TOLERANCE,
            ));
            checks.extend(self.sensing_checks(&check));
        }
        checks
    }

    fn sensing_checks(&self, check: &dyn Fn(Kind, &str, &str, &str, f64, f64) -> Check) -> Vec<Check> {
        let refused =
            |sensed: &Result<Option<SensedStep>, SensingError>| f64::from(u8::from(!matches!(sensed, Ok(Some(_)))));
        let clean: Vec<&SensedStep> = self.steps.iter().filter_map(|step| step.clean.as_ref().ok()?.as_ref()).collect();
        let each = clean.iter().flat_map(|sensed| {
            let largest_n = worst(sensed.forces.iter().map(|force| force.true_n));
            sensed.forces.iter().filter(move |force| force.true_n >= SHARES * largest_n)
        });
        let mut checks = vec![
            check(
                Kind::Internal,
                "steps that sensing refuses, without noise",
                SOURCE,
                "count",
                self.steps.iter().map(|step| refused(&step.clean)).sum(),
                EXACT_COUNT,
            ),
            check(
                Kind::Internal,
                "sensed total, nonlinear, without noise",
                SOURCE,
                "largest |sensed / true - 1|",
                worst(clean.iter().map(|sensed| sensed.total.relative_error().abs())),
                TOTAL_TOLERANCE,
            ),
            check(
                Kind::Internal,
                "each sensed force that is a tenth of the largest or more, nonlinear, without noise",
                SOURCE,
                "largest |sensed / true - 1|",
                worst(each.map(|force| force.relative_error().abs())),
                EACH_TOLERANCE,
            ),
        ];
        if let Some(pictures) = &self.pictures {
            let last = pictures.sensed.len() - 1;
            for which in 0..=last {
                let what = if which == last { "total".to_owned() } else { format!("force {}", which + 1) };
                let problem = format!("{what} at the end, {} mm noise: within 1.96 stated sigma", self.noise_mm);
                let mut row = check(
                    Kind::Internal,
                    &problem,
                    SOURCE,
                    "share of pictures",
                    pictures.coverage(which),
                    COVERAGE_TOLERANCE,
                );
                row = Check::new(row.kind, row.problem, row.source, row.quantity, 0.95, row.ours, row.tolerance);
                checks.push(row.with_refused(pictures.taken - pictures.answered, pictures.taken));
            }
        }
        checks
    }

    fn beyond_cone_n(&self, touch: &Touch) -> f64 {
        let normal_n = touch.force.dot(&touch.normal);
        let tangential_n = (touch.force - touch.normal * normal_n).norm();
        (tangential_n - self.friction * normal_n).max(0.0)
    }
}

/// The converged beam finger under the forces of frictionless touches.
fn beams_under(finger: &Finger, touches: &[Touch]) -> Result<FingerShape, StaticsError> {
    let mesh = Mesh::with_elements_per_member(finger, CONVERGED_ELEMENTS);
    let load = |touch: &Touch| match touch.part {
        TouchedPart::Rod(node) => Load::at_node(node, touch.force),
        TouchedPart::Plate(s_mm) => Load::at_place(s_mm, touch.force),
    };
    let loads: Vec<Load> = touches.iter().filter(|touch| !touch.clamped).map(load).collect();
    statics::solve(&mesh, &loads, Kinematics::Corotational)
}

fn take_pictures(scene: &ContactScene, step: &SceneStep, noise_mm: f64, taken: usize) -> Pictures {
    let mut noise = standard_normal(2);
    let answers: Vec<SensedStep> =
        (0..taken).filter_map(|_| scene.sense(step, noise_mm, &mut noise).ok().flatten()).collect();
    let contacts = answers.first().map_or(0, |answer| answer.forces.len());
    let force = |which: usize| move |answer: &SensedStep| answer.forces.get(which).copied().unwrap_or(answer.total);
    let sensed = (0..=contacts).map(|which| answers.iter().map(force(which)).collect()).collect();
    Pictures { taken, answered: answers.len(), sensed }
}
