//! Estimates factors on moduli robustly: markers with a wrong node number get little weight, and the residual is tested against the stated noise.

use super::factors::{distances_mm, require_identified};
use super::{
    CalibrationCase, CalibrationError, FactorEstimate, FactorModel, UnknownFactor, factors, median, youngs_modulus,
};
use crate::finger::{Finger, NodeId};
use crate::measurement::Marker;
use crate::sensing::{ResidualTest, noise_of};
use crate::statics::StaticsError;

/// A marker is down-weighted if its distance from the computed position exceeds this many standard deviations of a coordinate (Huber). Normal noise
/// exceeds this limit for one marker in ninety. With normal noise, down-weighting raises the standard deviation of the modulus factor by less than 1
/// %.
const FORGIVEN: f64 = 3.0;
/// A marker is reported as an outlier if its distance from the computed position exceeds both `OUTLYING` standard deviations and `OUTLYING_SHARE` of
/// the root mean square displacement. Normal noise exceeds five standard deviations for one marker in 270 000.
const OUTLYING: f64 = 5.0;
const OUTLYING_SHARE: f64 = 0.1;
/// Median length of normal noise vectors in a plane, in standard deviations of one coordinate: sqrt(2 ln 2).
const MEDIAN_DISTANCE: f64 = 1.177_410_022_515_474_7;
/// Reweighting ends when each factor changes by less than this share of its standard deviation, usually after two or three rounds. A relative change
/// below `ROUNDING` is a rounding error: shapes have about nine correct digits.
const SETTLED: f64 = 1e-2;
const ROUNDING: f64 = 1e-9;
const MOST_ROUNDS: usize = 20;
/// With the linear finger's factor, the finger may have no equilibrium under the loads. The modulus is then doubled, at most this number of times.
const MOST_DOUBLINGS: i32 = 6;

/// Robust estimate of factors on moduli.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustFactors {
    /// The factors. Their standard deviations include the error of the mesh, and follow from the residual if it contradicts the stated noise. The
    /// correlation matrix covers noise alone.
    pub estimate: FactorEstimate,
    /// Test of the residual against the stated noise, if the measurement contradicts this noise. The standard deviations then follow from the residual.
    pub contradiction: Option<ResidualTest>,
    /// Down-weighted markers that are far from their computed positions.
    pub outliers: Vec<OutlyingMarker>,
}

/// A marker far from its computed position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlyingMarker {
    /// Index of the marker's case, from 0.
    pub case: usize,
    /// Node of the marker.
    pub node: NodeId,
    /// Distance between measured and computed position, mm.
    pub distance_mm: f64,
}

/// Factors on moduli that minimise the sum of squared distances between measured and computed positions of the nodes. Distant markers are
/// down-weighted.
///
/// If the noise of `model` is not stated or contradicts the residual, the standard deviations follow from the residual.
///
/// # Reference
/// [`factors`] with weighted squares of distances. If [`UnknownFactor::Modulus`] is sought, the search starts from the factor of the linear finger
/// ([`youngs_modulus`]); weights are updated until the factors settle (Huber and Ronchetti, Robust Statistics, 2nd ed., sec. 7.8).
///
/// # Errors
/// [`CalibrationError`] if the statics fail at every tried modulus, or the factors are not identifiable.
pub fn robust_factors(
    finger: &Finger,
    cases: &[CalibrationCase],
    unknowns: &[UnknownFactor],
    model: &FactorModel,
) -> Result<RobustFactors, CalibrationError> {
    let unscaled = FactorModel { noise_mm: None, ..*model };
    let general = unknowns.iter().position(|unknown| *unknown == UnknownFactor::Modulus);
    let Some(general) = general else {
        let (estimate, weighed) = forgiving(finger, cases, unknowns, &unscaled)?;
        return tested(estimate, cases, &weighed, model);
    };
    let mut start = youngs_modulus(finger, cases)?.factor;
    if !start.is_finite() {
        return Err(CalibrationError::NotIdentifiable { parameters: UnknownFactor::Modulus.to_string() });
    }
    // With the linear finger's modulus, the co-rotational finger may have no equilibrium under the loads.
    let found = (0..=MOST_DOUBLINGS).find_map(|_| {
        let found = finger.with_modulus_factor(start).map_err(CalibrationError::from);
        match found.and_then(|finger| forgiving(&finger, cases, unknowns, &unscaled)) {
            Err(CalibrationError::Statics(StaticsError::NoEquilibrium { .. })) => {
                start *= 2.0;
                None
            }
            found => Some(found),
        }
    });
    let (mut estimate, weighed) = found.unwrap_or(Err(CalibrationError::NoMinimum))?;
    estimate.factors[general] *= start;
    tested(estimate, cases, &weighed, model)
}

/// Tests the residual of an estimate against the noise of `model`, widens the standard deviations by the misfit and by the error of the mesh, and
/// lists the outlying markers. `weighed` are the cases with the last weights of their markers.
fn tested(
    mut estimate: FactorEstimate,
    cases: &[CalibrationCase],
    weighed: &[CalibrationCase],
    model: &FactorModel,
) -> Result<RobustFactors, CalibrationError> {
    let coordinates: usize = cases.iter().map(|case| case.measurement.coordinate_count()).sum();
    let degrees_of_freedom = coordinates - estimate.unknowns.len();
    let squares_mm2 = estimate.residual_rms_mm.powi(2) * coordinates as f64;
    let test = ResidualTest::new(model.noise_mm, squares_mm2, degrees_of_freedom);
    let trusted_mm = noise_of(test, model.noise_mm, squares_mm2, degrees_of_freedom);
    // A perfect fit has zero noise and zero standard deviations.
    let wider = if estimate.noise_mm > 0.0 { trusted_mm / estimate.noise_mm } else { 1.0 };
    // The change of the factors with half as many elements is an upper bound of the mesh error.
    let coarse = FactorModel { elements: model.elements.div_ceil(2), noise_mm: None, ..*model };
    let on_coarse = factors(&estimate.finger, weighed, &estimate.unknowns, &coarse)?.factors;
    for (sigma, change) in estimate.relative_sigmas.iter_mut().zip(on_coarse) {
        *sigma = (*sigma * wider).hypot(change - 1.0);
    }
    estimate.noise_mm = trusted_mm;
    require_identified(&estimate.relative_sigmas, &estimate.unknowns)?;
    let outliers = outliers(cases, &estimate.distances_mm);
    Ok(RobustFactors { estimate, contradiction: test.filter(ResidualTest::contradicts), outliers })
}

/// Least-squares factors relative to `finger`, and the cases with the last weights of their markers. Markers far from their computed positions are
/// down-weighted. The weights are updated until the factors settle. The first weights follow from the distances between measured and computed
/// positions for the unchanged finger.
fn forgiving(
    finger: &Finger,
    cases: &[CalibrationCase],
    unknowns: &[UnknownFactor],
    model: &FactorModel,
) -> Result<(FactorEstimate, Vec<CalibrationCase>), CalibrationError> {
    let mut weighed = weighed_by(cases, &distances_mm(finger, cases, model)?);
    let mut estimate = factors(finger, &weighed, unknowns, model)?;
    for _ in 0..MOST_ROUNDS {
        weighed = weighed_by(cases, &estimate.distances_mm);
        // Each search starts from the last estimate, so its factors are changes.
        let mut next = factors(&estimate.finger, &weighed, unknowns, model)?;
        let has_settled = |(change, sigma): (&f64, &f64)| change.ln().abs() <= (SETTLED * sigma).max(ROUNDING);
        let have_settled = next.factors.iter().zip(&next.relative_sigmas).all(has_settled);
        next.factors.iter_mut().zip(&estimate.factors).for_each(|(factor, before)| *factor *= before);
        estimate = next;
        if have_settled {
            break;
        }
    }
    Ok((estimate, weighed))
}

/// The cases with the weights of markers at the given distances from their computed positions, mm.
fn weighed_by(cases: &[CalibrationCase], distances_mm: &[f64]) -> Vec<CalibrationCase> {
    let near_mm = (FORGIVEN * scatter_mm(distances_mm)).max(f64::MIN_POSITIVE);
    let mut distances_mm = distances_mm.iter();
    let weighed = |case: &CalibrationCase| {
        let measurement = case.measurement.clone().with_markers(|marker| {
            marker.weight *= distances_mm.next().map_or(1.0, |distance_mm| (near_mm / distance_mm).min(1.0));
        });
        CalibrationCase { measurement, ..case.clone() }
    };
    cases.iter().map(weighed).collect()
}

/// Robust standard deviation of a coordinate, mm, from the median distance.
fn scatter_mm(distances_mm: &[f64]) -> f64 {
    median(distances_mm.iter().copied()).unwrap_or_default() / MEDIAN_DISTANCE
}

fn outliers(cases: &[CalibrationCase], distances_mm: &[f64]) -> Vec<OutlyingMarker> {
    let markers = cases
        .iter()
        .enumerate()
        .flat_map(|(case, of)| of.measurement.markers().iter().map(move |marker| (case, marker)));
    let squares_mm2: f64 = markers.clone().map(|(_, marker)| marker.displacement.norm_squared()).sum();
    let moved_mm = (squares_mm2 / distances_mm.len() as f64).sqrt();
    let far_mm = f64::max(OUTLYING * scatter_mm(distances_mm), OUTLYING_SHARE * moved_mm);
    let outlying = |((case, marker), &distance_mm): ((usize, &Marker), &f64)| OutlyingMarker {
        case,
        node: marker.node,
        distance_mm,
    };
    markers.zip(distances_mm).filter(|(_, distance_mm)| **distance_mm > far_mm).map(outlying).collect()
}
