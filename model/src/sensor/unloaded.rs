//! Estimates a force on a finger whose unloaded shape may differ from the shape in the scene.

use super::Sensor;
use crate::Vector;
use crate::calibration::{OneView, SensedBefore, View, ViewModel, force_in_view};
use crate::estimators::{Answer, EstimatorError, Question};
use crate::measurement::BaseUncertainty;
use crate::observation::Observation;
use crate::sensing::{
    AssemblyErrors, CameraAbove, Contact, ContactPosition, ContactQuestion, Direction, Estimate, Lean, Normal,
    ResidualTest, SensingError, UnloadedFinger, Warning,
};
use nalgebra::{Isometry2, Point2};

/// Beam elements per member in a search for a force together with the unloaded shape.
const ELEMENTS_UNLOADED: usize = 4;
/// Assumed standard deviation of the markers, mm, due to an unknown unloaded shape. The first search, which does not estimate the unloaded shape,
/// uses this standard deviation.
const UNLOADED_ERROR_MM: f64 = 0.3;
/// Standard deviation, mm and rad, that is assumed for an exactly known base. No camera resolves an error as small as this standard deviation.
const EXACT: f64 = 1e-6;

impl Sensor {
    /// Possible errors of the unloaded finger, as seen in one observation. `frame` transforms from the finger frame to the reference frame of the
    /// camera's pose.
    pub(super) fn unloaded(
        &self,
        assembly: AssemblyErrors,
        frame: &Isometry2<f64>,
        seen: &Observation,
    ) -> UnloadedFinger {
        let scene = self.scene();
        let references = scene.base.as_ref().map_or(&[][..], |base| &base.references);
        let camera = scene.camera.and_then(|camera| camera.pose).zip(scene.markers).map(|(pose, markers)| {
            let eye = (frame.inverse() * Point2::from(pose.eye().xy())).coords;
            // The camera is assumed to be equally high above base references and markers.
            let middle = match references {
                [] => eye,
                some => some.iter().map(|reference| reference.at).sum::<Vector>() / some.len() as f64,
            };
            CameraAbove { eye, middle, distance_mm: pose.eye().z - markers.height_mm }
        });
        let base_sd_rad = scene.base.as_ref().and_then(|base| base.uncertainty).map_or(0.0, |base| base.sd_rad);
        let measured_in_frame_sd_rad = seen.counts_from_rest(&scene.finger).then_some(base_sd_rad);
        UnloadedFinger { assembly, camera, measured_in_frame_sd_rad }
    }

    /// Estimates one force together with the errors of the unloaded finger. The search starts from the estimate for the scene's finger, if that estimate
    /// succeeds. `None` for several contacts, for a contact with an object, and for estimators that do not search.
    pub(super) fn all_at_once(
        &self,
        question: &Question,
        unloaded: &UnloadedFinger,
    ) -> Option<Result<Answer, EstimatorError>> {
        let [asked] = question.contacts else { return None };
        let touches = matches!(asked.direction, Direction::Leaning(Lean { from: Normal::Object, .. }));
        (!touches && self.options.estimator.searches()).then(|| self.sensed_at_once(question, asked, unloaded))
    }

    fn sensed_at_once(
        &self,
        question: &Question,
        asked: &ContactQuestion,
        unloaded: &UnloadedFinger,
    ) -> Result<Answer, EstimatorError> {
        let scene = self.scene();
        let finger = &scene.finger;
        let noise_mm = question.noise_mm.map(|noise_mm| noise_mm.hypot(UNLOADED_ERROR_MM));
        let before = self.options.estimator.answer(finger, &Question { unloaded: None, noise_mm, ..*question });
        let start = match &before {
            Ok((contacts, estimate)) => Some(SensedBefore {
                s_mm: contacts[0].position_mm(finger).unwrap_or_default(),
                angle_deg: contacts[0].angle_deg,
                force_n: estimate.forces_n[0],
            }),
            Err(EstimatorError::Sensing(
                SensingError::NotConverged { .. }
                | SensingError::Unexplained { .. }
                | SensingError::Undetermined { .. }
                | SensingError::Ambiguous { .. }
                | SensingError::Unconfirmed,
            )) if asked.direction != Direction::Auto => None,
            Err(_) => return before,
        };
        let exact = BaseUncertainty { sd_mm: EXACT, sd_rad: EXACT, ..BaseUncertainty::default() };
        let Some(noise_mm) = question.noise_mm.or(before.as_ref().ok().map(|(_, estimate)| estimate.noise_mm)) else {
            return before;
        };
        let view = View {
            name: String::new(),
            measurement: question.measurement.clone(),
            noise_mm,
            base: question.measurement.base().unwrap_or(exact),
            eye: unloaded.camera.map_or(Vector::zeros(), |camera| camera.eye),
            force: None,
        };
        let model = ViewModel { elements: ELEMENTS_UNLOADED, ..ViewModel::of_scene(scene, Lean::NONE) };
        let is_from_rest = unloaded.measured_in_frame_sd_rad.is_some();
        let errors = unloaded.independent_errors(finger);
        let found =
            force_in_view(finger, OneView { view: &view, is_from_rest, question: *asked }, &model, &errors, start);
        let found = match found {
            Ok(found) => found,
            Err(refused) => return before.and(Err(refused.into())),
        };
        let contradicts = found.test.filter(ResidualTest::contradicts);
        if before.is_err() && contradicts.is_some() {
            return before;
        }
        let position = asked.position.unwrap_or(ContactPosition::At(found.s_mm));
        let model_error_n = before.map_or(vec![0.0], |(_, estimate)| estimate.model_error_n);
        let estimate = Estimate {
            forces_n: vec![found.force_n],
            sigmas_n: vec![found.sigma_n.hypot(model_error_n[0])],
            model_error_n,
            misfit_factor: 1.0,
            noise_mm: found.test.map_or(noise_mm, |test| test.trusted_noise_mm()),
            warning: contradicts.map(Warning::Residual),
            residual_rms_mm: found.residual_rms_mm,
            singular_values: Vec::new(),
        };
        Ok((vec![Contact { position, angle_deg: found.angle_deg }], estimate))
    }
}
