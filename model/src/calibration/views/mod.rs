//! Calibrates a finger and its rig from several views.
//!
//! A view is an image in which the front plate of the finger is pressed at one position. Each view adds unknowns: the contact position, the pose of the base
//! and, unless it was measured, the force. All views share the sought [`Quantity`]s. Without a measured force, only geometry is identifiable, because moduli
//! and forces scale together.

mod compliance;
mod contradiction;
mod derivatives;
mod errors;
mod forces;
mod friction;
mod outliers;
mod problem;
mod quantity;
mod refine;
mod rig;
mod scatter;
mod shape_motion;
mod start;
mod unloaded;
mod view;

pub use compliance::{BaseCompliance, compliance_of};
pub use friction::{FrictionEstimate, FrictionQuestion, LeftOutObject, MeasuredLean, friction_of};
pub use outliers::{Outlier, OutlierKind};
pub use quantity::{Quantity, Sought};
pub use refine::refined_views;
pub use rig::{RigEstimate, RigQuestion, UNSTATED_BASE, calibrate_rig};
pub use view::{LocatedView, View, ViewError};

use super::CalibrationError;
use crate::Vector;
use crate::finger::Finger;
use crate::measurement::MarkerErrors;
use crate::optimise::{Convergence, LevenbergMarquardt, Refusal};
use crate::sensing::{ForceUnknowns, Lean, Normal, Pad, UnloadedError};
use errors::{marker_errors, new_marker_errors};
use forces::scatter_of;
use nalgebra::{DMatrix, Isometry2};
use outliers::{check_use, outliers};
use problem::{Candidate, OWN, Point, Problem, residuals};
use scatter::{AddedForceError, Scatter};
use start::start_at_scene;
use unloaded::unloaded_errors;

/// Parameters of finger and camera that are the same in all views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewModel {
    /// Beam elements per member.
    pub elements: usize,
    /// Height of the camera above the plane of the beams, mm.
    pub camera_height_mm: f64,
    /// Height of the markers above the plane of the beams, mm.
    pub marker_height_mm: f64,
    /// Lean (angle between force and normal) of forces that were not measured.
    pub lean: Lean,
    /// Pad between objects and the plate; `None` if the scene states none.
    pub pad: Option<Pad>,
    /// Moment that the plates exert on each other at the tip without load, N mm.
    pub preload_nmm: f64,
    /// Relative standard deviation of a force due to the errors of the finger's model, dimensionless.
    pub model_error: f64,
}

/// Estimate of a sought quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundQuantity {
    /// The quantity and its prior.
    pub sought: Sought,
    /// Value in the quantity's unit. For a modulus, `value` is the dimensionless factor on the scene's modulus.
    pub value: f64,
    /// Change from the scene's value, in the unit of the prior's standard deviation: the logarithm of a factor.
    pub change: f64,
    /// Standard deviation in the unit of `value`. Half of a 95 % interval is 1.96 times this value, also if few measured forces leave their scatter
    /// uncertain.
    pub sigma: f64,
}

/// Estimates for one view, from the fit of the calibrated finger.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundView {
    /// Position of the force along the front plate, mm.
    pub s_mm: f64,
    /// Force in the finger frame, N.
    pub force: Vector,
    /// Standard deviation of the force's magnitude, N, as determined by all views. Zero for a measured force that counts as exact.
    pub force_sigma_n: f64,
    /// Transformation from the finger frame to the frame of the view, mm and rad.
    pub base: Isometry2<f64>,
    /// Rotation of the plate's normal at the contact, rad, averaged over a length of plate. The lean (angle between force and normal) refers to the
    /// normal with this mean rotation.
    pub normal_turn_rad: f64,
    /// Computed minus observed position of each marker, mm, in the frame of the view.
    pub residuals_mm: Vec<Vector>,
}

impl FoundView {
    /// Root mean square of the residual of a coordinate, mm.
    pub fn residual_rms_mm(&self) -> f64 {
        let squares: f64 = self.residuals_mm.iter().map(Vector::norm_squared).sum();
        (squares / (2 * self.residuals_mm.len()) as f64).sqrt()
    }

    /// Lean (angle between the force and the normal `from`), degrees, positive towards the tip.
    pub fn lean_deg(&self, finger: &Finger, from: Normal) -> f64 {
        let angle_deg = finger.angle_deg(self.force);
        match from {
            Normal::Undeformed => angle_deg,
            // An outline that touches the plate shares the plate's normal.
            Normal::Deformed { .. } | Normal::Object => angle_deg - self.normal_turn_rad.to_degrees(),
        }
    }
}

/// Result of a calibration of finger and rig.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewEstimate {
    /// The calibrated finger.
    pub finger: Finger,
    /// Height of the markers above the plane of the beams, mm.
    pub marker_height_mm: f64,
    /// Transformation from the finger frame to the frame of a view, mm and rad, without the part that differs between views.
    pub base: Isometry2<f64>,
    /// Estimates of the sought quantities.
    pub quantities: Vec<FoundQuantity>,
    /// Correlation matrix of the quantities, one row and column per quantity.
    pub correlation: DMatrix<f64>,
    /// Estimates for each view, from the fit of the calibrated finger.
    pub views: Vec<FoundView>,
    /// Errors of the markers estimated from the residuals, relative to the stated noise of the views.
    pub marker_errors: MarkerErrors,
    /// Errors of the markers in a new view. `calibration_error_mm` also includes the uncertainty of the calibrated geometry.
    pub new_marker_errors: MarkerErrors,
    /// Relative error of sensed forces. `None` if no modulus is sought or no force was measured.
    pub force_error: Option<ForceError>,
    /// Uncertainty of finger and rig that `force_error` does not cover: independent errors of one standard deviation each.
    pub unloaded_errors: Vec<UnloadedError>,
    /// Force whose measurement makes the forces of the other views most accurate. `None` without a view whose force was not measured.
    pub next_force: Option<NextForce>,
    /// Measured forces and markers that deviate more than the scatter of the other forces and markers suggests.
    pub outliers: Vec<Outlier>,
}

/// Force of a view that is to be measured next, to within 1 %. Standard deviations are root mean squares over the views without a measured
/// force, relative to each force, dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextForce {
    /// Index of the view.
    pub view: usize,
    /// Standard deviation of the forces now.
    pub now: f64,
    /// Standard deviation of the forces once this force is measured, by a linearised fit.
    pub then: f64,
}

/// Relative standard deviation of a force that is measured with a common load cell or a weight.
const MEASURED_SHARE: f64 = 0.01;

/// Relative standard deviations of one force, dimensionless. They cover errors that the noise, the position and the base of a view do not explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceError {
    /// Relative scatter of the measured forces, dimensionless. A scatter of 1 % and of the error of the finger's model is assumed if there are too
    /// few forces to compare.
    pub scatter: f64,
    /// Relative standard deviation of a force in a new image. `of_new` includes the uncertainty of the scatter and of fitted parameters that
    /// `new_marker_errors` does not cover.
    pub of_new: f64,
}

/// Calibration error, mm, with which the fit starts. Later rounds use the estimate of the last fit.
const FIRST_CALIBRATION_ERROR_MM: f64 = 0.05;
/// Relative scatter of forces with which the fit starts, beside the error of the finger's model. This value is kept if the measurements do not show the
/// scatter. `LEAST_SCATTER` is the
/// smallest scatter that matters.
const FIRST_SCATTER: f64 = 0.01;
const LEAST_SCATTER: f64 = 1e-5;
/// The fit converges to within a thousandth of the standard deviations of the unknowns. Derivatives by differences do not allow much higher accuracy.
const CONVERGENCE: Convergence = Convergence { relative_decrease: 1e-8, step: 0.0 };
/// Marker errors and scatter have settled when a round changes them by no more than this share.
const SETTLED: f64 = 1e-2;
const ROUNDS: usize = 50;
/// A quantity is not identifiable if its standard deviation reaches this limit. The first limit is for the logarithm of a factor, the second for any other
/// quantity (mm, degrees, N mm).
const LARGEST_SIGMAS: [f64; 2] = [1.0, 20.0];

/// Whether a round changes neither the marker errors nor the scatter of forces.
fn have_settled(before: (MarkerErrors, Option<f64>), after: (MarkerErrors, Option<f64>)) -> bool {
    let close = |before: f64, after: f64| (before - after).abs() <= SETTLED * after;
    let scatters_close =
        before.1.zip(after.1).is_none_or(|(before, after)| (before - after).abs() <= SETTLED * after + LEAST_SCATTER);
    close(before.0.noise_factor, after.0.noise_factor)
        && close(before.0.calibration_error_mm, after.0.calibration_error_mm)
        && scatters_close
}

/// Estimates the shared quantities of a finger and its rig from several views.
///
/// # Reference
/// Nonlinear least squares over all views at once, including each view's own unknowns, by the method of Levenberg and Marquardt. This is bundle
/// adjustment (Triggs et al. 2000) with the co-rotational finger in place of points; derivatives follow from the tangent stiffness at each equilibrium. The variance of the
/// residuals beyond the noise is estimated with the fit, so that priors have the right weight. The stated noise is reduced if residuals are smaller
/// than this noise. If a modulus is sought, the relative variance of measured forces is also estimated. The relative variance of measured forces
/// covers errors of the force sensor, and errors of the model that markers do not show. All variances follow by restricted maximum likelihood
/// (Patterson and Thompson, Biometrika 58, 1971). Fits are repeated until the variances settle.
///
/// # Errors
/// [`CalibrationError`] if the scene's finger does not explain a view, a view contradicts the others, a quantity is not identifiable, or the
/// calibrated finger would be too inaccurate for use.
pub fn views(
    finger: &Finger,
    views: &[View],
    sought: &[Sought],
    model: &ViewModel,
) -> Result<ViewEstimate, CalibrationError> {
    Ok(views_from(None, finger, views, sought, model)?.0)
}

/// Point and variances at which a fit has settled. The fit on a finer mesh starts from them.
#[derive(Debug, Clone)]
struct Settled {
    point: Point,
    errors: MarkerErrors,
    scatter: Option<f64>,
}

/// Estimates like [`views`], and returns the settled fit. The search starts from `start`, the settled fit of the same views on another mesh. If `start`
/// is `None`, the search starts from the scene's finger.
fn views_from(
    start: Option<Settled>,
    finger: &Finger,
    views: &[View],
    sought: &[Sought],
    model: &ViewModel,
) -> Result<(ViewEstimate, Settled), CalibrationError> {
    let leaning = views.iter().filter(|view| view.force.is_none()).count();
    let shares_lean = !sought.is_empty() && leaning > 1 && model.lean.sd_deg > 0.0;
    let shared_lean = shares_lean.then_some(Sought { quantity: Quantity::Lean, prior_sd: Some(model.lean.sd_deg) });
    let sought = &[sought, shared_lean.as_slice()].concat()[..];
    let is_scaled = sought.iter().any(|sought| sought.quantity.is_modulus()) && views.iter().any(|v| v.force.is_some());
    // Forces that are too few to show their scatter may at least err as the beam model does.
    let first_scatter = FIRST_SCATTER.hypot(model.model_error);
    let scatter = is_scaled.then_some(first_scatter);
    let errors = MarkerErrors { calibration_error_mm: FIRST_CALIBRATION_ERROR_MM, ..MarkerErrors::default() };
    let mut problem = Problem { finger, views, sought, model, errors, scatter, shapes: Vec::new() };
    let names = |quantities: &mut dyn Iterator<Item = usize>| {
        quantities.map(|k| sought[k].quantity.to_string()).collect::<Vec<_>>().join(", ")
    };
    let all = || names(&mut (0..sought.len()));
    let coordinates: usize = views.iter().map(|view| view.measurement.coordinate_count()).sum();
    let unknowns = sought.iter().filter(|sought| sought.prior_sd.is_none()).count()
        + views.iter().map(|view| if view.force.is_some() { 1 } else { 2 }).sum::<usize>();
    if coordinates <= unknowns {
        return Err(CalibrationError::TooFewMarkers { unknowns, coordinates });
    }
    let mut point = match start {
        None => start_at_scene(&problem)?,
        Some(start) => {
            (problem.errors, problem.scatter) = (start.errors, start.scatter);
            start.point
        }
    };
    let mut found = None;
    for _ in 0..ROUNDS {
        let search = LevenbergMarquardt { convergence: CONVERGENCE, ..LevenbergMarquardt::default() };
        let fitted = search.minimise(&mut problem, point).map_err(Refusal::into_error)?;
        point = fitted.point.clone();
        let covariance = fitted.covariance();
        let covariance = covariance.ok_or_else(|| CalibrationError::NotSeparable { parameters: all() })?;
        let before = (problem.errors, problem.scatter);
        problem.errors = marker_errors(&problem, &fitted, &covariance);
        let scatter = problem.scatter.and_then(|_| scatter_of(&problem, &fitted));
        problem.scatter = problem.scatter.map(|_| {
            scatter.as_ref().and_then(Scatter::most_likely).map_or(first_scatter, |share| share.max(LEAST_SCATTER))
        });
        found = Some((fitted, covariance, scatter));
        if have_settled(before, (problem.errors, problem.scatter)) {
            break;
        }
    }
    let (fitted, covariance, scatter) = found.ok_or(CalibrationError::NoMinimum)?;
    let sigma = |k: usize| covariance[(k, k)].sqrt();
    // Few measured forces leave their scatter uncertain. The interval of a quantity then is wider than that of the most likely scatter.
    let sigma_of_shared = |k: usize| scatter.as_ref().and_then(|scatter| scatter.of_shared(k)).unwrap_or(sigma(k));
    let open = |k: &usize| {
        let quantity = sought[*k].quantity;
        let limit = LARGEST_SIGMAS[usize::from(!quantity.is_modulus())];
        // If no view constrains a shared lean, the lean is as uncertain as its prior.
        sigma_of_shared(*k).is_nan() || sigma_of_shared(*k) >= limit && quantity != Quantity::Lean
    };
    if (0..sought.len()).any(|k| open(&k)) {
        return Err(CalibrationError::NotIdentifiable { parameters: names(&mut (0..sought.len()).filter(open)) });
    }
    let of_new = problem.scatter.map(|most_likely| match &scatter {
        // Whoever senses a new force adds the error of the finger's model.
        Some(scatter) => scatter.of_new(most_likely, FIRST_SCATTER),
        None => AddedForceError { share: most_likely, of_markers: 0.0 },
    });
    let force_error = problem.scatter.zip(of_new).map(|(scatter, of_new)| ForceError { scatter, of_new: of_new.share });
    if !sought.is_empty() {
        check_use(&problem, &fitted, &covariance, force_error)?;
    }
    let point = &fitted.point;
    let candidate = problem.candidate(&point.shared).ok_or(CalibrationError::NoMinimum)?;
    let quantities = sought.iter().zip(&point.shared).enumerate();
    let quantities =
        quantities.map(|(k, (sought, change))| found_quantity(&problem, sought, *change, sigma_of_shared(k)));
    let found_view = |(view, own, _, column): (_, _, _, usize)| {
        let is_sought = problem.own_count(view) > OWN;
        let force_sigma_n = if is_sought { sigma(column + OWN) } else { 0.0 };
        found_view(&problem, &candidate, view, own, force_sigma_n).ok_or(CalibrationError::NoMinimum)
    };
    let found_views = problem.parts(point).map(found_view).collect::<Result<Vec<_>, _>>()?;
    let settled = Settled { point: fitted.point.clone(), errors: problem.errors, scatter: problem.scatter };
    let estimate = ViewEstimate {
        quantities: quantities.collect(),
        correlation: DMatrix::from_fn(sought.len(), sought.len(), |i, j| covariance[(i, j)] / (sigma(i) * sigma(j))),
        views: found_views,
        marker_errors: problem.errors,
        new_marker_errors: new_marker_errors(&problem, of_new.map_or(0.0, |of_new| of_new.of_markers)),
        unloaded_errors: match force_error {
            Some(_) => Vec::new(),
            None => unloaded_errors(&problem, &fitted, &candidate.base),
        },
        force_error,
        next_force: next_force(&problem, &fitted.point, &covariance),
        outliers: outliers(&problem, &fitted, &covariance),
        marker_height_mm: candidate.marker_height_mm,
        base: candidate.base,
        finger: candidate.mesh.finger().clone(),
    };
    Ok((estimate, settled))
}

/// The force whose measurement makes the forces that were not measured most accurate. A measurement of one unknown conditions the covariance on it.
fn next_force(problem: &Problem, point: &Point, covariance: &DMatrix<f64>) -> Option<NextForce> {
    let parts = problem.parts(point).enumerate();
    let unknown: Vec<(usize, usize, f64)> = parts
        .filter(|(_, (view, ..))| view.force.is_none())
        .map(|(i, (_, own, _, column))| (i, column + OWN, own.force_n))
        .collect();
    let rms = |variance: &dyn Fn(usize) -> f64| {
        let squares = unknown.iter().map(|(_, column, force_n)| variance(*column) / force_n.powi(2));
        (squares.sum::<f64>() / unknown.len() as f64).sqrt()
    };
    let now = rms(&|column| covariance[(column, column)]);
    let measured = |&(view, of, force_n): &(usize, usize, f64)| {
        let total = covariance[(of, of)] + (MEASURED_SHARE * force_n).powi(2);
        NextForce {
            view,
            now,
            then: rms(&|column| covariance[(column, column)] - covariance[(column, of)].powi(2) / total),
        }
    };
    unknown.iter().map(measured).min_by(|a, b| a.then.total_cmp(&b.then))
}

/// Estimates for a view with a candidate (finger and rig). `None` if the candidate has no equilibrium.
fn found_view(
    problem: &Problem,
    candidate: &Candidate,
    view: &View,
    own: &ForceUnknowns,
    force_sigma_n: f64,
) -> Option<FoundView> {
    let pressed = problem.pressed(candidate, view, own, None)?;
    let over_mm = match problem.model.lean.from {
        Normal::Deformed { over_mm } => over_mm,
        Normal::Undeformed | Normal::Object => 0.0,
    };
    Some(FoundView {
        s_mm: own.s_mm,
        force: pressed.force() * (view.force.map_or(own.force_n, |force| force.norm()) / own.force_n),
        force_sigma_n,
        base: candidate.base * own.base,
        normal_turn_rad: pressed.normal_turn_rad(over_mm).ok()?,
        residuals_mm: residuals(candidate, view, &pressed).map(|(_, left)| left).collect(),
    })
}

/// Estimate of a sought quantity. `change` is the value of the quantity's unknown, and `sigma` the unknown's standard deviation. For a factor,
/// `change` and `sigma` refer to the factor's logarithm. For any other quantity, `change` and `sigma` are in the quantity's unit.
fn found_quantity(problem: &Problem, sought: &Sought, change: f64, sigma: f64) -> FoundQuantity {
    let is_modulus = sought.quantity.is_modulus();
    let value = if is_modulus { change.exp() } else { problem.stated(sought.quantity) + change };
    FoundQuantity { sought: *sought, value, change, sigma: sigma * if is_modulus { value } else { 1.0 } }
}
