//! Study of a contact scene, in which forces are sensed at every step. Also reads the shipped contact scenes.

use super::samples::NoiseSamples;
use super::verified::verify;
use super::{FINENESS, VerifiedStep};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use finray_contact::ContactError;
use finray_contact::path::PressError;
use finray_contact::press::{ContactScene, ForceRow, NotSensed, SceneStep, SensedStep, force_rows};
use finray_model::scene::ObjectMotion;

/// Number of noise samples per step in a full study. With this number, all steps of a scene together have some hundreds to a thousand samples.
pub const SAMPLES: usize = 50;
/// Spacing of sample seeds. The first seed of a step is this number times the step's number (from 1).
const SEEDS_A_STEP: u64 = 1_000_000;

/// One step with its sensed forces.
#[derive(Debug, Clone, PartialEq)]
pub struct StudiedStep {
    /// Equilibrium of finger and object, with true forces.
    pub step: SceneStep,
    /// Forces sensed without noise; `None` if no contact deforms the finger.
    pub clean: Result<Option<SensedStep>, NotSensed>,
    /// Forces sensed from one noise sample; `None` if no contact deforms the finger.
    pub noisy: Result<Option<SensedStep>, NotSensed>,
    /// Forces sensed from many noise samples; `None` without samples, or if no contact deforms the finger.
    pub samples: Option<NoiseSamples>,
}

/// Results of a contact scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneStudy {
    /// Name of the scene.
    pub name: String,
    /// Coefficient of friction, dimensionless.
    pub friction: f64,
    /// Length of the front plate, mm.
    pub length_mm: f64,
    /// Standard deviation of a coordinate of markers and outline points, mm.
    pub noise_mm: f64,
    /// Closed outline of the object relative to its reference point, mm.
    pub outline: Vec<Vector>,
    /// Steps up to the end of the scene, or up to a failure.
    pub steps: Vec<StudiedStep>,
    /// True forces, and forces sensed from one noise sample per step.
    pub rows: Vec<ForceRow>,
    /// Reason of a premature end; `None` if the scene is complete.
    pub stopped: Option<ContactError>,
    /// Largest fibre strain of beams under the contact forces, relative to its limit; `None` if no step has an equilibrium of the beams.
    pub largest_strain: Option<StrainOfScene>,
    /// Verification of the steps by lattice and rapier, on a lattice with [`FINENESS`].
    pub verified: Vec<VerifiedStep>,
}

/// A fibre strain in a scene, and the limit of the beam model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainOfScene {
    /// Fibre strain, dimensionless.
    pub strain: f64,
    /// Largest strain at which the material is linear, dimensionless.
    pub limit: f64,
}

/// Why a contact scene could not be studied.
#[derive(Debug, thiserror::Error)]
pub enum SceneStudyError {
    /// A shipped scene cannot be read.
    #[error("cannot read a shipped scene: {0}")]
    Scene(#[from] SceneError),
    /// A shipped outline cannot be read.
    #[error("cannot read a shipped outline: {0}")]
    Csv(#[from] csv::Error),
    /// An outline is invalid.
    #[error(transparent)]
    Outline(#[from] PressError),
    /// The lattice does not settle in rapier, even without the object.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

/// Runs several scenes in parallel. The noise is the camera noise
/// of each scene, or `noise_mm` (mm) if the scene states none. Each step has `samples` noise samples.
///
/// # Errors
/// [`SceneStudyError`] for an invalid outline, or if the lattice does not settle.
pub fn run_all(
    scenes: &[SceneWithOutline],
    noise_mm: f64,
    samples: usize,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<SceneStudy>, SceneStudyError> {
    let run = |SceneWithOutline { scene, corners, .. }: &SceneWithOutline| {
        // Scenes with a free object are skipped, because only a gripper can hold such an object.
        let is_pressed = |object: &&ObjectDescription| !matches!(object.motion, ObjectMotion::Free { .. });
        let Some(object) = scene.object.as_ref().filter(is_pressed) else { return Ok(None) };
        let prepared = ContactScene::new(scene, object, corners)?;
        let noise_mm = scene.noise_mm.unwrap_or(noise_mm);
        SceneStudy::run(&scene.name, &prepared, noise_mm, samples, done).map(Some)
    };
    let studies: Vec<Option<SceneStudy>> = scenes.par_iter().map(run).collect::<Result<_, SceneStudyError>>()?;
    Ok(studies.into_iter().flatten().collect())
}

/// A scene with its text and the corners of its object's outline.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneWithOutline {
    /// Scene as read from its text.
    pub scene: Scene,
    /// Text of the scene's file.
    pub text: String,
    /// Corners of a polygon, mm; empty for other outlines.
    pub corners: Vec<Vector>,
}

impl SceneWithOutline {
    /// Reads a scene without an object, or with an object that is no polygon.
    ///
    /// # Errors
    /// [`SceneError`] if the text is not a valid scene.
    pub fn from_toml(text: &str) -> Result<SceneWithOutline, SceneError> {
        Ok(SceneWithOutline { scene: Scene::from_toml(text)?, text: text.to_owned(), corners: Vec::new() })
    }
}

/// The shipped contact scenes, the disc first.
///
/// # Errors
/// [`SceneStudyError`] if a scene or an outline cannot be read.
pub fn shipped() -> Result<Vec<SceneWithOutline>, SceneStudyError> {
    let scene = |text: &str, corners: &[Vector]| -> Result<_, SceneStudyError> {
        Ok(SceneWithOutline { corners: corners.to_vec(), ..SceneWithOutline::from_toml(text)? })
    };
    let mut fork = csv::Reader::from_reader(finray_fixtures::FORK_OUTLINE.as_bytes());
    let fork: Vec<[f64; 2]> = fork.deserialize().collect::<Result<_, _>>()?;
    let fork: Vec<Vector> = fork.into_iter().map(Vector::from).collect();
    Ok(vec![
        scene(finray_fixtures::DISC_SCENE, &[])?,
        scene(finray_fixtures::BOX_SCENE, &[])?,
        scene(finray_fixtures::FORK_SCENE, &fork)?,
        scene(finray_fixtures::FRICTION_SCENE, &[])?,
    ])
}

impl SceneStudy {
    /// Runs a prepared scene, with `samples` noise samples of each step and noise of `noise_mm` (mm). `done` is called after every step.
    ///
    /// # Errors
    /// [`SceneStudyError::Lattice`] if the lattice does not settle. A step without equilibrium ends the scene early.
    pub fn run(
        name: &str,
        scene: &ContactScene,
        noise_mm: f64,
        samples: usize,
        done: &dyn Fn(),
    ) -> Result<SceneStudy, SceneStudyError> {
        let (mut steps, mut rows) = (Vec::new(), Vec::new());
        let mut noise = Noise::new(1);
        let run = scene.run(|step| {
            let clean = scene.sense(&step, 0.0, || 0.0);
            let noisy = scene.sense(&step, noise_mm, || noise.standard_normal());
            rows.extend(force_rows(scene, steps.len() + 1, &step, noisy.as_ref().ok().and_then(Option::as_ref)));
            steps.push(StudiedStep { step, clean, noisy, samples: None });
            done();
        });
        let friction = scene.object().friction;
        let pressed: Vec<SceneStep> = steps.iter().map(|studied| studied.step.clone()).collect();
        let verified = verify(scene, &pressed, FINENESS)?;
        let limits = &scene.scene().strain_limits;
        let strains = steps.iter().filter_map(|studied| {
            let validity = studied.step.validity(scene.finger()).ok().flatten()?;
            let strain = validity.largest_strain(limits)?;
            Some(StrainOfScene { strain: strain.strain, limit: limits.of(strain.member.part) })
        });
        let largest_strain = strains.max_by(|a, b| (a.strain / a.limit).total_cmp(&(b.strain / b.limit)));
        if noise_mm > 0.0 {
            for (number, studied) in steps.iter_mut().enumerate() {
                let first_seed = SEEDS_A_STEP * (number as u64 + 1);
                studied.samples = NoiseSamples::take(scene, &studied.step, noise_mm, samples, first_seed);
            }
        }
        Ok(SceneStudy {
            name: name.to_owned(),
            friction,
            length_mm: scene.finger().plate_length_mm(Plate::Front),
            noise_mm,
            outline: scene.object().outline.points(),
            steps,
            rows,
            stopped: run.err(),
            largest_strain,
            verified,
        })
    }
}
