//! Uncertainty of a force due to an uncertain lean (angle between force and normal), beyond the linearisation at the estimate.
//!
//! Markers that barely constrain the direction of a force let the direction trade off against contact position and magnitude. The uncertainty of a
//! force due to an uncertain lean grows with the lean. The linearisation at the estimate may show only half of the uncertainty that an uncertain lean
//! causes.

use super::estimate::{FoundLean, NonlinearEstimate};
use super::linearised::Seen;
use super::minima::minimum_near;
use super::problem::{ForceProblem, State};
use super::search_history::SearchHistory;
use super::states::carry_over;
use crate::sensing::{ContactQuestion, Direction, Lean, SensingError};

/// Distance, in standard deviations, of two leans (angles between force and normal) on either side of the estimated lean. Forces are evaluated at the
/// two leans that lie this distance from the estimate. The distance sqrt(3) gives the outer points of three-point Gauss-Hermite quadrature, and also
/// the ends of a uniform distribution.
const REACH: f64 = 1.732_050_807_568_877_2;
/// An uncertain lean (angle between force and normal) needs evaluation only if it contributes more than this share of a force's standard deviation.
const COUNTS: f64 = 0.3;

/// Widens the standard deviations of forces for each uncertain lean (angle between force and normal). The forces at both ends of the lean's range
/// may imply a larger deviation than the linearisation at the estimate. The larger deviation is then used.
///
/// # Errors
/// [`SensingError::Undetermined`] if the search fails at both ends of the lean's range.
pub(super) fn widen_by_leans(
    problem: &ForceProblem,
    state: &State,
    seen: Seen,
    estimate: &mut NonlinearEstimate,
) -> Result<(), SensingError> {
    for found in std::mem::take(&mut estimate.leans) {
        let linear_n = |j: usize| found.by_lean_n[j] * found.sd_deg;
        let counts = |(j, sigma_n): (usize, &f64)| linear_n(j).abs() > COUNTS * sigma_n;
        if !estimate.forces.sigmas_n.iter().enumerate().any(counts) {
            continue;
        }
        // If the search fails at one end of the lean's range, only the other end counts.
        let ends = [-REACH, REACH].map(|reach| leaning_at(problem, state, &found, reach * found.sd_deg, seen).ok());
        let answered = ends.iter().flatten().count();
        if answered == 0 {
            let (contact, sigma) = (found.contact + 1, found.sd_deg);
            return Err(SensingError::Undetermined { what: "the direction", contact, sigma, unit: "deg" });
        }
        for j in 0..state.forces_n.len() {
            let off_n2 = |end: &Vec<f64>| ((end[j] - state.forces_n[j]) / REACH).powi(2);
            let mean_n2 = ends.iter().flatten().map(off_n2).sum::<f64>() / answered as f64;
            let second_order_n2 = if j == found.contact { found.second_order_n2 } else { 0.0 };
            let more_n2 = (mean_n2 - linear_n(j).powi(2) - second_order_n2).max(0.0);
            estimate.forces.add_variance(j, more_n2);
        }
    }
    Ok(())
}

/// Forces, N, that explain the measurement best if `more_deg`, in degrees, is added to the lean `found`.
///
/// # Errors
/// [`SensingError`] if the search finds no forces for the changed lean.
fn leaning_at(
    problem: &ForceProblem,
    state: &State,
    found: &FoundLean,
    more_deg: f64,
    seen: Seen,
) -> Result<Vec<f64>, SensingError> {
    let mut questions: Vec<ContactQuestion> = problem.questions.clone();
    let mut state = state.clone();
    if let Direction::Leaning(lean) = &mut questions[found.contact].direction {
        *lean = Lean { angle_deg: found.lean_deg + more_deg, sd_deg: 0.0, build_up_n: 0.0, ..*lean };
        state.nuisances.further_leans_deg[found.contact] = 0.0;
    }
    let mut problem = problem.with_questions(&questions)?;
    problem.expect(seen)?;
    let start = carry_over(&mut problem, state, seen)?;
    // The history is empty, so the search cannot end because it meets the path of an earlier search.
    let found = minimum_near(&mut problem, start, seen, &mut SearchHistory::default())?;
    Ok(found.ok_or(SensingError::NoContact)?.state.forces_n)
}
