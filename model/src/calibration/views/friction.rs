//! Friction, from forces that were measured.

use crate::calibration::CalibrationError;
use crate::sensing::{Lean, Normal};

/// Build-up forces that are tried, over three powers of ten: 0.7 % from one to the next.
const BUILD_UPS: usize = 1000;

/// How forces that were measured lean, as friction would have it: the coefficient and, if it is sought, the force over which it builds up, for
/// which leans are met best; the standard deviation is that of what is left. `leans` has force, N, and lean, degrees, of each view.
///
/// # Errors
/// [`CalibrationError::TooFewViews`] where there are no more views than unknowns.
pub fn friction_of(leans: &[(f64, f64)], from: Normal, builds_up: bool) -> Result<Lean, CalibrationError> {
    let unknowns = 1 + usize::from(builds_up);
    if leans.len() <= unknowns {
        return Err(CalibrationError::TooFewViews { views: leans.len(), unknowns });
    }
    let with = |build_up_n: f64| {
        let unit = Lean { angle_deg: 1.0, build_up_n, from, ..Lean::NONE };
        let shares = || leans.iter().map(|(force_n, lean_deg)| (unit.mean_deg(*force_n), lean_deg));
        let angle_deg = shares().map(|(share, lean)| share * lean).sum::<f64>()
            / shares().map(|(share, _)| share * share).sum::<f64>();
        let squares: f64 = shares().map(|(share, lean)| (lean - angle_deg * share).powi(2)).sum();
        let sd_deg = (squares / (leans.len() - unknowns) as f64).sqrt();
        Lean { angle_deg, sd_deg, ..unit }
    };
    if !builds_up {
        return Ok(with(0.0));
    }
    let largest_n = leans.iter().fold(0.0_f64, |m, (force_n, _)| m.max(force_n.abs()));
    // From at once to hardly: the sum of squares is smooth in between.
    let tried = |i: usize| with(largest_n * 10f64.powf(-2.0 + 3.0 * i as f64 / BUILD_UPS as f64));
    let best = (0..=BUILD_UPS).map(tried).chain([with(0.0)]).min_by(|a, b| a.sd_deg.total_cmp(&b.sd_deg));
    best.ok_or(CalibrationError::NoMinimum)
}
