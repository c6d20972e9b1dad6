//! Views that contradict the scene's finger or each other by more than what is sought could explain: each view by itself, before any fit.

use super::problem::{Candidate, Problem, ViewUnknowns};
use super::shape_motion::motion_of_shape;
use super::{Quantity, View, ViewError};
use crate::calibration::{CalibrationError, median};
use crate::measurement::BaseUncertainty;
use crate::sensing::{ContactQuestion, Direction, NonlinearEstimator};
use crate::{NodeId, Vector};
use nalgebra::Isometry2;

/// What markers may be off the finger by before anything was calibrated, mm; and its base where that is sought, mm and rad.
const UNCALIBRATED_MM: f64 = 0.3;
const SOUGHT_BASE: [f64; 2] = [5.0, 0.05];
/// A measured force that is more times as large as what the markers show, or as small, against the other views, is none of its image: of a finger
/// that is not calibrated, what the markers show may be off by half.
const LARGEST_TIMES: f64 = 2.0;
/// The same for all views together, against the scene's finger, whose modulus may be a guess: beyond, a search has nowhere to begin.
const LARGEST_FACTOR: f64 = 5.0;
/// By how many of its standard deviations a force that the markers show must be off.
const SURE: f64 = 3.0;
/// A marker has another node's name if it is nearer to where the finger has that node than to its own place by this factor.
const NEARER: f64 = 0.5;

/// The force of a view as estimated from its markers alone, with the other unknowns of the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MarkerForce {
    pub own: ViewUnknowns,
    pub sigma_n: f64,
}

/// A measured force over what is shown of it otherwise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compared<'v> {
    pub view: &'v View,
    pub times: f64,
    /// Standard deviation of 1 / `times` as noise and base of the view leave it.
    pub inverse_sd: f64,
}

impl Compared<'_> {
    fn of(view: &View, of_markers: MarkerForce) -> Option<Compared<'_>> {
        let measured_n = view.force?.norm();
        Some(Compared { view, times: measured_n / of_markers.own.force_n, inverse_sd: of_markers.sigma_n / measured_n })
    }

    /// Whether noise does not explain that `times` is not another one.
    pub fn is_surely_not(&self, other: f64) -> bool {
        (1.0 / self.times - 1.0 / other).abs() > SURE * self.inverse_sd
    }
}

impl Problem<'_> {
    fn seeks_base(&self) -> bool {
        let is_of_base = |quantity| matches!(quantity, Quantity::BaseX | Quantity::BaseY | Quantity::BaseTurn);
        self.sought.iter().any(|sought| is_of_base(sought.quantity))
    }

    /// What the markers of a view show of its force if its direction is that of the measured one, by the scene's finger; `None` where it does not
    /// answer.
    pub(super) fn marker_force(&self, stated: &Candidate, view: &View) -> Option<MarkerForce> {
        // Along the line of the measured force, inwards: its sign may be wrong.
        let angle_deg = self.finger.angle_deg(view.force?);
        let outwards_deg: f64 = if angle_deg.abs() > 90.0 { 180.0 } else { 0.0 };
        let direction = Direction::Angle(angle_deg - outwards_deg.copysign(angle_deg));
        let questions = [ContactQuestion { position: None, direction }];
        let mut estimator = NonlinearEstimator::new(&stated.mesh, &questions).ok()?.with_pad(self.model.pad);
        let [sd_mm, sd_rad] = if self.seeks_base() { SOUGHT_BASE } else { [0.0; 2] };
        let (sd_mm, sd_rad) = (view.base.sd_mm.hypot(sd_mm), view.base.sd_rad.hypot(sd_rad));
        let measurement = view.measurement.clone().with_uncertain_base(BaseUncertainty { sd_mm, sd_rad, ..view.base });
        let sensed = estimator.estimate(&measurement, Some(view.noise_mm.hypot(UNCALIBRATED_MM))).ok()?;
        let own = ViewUnknowns {
            s_mm: sensed.contacts[0].position_mm(self.finger)?,
            base: Isometry2::identity(),
            force_n: if outwards_deg > 0.0 { -sensed.forces.forces_n[0] } else { sensed.forces.forces_n[0] },
            further_lean_deg: 0.0,
        };
        Some(MarkerForce { own, sigma_n: sensed.forces.sigmas_n[0] })
    }

    /// Compares measured forces with what markers show, `marker_forces` one a view.
    ///
    /// # Errors
    /// [`CalibrationError::ForceScale`] where they are off alike, and [`ViewError::Force`] for the view that is further off than the others.
    pub(super) fn check_forces(&self, marker_forces: &[Option<MarkerForce>]) -> Result<(), CalibrationError> {
        let of_view = |(view, of_markers): (_, &Option<MarkerForce>)| Compared::of(view, (*of_markers)?);
        let all: Vec<Compared> = self.views.iter().zip(marker_forces).filter_map(of_view).collect();
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

    /// A marker of a view that is where the finger has another node, wherever its base is.
    pub(super) fn wrong_name(&self, stated: &Candidate, view: &View, own: &ViewUnknowns) -> Option<ViewError> {
        let pressed = self.pressed(stated, view, own)?;
        // Where each was seen, and where the finger has it.
        let places: Vec<(NodeId, Vector, Vector)> = self
            .residuals(stated, view, own, &pressed)
            .map(|(marker, left)| {
                let seen = self.finger.marker_position(marker.node) + marker.displacement;
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
}
