//! Estimates friction from measured forces.

use super::scatter::predictive_sd;
use crate::calibration::CalibrationError;
use crate::sensing::{Lean, Normal};

/// Options for the estimate of friction between finger and objects.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrictionQuestion {
    /// Whether friction builds up as the force grows. If friction builds up, the build-up force of friction is also estimated.
    pub builds_up: bool,
    /// Standard deviation of the coefficient of friction from object to object, dimensionless. For a single object, `between_objects` is the assumed
    /// deviation. For several objects, `between_objects` sets the scale of the prior. Zero if this deviation is not stated.
    pub between_objects: f64,
}

/// The search tries this number of build-up forces over three powers of ten, in steps of 0.7 %.
const BUILD_UPS: usize = 1000;
/// The search tries standard deviations of the lean from object to object, from the first to the second value, degrees, in steps of 2 %.
const SDS_DEG: [f64; 2] = [0.01, 60.0];
const SDS: usize = 400;
/// Standard deviation of the coefficient of friction from object to object, dimensionless, if no deviation is stated.
const USUAL_BETWEEN_OBJECTS: f64 = 0.05;

/// Name of the object that pressed the finger (empty if unknown), measured force, N, and lean of the force, degrees. The lean is the angle from the normal,
/// positive towards the tip.
pub type MeasuredLean<'o> = (&'o str, f64, f64);

/// Friction estimated from measured forces.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionEstimate {
    /// Mean lean (angle between force and normal), and the standard deviation of the lean of a single force of a new object.
    pub lean: Lean,
    /// Standard deviation of the coefficient of friction from object to object, dimensionless. `None` for a single object.
    pub between_objects: Option<f64>,
    /// Cross-validation, in which each object is predicted from the others. Empty if there are too few objects.
    pub left_out: Vec<LeftOutObject>,
}

/// Measured leans (angles between force and normal) for one object, and their prediction from the forces of the other objects.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOutObject {
    /// Name of the object.
    pub object: String,
    /// Predicted mean lean of the object's forces (angle from the normal), degrees.
    pub predicted_deg: f64,
    /// Standard deviation of the lean of a single force about the prediction, degrees.
    pub sigma_deg: f64,
    /// Measured mean lean of the object's forces (angle from the normal), degrees.
    pub measured_deg: f64,
}

/// Fitted leans (angles between force and normal) of each object. All objects share the build-up force of friction.
struct Fit {
    build_up_n: f64,
    /// Lean of a sliding force, degrees, and its variance, degrees^2, for each object.
    sliding: Vec<(f64, f64)>,
    /// Standard deviation of the lean of a single force within an object, degrees.
    within_deg: f64,
}

impl Fit {
    fn new(objects: &[&[MeasuredLean]], build_up_n: f64, degrees_of_freedom: usize) -> Fit {
        let unit = Lean { angle_deg: 1.0, build_up_n, ..Lean::NONE };
        let (mut sum_of_squares, mut sliding) = (0.0, Vec::new());
        for leans in objects {
            let shares = || leans.iter().map(|(_, force_n, lean)| (unit.mean_deg(*force_n), lean));
            let squares: f64 = shares().map(|(share, _)| share * share).sum();
            let angle_deg = shares().map(|(share, lean)| share * lean).sum::<f64>() / squares;
            sum_of_squares += shares().map(|(share, lean)| (lean - angle_deg * share).powi(2)).sum::<f64>();
            sliding.push((angle_deg, 1.0 / squares));
        }
        let variance = sum_of_squares / degrees_of_freedom as f64;
        sliding.iter_mut().for_each(|(_, of)| *of *= variance);
        Fit { build_up_n, sliding, within_deg: variance.sqrt() }
    }

    /// Mean lean over objects, degrees, the variance of this mean, degrees^2, and the logarithm of the restricted likelihood. The assumed standard deviation of
    /// the lean from object to object is `between_deg`.
    fn mean(&self, between_deg: f64) -> [f64; 3] {
        let variances = || self.sliding.iter().map(|(_, variance)| variance + between_deg * between_deg);
        let variance = 1.0 / variances().map(|variance| 1.0 / variance).sum::<f64>();
        let mean = variance * self.sliding.iter().zip(variances()).map(|((angle, _), of)| angle / of).sum::<f64>();
        let off = self.sliding.iter().zip(variances()).map(|((angle, _), of)| of.ln() + (angle - mean).powi(2) / of);
        [mean, variance, 0.5 * (variance.ln() - off.sum::<f64>())]
    }

    /// Returns three values in degrees. The first is the mean lean of a sliding force. The second is the most likely standard deviation of this lean
    /// from object to object. The third is the standard deviation of a new object's lean about the mean. The third value, for a new object, includes
    /// the uncertainty due to few objects; 1.96 times this value is half the width of a 95 % interval.
    ///
    /// # Reference
    /// Restricted maximum likelihood, and the posterior predictive distribution of a new group (Gelman et al., Bayesian Data Analysis, 3rd ed., sec.
    /// 5.4). The prior is the half-Cauchy prior for few groups (Gelman, Bayesian Analysis 1, 2006). The scale of the half-Cauchy prior is the assumed
    /// standard deviation from object to object.
    fn over_objects(&self, assumed_deg: f64) -> [f64; 3] {
        let [least, most] = SDS_DEG;
        let tried: Vec<f64> = (0..=SDS).map(|i| least * (most / least).powf(i as f64 / SDS as f64)).collect();
        let found: Vec<[f64; 3]> = tried.iter().map(|between_deg| self.mean(*between_deg)).collect();
        let best = (0..=SDS).max_by(|&i, &j| found[i][2].total_cmp(&found[j][2])).unwrap_or(0);
        let prior = |between_deg: f64| between_deg / (1.0 + (between_deg / assumed_deg).powi(2));
        let likely =
            |(sd, [_, variance, of]): (&f64, &[f64; 3])| (prior(*sd) * (of - found[best][2]).exp(), sd * sd + variance);
        let likely: Vec<(f64, f64)> = tried.iter().zip(&found).map(likely).collect();
        [found[best][0], if best > 0 { tried[best] } else { 0.0 }, predictive_sd(&likely, [least, 10.0 * most])]
    }
}

/// Fits the coefficient of friction to the leans of measured forces (angles between force and the normal `from`). If `question` states that friction
/// builds up, also fits the build-up force. The standard deviation of the returned lean applies to a single force of a new object. The standard
/// deviation of the returned lean combines the residual within objects with the difference between objects. For a single object, the difference
/// between objects is assumed.
///
/// # Errors
/// [`CalibrationError::TooFewViews`] if there are no more views than unknowns. [`CalibrationError::FrictionLimit`] if a sliding force leans by 90
/// degrees or more, or the build-up force exceeds the largest force.
pub fn friction_of(
    leans: &[MeasuredLean],
    from: Normal,
    question: FrictionQuestion,
) -> Result<FrictionEstimate, CalibrationError> {
    let mut sorted = leans.to_vec();
    sorted.sort_by_key(|(object, ..)| *object);
    let objects: Vec<&[MeasuredLean]> = sorted.chunk_by(|a, b| a.0 == b.0).collect();
    let left_out = |i: usize| {
        let (its, others) = (objects[i], [&objects[..i], &objects[i + 1..]].concat());
        let lean = of_objects(&others, from, question).ok()?.lean;
        let mean = |of: &dyn Fn(&MeasuredLean) -> f64| its.iter().map(of).sum::<f64>() / its.len() as f64;
        let predicted_deg = mean(&|(_, force_n, _)| lean.mean_deg(*force_n));
        let measured_deg = mean(&|(.., lean_deg)| *lean_deg);
        Some(LeftOutObject { object: its[0].0.to_owned(), predicted_deg, sigma_deg: lean.sd_deg, measured_deg })
    };
    let estimate = of_objects(&objects, from, question)?;
    Ok(FrictionEstimate { left_out: (0..objects.len()).filter_map(left_out).collect(), ..estimate })
}

/// Fits friction without cross-validation.
fn of_objects(
    objects: &[&[MeasuredLean]],
    from: Normal,
    FrictionQuestion { builds_up, between_objects }: FrictionQuestion,
) -> Result<FrictionEstimate, CalibrationError> {
    let views = objects.iter().map(|leans| leans.len()).sum();
    let unknowns = objects.len().max(1) + usize::from(builds_up);
    if views <= unknowns {
        return Err(CalibrationError::TooFewViews { views, unknowns });
    }
    let largest_n = objects.concat().iter().fold(0.0_f64, |m, (_, force_n, _)| m.max(force_n.abs()));
    // With the smallest tried build-up force, friction acts almost immediately; with the largest, hardly any friction builds up. The sum of squares
    // is smooth between the tried values.
    let tried = (0..=BUILD_UPS).map(|i| largest_n * 10f64.powf(-2.0 + 3.0 * i as f64 / BUILD_UPS as f64));
    let fits = tried.filter(|_| builds_up).chain([0.0]).map(|n| Fit::new(objects, n, views - unknowns));
    let fit = fits.min_by(|a, b| a.within_deg.total_cmp(&b.within_deg)).ok_or(CalibrationError::NoMinimum)?;
    let cos_squared = |angle_deg: f64| angle_deg.to_radians().cos().powi(2);
    let in_degrees = |coefficient: f64, angle_deg| (coefficient * cos_squared(angle_deg)).to_degrees();
    let (angle_deg, between_deg, new_deg) = match fit.sliding[..] {
        [(angle_deg, _)] => (angle_deg, None, in_degrees(between_objects, angle_deg)),
        _ => {
            let assumed = if between_objects > 0.0 { between_objects } else { USUAL_BETWEEN_OBJECTS };
            let [angle_deg, between_deg, new_deg] = fit.over_objects(in_degrees(assumed, fit.mean(SDS_DEG[1])[0]));
            (angle_deg, Some(between_deg), new_deg)
        }
    };
    let lean = Lean { angle_deg, sd_deg: fit.within_deg.hypot(new_deg), build_up_n: fit.build_up_n, from };
    if angle_deg.abs() >= 90.0 || fit.build_up_n > largest_n {
        return Err(CalibrationError::FrictionLimit { angle_deg, build_up_n: fit.build_up_n, largest_n });
    }
    let between_objects = between_deg.map(|deg| deg.to_radians() / cos_squared(angle_deg));
    Ok(FrictionEstimate { lean, between_objects, left_out: Vec::new() })
}
