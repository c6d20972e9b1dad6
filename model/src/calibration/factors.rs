//! Several moduli at once: the general one and those of zones, with their covariance and identifiability tests.

use super::{CalibrationCase, CalibrationError};
use crate::finger::{Finger, ImpossibleFinger};
use crate::keys::{SceneTable, ZONE};
use crate::mesh::Mesh;
use crate::statics::{Statics, StaticsError, equilibria};
use crate::{Kinematics, Vector};
use nalgebra::{DMatrix, DVector};
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
    /// Gauss-Newton steps taken.
    pub iterations: usize,
}

impl FactorEstimate {
    /// Pairs of unknowns (by index) that the data hardly distinguish, with their correlation: one may rise while the other
    /// falls or rises with it.
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
/// The search ends when a step changes no factor by more; the next would change it by the square of that.
const SMALLEST_STEP: f64 = 1e-10;
/// Far more steps than any problem took that ended.
const MAX_STEPS: usize = 100;
/// Largest change of ln(factor) in a step: a factor of 2.7.
const LARGEST_STEP: f64 = 1.0;
/// Damping at the start, and what a good and a bad step make of it (Marquardt 1963).
const DAMPING: (f64, f64, f64) = (1e-3, 0.1, 10.0);
/// Damping beyond this makes steps too small to count.
const MOST_DAMPING: f64 = 1e12;

/// Factors on moduli for which the sum of squared distances between measured and computed nodes is smallest.
///
/// Each `unknown` is a factor on what the finger's description says, which is also where the search starts. Logarithms are
/// sought, so that factors stay positive. One group that holds all of the finger and [`Unknown::Modulus`] are the same:
/// that is refused, and so is all else that is not identifiable.
///
/// # Reference
/// Eq. (11) of Xu et al. (2021) for several unknowns, with squares in place of distances: Gauss-Newton with the damping of
/// Marquardt (1963). In equilibrium r(u, p) = 0, so du/dp = -K^-1 dr/dp with the tangent stiffness K; the forces of a
/// member are proportional to its modulus, so dr/dp is their sum, each by the share of its compliance that the zone has
/// ([`Mesh::zone_shares`]). Covariance of the logarithms: s^2 (J^T W^2 J)^-1.
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
    let mut logs = DVector::zeros(count);
    let mut now = Sensitivities::at(finger, cases, unknowns, logs.as_slice(), model)?;
    let coordinates = now.residual.len();
    if coordinates <= count {
        return Err(CalibrationError::TooFewMarkers { unknowns: count, coordinates });
    }
    require_separable(&now.jacobian, unknowns)?;
    let mut damping = DAMPING.0;
    let mut iterations = 0;
    loop {
        iterations += 1;
        let (step, next) = loop {
            let step = damped_step(&now, damping);
            let trial = &logs + &step;
            let small = step.amax() <= SMALLEST_STEP;
            // A finger that cannot carry the loads is too soft: a shorter step.
            let next = Sensitivities::at(finger, cases, unknowns, trial.as_slice(), model);
            match next {
                Ok(next) if next.squares() <= now.squares() || small => break (step, next),
                Ok(_) | Err(CalibrationError::Statics(_)) if damping < MOST_DAMPING => damping *= DAMPING.2,
                Ok(_) => return Err(CalibrationError::NoMinimum),
                Err(error) => return Err(error),
            }
        };
        logs += &step;
        now = next;
        damping *= DAMPING.1;
        if step.amax() <= SMALLEST_STEP {
            break;
        }
        if iterations >= MAX_STEPS {
            return Err(CalibrationError::NoMinimum);
        }
    }
    require_separable(&now.jacobian, unknowns)?;
    let degrees_of_freedom = (coordinates - count) as f64;
    let noise_mm = model.noise_mm.unwrap_or((now.squares() / degrees_of_freedom).sqrt());
    let information = now.jacobian.tr_mul(&now.jacobian);
    // The singular values made sure that there is an inverse.
    let per_noise =
        information.try_inverse().ok_or_else(|| CalibrationError::NotIdentifiable { parameters: names(unknowns) })?;
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
        finger: now.finger,
        unknowns: unknowns.to_vec(),
        factors: logs.iter().map(|log| log.exp()).collect(),
        relative_sigmas,
        correlation,
        noise_mm,
        residual_rms_mm: (now.residual.norm_squared() / coordinates as f64).sqrt(),
        iterations,
    })
}

/// The finger with some factors applied, and how far it is from what was measured.
struct Sensitivities {
    finger: Finger,
    /// Weighted computed minus measured displacement, 2 rows (x, y) a marker, mm.
    residual: DVector<f64>,
    /// Its derivative by the logarithm of each factor, mm.
    jacobian: DMatrix<f64>,
}

impl Sensitivities {
    fn at(
        finger: &Finger,
        cases: &[CalibrationCase],
        unknowns: &[Unknown],
        logs: &[f64],
        model: &FactorModel,
    ) -> Result<Sensitivities, CalibrationError> {
        let finger = with_factors(finger, unknowns, logs)?;
        let mesh = Mesh::with_elements_per_member(&finger, model.elements);
        let shares: Vec<_> = unknowns.iter().map(|unknown| shares(&mesh, unknown)).collect();
        let markers: usize = cases.iter().map(|case| case.measurement.markers().len()).sum();
        let mut residual = DVector::zeros(2 * markers);
        let mut jacobian = DMatrix::zeros(2 * markers, unknowns.len());
        let mut statics = Statics::ladder(&mesh, model.kinematics);
        let mut response = vec![Vector::zeros(); mesh.frame().node_count()];
        let mut row = 0;
        let loads = cases.iter().map(|case| mesh.frame_load(&case.load).map(|load| [load]));
        let loads = loads.collect::<Result<Vec<_>, _>>().map_err(StaticsError::from)?;
        let found = equilibria(&mesh, model.kinematics, &loads);
        for ((case, load), found) in cases.iter().zip(&loads).zip(found) {
            let motion = found?.motion;
            let shape = mesh.shape(&motion);
            if !statics.linearise(&motion, load) {
                return Err(StaticsError::NoEquilibrium { converged_fraction: 1.0 }.into());
            }
            for (i, marker) in case.measurement.markers().iter().enumerate() {
                let away =
                    (shape.motion(marker.node).marker_displacement(&finger) - marker.displacement) * marker.weight;
                (residual[row + 2 * i], residual[row + 2 * i + 1]) = (away.x, away.y);
            }
            for (column, shares) in shares.iter().enumerate() {
                statics.equations_mut().stiffened(&motion, shares, &mut response);
                for (i, marker) in case.measurement.markers().iter().enumerate() {
                    let change = response[mesh.frame_node(marker.node)] * marker.weight;
                    (jacobian[(row + 2 * i, column)], jacobian[(row + 2 * i + 1, column)]) = (change.x, change.y);
                }
            }
            row += case.measurement.coordinate_count();
        }
        Ok(Sensitivities { finger, residual, jacobian })
    }

    fn squares(&self) -> f64 {
        self.residual.norm_squared()
    }
}

/// Members and how far their stiffness follows an unknown.
fn shares(mesh: &Mesh, unknown: &Unknown) -> Vec<(usize, f64)> {
    match unknown {
        Unknown::Modulus => (0..mesh.frame().members().len()).map(|member| (member, 1.0)).collect(),
        Unknown::Zones(zones) => zones.iter().flat_map(|&zone| mesh.zone_shares(zone)).collect(),
    }
}

/// The finger with factors of which the logarithms are given.
fn with_factors(finger: &Finger, unknowns: &[Unknown], logs: &[f64]) -> Result<Finger, ImpossibleFinger> {
    let mut description = finger.description().clone();
    let mut general = 1.0;
    for (unknown, log) in unknowns.iter().zip(logs) {
        match unknown {
            Unknown::Modulus => general *= log.exp(),
            Unknown::Zones(zones) => {
                for &zone in zones {
                    let missing = || ImpossibleFinger {
                        key: ZONE.path().to_owned(),
                        reason: format!(
                            "expected at least {} zones, found {}",
                            zone + 1,
                            finger.description().zones.len()
                        ),
                    };
                    description.zones.get_mut(zone).ok_or_else(missing)?.modulus_factor *= log.exp();
                }
            }
        }
    }
    Finger::new(description)?.with_modulus_factor(general)
}

/// Marquardt's step, with columns scaled to unit length: least squares of the sensitivities stacked on the damping.
fn damped_step(now: &Sensitivities, damping: f64) -> DVector<f64> {
    let (rows, columns) = now.jacobian.shape();
    let mut stacked = now.jacobian.clone().resize_vertically(rows + columns, 0.0);
    let scales: Vec<f64> = now.jacobian.column_iter().map(|column| column.norm()).collect();
    for (k, scale) in scales.iter().enumerate() {
        stacked.column_mut(k).rows_mut(0, rows).unscale_mut(*scale);
        stacked[(rows + k, k)] = damping.sqrt();
    }
    let target = (-&now.residual).resize_vertically(rows + columns, 0.0);
    let qr = stacked.qr();
    let mut step = qr.q().tr_mul(&target);
    // The damping keeps the triangle regular.
    qr.r().solve_upper_triangular_mut(&mut step);
    for (value, scale) in step.iter_mut().zip(&scales) {
        *value = (*value / scale).clamp(-LARGEST_STEP, LARGEST_STEP);
    }
    step
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
    let svd = scaled.svd(false, true);
    let smallest = svd.singular_values.imin();
    if svd.singular_values[smallest] * LARGEST_SPAN > svd.singular_values.max() {
        return Ok(());
    }
    let change = |k: usize| svd.v_t.as_ref().map_or(1.0, |v_t| v_t[(smallest, k)].abs() / scales[k]);
    let most = (0..unknowns.len()).map(change).fold(0.0, f64::max);
    let mixed = (0..unknowns.len()).filter(|&k| change(k) > NAMED_SHARE * most).map(|k| &unknowns[k]);
    Err(CalibrationError::NotSeparable { parameters: names(mixed) })
}

fn names<'u>(unknowns: impl IntoIterator<Item = &'u Unknown>) -> String {
    unknowns.into_iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
