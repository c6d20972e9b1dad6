//! How a base gives way, from views under measured forces.

use crate::calibration::CalibrationError;

/// By how much a force turns the base that the finger is clamped to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseCompliance {
    /// Turn from x to y, degrees a newton.
    pub deg_per_n: f64,
    /// Its standard deviation; of two views not known, and infinite.
    pub sigma_deg_per_n: f64,
}

/// The straight line through the turns of a base over the forces of some views: least squares, with the turn without force as the other unknown.
/// `turns` has force, N, and turn, degrees, of each; all of one mounting.
///
/// # Errors
/// [`CalibrationError::TooFewViews`] for fewer than two views, [`CalibrationError::NotIdentifiable`] for forces that are all alike.
pub fn compliance_of(turns: &[(f64, f64)]) -> Result<BaseCompliance, CalibrationError> {
    const UNKNOWNS: usize = 2;
    let views = turns.len();
    let count = views as f64;
    let [mean_n, mean_deg] = turns.iter().fold([0.0; 2], |[n, deg], turn| [n + turn.0 / count, deg + turn.1 / count]);
    let spread_n2: f64 = turns.iter().map(|(force_n, _)| (force_n - mean_n).powi(2)).sum();
    if views < UNKNOWNS {
        return Err(CalibrationError::TooFewViews { views, unknowns: UNKNOWNS });
    }
    // Forces that are all alike, but for rounding.
    if spread_n2 <= (f64::EPSILON * mean_n).powi(2) * count {
        return Err(CalibrationError::NotIdentifiable { parameters: "base_deg_per_n".to_owned() });
    }
    let products: f64 = turns.iter().map(|(force_n, turn_deg)| (force_n - mean_n) * (turn_deg - mean_deg)).sum();
    let deg_per_n = products / spread_n2;
    let off = |(force_n, turn_deg): &(f64, f64)| turn_deg - mean_deg - deg_per_n * (force_n - mean_n);
    let squares: f64 = turns.iter().map(|turn| off(turn).powi(2)).sum();
    let variance = if views > UNKNOWNS { squares / (views - UNKNOWNS) as f64 } else { f64::INFINITY };
    Ok(BaseCompliance { deg_per_n, sigma_deg_per_n: (variance / spread_n2).sqrt() })
}
