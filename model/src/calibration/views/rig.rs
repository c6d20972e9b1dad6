//! Calibrates finger, rig, friction and base compliance of a scene, and lists the resulting values of the scene file.

use super::{
    BaseCompliance, ForceError, FrictionEstimate, FrictionQuestion, LocatedView, Quantity, Sought, View, ViewEstimate,
    ViewModel, compliance_of, friction_of, refined_views, views,
};
use crate::calibration::{CalibrationError, SceneValues, modulus_values};
use crate::estimators::ELEMENTS;
use crate::finger::{BracketLengths, RibPositions, ThicknessError};
use crate::keys::{ASSEMBLY, BASE, CAMERA, CONTACT, MARKERS, REFERENCE, RIBS};
use crate::measurement::BaseUncertainty;
use crate::sensing::{Lean, Pad, UnloadedError};
use crate::{Finger, Scene, Vector};
use nalgebra::Point2;
use toml::Value;

/// Camera height, mm, for a scene without a camera: so large that the height of markers has no effect.
const NO_CAMERA_MM: f64 = 1e12;

/// Prior uncertainty of the base relative to its references, if the scene states no uncertainty of the base. This prior suits a compliant part that
/// is mounted by hand. Images state only the accuracy of the located references, which is far higher than the accuracy of a part mounted by hand.
pub const UNSTATED_BASE: BaseUncertainty =
    BaseUncertainty { sd_mm: 1.0, sd_rad: std::f64::consts::PI / 180.0, turn_rad_per_n: 0.0, turn_sd_rad_per_n: 0.0 };

/// If the relative scatter of measured forces exceeds this value, the calibration also tries forces mirrored about the normal. If the mirrored forces
/// scatter less by more than the factor `FAR_LESS`, the sign of a force component is wrong.
const LARGE_SCATTER: f64 = 0.03;
const FAR_LESS: f64 = 3.0;
/// Relative error of forces on a finger whose joints were fitted without any measured force, dimensionless, beyond what the fit states: the errors of the
/// joints change all forces alike, and no residual shows it. Chosen from 60 random fingers, judged on 60 others (`fixtures/remounted`).
const UNMEASURED_JOINTS: f64 = 0.0365;

/// Quantities that a calibration of finger and rig estimates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RigQuestion {
    /// Quantities of finger, markers and base.
    pub sought: Vec<Sought>,
    /// Friction between finger and objects, estimated from the directions of measured forces. `None` if friction is not estimated.
    pub friction: Option<FrictionQuestion>,
    /// Whether the rotation of the base under force is estimated.
    pub base_compliance: bool,
    /// Relative standard deviation of sensed forces from object to object, dimensionless. Images of one object do not show how the forces deviate
    /// from object to object.
    pub force_error_between_objects: f64,
}

/// A calibrated finger with its rig.
#[derive(Debug, Clone, PartialEq)]
pub struct RigEstimate {
    /// Finger, markers, base and their errors.
    pub views: ViewEstimate,
    /// Friction between finger and objects. `None` if friction was not sought.
    pub friction: Option<FrictionEstimate>,
    /// Rotation of the base under force. `None` if the rotation of the base under force was not sought.
    pub compliance: Option<BaseCompliance>,
    /// Relative standard deviation of a factor on all moduli, dimensionless: the part of the error of a force in a new image that a fitted `modulus`
    /// leaves, and zero if the moduli of single plates are fitted. `None` if no modulus is sought.
    pub modulus_sd: Option<f64>,
    /// Uncertainty of the thicknesses, and how a fitted `modulus` depends on them.
    pub thickness: ThicknessError,
    /// Relative standard deviation of a force in a new image beyond `modulus_sd`, including the variation from object to object, dimensionless.
    /// `None` if it is unknown.
    pub force_error: Option<f64>,
    /// Whether the base was sought with the prior [`UNSTATED_BASE`], because the scene states no uncertainty of the base.
    pub is_base_unstated: bool,
}

impl ViewModel {
    /// Model of a scene's finger and camera. `lean` (angle between force and normal) applies to forces that were not measured.
    pub fn of_scene(scene: &Scene, lean: Lean) -> ViewModel {
        ViewModel {
            elements: ELEMENTS,
            camera_height_mm: scene.camera.and_then(|camera| camera.pose).map_or(NO_CAMERA_MM, |pose| pose.eye().z),
            marker_height_mm: scene.markers.map_or(0.0, |markers| markers.height_mm),
            lean,
            pad: scene.contact.pad,
            preload_nmm: scene.assembly.as_ref().map_or(0.0, |assembly| assembly.preload_nmm),
            model_error: scene.model_error.share(),
        }
    }

    /// Surface on which a force acts, as in sensing: of the pad; without a pad, of the plate if friction turns a force that was not measured. `None`
    /// for the middle line.
    pub(super) fn surface_of(&self, is_measured: bool) -> Option<Pad> {
        self.pad.or((!is_measured && self.lean.has_friction()).then(Pad::default))
    }
}

/// Calibrates a scene's finger and rig from located views. `lean` (angle between force and normal) applies to forces that were not measured.
///
/// # Errors
/// [`CalibrationError`] if a view is refused, or a sought quantity is not identifiable.
pub fn calibrate_rig(
    scene: &Scene,
    seen: &[LocatedView],
    question: &RigQuestion,
    lean: Lean,
) -> Result<RigEstimate, CalibrationError> {
    let is_base_unstated =
        scene.base.as_ref().is_some_and(|base| !base.references.is_empty() && base.uncertainty.is_none());
    let view = |seen: &LocatedView| match is_base_unstated {
        true => View { base: UNSTATED_BASE, ..seen.view.clone() },
        false => seen.view.clone(),
    };
    let all: Vec<View> = seen.iter().map(view).collect();
    let model = ViewModel::of_scene(scene, lean);
    // What the scene states of the stiffness is the prior of a factor on all moduli.
    let stated_sd = Some(scene.stiffness_error.share()).filter(|sd| *sd > 0.0);
    let with_prior = |sought: &Sought| match sought.quantity {
        Quantity::Modulus => Sought { prior_sd: sought.prior_sd.or(stated_sd), ..*sought },
        _ => *sought,
    };
    let sought: Vec<Sought> = question.sought.iter().map(with_prior).collect();
    let mut found = refined_views(&scene.finger, &all, &sought, &model)?;
    // With the median, the noise factor would not hold for half of the images from which it was estimated.
    found.new_marker_errors.noise_factor_of_mm = all.iter().map(|view| view.noise_mm).reduce(f64::max);
    check_side(scene, &all, &sought, &model, &found)?;
    let measured = || seen.iter().zip(&found.views).filter(|(seen, _)| seen.view.force.is_some());
    let leans: Vec<_> = measured()
        .map(|(seen, view)| {
            (seen.object.as_deref().unwrap_or_default(), view.force.norm(), view.lean_deg(&found.finger, lean.from))
        })
        .collect();
    let friction = question.friction.map(|question| friction_of(&leans, lean.from, question)).transpose()?;
    let turns = || -> Vec<(f64, f64)> {
        let turn_deg = |seen: &LocatedView, base: &nalgebra::Isometry2<f64>| {
            (seen.base.rotation * base.rotation).angle().to_degrees()
        };
        measured().map(|(seen, view)| (view.force.norm(), turn_deg(seen, &view.base))).collect()
    };
    let compliance = question.base_compliance.then(|| compliance_of(&turns())).transpose()?;
    let between_objects = question.force_error_between_objects;
    let [modulus_sd, force_error] = match found.force_error {
        None => {
            let are_joints = |it: &Sought| {
                matches!(it.quantity, Quantity::Bracket(_) | Quantity::OwnBracket(..) | Quantity::RibPosition(..))
            };
            let is_unmeasured = measured().next().is_none() && sought.iter().any(are_joints);
            let least = if is_unmeasured { scene.contact.force_error.max(UNMEASURED_JOINTS) } else { 0.0 };
            [None, Some(between_objects.max(least)).filter(|share| *share > 0.0)]
        }
        Some(ForceError { of_new, .. }) => {
            let modulus = found.quantities.iter().find(|found| found.sought.quantity == Quantity::Modulus);
            // The error of a new force includes that of the modulus, which has a key of its own.
            let of_modulus = modulus.map_or(0.0, |found| (found.sigma / found.value).min(of_new));
            let rest = (of_new.powi(2) - of_modulus.powi(2)).max(0.0).sqrt();
            [Some(of_modulus), Some(rest.hypot(between_objects))]
        }
    };
    let modulus_of = |finger: &Finger| -> Result<f64, CalibrationError> {
        let found = views(finger, &all, &sought, &model)?;
        Ok(found.quantities.iter().find(|it| it.sought.quantity == Quantity::Modulus).map_or(1.0, |it| it.value))
    };
    let thickness = match modulus_sd {
        None => scene.thickness_error,
        Some(_) => scene.thickness_error.calibrated(&scene.finger, modulus_of)?,
    };
    Ok(RigEstimate { views: found, friction, compliance, modulus_sd, thickness, force_error, is_base_unstated })
}

/// Refuses measured forces that scatter far less after mirroring about the normal, because one of their components then has the wrong sign.
fn check_side(
    scene: &Scene,
    all: &[View],
    sought: &[Sought],
    model: &ViewModel,
    found: &ViewEstimate,
) -> Result<(), CalibrationError> {
    let scatter = |estimate: &ViewEstimate| Some(estimate.force_error?.scatter);
    let Some(of_measured) = scatter(found).filter(|scatter| *scatter > LARGE_SCATTER) else { return Ok(()) };
    let finger = &scene.finger;
    let mirrored = |force: Vector| finger.direction(-finger.angle_deg(force)) * force.norm();
    let all: Vec<View> = all.iter().map(|view| View { force: view.force.map(mirrored), ..view.clone() }).collect();
    match views(finger, &all, sought, model).ok().as_ref().and_then(scatter) {
        Some(mirrored) if FAR_LESS * mirrored < of_measured => {
            Err(CalibrationError::MirroredForces { scatter: of_measured, mirrored })
        }
        _ => Ok(()),
    }
}

impl Lean {
    /// Coefficient of friction, and standard deviation of the coefficient for a single force, both dimensionless.
    pub fn coefficient(&self) -> [f64; 2] {
        let coefficient = self.angle_deg.to_radians().tan();
        [coefficient, self.sd_deg.to_radians() * (1.0 + coefficient * coefficient)]
    }
}

impl RigEstimate {
    /// Values of the calibrated scene by key. The calibrated values replace the values of the scene; `None` removes the key.
    pub fn scene_values(&self, scene: &Scene) -> SceneValues {
        let mut values = self.finger_values();
        let mut put = |key: String, value: Value| values.push((key, Some(value)));
        let errors = self.views.new_marker_errors;
        put(MARKERS.noise_factor.path(), Value::from(errors.noise_factor));
        put(MARKERS.model_error_mm.path(), Value::from(errors.calibration_error_mm));
        let reduced_mm = errors.noise_factor_of_mm.filter(|_| errors.noise_factor < 1.0);
        values.push((MARKERS.noise_factor_of_mm.path(), reduced_mm.map(Value::from)));
        let mut put = |key: String, value: Value| values.push((key, Some(value)));
        if let Some(share) = self.force_error {
            put(CONTACT.force_error_share.path(), Value::from(share));
        }
        if self.is_base_unstated {
            put(BASE.sigma_mm.path(), Value::from(UNSTATED_BASE.sd_mm));
            put(BASE.sigma_deg.path(), Value::from(UNSTATED_BASE.sd_rad.to_degrees()));
        }
        // A base that is known exactly does not rotate under force.
        let is_sought = self.is_base_unstated || scene.base.as_ref().is_some_and(|base| base.uncertainty.is_some());
        if let Some(BaseCompliance { deg_per_n, sigma_deg_per_n }) = self.compliance.filter(|_| is_sought) {
            put(BASE.turn_deg_per_n.path(), Value::from(deg_per_n));
            if sigma_deg_per_n.is_finite() {
                put(BASE.turn_sigma_deg_per_n.path(), Value::from(sigma_deg_per_n));
            }
        }
        if let Some(FrictionEstimate { lean, .. }) = &self.friction {
            let [coefficient, sigma] = lean.coefficient();
            put(CONTACT.friction.path(), Value::from(coefficient));
            put(CONTACT.friction_sigma.path(), Value::from(sigma));
            if lean.build_up_n > 0.0 {
                put(CONTACT.friction_build_up_n.path(), Value::from(lean.build_up_n));
            }
            // A scene states either a coefficient or a range of coefficients.
            values.push((CONTACT.friction_range.path(), None));
        }
        values.extend(self.base_values(scene));
        // The assembly errors include the uncertainty of calibrated values. The keys for the standard deviations of calibrated values are therefore
        // removed.
        let known = [
            (self.sought(|quantity| *quantity == Quantity::Preload), &ASSEMBLY.preload_sigma_nmm),
            (self.sought(|quantity| *quantity == Quantity::MarkerHeight), &ASSEMBLY.height_sigma_mm),
            (self.seeks_joints(), &ASSEMBLY.joint_sigma_mm),
        ];
        if scene.assembly.is_some() {
            values.extend(known.into_iter().filter(|(is_known, _)| *is_known).map(|(_, key)| (key.path(), None)));
        }
        let errors: Vec<Vec<f64>> = self.views.unloaded_errors.iter().map(UnloadedError::to_row).collect();
        if !errors.is_empty() || scene.assembly.as_ref().is_some_and(|assembly| !assembly.further.is_empty()) {
            let rows = Some(errors).filter(|errors| !errors.is_empty()).map(Value::from);
            values.push((ASSEMBLY.errors.path(), rows));
        }
        values
    }

    /// Whether positions of rib joints were sought, both along the plates and perpendicular to them.
    fn seeks_joints(&self) -> bool {
        self.sought(|quantity| matches!(quantity, Quantity::RibPosition(..)))
            && self.sought(|quantity| matches!(quantity, Quantity::OwnBracket(..)))
    }

    fn sought(&self, wanted: impl Fn(&Quantity) -> bool) -> bool {
        self.views.quantities.iter().any(|found| wanted(&found.sought.quantity))
    }

    /// Calibrated values of finger and markers.
    fn finger_values(&self) -> SceneValues {
        let description = self.views.finger.description();
        let pairs = |of: &[[f64; 2]]| Value::from(of.iter().map(|pair| pair.to_vec()).collect::<Vec<_>>());
        let moduli = self.modulus_sd.map(|sd| modulus_values(&self.views.finger, 1.0, sd, self.thickness));
        let mut values: SceneValues = moduli.unwrap_or_default();
        let mut put = |key: String, value: Value| values.push((key, Some(value)));
        if self.sought(|quantity| matches!(quantity, Quantity::Bracket(_) | Quantity::OwnBracket(..))) {
            let lengths = match &description.ribs.bracket_mm {
                BracketLengths::Alike(lengths_mm) => Value::from(lengths_mm.to_vec()),
                BracketLengths::Each(each) => pairs(each),
            };
            put(RIBS.bracket_mm.path(), lengths);
        }
        if self.sought(|quantity| matches!(quantity, Quantity::Clip | Quantity::PlateClip(_))) {
            put(RIBS.clip_mm.path(), Value::from(description.ribs.clip_mm.to_vec()));
        }
        if let RibPositions::Positions(positions) = &description.ribs.positions
            && self.sought(|quantity| matches!(quantity, Quantity::RibPosition(..)))
        {
            put(RIBS.positions_mm.path(), pairs(positions));
        }
        if self.sought(|quantity| *quantity == Quantity::MarkerHeight) {
            put(MARKERS.height_mm.path(), Value::from(self.views.marker_height_mm));
        }
        if let Some(found) = self.views.quantities.iter().find(|found| found.sought.quantity == Quantity::Preload) {
            put(ASSEMBLY.preload_nmm.path(), Value::from(found.value));
        }
        values
    }

    /// Positions of the base references or, without references, the camera's pose, in the frame of the calibrated finger. Empty if the base was not
    /// sought.
    fn base_values(&self, scene: &Scene) -> SceneValues {
        if !self.sought(|quantity| *quantity == Quantity::BaseX) {
            return Vec::new();
        }
        let moved = self.views.base;
        let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
        if let (true, Some(pose)) = (references.is_empty(), scene.camera.and_then(|camera| camera.pose)) {
            let pose = pose.of_moved_base(&moved);
            let rotation = Value::from(pose.rotation_vector_rad().to_vec());
            let translation = Value::from(pose.translation_mm.iter().copied().collect::<Vec<_>>());
            return vec![
                (CAMERA.rotation_vector_rad.path(), Some(rotation)),
                (CAMERA.translation_mm.path(), Some(translation)),
            ];
        }
        let at_mm = |(i, at): (usize, Vector)| {
            let at: Vector = (moved.inverse() * Point2::from(at)).coords;
            (REFERENCE.at_mm.path_in(i + 1), Some(Value::from(vec![at.x, at.y])))
        };
        references.iter().map(|reference| reference.at).enumerate().map(at_mm).collect()
    }
}
