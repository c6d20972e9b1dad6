//! Starting point of a calibration.

use super::contradiction::MarkerForce;
use super::contradiction::{check_forces, marker_force, wrong_name};
use super::problem::{Candidate, Point, Problem, residuals};
use super::shape_motion::misfit_of_shape;
use super::unloaded::unloaded_error;
use super::{FIRST_CALIBRATION_ERROR_MM, View, ViewError};
use crate::calibration::CalibrationError;
use crate::finger::{Plate, ThicknessError};
use crate::measurement::Marker;
use crate::sensing::{
    AssemblyErrors, CameraAbove, ContactQuestion, Direction, ForceUnknowns, Lean, NonlinearEstimator, UnloadedError,
    UnloadedFinger, linearise_assembly,
};
use nalgebra::Isometry2;

/// The plate is divided into this number of sections. The search for a contact first tries the points between the sections.
const PLACES: usize = 50;

/// Starting point of the search in one view.
struct Beginning {
    /// Starting point with the measured force, or with the force from the markers if no force was measured. `None` if the finger has no equilibrium
    /// under the measured force.
    own: Option<ForceUnknowns>,
    /// Force estimated from the markers, for comparison with the measured force. `None` if no force was measured or the markers do not determine the
    /// force.
    of_markers: Option<MarkerForce>,
}

/// Starting point of the search. For each view, the starting point contains the unknowns with which the scene's finger explains the view best.
///
/// # Errors
/// [`CalibrationError`] if the scene's finger does not explain a view, or a view contradicts the finger or the other views.
pub(super) fn start_at_scene(problem: &Problem) -> Result<Point, CalibrationError> {
    let shared = vec![0.0; problem.sought.len()];
    let stated = problem.candidate(&shared).ok_or(CalibrationError::NoMinimum)?;
    let of_view = |view: &View| beginning(problem, &stated, view).map_err(|error| view.wrong(error));
    let begins: Vec<Beginning> = problem.views.iter().map(of_view).collect::<Result<_, _>>()?;
    let marker_forces: Vec<Option<MarkerForce>> = begins.iter().map(|beginning| beginning.of_markers).collect();
    // A calibration without sought quantities only compares the unchanged finger with the measured forces, so no force is refused.
    if !problem.sought.is_empty() {
        check_forces(problem, &marker_forces)?;
    }
    let own = begins.iter().zip(problem.views).map(|(beginning, view)| {
        let force_n = view.force.map_or(0.0, |force| force.norm());
        beginning.own.ok_or_else(|| view.wrong(ViewError::NotCarried { force_n }))
    });
    Ok(Point { shared, own: own.collect::<Result<_, _>>()? })
}

fn beginning(problem: &Problem, stated: &Candidate, view: &View) -> Result<Beginning, ViewError> {
    let Some(force) = view.force else {
        let own = start_of_unknown(problem, stated, view)?;
        return wrong_name(problem, stated, view, &own).map_or(Ok(Beginning { own: Some(own), of_markers: None }), Err);
    };
    let (own, of_markers) = (start_of_known(problem, stated, view, force.norm()), marker_force(problem, stated, view));
    // The measured force or the force from the markers may be wrong, so node numbers are refused only if they look wrong with each of the two
    // forces.
    let explained = own.into_iter().chain(of_markers.map(|of_markers| of_markers.own));
    let names: Vec<Option<ViewError>> = explained.map(|own| wrong_name(problem, stated, view, &own)).collect();
    match names.into_iter().reduce(|first, second| first.filter(|_| second.is_some())).flatten() {
        Some(error) => Err(error),
        None => Ok(Beginning { own, of_markers }),
    }
}

/// Position along the plate at which the measured force explains the markers best, after the best rigid motion of the finger. `None` if the finger has no
/// equilibrium under the force at any position.
fn start_of_known(problem: &Problem, stated: &Candidate, view: &View, force_n: f64) -> Option<ForceUnknowns> {
    let length_mm = problem.finger.plate_length_mm(Plate::Front);
    let mut near = None;
    let mut misfit = |own: &ForceUnknowns| {
        let pressed = problem.pressed(stated, view, own, near.as_ref())?;
        let at =
            |(marker, left): (&Marker, _)| (problem.finger.marker_position(marker.node) + marker.displacement, left);
        let misfit = misfit_of_shape(&residuals(stated, view, &pressed).map(at).collect::<Vec<_>>());
        near = Some(pressed.into_shape());
        Some(misfit)
    };
    let tried = (1..PLACES).map(|i| ForceUnknowns::at(length_mm * i as f64 / PLACES as f64, force_n));
    let tried = tried.filter_map(|own| misfit(&own).map(|misfit| (misfit, own)));
    tried.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, own)| own)
}

/// Force and position with which the scene's finger explains the view best. If the scene's finger does not explain the view, the search also varies the
/// sought quantities within their priors.
fn start_of_unknown(problem: &Problem, stated: &Candidate, view: &View) -> Result<ForceUnknowns, ViewError> {
    let direction = Direction::Leaning(Lean { sd_deg: 0.0, ..problem.model.lean });
    let question = ContactQuestion { pad: problem.model.pad, ..ContactQuestion::new(None, direction) };
    let questions = [question];
    let mut estimator = NonlinearEstimator::new(&stated.mesh, &questions)?;
    let measurement = view.measurement.clone().with_base(view.base);
    let sensed = estimator.estimate(&measurement, Some(view.noise_mm.hypot(FIRST_CALIBRATION_ERROR_MM)));
    let refused = match sensed {
        Ok(sensed) => {
            let s_mm = sensed.contacts[0].position_mm(problem.finger).unwrap_or_default();
            return Ok(ForceUnknowns::at(s_mm, sensed.forces.forces_n[0]));
        }
        Err(refused) => refused,
    };
    let errors: Vec<UnloadedError> = (0..problem.sought.len())
        .filter_map(|k| {
            let mut changes = vec![0.0; problem.sought.len()];
            changes[k] = problem.sought[k].prior_sd?;
            Some(unloaded_error(problem, &changes, &Isometry2::identity()))
        })
        .collect();
    let height_mm = problem.model.camera_height_mm - problem.model.marker_height_mm;
    let unloaded = UnloadedFinger {
        assembly: AssemblyErrors { further: errors, ..AssemblyErrors::default() },
        thickness: ThicknessError::default(),
        camera: Some(CameraAbove { eye: view.eye, middle: view.eye, distance_mm: height_mm }),
        measured_in_frame_sd_rad: None,
    };
    let noise_mm = view.noise_mm.hypot(FIRST_CALIBRATION_ERROR_MM);
    let found = linearise_assembly(problem.finger, &questions, None, &unloaded, &measurement, noise_mm, None);
    let found = found.map_err(|_| refused)?;
    let s_mm = found.contacts[0].position_mm(problem.finger).unwrap_or_default();
    Ok(ForceUnknowns::at(s_mm, found.forces_n[0]))
}
