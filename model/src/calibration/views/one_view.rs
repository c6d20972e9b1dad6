//! Estimates the force in one view together with errors of the unloaded finger.

use super::positions::{ForceAt, Spread, scan};
use super::problem::{OWN, Point, Problem, ViewUnknowns, free_part_mm};
use super::{CONVERGENCE, Quantity, Sought, View, ViewModel};
use crate::finger::{Finger, Plate};
use crate::measurement::MarkerErrors;
use crate::optimise::{Convergence, LevenbergMarquardt, covariance};
use crate::sensing::{
    COUNTS, Contact, ContactPosition, ContactQuestion, Direction, LARGEST_DEPARTURE, LARGEST_POSITION_SIGMA, Lean,
    Normal, REACH, ResidualTest, SensingError, UnloadedError, WELL_KNOWN,
};
use nalgebra::{DVector, Isometry2};

/// Relative standard deviation assumed for a force of unknown magnitude and known direction. The value is so large that it has no effect.
const UNKNOWN_SHARE: f64 = 1e3;
/// Standard deviations of a marker coordinate, mm, that the first searches assume in addition to the stated noise.
const FIRST_ERRORS_MM: [f64; 2] = [0.3, 0.02];
/// Convergence of the first searches, which only provide a starting point.
const FIRST_CONVERGENCE: Convergence = Convergence { relative_decrease: 1e-3, step: 0.0 };
/// Starting points of a search that has no earlier estimate. `STARTS` lists positions as shares of the plate's length; `FIRST_FORCE_N` is the force,
/// N.
const STARTS: [f64; 4] = [0.35, 0.5, 0.65, 0.8];
const FIRST_FORCE_N: f64 = 1.0;
/// The dependence of force on position counts as nonlinear if the position's standard deviation exceeds this share of the distance to the nearer end
/// of the plate.
const UNCERTAIN_POSITION: f64 = 0.1;
/// Standard deviation assumed for an unknown direction, degrees. The value is so large that it has no effect.
const UNKNOWN_DEG: f64 = 1e3;

/// A view with the known and unknown parts of its contact.
#[derive(Debug, Clone, Copy)]
pub struct OneView<'v> {
    /// The view. Its measured force is ignored.
    pub view: &'v View,
    /// Whether displacements refer to an image of the unloaded finger, not to the scene's finger.
    pub is_from_rest: bool,
    /// Position and direction of the contact, known or sought.
    pub question: ContactQuestion,
}

/// Earlier estimate of a contact in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedBefore {
    /// Position along the front plate, mm.
    pub s_mm: f64,
    /// Direction, degrees from the front plate's undeformed normal.
    pub angle_deg: f64,
    /// Force, N.
    pub force_n: f64,
}

/// Estimated force in one view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceInView {
    /// Position along the front plate, mm.
    pub s_mm: f64,
    /// Direction in the frame of the view, degrees from the front plate's undeformed normal.
    pub angle_deg: f64,
    /// Force, N.
    pub force_n: f64,
    /// Standard deviation of the force, N. The standard deviation follows from the residual if the residual contradicts the noise of the view.
    pub sigma_n: f64,
    /// Sum of squared residuals divided by their variances, priors included, dimensionless.
    pub squares: f64,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// Test of the residual against the noise of the view. `None` if the noise is zero or no degree of freedom remains.
    pub test: Option<ResidualTest>,
}

/// Estimates a force together with the unknown parts of its position and direction, the pose of the base, and errors of the unloaded finger. The
/// search starts from `before` or, if it is `None`, from several positions along the plate.
///
/// # Errors
/// [`SensingError::NoSuchFinger`] if the search finds no minimum or an unknown is not identifiable. [`SensingError::Undetermined`] for a force so
/// uncertain that the markers do not respond linearly to a change of the force by one standard deviation. [`SensingError::Undetermined`] also for a
/// position that the markers do not confine to a part of the plate.
///
/// # Reference
/// Nonlinear least squares with Gaussian priors, as in [`views`](super::views). The standard deviation belongs to the linearised posterior
/// distribution.
pub fn force_in_view(
    finger: &Finger,
    asked: OneView,
    model: &ViewModel,
    errors: &[UnloadedError],
    before: Option<SensedBefore>,
) -> Result<ForceInView, SensingError> {
    let Found { force: mut found, lean: sought, shared, position_sd_mm, is_linear } =
        best_in_view(finger, asked, model, errors, before)?;
    let question = asked.question;
    let from = |question, start, shared: Option<&Vec<f64>>| {
        found_from(finger, OneView { question, ..asked }, model, errors, start, shared)
    };
    let undetermined = |what, sigma, unit| Err(SensingError::Undetermined { what, contact: 1, sigma, unit });
    let length_mm = finger.plate_length_mm(Plate::Front);
    if question.position.is_none() {
        let to_end_mm = found.s_mm.min(length_mm - found.s_mm);
        let mut spread = Spread { sigma_n: found.sigma_n, position_sd_mm, is_bounded: true };
        if position_sd_mm > UNCERTAIN_POSITION * to_end_mm {
            let wider = found.test.map_or(1.0, |test| test.trusted_noise_mm() / asked.view.noise_mm);
            let limits = (length_mm, free_part_mm(finger));
            let near = SensedBefore { s_mm: found.s_mm, angle_deg: found.angle_deg, force_n: found.force_n };
            spread =
                scan((found.at(), &(near, shared.clone())), position_sd_mm, limits, wider, |s_mm, (near, shared)| {
                    let question = ContactQuestion { position: Some(ContactPosition::At(s_mm)), ..question };
                    let Found { force, shared, .. } = from(question, SensedBefore { s_mm, ..*near }, Some(shared))?;
                    let near = SensedBefore { s_mm, angle_deg: force.angle_deg, force_n: force.force_n };
                    Some((force.at(), (near, shared)))
                });
        }
        if !spread.is_bounded || spread.position_sd_mm > LARGEST_POSITION_SIGMA * length_mm {
            return undetermined("the position", spread.position_sd_mm, "mm");
        }
        found.sigma_n = found.sigma_n.max(spread.sigma_n);
    }
    if !is_linear {
        return undetermined("the force", found.sigma_n, "N");
    }
    if let (Some(sought), Direction::Leaning(lean)) = (sought, question.direction)
        && (sought.by_lean_n * sought.sd_deg).abs() > COUNTS * found.sigma_n
    {
        // The force may depend nonlinearly on its lean (angle from the normal). Forces estimated at two other leans therefore increase `sigma_n`, as
        // in `NonlinearEstimator`.
        let off_n2 = |reach: f64| {
            let angle_deg = sought.lean_deg + reach * sought.sd_deg;
            let direction = Direction::Leaning(Lean { angle_deg, sd_deg: 0.0, build_up_n: 0.0, ..lean });
            let start = SensedBefore { s_mm: found.s_mm, angle_deg, force_n: found.force_n };
            let end = from(ContactQuestion { direction, ..question }, start, Some(&shared))?.force;
            Some(((end.force_n - found.force_n) / reach).powi(2))
        };
        let ends: Vec<f64> = [-REACH, REACH].into_iter().filter_map(off_n2).collect();
        let mean_n2 = ends.iter().sum::<f64>() / ends.len().max(1) as f64;
        let more_n2 = mean_n2 - (sought.by_lean_n * sought.sd_deg).powi(2);
        found.sigma_n = found.sigma_n.hypot(more_n2.max(0.0).sqrt());
    }
    Ok(found)
}

/// The best minimum of the search of [`force_in_view`], regardless of the uncertainty of its force.
///
/// # Errors
/// [`SensingError::NoSuchFinger`] if the search finds no minimum or an unknown is not identifiable.
pub(super) fn best_in_view(
    finger: &Finger,
    asked: OneView,
    model: &ViewModel,
    errors: &[UnloadedError],
    before: Option<SensedBefore>,
) -> Result<Found, SensingError> {
    let question = asked.question;
    let angle_deg = match question.direction {
        Direction::Angle(angle_deg) => angle_deg,
        Direction::Leaning(lean) => lean.mean_deg(FIRST_FORCE_N),
        Direction::Auto => 0.0,
    };
    let known_mm = question.position.and_then(|position| Contact { position, angle_deg }.position_mm(finger));
    let at = |share: f64| share * finger.plate_length_mm(Plate::Front);
    let first = |share: f64| SensedBefore { s_mm: known_mm.unwrap_or(at(share)), angle_deg, force_n: FIRST_FORCE_N };
    let starts = before.map_or_else(|| STARTS.map(first).to_vec(), |before| vec![before]);
    let found = starts.into_iter().filter_map(|start| found_from(finger, asked, model, errors, start, None));
    found.min_by(|a, b| a.force.squares.total_cmp(&b.force.squares)).ok_or(SensingError::NoSuchFinger)
}

impl ForceInView {
    fn at(&self) -> ForceAt {
        ForceAt { s_mm: self.s_mm, force_n: self.force_n, sigma_n: self.sigma_n, squares: self.squares }
    }
}

/// A minimum that a search found.
pub(super) struct Found {
    pub(super) force: ForceInView,
    /// The lean, if it was sought.
    lean: Option<SoughtLean>,
    /// Errors of the unloaded finger, in standard deviations.
    shared: Vec<f64>,
    /// Standard deviation of the position, mm. Zero for a known position.
    position_sd_mm: f64,
    /// Whether the relative uncertainty of the force is small, or the markers respond linearly to a change of the force by one standard deviation.
    is_linear: bool,
}

/// An estimated lean (angle between force and normal) and its standard deviation, degrees. `by_lean_n` is the derivative of the force with respect to the lean,
/// N per degree.
struct SoughtLean {
    lean_deg: f64,
    sd_deg: f64,
    by_lean_n: f64,
}

fn found_from(
    finger: &Finger,
    asked: OneView,
    model: &ViewModel,
    errors: &[UnloadedError],
    before: SensedBefore,
    shared: Option<&Vec<f64>>,
) -> Option<Found> {
    let OneView { view, is_from_rest, question } = asked;
    let lean = match question.direction {
        Direction::Leaning(lean) => lean,
        _ => Lean { angle_deg: before.angle_deg, sd_deg: UNKNOWN_DEG, ..Lean::NONE },
    };
    // A known direction refers to the frame of the view.
    let along = match question.direction {
        Direction::Angle(angle_deg) => Some(finger.direction(angle_deg) * before.force_n.abs()),
        _ => None,
    };
    let views = [View { force: along, ..view.clone() }];
    let sought: Vec<Sought> =
        (0..errors.len()).map(|k| Sought { quantity: Quantity::Unloaded(k), prior_sd: Some(1.0) }).collect();
    let own = ViewUnknowns {
        s_mm: before.s_mm,
        base: Isometry2::identity(),
        force_n: before.force_n,
        further_lean_deg: match question.direction {
            Direction::Leaning(_) => further_lean_deg(&lean, &before),
            _ => 0.0,
        },
    };
    let at = shared.cloned().unwrap_or_else(|| vec![0.0; errors.len()]);
    let mut point = Point { shared: at, own: vec![own] };
    let search = LevenbergMarquardt { convergence: CONVERGENCE, ..LevenbergMarquardt::default() };
    let model = ViewModel { lean, ..*model };
    let mut problem = Problem {
        finger,
        views: &views,
        sought: &sought,
        unloaded: errors,
        model: &model,
        errors: MarkerErrors::default(),
        scatter: along.map(|_| UNKNOWN_SHARE),
        is_position_known: question.position.is_some(),
        is_from_rest,
    };
    // Large assumed marker errors in the first searches keep the search from ending at local minima far from the priors.
    let first = LevenbergMarquardt { convergence: FIRST_CONVERGENCE, ..search };
    for model_mm in FIRST_ERRORS_MM.into_iter().filter(|model_mm| shared.is_none() && *model_mm > view.noise_mm) {
        problem.errors.model_mm = model_mm;
        point = first.minimise(&mut problem, point).ok()?.point;
    }
    problem.errors = MarkerErrors::default();
    let fitted = search.minimise(&mut problem, point).ok()?;
    let own = fitted.point.own[0];
    let known = usize::from(question.position.is_some());
    // Removes the column of a known position. The position is the first of the view's own unknowns.
    let by = match known {
        0 => fitted.jacobian.clone(),
        _ => fitted.jacobian.clone().remove_column(errors.len()),
    };
    let force = errors.len() + OWN - known;
    let covariance = covariance(&by)?;
    let variance_n2 = covariance[(force, force)];
    // The lean (angle between force and normal) is the last unknown of a view whose direction is sought.
    let sought = match question.direction {
        Direction::Leaning(lean) if lean.sd_deg > 0.0 => Some(SoughtLean {
            lean_deg: lean.mean_deg(own.force_n) + own.further_lean_deg,
            sd_deg: covariance[(force + 1, force + 1)].sqrt(),
            by_lean_n: covariance[(force, force + 1)] / covariance[(force + 1, force + 1)],
        }),
        _ => None,
    };
    let candidate = problem.candidate(&fitted.point.shared)?;
    let pressed = problem.pressed(&candidate, &views[0], &own)?;
    let coordinates = view.measurement.coordinate_count();
    let squares_mm2 = fitted.squares * view.noise_mm.powi(2);
    let test = ResidualTest::new(Some(view.noise_mm), squares_mm2, by.nrows().saturating_sub(by.ncols()));
    let wider = test.map_or(1.0, |test| test.trusted_noise_mm() / view.noise_mm);
    let of_markers = fitted.residual.rows(0, coordinates).norm_squared() / coordinates as f64;
    let sigma_n = variance_n2.sqrt() * wider;
    let follows = |change_n: f64| {
        let changed = ViewUnknowns { force_n: own.force_n + change_n, ..own };
        let Some(rows) = problem.weighted(Some(&pressed), &candidate, &views[0], &changed) else { return false };
        let moved = DVector::from_vec(rows).rows(0, coordinates) - fitted.residual.rows(0, coordinates);
        let linear = fitted.jacobian.column(errors.len() + OWN).rows(0, coordinates) * change_n;
        (moved - &linear).norm() <= LARGEST_DEPARTURE * linear.norm()
    };
    let position_sd_mm = if known == 0 { covariance[(errors.len(), errors.len())].sqrt() } else { 0.0 };
    let is_linear = sigma_n <= WELL_KNOWN * own.force_n.abs() || [-sigma_n, sigma_n].into_iter().all(follows);
    let force = (candidate.base * own.base).rotation * pressed.force;
    let found = ForceInView {
        s_mm: own.s_mm,
        angle_deg: match question.direction {
            Direction::Angle(angle_deg) => angle_deg,
            _ => finger.angle_deg(force * own.force_n.signum()),
        },
        force_n: own.force_n,
        sigma_n,
        squares: fitted.squares,
        residual_rms_mm: of_markers.sqrt() * view.noise_mm,
        test,
    };
    Some(Found { force: found, lean: sought, shared: fitted.point.shared, position_sd_mm, is_linear })
}

/// Difference between the lean (angle between force and normal) of an earlier estimate and the mean lean, degrees. Zero unless the lean refers to the
/// undeformed normal.
fn further_lean_deg(lean: &Lean, before: &SensedBefore) -> f64 {
    match lean.from {
        Normal::Undeformed => before.angle_deg - lean.mean_deg(before.force_n),
        _ => 0.0,
    }
}
