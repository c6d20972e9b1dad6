//! Estimates several moduli at once, of the whole finger and of zones, with their covariance and identifiability tests.

mod problem;

use super::{CalibrationCase, CalibrationError};
use crate::Kinematics;
use crate::finger::Finger;
use crate::optimise::{Convergence, LevenbergMarquardt, Refusal, SingularParts};
use nalgebra::{DMatrix, DVector};
use problem::{FactorProblem, with_factors};
use std::fmt;

/// An unknown of a calibration: a factor on moduli.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnknownFactor {
    /// One factor on all moduli of the finger.
    Modulus,
    /// One common factor on the modulus factors of some zones. The numbers of the zones count from 0 in the order of the finger's description. A zone
    /// at the base can represent a compliant clamp. A clamp with rotational stiffness k (N mm/rad) corresponds to a first member of length l and
    /// factor f with l (1/f - 1) / (E I) = 1 / k.
    Zones(Vec<usize>),
}

/// Names of parameters in results: `modulus_factor`, `zone_3_modulus_factor`, `zone_1+2_modulus_factor`.
impl fmt::Display for UnknownFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnknownFactor::Modulus => f.write_str("modulus_factor"),
            UnknownFactor::Zones(zones) => {
                let numbers: Vec<_> = zones.iter().map(|zone| (zone + 1).to_string()).collect();
                write!(f, "zone_{}_modulus_factor", numbers.join("+"))
            }
        }
    }
}

/// Model of the finger in a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorModel {
    /// Linear or co-rotational kinematics.
    pub kinematics: Kinematics,
    /// Beam elements per member. For the linear finger, one element per member is exact.
    pub elements: usize,
    /// Standard deviation of one measured coordinate, mm. If `noise_mm` is `None`, the noise is estimated from the residual.
    pub noise_mm: Option<f64>,
}

/// Estimated factors, in the order of the unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorEstimate {
    /// The finger with the factors applied.
    pub finger: Finger,
    /// The unknowns.
    pub unknowns: Vec<UnknownFactor>,
    /// Factor of each unknown on the scene's modulus, dimensionless.
    pub factors: Vec<f64>,
    /// Relative standard deviation of each factor, dimensionless: the standard deviation of its logarithm.
    pub relative_sigmas: Vec<f64>,
    /// Correlation matrix of the factors' logarithms, one row and column for each unknown.
    pub correlation: DMatrix<f64>,
    /// Standard deviation of one measured coordinate, mm, from which `relative_sigmas` follow.
    pub noise_mm: f64,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// Distance between measured and computed position of each marker, mm, one case after the other.
    pub distances_mm: Vec<f64>,
}

impl FactorEstimate {
    /// Whether a factor of `other` differs from this estimate's factor by more than one standard deviation. Both estimates must have the same unknowns.
    pub fn differs_from(&self, other: &FactorEstimate) -> bool {
        let pairs = self.factors.iter().zip(&other.factors).zip(&self.relative_sigmas);
        pairs.into_iter().any(|((own, other), sigma)| (other / own).ln().abs() > *sigma)
    }

    /// Pairs of unknowns (indices from 0) that the measurements barely separate, with their correlation, dimensionless.
    pub fn entangled(&self) -> Vec<(usize, usize, f64)> {
        let pairs = (0..self.factors.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let correlated = pairs.map(|(i, j)| (i, j, self.correlation[(i, j)]));
        correlated.filter(|(_, _, correlation)| correlation.abs() >= ENTANGLED).collect()
    }
}

/// A pair of unknowns is reported if its absolute correlation is at least this value. At this correlation, knowledge of one factor of a pair would
/// reduce the standard deviation of the other factor to a third.
const ENTANGLED: f64 = 0.95;
/// Factors are refused if the largest singular value of the scaled Jacobian is at least this many times the smallest. Sensitivities have nine correct
/// digits, so a singular value that is 1e7 times smaller than the largest is a rounding error. For independent zones of the paper's finger, the ratio
/// of the largest to the smallest singular value is below 1e4.
const LARGEST_SPAN: f64 = 1e7;
/// A factor is not identifiable if the standard deviation of its logarithm is at least this value. A value of 1 means that the factor is uncertain by
/// a factor of e in either direction.
const LARGEST_RELATIVE_SIGMA: f64 = 1.0;
/// An error message names an unknown of an inseparable combination if the unknown's change exceeds this share of the largest change in the
/// combination.
const NAMED_SHARE: f64 = 0.2;
/// The search ends when a step changes no factor by more than this share. Convergence is quadratic: the next step would change a factor by the square of this
/// share.
const SMALLEST_STEP: f64 = 1e-10;

/// Estimates factors on moduli that minimise the sum of squared distances between measured and computed positions of the nodes.
///
/// Each unknown is a factor on the scene's modulus, and the search starts at a factor of 1. The search varies the logarithms of the factors, so
/// factors stay positive. Factors that are not identifiable are refused, for example [`UnknownFactor::Modulus`] together with a group of zones that covers
/// the whole finger.
///
/// # Reference
/// Eq. (11) of Xu et al. (2021), extended to several unknowns, with squared distances in place of distances, minimised by [`LevenbergMarquardt`]. In
/// equilibrium, the residual forces r(u, p) are zero for displacements u and logarithms p of the factors. Hence du/dp = -K^-1 dr/dp with the tangent
/// stiffness K. The forces of a member are proportional to its modulus, so dr/dp is the sum of the member forces, each weighted by the zone's share
/// of the member's compliance ([`Mesh::zone_shares`](crate::Mesh::zone_shares)). The covariance of the logarithms is s^2 (J^T W^2 J)^-1, with the
/// noise s, the Jacobian J and the marker weights W.
///
/// # Errors
/// [`CalibrationError`] if the statics fail, the search does not converge, or the factors are not identifiable.
pub fn factors(
    finger: &Finger,
    cases: &[CalibrationCase],
    unknowns: &[UnknownFactor],
    model: &FactorModel,
) -> Result<FactorEstimate, CalibrationError> {
    let count = unknowns.len();
    let coordinates: usize = cases.iter().map(|case| case.measurement.coordinate_count()).sum();
    if coordinates <= count {
        return Err(CalibrationError::TooFewMarkers { unknowns: count, coordinates });
    }
    let mut problem = FactorProblem { finger, cases, unknowns, model, motions: Vec::new() };
    let start = DVector::zeros(count);
    problem.residual_at(&start)?;
    require_separable(&problem.jacobian_at(&start)?, unknowns)?;
    let convergence = Convergence { relative_decrease: 0.0, step: SMALLEST_STEP };
    let method = LevenbergMarquardt { convergence, ..LevenbergMarquardt::default() };
    let fit = method.minimise(&mut problem, start).map_err(Refusal::into_error)?;
    if !fit.has_converged() {
        return Err(CalibrationError::NoMinimum);
    }
    require_separable(&fit.jacobian, unknowns)?;
    let degrees_of_freedom = (coordinates - count) as f64;
    let noise_mm = model.noise_mm.unwrap_or((fit.squares / degrees_of_freedom).sqrt());
    // The test of the singular values has ensured that an inverse exists.
    let per_noise =
        fit.covariance().ok_or_else(|| CalibrationError::NotIdentifiable { parameters: names(unknowns) })?;
    let sigmas: Vec<f64> = (0..count).map(|k| per_noise[(k, k)].sqrt()).collect();
    let correlation = DMatrix::from_fn(count, count, |i, j| per_noise[(i, j)] / (sigmas[i] * sigmas[j]));
    let relative_sigmas: Vec<f64> = sigmas.iter().map(|sigma| sigma * noise_mm).collect();
    require_identified(&relative_sigmas, unknowns)?;
    Ok(FactorEstimate {
        finger: with_factors(finger, unknowns, fit.point.as_slice())?,
        unknowns: unknowns.to_vec(),
        factors: fit.point.iter().map(|log| log.exp()).collect(),
        relative_sigmas,
        correlation,
        noise_mm,
        residual_rms_mm: (fit.squares / coordinates as f64).sqrt(),
        distances_mm: distances_of(cases, &fit.residual),
    })
}

/// Distance between measured and computed position of each marker for an unchanged finger, mm, one case after the other.
///
/// # Errors
/// [`CalibrationError`] if the statics of the finger cannot be solved.
pub(super) fn distances_mm(
    finger: &Finger,
    cases: &[CalibrationCase],
    model: &FactorModel,
) -> Result<Vec<f64>, CalibrationError> {
    let mut problem = FactorProblem { finger, cases, unknowns: &[], model, motions: Vec::new() };
    Ok(distances_of(cases, &problem.residual_at(&DVector::zeros(0))?))
}

fn distances_of(cases: &[CalibrationCase], residual: &DVector<f64>) -> Vec<f64> {
    let markers = cases.iter().flat_map(|case| case.measurement.markers());
    markers.zip(residual.as_slice().chunks(2)).map(|(marker, at)| at[0].hypot(at[1]) / marker.weight).collect()
}

/// Refuses factors whose relative standard deviations are too large. NaN counts as too large.
pub(super) fn require_identified(relative_sigmas: &[f64], unknowns: &[UnknownFactor]) -> Result<(), CalibrationError> {
    let is_identified = |sigma: &f64| *sigma < LARGEST_RELATIVE_SIGMA;
    let unidentified: Vec<_> =
        relative_sigmas.iter().zip(unknowns).filter(|(sigma, _)| !is_identified(sigma)).map(|(_, of)| of).collect();
    if unidentified.is_empty() {
        return Ok(());
    }
    Err(CalibrationError::NotIdentifiable { parameters: names(unidentified) })
}

/// Refuses an unknown that moves no marker, and unknowns whose effects on the markers cancel in some combination.
fn require_separable(jacobian: &DMatrix<f64>, unknowns: &[UnknownFactor]) -> Result<(), CalibrationError> {
    let scales: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    let largest = scales.iter().copied().fold(0.0, f64::max);
    // An unknown that belongs to an unloaded part moves markers only by rounding errors.
    let moves = |k: usize| scales[k] > largest / LARGEST_SPAN;
    let unmoved: Vec<_> = (0..unknowns.len()).filter(|&k| !moves(k)).collect();
    if !unmoved.is_empty() {
        return Err(CalibrationError::NotIdentifiable { parameters: names(unmoved.iter().map(|&k| &unknowns[k])) });
    }
    let mut scaled = jacobian.clone();
    for (mut column, scale) in scaled.column_iter_mut().zip(&scales) {
        column.unscale_mut(*scale);
    }
    let parts = SingularParts::of(scaled);
    if parts.span() < LARGEST_SPAN {
        return Ok(());
    }
    let weakest = parts.weakest();
    let change = |k: usize| weakest[k].abs() / scales[k];
    let most = (0..unknowns.len()).map(change).fold(0.0, f64::max);
    let mixed = (0..unknowns.len()).filter(|&k| change(k) > NAMED_SHARE * most).map(|k| &unknowns[k]);
    Err(CalibrationError::NotSeparable { parameters: names(mixed) })
}

fn names<'u>(unknowns: impl IntoIterator<Item = &'u UnknownFactor>) -> String {
    unknowns.into_iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
