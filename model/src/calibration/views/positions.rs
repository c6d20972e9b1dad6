//! Distribution of a force whose position along the plate is uncertain.
//!
//! A force near the base bends the finger like a smaller force farther from the base. If the position's uncertainty is a large share of its distance
//! from an end of the plate, the force is a strongly nonlinear function of the position. If the position is very uncertain, a linearised standard
//! deviation of the force is too small.

/// Step between the positions of a scan, in standard deviations of the position.
const STEP_SDS: f64 = 0.75;
/// Largest step of a scan, as a share of the plate's length, and largest number of steps on either side of the best position.
const LARGEST_STEP: f64 = 0.1;
const MOST_STEPS: usize = 12;
/// A scan ends at a position at which the sum of squared residuals exceeds the smallest sum by this value. For a linear finger, a scan therefore ends
/// three standard deviations from the best position.
const BEYOND: f64 = 9.0;
/// The markers do not bound the position if the sum of squared residuals grows by less than this value up to an end of the plate. For a linear
/// finger, the sum of squared residuals grows by this value over one standard deviation of the position.
const BOUNDED: f64 = 1.0;

/// Estimate of a force at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ForceAt {
    /// Position along the front plate, mm.
    pub s_mm: f64,
    /// Force, N.
    pub force_n: f64,
    /// Standard deviation of the force, N.
    pub sigma_n: f64,
    /// Sum of squared residuals divided by their variances, dimensionless.
    pub squares: f64,
}

/// Posterior distribution of a force and of its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    /// Standard deviation of the force about its best estimate, N.
    pub sigma_n: f64,
    /// Standard deviation of the position about its best estimate, mm.
    pub position_sd_mm: f64,
    /// Whether the markers bound the position within the plate.
    pub is_bounded: bool,
}

/// Scans the positions on both sides of the best position. `at` estimates the force at a known position, mm. Each search of `at` starts from the
/// result at a nearby position. `wider` is the factor by which the residual exceeds the noise.
///
/// # Reference
/// The force has a mixture of normal distributions, weighted by the profile likelihood (Bates and Watts, Nonlinear Regression Analysis and Its
/// Applications, ch. 6).
pub(super) fn scan<N>(
    best: (ForceAt, &N),
    position_sd_mm: f64,
    (length_mm, [least_mm, most_mm]): (f64, [f64; 2]),
    wider: f64,
    at: impl Fn(f64, &N) -> Option<(ForceAt, N)>,
) -> Spread {
    let (found, near) = best;
    let step_mm = (STEP_SDS * position_sd_mm).min(LARGEST_STEP * length_mm);
    let growth = |other: &ForceAt| (other.squares - found.squares) / (wider * wider);
    // Sum of the weights, and weighted sums of the squared deviations of force and position.
    let (mut weights, mut of_force_n2, mut of_position_mm2) = (0.0, 0.0, 0.0);
    let mut count = |other: &ForceAt, sigma_n: f64| {
        let weight = (-0.5 * growth(other)).exp();
        weights += weight;
        of_force_n2 += weight * ((other.force_n - found.force_n).powi(2) + sigma_n.powi(2));
        of_position_mm2 += weight * (other.s_mm - found.s_mm).powi(2);
    };
    let mut is_bounded = true;
    let mut own_sigma_n: Option<f64> = None;
    for step_mm in [-step_mm, step_mm] {
        let mut last: Option<(ForceAt, N)> = None;
        for number in 1..=MOST_STEPS {
            let s_mm = found.s_mm + number as f64 * step_mm;
            let (from, near) = last.as_ref().map_or((&found, near), |(from, near)| (from, near));
            if !(least_mm..=most_mm).contains(&s_mm) {
                is_bounded &= growth(from) > BOUNDED;
                break;
            }
            let Some(next) = at(s_mm, near) else { break };
            own_sigma_n = own_sigma_n.or(Some(next.0.sigma_n));
            count(&next.0, next.0.sigma_n);
            if growth(&next.0) > BEYOND {
                break;
            }
            last = Some(next);
        }
    }
    // The standard deviation of the force for a known position hardly differs between the best position and a neighbouring position.
    count(&found, own_sigma_n.unwrap_or(found.sigma_n));
    Spread { sigma_n: (of_force_n2 / weights).sqrt(), position_sd_mm: (of_position_mm2 / weights).sqrt(), is_bounded }
}
