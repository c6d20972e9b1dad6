//! Estimates the compliance of the base from views with measured forces.

use crate::calibration::CalibrationError;

/// Rotation of the clamped base per newton of measured force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseCompliance {
    /// Rotation, positive from x to y, degrees per newton.
    pub deg_per_n: f64,
    /// Standard deviation, degrees per newton. Infinite for two views, which leave no residual.
    pub sigma_deg_per_n: f64,
}

/// Fits the rotation of the base as a linear function of the force, by least squares. `turns` lists the force, N, and the rotation, degrees, of each
/// view. All views must show the same mounting of the finger.
///
/// # Errors
/// [`CalibrationError::TooFewViews`] for fewer than two views, [`CalibrationError::NotIdentifiable`] if all forces are equal.
pub fn compliance_of(turns: &[(f64, f64)]) -> Result<BaseCompliance, CalibrationError> {
    const UNKNOWNS: usize = 2;
    let views = turns.len();
    let count = views as f64;
    let [mean_n, mean_deg] = turns.iter().fold([0.0; 2], |[n, deg], turn| [n + turn.0 / count, deg + turn.1 / count]);
    let spread_n2: f64 = turns.iter().map(|(force_n, _)| (force_n - mean_n).powi(2)).sum();
    if views < UNKNOWNS {
        return Err(CalibrationError::TooFewViews { views, unknowns: UNKNOWNS });
    }
    // All forces are equal except for rounding.
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
