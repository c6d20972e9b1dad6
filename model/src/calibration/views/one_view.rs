//! The force in one view of a finger that may not be quite the scene's: everything that is unknown is sought at once, as in a calibration.

use super::problem::{OWN, Point, Problem, ViewUnknowns};
use super::{CONVERGENCE, Quantity, Sought, View, ViewModel};
use crate::finger::Finger;
use crate::measurement::MarkerErrors;
use crate::optimise::{LevenbergMarquardt, covariance};
use crate::sensing::{ContactQuestion, Direction, Lean, ResidualTest, UnloadedError};
use nalgebra::Isometry2;

/// Standard deviation of the magnitude of a force of which the direction alone is known, as a share: none that counts.
const UNKNOWN_SHARE: f64 = 1e3;
/// Standard deviation, degrees, of a direction that is not known.
const UNKNOWN_DEG: f64 = 1e3;

/// Where a contact of a view was sensed before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensedBefore {
    /// Position along the front plate, mm.
    pub s_mm: f64,
    /// Direction, degrees from the front plate's undeformed normal.
    pub angle_deg: f64,
    /// Force, N.
    pub force_n: f64,
}

/// A force in one view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceInView {
    /// Position along the front plate, mm.
    pub s_mm: f64,
    /// Direction, degrees from the front plate's undeformed normal, in the frame of the view where it is known.
    pub angle_deg: f64,
    /// Force, N.
    pub force_n: f64,
    /// Its standard deviation, N; it rests on the residual where that contradicts the noise of the view.
    pub sigma_n: f64,
    /// Sum of squares of the fit in standard deviations, priors included.
    pub squares: f64,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// The residual against the noise of the view.
    pub test: Option<ResidualTest>,
}

/// Seeks a force, its position and direction as far as a question leaves them open, the base, and errors of the unloaded finger, from where the force was sensed
/// before. `None` where the search finds no minimum, or not all is identifiable.
///
/// # Reference
/// As [`views`](super::views): nonlinear least squares with Gaussian priors; the standard deviation is that of the linearised posterior distribution.
pub fn force_in_view(
    finger: &Finger,
    view: &View,
    question: &ContactQuestion,
    model: &ViewModel,
    errors: &[UnloadedError],
    before: SensedBefore,
) -> Option<ForceInView> {
    let lean = match question.direction {
        Direction::Leaning(lean) => lean,
        _ => Lean { angle_deg: before.angle_deg, sd_deg: UNKNOWN_DEG, ..Lean::NONE },
    };
    // A direction that is known is known in the frame of the view.
    let along = match question.direction {
        Direction::Angle(angle_deg) => Some(finger.direction(angle_deg) * before.force_n.abs()),
        _ => None,
    };
    let views = [View { force: along, ..view.clone() }];
    let sought: Vec<Sought> =
        (0..errors.len()).map(|k| Sought { quantity: Quantity::Unloaded(k), prior_sd: Some(1.0) }).collect();
    let mut problem = Problem {
        finger,
        views: &views,
        sought: &sought,
        unloaded: errors,
        model: &ViewModel { lean, ..*model },
        errors: MarkerErrors::default(),
        scatter: along.map(|_| UNKNOWN_SHARE),
        is_position_known: question.position.is_some(),
    };
    let own = ViewUnknowns {
        s_mm: before.s_mm,
        base: Isometry2::identity(),
        force_n: before.force_n,
        further_lean_deg: match question.direction {
            Direction::Leaning(_) => finger_lean_deg(&lean, &before),
            _ => 0.0,
        },
    };
    let start = Point { shared: vec![0.0; errors.len()], own: vec![own] };
    let search = LevenbergMarquardt { convergence: CONVERGENCE, ..LevenbergMarquardt::default() };
    let fitted = search.minimise(&mut problem, start).ok()?;
    let own = fitted.point.own[0];
    let known = usize::from(question.position.is_some());
    // Without the position, which is the first of the view's own unknowns, if it is known.
    let by = match known {
        0 => fitted.jacobian.clone(),
        _ => fitted.jacobian.clone().remove_column(errors.len()),
    };
    let force = errors.len() + OWN - known;
    let variance_n2 = covariance(&by)?[(force, force)];
    let candidate = problem.candidate(&fitted.point.shared)?;
    let pressed = problem.pressed(&candidate, &views[0], &own)?;
    let coordinates = view.measurement.coordinate_count();
    let squares_mm2 = fitted.squares * view.noise_mm.powi(2);
    let test = ResidualTest::new(Some(view.noise_mm), squares_mm2, by.nrows().saturating_sub(by.ncols()));
    let wider = test.map_or(1.0, |test| test.trusted_noise_mm() / view.noise_mm);
    let of_markers = fitted.residual.rows(0, coordinates).norm_squared() / coordinates as f64;
    let force = (candidate.base * own.base).rotation * pressed.force;
    Some(ForceInView {
        s_mm: own.s_mm,
        angle_deg: match question.direction {
            Direction::Angle(angle_deg) => angle_deg,
            _ => finger.angle_deg(force * own.force_n.signum()),
        },
        force_n: own.force_n,
        sigma_n: variance_n2.sqrt() * wider,
        squares: fitted.squares,
        residual_rms_mm: of_markers.sqrt() * view.noise_mm,
        test,
    })
}

/// How much further than its mean a force leant that was sensed before, about the undeformed normal; zero about another one.
fn finger_lean_deg(lean: &Lean, before: &SensedBefore) -> f64 {
    match lean.from {
        crate::sensing::Normal::Undeformed => before.angle_deg - lean.mean_deg(before.force_n),
        _ => 0.0,
    }
}
