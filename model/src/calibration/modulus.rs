//! One modulus of the co-rotational finger, from shapes of which single markers may be another node's.

use super::factors::distances_mm;
use super::{CalibrationCase, CalibrationError, FactorEstimate, FactorModel, Unknown, factors, median, youngs_modulus};
use crate::Kinematics;
use crate::finger::{Finger, NodeId};
use crate::measurement::Marker;
use crate::sensing::{ResidualTest, noise_of};
use crate::statics::StaticsError;

/// A marker farther from the finger than this many standard deviations of a coordinate counts as if it were so far. Of normal noise one in ninety is:
/// sigma grows by less than a hundredth.
const FORGIVEN: f64 = 3.0;
/// From this many on, and from this share of the root mean square displacement, a marker is named: noise leaves one in 270 000 so far off.
const OUTLYING: f64 = 5.0;
const OUTLYING_SHARE: f64 = 0.1;
/// Median distance of normal noise in a plane, in standard deviations of a coordinate: sqrt(2 ln 2).
const MEDIAN_DISTANCE: f64 = 1.177_410_022_515_474_7;
/// Markers are weighed anew until the factor changes by less than this share of its standard deviation: two or three times.
const SETTLED: f64 = 1e-2;
const MOST_ROUNDS: usize = 20;
/// A finger that the linear one says is this many times too soft to carry the loads is not sought.
const MOST_DOUBLINGS: i32 = 6;

/// Modulus of the co-rotational finger as a factor on what its description says.
#[derive(Debug, Clone, PartialEq)]
pub struct CorotationalModulus {
    /// Factor on all moduli of the finger.
    pub factor: f64,
    /// Its standard deviation, with the error of the mesh.
    pub sigma: f64,
    /// Mean distance between measured and computed nodes, mm.
    pub mean_distance_mm: f64,
    /// The test of the stated noise, where the measurement contradicts it: `sigma` then rests on the residual.
    pub contradiction: Option<ResidualTest>,
    /// Markers far from where the finger has them, which count little.
    pub outliers: Vec<OutlyingMarker>,
}

/// A marker that is far from where the finger has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlyingMarker {
    /// Its case, from 0.
    pub case: usize,
    /// Its node.
    pub node: NodeId,
    /// How far, mm.
    pub distance_mm: f64,
}

/// Young's modulus of the co-rotational finger: the factor on all moduli for which the sum of the squared distances between measured and computed
/// nodes is smallest, where markers that are far off count less the farther they are.
///
/// `elements` a member; `noise_mm` is the standard deviation of one measured coordinate, estimated from the residual if unknown or contradicted.
///
/// # Reference
/// Eq. (11) of Xu et al. (2021), see [`youngs_modulus`], with equilibria in place of the linear finger, and least squares with weights in place of the
/// sum of distances: by [`factors`] from the linear finger's answer, reweighted until it settles (Huber and Ronchetti, Robust Statistics, 2nd ed.,
/// sec. 7.8).
///
/// # Errors
/// [`CalibrationError`] when no factor follows from the measurements.
pub fn corotational_modulus(
    finger: &Finger,
    cases: &[CalibrationCase],
    elements: usize,
    noise_mm: Option<f64>,
) -> Result<CorotationalModulus, CalibrationError> {
    let linear = youngs_modulus(finger, cases)?;
    if !linear.factor.is_finite() {
        return Err(CalibrationError::NotIdentifiable { parameters: Unknown::Modulus.to_string() });
    }
    let model = FactorModel { kinematics: Kinematics::Corotational, elements, noise_mm: None };
    // The linear finger bends more than the co-rotational one, which may not carry the loads with its modulus.
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
    // What half the elements change is more than what all of them still miss.
    let coarse = FactorModel { elements: elements.div_ceil(2), ..model };
    let mesh_error = factors(&estimate.finger, &weighed, &[Unknown::Modulus], &coarse)?.factors[0] - 1.0;
    let coordinates: usize = cases.iter().map(|case| case.measurement.coordinate_count()).sum();
    let squares_mm2 = estimate.residual_rms_mm.powi(2) * coordinates as f64;
    let test = ResidualTest::new(noise_mm, squares_mm2, coordinates - 1);
    let trusted_mm = noise_of(test, noise_mm, squares_mm2, coordinates - 1);
    // A perfect fit leaves neither noise nor deviation.
    let wider = if estimate.noise_mm > 0.0 { trusted_mm / estimate.noise_mm } else { 1.0 };
    let factor = start * estimate.factors[0];
    Ok(CorotationalModulus {
        factor,
        sigma: factor * (estimate.relative_sigmas[0] * wider).hypot(mesh_error),
        mean_distance_mm: estimate.distances_mm.iter().sum::<f64>() / estimate.distances_mm.len() as f64,
        contradiction: test.filter(ResidualTest::contradicts),
        outliers: outliers(cases, &estimate.distances_mm),
    })
}

/// The factor by least squares, with the markers weighed by their distances until it settles: at first by those from the finger as it is. With the
/// weights of the last fit.
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
            let share = |_: &_| distances_mm.next().map_or(1.0, |distance_mm| (near_mm / distance_mm).min(1.0));
            case.measurement = own.measurement.reweighted(share);
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

/// Standard deviation of a coordinate that most markers keep to, mm.
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
