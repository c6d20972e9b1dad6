//! Where the search begins.

use super::problem::{Candidate, Own, Point, Problem};
use super::{FIRST_MODEL_ERROR_MM, View};
use crate::Vector;
use crate::calibration::CalibrationError;
use crate::finger::Plate;
use crate::sensing::{ContactQuestion, Direction, Lean, NonlinearEstimator};
use nalgebra::Isometry2;

/// Parts of the plate at whose ends a contact is sought at first.
const PLACES: usize = 50;

impl Problem<'_> {
    /// Where the search begins: every view as the scene's finger explains it best.
    pub(super) fn start(&self) -> Result<Point, CalibrationError> {
        let shared = vec![0.0; self.sought.len()];
        let stated = self.candidate(&shared).ok_or(CalibrationError::NoMinimum)?;
        let own = self.views.iter().map(|view| match view.force {
            Some(force) => self.start_of_known(&stated, view, force.norm()),
            None => self.start_of_unknown(&stated, view),
        });
        Ok(Point { shared, own: own.collect::<Result<_, _>>()? })
    }

    /// The place along the plate where a measured force bends the finger most like what is seen, wherever the base is.
    fn start_of_known(&self, stated: &Candidate, view: &View, force_n: f64) -> Result<Own, CalibrationError> {
        let length_mm = self.finger.plate_length_mm(Plate::Front);
        let at = |i: usize| Own {
            s_mm: length_mm * i as f64 / PLACES as f64,
            base: Isometry2::identity(),
            force_n,
            further_lean_deg: 0.0,
        };
        let misfit = |own: &Own| {
            let pressed = self.pressed(stated, view, own)?;
            Some(misfit_of_shape(
                self.residuals(stated, view, own, &pressed)
                    .map(|(marker, left)| (self.finger.marker_position(marker.node) + marker.displacement, left)),
            ))
        };
        let tried = (1..PLACES).map(at).filter_map(|own| misfit(&own).map(|misfit| (misfit, own)));
        let best = tried.min_by(|(a, _), (b, _)| a.total_cmp(b));
        best.map(|(_, own)| own).ok_or(CalibrationError::NotCarried { force_n })
    }

    /// Force and place as they are sensed.
    fn start_of_unknown(&self, stated: &Candidate, view: &View) -> Result<Own, CalibrationError> {
        let direction = Direction::Leaning(Lean { sd_deg: 0.0, ..self.model.lean });
        let questions = [ContactQuestion { position: None, direction }];
        let mut estimator = NonlinearEstimator::new(&stated.mesh, &questions)?.with_pad(self.model.pad);
        let measurement = view.measurement.clone().with_uncertain_base(view.base);
        let sensed = estimator.estimate(&measurement, Some(view.noise_mm.hypot(FIRST_MODEL_ERROR_MM)))?;
        Ok(Own {
            s_mm: sensed.contacts[0].position_mm(self.finger).unwrap_or_default(),
            base: Isometry2::identity(),
            force_n: sensed.forces.forces_n[0],
            further_lean_deg: 0.0,
        })
    }
}

/// What is left of residuals at points, mm^2, once the whole shape has moved to where they are least.
fn misfit_of_shape(residuals: impl Iterator<Item = (Vector, Vector)>) -> f64 {
    let all: Vec<(Vector, Vector)> = residuals.collect();
    let count = all.len().max(1) as f64;
    let [middle, shift] =
        all.iter().fold([Vector::zeros(); 2], |[p, r], (point, left)| [p + point / count, r + left / count]);
    let (mut squares, mut turned, mut arms) = (0.0, 0.0, 0.0);
    for (point, left) in &all {
        let (arm, left) = (point - middle, left - shift);
        squares += left.norm_squared();
        turned += arm.perp(&left);
        arms += arm.norm_squared();
    }
    squares - turned * turned / arms.max(f64::MIN_POSITIVE)
}
