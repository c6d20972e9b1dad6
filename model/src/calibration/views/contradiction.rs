//! Refuses views that contradict the scene's finger or the other views so strongly that no change of the sought quantities explains the
//! contradiction. Each view is tested before any fit.

use super::problem::{Candidate, Problem, residuals};
use super::shape_motion::motion_of_shape;
use super::{Quantity, Sought, View, ViewError};
use crate::calibration::{CalibrationError, median};
use crate::measurement::BaseUncertainty;
use crate::sensing::{ContactQuestion, Direction, ForceUnknowns, NonlinearEstimator};
use crate::{NodeId, Vector};

/// Standard deviations assumed before calibration: `UNCALIBRATED_MM` for markers, mm, and `SOUGHT_BASE` for a base whose pose is sought, mm and rad.
const UNCALIBRATED_MM: f64 = 0.3;
const SOUGHT_BASE: [f64; 2] = [5.0, 0.05];
/// A view is refused if its ratio of measured force to marker force (force estimated from the markers) differs from the median by more than this
/// factor. Forces estimated from the markers of an uncalibrated finger are wrong by up to half. Beyond this limit, the measured force does not belong
/// to its image.
const LARGEST_TIMES: f64 = 2.0;
/// A calibration is refused if the median ratio of measured force to marker force (force estimated from the markers), or its reciprocal, exceeds this
/// limit. The scene's modulus may be a guess, but beyond this limit the search has no starting point.
const LARGEST_FACTOR: f64 = 5.0;
/// A measured force counts as wrong only if it deviates from the force estimated from the markers by more than this many standard deviations of the
/// estimate.
const SURE: f64 = 3.0;
/// A marker has a wrong node number if its distance to another node's computed position is below this share of its distance to its own node's position.
const NEARER: f64 = 0.5;

/// Force and other unknowns of a view, estimated from the view's markers alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MarkerForce {
    pub own: ForceUnknowns,
    /// Standard deviation of the force, N.
    pub sigma_n: f64,
}

/// A measured force compared with another estimate of the same force.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compared<'v> {
    pub view: &'v View,
    /// Ratio of the measured force to the other estimate, dimensionless.
    pub times: f64,
    /// Standard deviation of 1 / `times` due to the noise and the uncertain base of the view, dimensionless.
    pub inverse_sd: f64,
}

impl Compared<'_> {
    fn of(view: &View, of_markers: MarkerForce) -> Option<Compared<'_>> {
        let measured_n = view.force?.norm();
        Some(Compared { view, times: measured_n / of_markers.own.force_n, inverse_sd: of_markers.sigma_n / measured_n })
    }

    /// Whether `times` differs from `other` by more than noise explains.
    pub fn is_surely_not(&self, other: f64) -> bool {
        (1.0 / self.times - 1.0 / other).abs() > SURE * self.inverse_sd
    }
}

/// Force that the markers of a view show along the measured direction, estimated with the scene's finger. `None` if no force was measured or the
/// estimator returns no force.
pub(super) fn marker_force(problem: &Problem, stated: &Candidate, view: &View) -> Option<MarkerForce> {
    // The estimated force points inwards along the line of the measured force. The sign of the measured force is not used, because it may be
    // wrong.
    let angle_deg = problem.finger.angle_deg(view.force?);
    let outwards_deg: f64 = if angle_deg.abs() > 90.0 { 180.0 } else { 0.0 };
    let direction = Direction::Angle(angle_deg - outwards_deg.copysign(angle_deg));
    let questions = [ContactQuestion { pad: problem.model.pad, ..ContactQuestion::new(None, direction) }];
    let mut estimator = NonlinearEstimator::new(&stated.mesh, &questions).ok()?;
    let is_of_base = |it: &Sought| matches!(it.quantity, Quantity::BaseX | Quantity::BaseY | Quantity::BaseTurn);
    let [sd_mm, sd_rad] = if problem.sought.iter().any(is_of_base) { SOUGHT_BASE } else { [0.0; 2] };
    let (sd_mm, sd_rad) = (view.base.sd_mm.hypot(sd_mm), view.base.sd_rad.hypot(sd_rad));
    let measurement = view.measurement.clone().with_base(BaseUncertainty { sd_mm, sd_rad, ..view.base });
    let sensed = estimator.estimate(&measurement, Some(view.noise_mm.hypot(UNCALIBRATED_MM))).ok()?;
    let force_n = if outwards_deg > 0.0 { -sensed.forces.forces_n[0] } else { sensed.forces.forces_n[0] };
    let own = ForceUnknowns::at(sensed.contacts[0].position_mm(problem.finger)?, force_n);
    Some(MarkerForce { own, sigma_n: sensed.forces.sigmas_n[0] })
}

/// Compares measured forces with marker forces (forces estimated from the markers). `marker_forces` has one entry per view.
///
/// # Errors
/// [`CalibrationError::ForceScale`] if all forces deviate by a common factor, [`ViewError::Force`] for the view that deviates most from the others.
pub(super) fn check_forces(problem: &Problem, marker_forces: &[Option<MarkerForce>]) -> Result<(), CalibrationError> {
    let of_view = |(view, of_markers): (_, &Option<MarkerForce>)| Compared::of(view, (*of_markers)?);
    let all: Vec<Compared> = problem.views.iter().zip(marker_forces).filter_map(of_view).collect();
    let Some(usual) = median(all.iter().map(|it| it.times)) else { return Ok(()) };
    if !(LARGEST_FACTOR.recip()..=LARGEST_FACTOR).contains(&usual) {
        return Err(CalibrationError::ForceScale { times: usual });
    }
    let off = |it: &Compared| if it.times > 0.0 { (it.times / usual).ln().abs() } else { f64::INFINITY };
    match all.iter().filter(|it| it.is_surely_not(usual)).max_by(|a, b| off(a).total_cmp(&off(b))) {
        Some(worst) if off(worst) > LARGEST_TIMES.ln() => {
            Err(worst.view.wrong(ViewError::Force { times: worst.times, usual }))
        }
        _ => Ok(()),
    }
}

/// Finds a marker of a view at the computed position of another node, after the best rigid motion of the finger. `None` if every marker has the right node.
pub(super) fn wrong_name(problem: &Problem, stated: &Candidate, view: &View, own: &ForceUnknowns) -> Option<ViewError> {
    let pressed = problem.pressed(stated, view, own, None)?;
    // Node, observed position and computed position of each marker.
    let places: Vec<(NodeId, Vector, Vector)> = residuals(stated, view, &pressed)
        .map(|(marker, left)| {
            let seen = problem.finger.marker_position(marker.node) + marker.displacement;
            (marker.node, seen, seen + left)
        })
        .collect();
    let moved = motion_of_shape(&places.iter().map(|(_, seen, place)| (*place, seen - place)).collect::<Vec<_>>());
    let away_mm = |seen: &Vector, place: &Vector| (seen - place - moved(place)).norm();
    places.iter().find_map(|(node, seen, place)| {
        let own_mm = away_mm(seen, place);
        let others = places.iter().filter(|(other, ..)| other != node);
        let is_there = |place: &Vector| away_mm(seen, place) < NEARER * own_mm;
        let (other, ..) = others.into_iter().find(|(.., place)| is_there(place))?;
        Some(ViewError::Name { node: *node, other: *other, away_mm: own_mm })
    })
}
