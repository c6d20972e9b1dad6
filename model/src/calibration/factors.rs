//! Several moduli at once: the general one and those of zones, with their covariance and identifiability tests.

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
pub enum Unknown {
    /// One factor on all moduli of the finger.
    Modulus,
    /// One factor on the modulus factors of some zones, counted from 0 in the order of the finger's description. The
    /// compliance of a clamp is that of a zone at the base: a clamp of rotational stiffness k (N mm/rad) gives way as a
    /// first member of length l whose factor is f does beyond its own bending, l (1/f - 1) / (E I) = 1 / k.
    Zones(Vec<usize>),
}

/// As parameters are called in results: `modulus_factor`, `zone_3_modulus_factor`, `zone_1+2_modulus_factor`.
impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unknown::Modulus => f.write_str("modulus_factor"),
            Unknown::Zones(zones) => {
                let numbers: Vec<_> = zones.iter().map(|zone| (zone + 1).to_string()).collect();
                write!(f, "zone_{}_modulus_factor", numbers.join("+"))
            }
        }
    }
}

/// How the finger of a calibration is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorModel {
    /// Linear or co-rotational.
    pub kinematics: Kinematics,
    /// Elements a member; the linear finger is exact with one.
    pub elements: usize,
    /// Standard deviation of one measured coordinate, mm; estimated from the residual if unknown.
    pub noise_mm: Option<f64>,
}

/// Factors that were found, in the order of the unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorEstimate {
    /// The finger with the factors applied.
    pub finger: Finger,
    /// The unknowns.
    pub unknowns: Vec<Unknown>,
    /// Factor of each on what the description said.
    pub factors: Vec<f64>,
    /// Standard deviation of each factor over the factor, that is of its logarithm.
    pub relative_sigmas: Vec<f64>,
    /// Correlation of the factors, symmetric with ones on the diagonal.
    pub correlation: DMatrix<f64>,
    /// Standard deviation of one coordinate that the sigmas rest on, mm.
    pub noise_mm: f64,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// Distance between measured and computed node of each marker, by case, mm.
    pub distances_mm: Vec<f64>,
    /// Gauss-Newton steps taken.
    pub iterations: usize,
}

impl FactorEstimate {
    /// Whether a factor of another estimate of the same unknowns is more than a standard deviation of this one away.
    pub fn differs_from(&self, other: &FactorEstimate) -> bool {
        let pairs = self.factors.iter().zip(&other.factors).zip(&self.relative_sigmas);
        pairs.into_iter().any(|((own, other), sigma)| (other / own).ln().abs() > *sigma)
    }

    /// Pairs of unknowns (by index) that the data hardly distinguish, with their correlation: one may rise while the other falls or rises with it.
    pub fn entangled(&self) -> Vec<(usize, usize, f64)> {
        let pairs = (0..self.factors.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let correlated = pairs.map(|(i, j)| (i, j, self.correlation[(i, j)]));
        correlated.filter(|(_, _, correlation)| correlation.abs() >= ENTANGLED).collect()
    }
}

/// From here on correlated factors are named: what one gains from knowing the other is a factor of three in sigma.
const ENTANGLED: f64 = 0.95;
/// Singular values of the scaled sensitivities that span more leave no unique answer: sensitivities are good to nine
/// digits, so what lies further below is rounding. Independent zones of the paper's finger span less than 1e4.
const LARGEST_SPAN: f64 = 1e7;
/// A factor whose logarithm has this standard deviation or more is not identifiable: 1 is a factor of e either way.
const LARGEST_RELATIVE_SIGMA: f64 = 1.0;
/// Unknowns that change by more than this share of the one that changes most, where the data see no change, are named.
const NAMED_SHARE: f64 = 0.2;
/// The search ends when a step would change no factor by more than this share; the next would change it by the square of that.
const SMALLEST_STEP: f64 = 1e-10;

/// Factors on moduli for which the sum of squared distances between measured and computed nodes is smallest.
///
/// Each `unknown` is a factor on what the finger's description says, which is also where the search starts. Logarithms are
/// sought, so that factors stay positive. One group that holds all of the finger and [`Unknown::Modulus`] are the same:
/// that is refused, and so is all else that is not identifiable.
///
/// # Reference
/// Eq. (11) of Xu et al. (2021) for several unknowns, with squares in place of distances, by [`LevenbergMarquardt`]. In
/// equilibrium r(u, p) = 0, so du/dp = -K^-1 dr/dp with the tangent stiffness K; the forces of a member are proportional to
/// its modulus, so dr/dp is their sum, each by the share of its compliance that the zone has
/// ([`Mesh::zone_shares`](crate::Mesh::zone_shares)). Covariance of the logarithms: s^2 (J^T W^2 J)^-1.
///
/// # Errors
/// [`CalibrationError`] when the finger cannot be solved at the start, or the factors are not identifiable.
pub fn factors(
    finger: &Finger,
    cases: &[CalibrationCase],
    unknowns: &[Unknown],
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
    // The singular values made sure that there is an inverse.
    let per_noise =
        fit.covariance().ok_or_else(|| CalibrationError::NotIdentifiable { parameters: names(unknowns) })?;
    let sigmas: Vec<f64> = (0..count).map(|k| per_noise[(k, k)].sqrt()).collect();
    let correlation = DMatrix::from_fn(count, count, |i, j| per_noise[(i, j)] / (sigmas[i] * sigmas[j]));
    let relative_sigmas: Vec<f64> = sigmas.iter().map(|sigma| sigma * noise_mm).collect();
    // What is not a number is not identifiable either.
    let identifiable = |k: usize| relative_sigmas[k] < LARGEST_RELATIVE_SIGMA;
    let unidentifiable: Vec<_> = (0..count).filter(|&k| !identifiable(k)).collect();
    if !unidentifiable.is_empty() {
        let parameters = names(unidentifiable.iter().map(|&k| &unknowns[k]));
        return Err(CalibrationError::NotIdentifiable { parameters });
    }
    Ok(FactorEstimate {
        finger: with_factors(finger, unknowns, fit.point.as_slice())?,
        unknowns: unknowns.to_vec(),
        factors: fit.point.iter().map(|log| log.exp()).collect(),
        relative_sigmas,
        correlation,
        noise_mm,
        residual_rms_mm: (fit.squares / coordinates as f64).sqrt(),
        distances_mm: distances_of(cases, &fit.residual),
        iterations: fit.iterations,
    })
}

/// Distance between measured and computed node of each marker of a finger as it is, by case, mm.
///
/// # Errors
/// [`CalibrationError`] when the finger cannot be solved.
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

/// Refuses what is not identifiable: an unknown that moves no marker, or several of which only a combination shows.
fn require_separable(jacobian: &DMatrix<f64>, unknowns: &[Unknown]) -> Result<(), CalibrationError> {
    let scales: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    let largest = scales.iter().copied().fold(0.0, f64::max);
    // A part at which no load pulls shows rounding at most.
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

fn names<'u>(unknowns: impl IntoIterator<Item = &'u Unknown>) -> String {
    unknowns.into_iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
