//! Friction, from forces that were measured.

use super::scatter::TWO_SIDED_95;
use crate::calibration::CalibrationError;
use crate::sensing::{Lean, Normal};
use statrs::function::erf::erfc;

/// How friction is sought.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrictionQuestion {
    /// Whether it builds up over a force, which is sought, too.
    pub builds_up: bool,
    /// Standard deviation of the coefficient from object to object: what is assumed of a single one; of several, the scale of its prior. Zero: none is stated.
    pub between_objects: f64,
}

/// Build-up forces that are tried, over three powers of ten: 0.7 % from one to the next.
const BUILD_UPS: usize = 1000;
/// Standard deviations from object to object that are tried, degrees, from the first to the last: 2 % from one to the next.
const SDS_DEG: [f64; 2] = [0.01, 60.0];
const SDS: usize = 400;
/// Halvings of a step for half of an interval, and the chance outside it.
const HALVINGS: usize = 50;
const OUTSIDE: f64 = 0.05;
/// By how much coefficients of friction differ from object to object where nothing else is stated.
const USUAL_BETWEEN_OBJECTS: f64 = 0.05;

/// What pressed the finger (empty where that is not known), the measured force, N, and its lean from the normal towards the tip, degrees.
pub type MeasuredLean<'o> = (&'o str, f64, f64);

/// Friction as measured forces show it.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionEstimate {
    /// Mean lean and standard deviation of a single force of a new object.
    pub lean: Lean,
    /// Standard deviation of the coefficient from object to object; `None` of a single object.
    pub between_objects: Option<f64>,
    /// Each object as the others predict it. Empty where they are too few.
    pub left_out: Vec<LeftOutObject>,
}

/// Leans under an object, from forces that were measured under others.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOutObject {
    /// The object.
    pub object: String,
    /// Mean over its forces, degrees, as the others predict it.
    pub predicted_deg: f64,
    /// Standard deviation of a single force about that, degrees.
    pub sigma_deg: f64,
    /// The same mean as measured, degrees.
    pub measured_deg: f64,
}

/// Leans of each object under one law: objects share the force over which friction builds up.
struct Fit {
    build_up_n: f64,
    /// Lean of a force that slides, degrees, and its variance, of each object.
    sliding: Vec<(f64, f64)>,
    /// Standard deviation of a single force within an object, degrees.
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

    /// Mean over objects where they differ by a standard deviation, its variance, and the logarithm of the restricted likelihood.
    fn mean(&self, between_deg: f64) -> [f64; 3] {
        let variances = || self.sliding.iter().map(|(_, variance)| variance + between_deg * between_deg);
        let variance = 1.0 / variances().map(|variance| 1.0 / variance).sum::<f64>();
        let mean = variance * self.sliding.iter().zip(variances()).map(|((angle, _), of)| angle / of).sum::<f64>();
        let off = self.sliding.iter().zip(variances()).map(|((angle, _), of)| of.ln() + (angle - mean).powi(2) / of);
        [mean, variance, 0.5 * (variance.ln() - off.sum::<f64>())]
    }

    /// Mean lean of a force that slides, degrees, the standard deviation from object to object that is most likely, and that of a new object about the
    /// mean, of which 1.96 are half of a 95 % interval. Few objects leave the scatter open.
    ///
    /// # Reference
    /// Restricted maximum likelihood; posterior predictive distribution of a new group (Gelman et al., Bayesian Data Analysis, 3rd ed., sec. 5.4) with the
    /// half-Cauchy prior of few groups (Gelman, Bayesian Analysis 1, 2006), whose scale is what is assumed between objects.
    fn over_objects(&self, assumed_deg: f64) -> [f64; 3] {
        let [least, most] = SDS_DEG;
        let tried: Vec<f64> = (0..=SDS).map(|i| least * (most / least).powf(i as f64 / SDS as f64)).collect();
        let found: Vec<[f64; 3]> = tried.iter().map(|between_deg| self.mean(*between_deg)).collect();
        let best = (0..=SDS).max_by(|&i, &j| found[i][2].total_cmp(&found[j][2])).unwrap_or(0);
        let prior = |between_deg: f64| between_deg / (1.0 + (between_deg / assumed_deg).powi(2));
        let likely =
            |(sd, [_, variance, of]): (&f64, &[f64; 3])| (prior(*sd) * (of - found[best][2]).exp(), sd * sd + variance);
        let likely: Vec<(f64, f64)> = tried.iter().zip(&found).map(likely).collect();
        let all: f64 = likely.iter().map(|(likely, _)| likely).sum();
        let (mut low, mut high) = (least, 10.0 * most);
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            let beyond = |variance: f64| erfc(TWO_SIDED_95 * middle / (2.0 * variance).sqrt());
            let chance: f64 = likely.iter().map(|(likely, variance)| likely * beyond(*variance)).sum();
            if chance > OUTSIDE * all { low = middle } else { high = middle }
        }
        [found[best][0], if best > 0 { tried[best] } else { 0.0 }, low]
    }
}

/// How forces that were measured lean, as friction would have it: the coefficient and, if it is sought, the force over which it builds up, for
/// which leans are met best. The standard deviation is that of a single force of a new object: of what is left, and of what objects differ by, which one
/// object does not show: it is then what is assumed.
///
/// # Errors
/// [`CalibrationError::TooFewViews`] where there are no more views than unknowns. [`CalibrationError::FrictionLimit`] where leans do not show at which
/// lean, below 90 degrees, a force slides.
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

/// Without leaving any object out.
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
    // From at once to hardly: the sum of squares is smooth in between.
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
