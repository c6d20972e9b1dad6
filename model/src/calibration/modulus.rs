//! Estimates one modulus of the co-rotational finger. The method is robust to markers with a wrong node number.

use super::factors::distances_mm;
use super::{CalibrationCase, CalibrationError, FactorEstimate, FactorModel, Unknown, factors, median, youngs_modulus};
use crate::Kinematics;
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
/// Reweighting ends when the factor changes by less than this share of its standard deviation, usually after two or three rounds.
const SETTLED: f64 = 1e-2;
const MOST_ROUNDS: usize = 20;
/// With the linear finger's factor, the finger may have no equilibrium under the loads. The modulus is then doubled, at most this number of times.
const MOST_DOUBLINGS: i32 = 6;

/// Modulus of the finger as a factor on the scene's modulus.
#[derive(Debug, Clone, PartialEq)]
pub struct ModulusEstimate {
    /// Factor on all moduli of the finger, dimensionless.
    pub factor: f64,
    /// Standard deviation of the factor, dimensionless, including the error of the mesh.
    pub sigma: f64,
    /// Mean distance between measured and computed positions of a node, mm.
    pub mean_distance_mm: f64,
    /// Test of the residual against the stated noise, if the measurement contradicts this noise. `sigma` then follows from the residual.
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

/// Young's modulus of the co-rotational finger. Finds the factor on all moduli that minimises the sum of squared distances between measured and
/// computed positions of the nodes. Distant markers are down-weighted.
///
/// `elements` is the number of beam elements per member. `noise_mm` is the standard deviation of one measured coordinate, mm. If the noise is unknown
/// or contradicts the residual, it is estimated from the residual.
///
/// # Reference
/// Eq. (11) of Xu et al. (2021) as in [`youngs_modulus`], with co-rotational equilibria and weighted squares of distances. [`factors`] starts from the linear
/// finger's factor; weights are updated until the factor settles (Huber and Ronchetti, Robust Statistics, 2nd ed., sec. 7.8).
///
/// # Errors
/// [`CalibrationError`] if the statics fail at every tried modulus, or the factor is not identifiable.
pub fn corotational_modulus(
    finger: &Finger,
    cases: &[CalibrationCase],
    elements: usize,
    noise_mm: Option<f64>,
) -> Result<ModulusEstimate, CalibrationError> {
    let linear = youngs_modulus(finger, cases)?;
    if !linear.factor.is_finite() {
        return Err(CalibrationError::NotIdentifiable { parameters: Unknown::Modulus.to_string() });
    }
    let model = FactorModel { kinematics: Kinematics::Corotational, elements, noise_mm: None };
    // With the linear finger's modulus, the co-rotational finger may have no equilibrium under the loads.
    let mut start = linear.factor;
    let found = (0..=MOST_DOUBLINGS).find_map(|_| {
        let found = finger.with_modulus_factor(start).map_err(CalibrationError::from);
        match found.and_then(|finger| forgiving(&finger, cases, &model)) {
            Err(CalibrationError::Statics(StaticsError::NoEquilibrium { .. })) => {
                start *= 2.0;
                None
            }
            found => Some(found),
        }
    });
    let (estimate, weighed) = found.unwrap_or(Err(CalibrationError::NoMinimum))?;
    // The change of the factor with half as many elements is an upper bound of the mesh error.
    let coarse = FactorModel { elements: elements.div_ceil(2), ..model };
    let mesh_error = factors(&estimate.finger, &weighed, &[Unknown::Modulus], &coarse)?.factors[0] - 1.0;
    let coordinates: usize = cases.iter().map(|case| case.measurement.coordinate_count()).sum();
    let squares_mm2 = estimate.residual_rms_mm.powi(2) * coordinates as f64;
    let test = ResidualTest::new(noise_mm, squares_mm2, coordinates - 1);
    let trusted_mm = noise_of(test, noise_mm, squares_mm2, coordinates - 1);
    // A perfect fit has zero noise and zero standard deviation.
    let wider = if estimate.noise_mm > 0.0 { trusted_mm / estimate.noise_mm } else { 1.0 };
    let factor = start * estimate.factors[0];
    Ok(ModulusEstimate {
        factor,
        sigma: factor * (estimate.relative_sigmas[0] * wider).hypot(mesh_error),
        mean_distance_mm: estimate.distances_mm.iter().sum::<f64>() / estimate.distances_mm.len() as f64,
        contradiction: test.filter(ResidualTest::contradicts),
        outliers: outliers(cases, &estimate.distances_mm),
    })
}

/// Least-squares factor on all moduli, and the cases with the last weights of their markers. Markers far from their computed positions are
/// down-weighted. The weights are updated until the factor settles. The first weights follow from the distances between measured and computed
/// positions for the unchanged finger.
fn forgiving(
    finger: &Finger,
    cases: &[CalibrationCase],
    model: &FactorModel,
) -> Result<(FactorEstimate, Vec<CalibrationCase>), CalibrationError> {
    let mut weighed = cases.to_vec();
    let mut fitted = |distances_mm: &[f64]| {
        let near_mm = (FORGIVEN * scatter_mm(distances_mm)).max(f64::MIN_POSITIVE);
        let mut distances_mm = distances_mm.iter();
        for (case, own) in weighed.iter_mut().zip(cases) {
            case.measurement = own.measurement.clone().with_markers(|marker| {
                marker.weight *= distances_mm.next().map_or(1.0, |distance_mm| (near_mm / distance_mm).min(1.0));
            });
        }
        factors(finger, &weighed, &[Unknown::Modulus], model)
    };
    let mut estimate = fitted(&distances_mm(finger, cases, model)?)?;
    for _ in 0..MOST_ROUNDS {
        let next = fitted(&estimate.distances_mm)?;
        let change = (next.factors[0] / estimate.factors[0]).ln().abs();
        estimate = next;
        if change <= SETTLED * estimate.relative_sigmas[0] {
            break;
        }
    }
    Ok((estimate, weighed))
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
