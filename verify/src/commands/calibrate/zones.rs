//! `finray calibrate --measurements --zones`: one factor on all moduli, and factors of zones.

use super::{
    Arguments, EACH, ELEMENTS, Row, WeightFit, correlations, failure, modulus_rows, warn_of_contradictions,
    warn_of_modulus,
};
use crate::commands::prelude::*;
use finray_model::Kinematics;
use finray_model::calibration::{
    CalibrationCase, FactorEstimate, FactorModel, RobustFactors, UnknownFactor, modulus_values, robust_factors,
};
use finray_model::finger::ThicknessError;

/// Estimates the factors. Prints a warning if the linear finger was chosen, the co-rotational finger fits the measured displacements better, and a
/// factor differs by more than sigma.
pub fn run(
    arguments: &Arguments,
    groups: &str,
    scene: &Scene,
    cases: &[CalibrationCase],
    noise_mm: Option<f64>,
) -> Result<WeightFit, Failure> {
    let finger = &scene.finger;
    let unknowns = unknowns(groups, finger.description().zones.len())?;
    let fit = |kinematics: Kinematics| {
        // One element per member is exact for the linear finger.
        let elements = if kinematics == Kinematics::Linear { 1 } else { ELEMENTS };
        robust_factors(finger, cases, &unknowns, &FactorModel { kinematics, elements, noise_mm })
    };
    let RobustFactors { estimate, contradiction, outliers } = fit(arguments.kinematics).map_err(failure)?;
    // The factor on all moduli is the first unknown.
    if let Some(factor) = estimate.factors.first() {
        warn_of_modulus(*factor, scene.stiffness_error.share());
    }
    warn_of_contradictions(&outliers, contradiction);
    if arguments.kinematics == Kinematics::Linear {
        let closer = fit(Kinematics::Corotational).ok().map(|found| found.estimate);
        if let Some(closer) =
            closer.filter(|other| other.residual_rms_mm < estimate.residual_rms_mm && other.differs_from(&estimate))
        {
            print_message(format_args!(
                "warning: the co-rotational finger is closer to the measured nodes ({:.3} mm rms) than the linear \
                    finger ({:.3} mm rms), and its fitted factors differ from the linear ones: displacements are too \
                    large for --kinematics linear",
                closer.residual_rms_mm, estimate.residual_rms_mm
            ));
        }
    }
    for (i, j, correlation) in estimate.entangled() {
        let [one, other] = [i, j].map(|k| &estimate.unknowns[k]);
        print_message(format_args!("warning: {one} and {other} are hardly separable: correlation {correlation:.3}"));
    }
    let mut files = Vec::new();
    if let Some(path) = &arguments.correlations {
        let names: Vec<String> = estimate.unknowns.iter().map(ToString::to_string).collect();
        files.push((path.clone(), csv_text(correlations(&names, &estimate.correlation))?));
    }
    files.push((arguments.out.clone(), csv_text(factor_rows(finger, &estimate))?));
    // The factors of zones contain the thicknesses in part; the thicknesses count as independent of the moduli.
    let thickness = ThicknessError::default();
    let values = modulus_values(&estimate.finger, 1.0, estimate.relative_sigmas[0], thickness);
    let done = format!("{} estimated from {}", count(estimate.factors.len(), "factor"), count(cases.len(), "case"));
    Ok(WeightFit { files, values, done })
}

/// The unknown factors for a value of `--zones` such as `1+2,3`: one on all moduli, then one per group of zones. Zones are numbered from 1.
fn unknowns(groups: &str, zone_count: usize) -> Result<Vec<UnknownFactor>, Failure> {
    let bad = |reason: String| bad_input(format!("--zones: {reason}"));
    if zone_count == 0 {
        return Err(bad("expected tables [[finger.zone]] in the scene, found none".to_owned()));
    }
    let zones: Vec<Vec<usize>> = if groups == EACH {
        (0..zone_count).map(|zone| vec![zone]).collect()
    } else {
        let zone = |text: &str| {
            let number = text.trim().parse::<usize>().ok().filter(|number| (1..=zone_count).contains(number));
            number.map(|number| number - 1).ok_or_else(|| {
                bad(format!(
                    "expected groups of zones, 1 to {zone_count}, where + joins the zones of a group and a comma \
                    separates groups, for instance 1+2,3; found \"{text}\""
                ))
            })
        };
        groups.split(',').map(|group| group.split('+').map(zone).collect()).collect::<Result<_, _>>()?
    };
    let mut named: Vec<usize> = zones.concat();
    named.sort_unstable();
    if let Some(twice) = named.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(bad(format!("zone {} is named twice", twice[0] + 1)));
    }
    Ok(std::iter::once(UnknownFactor::Modulus).chain(zones.into_iter().map(UnknownFactor::Zones)).collect())
}

/// Rows of a result: the moduli, the factor on all moduli, then the factor of each estimated zone.
fn factor_rows(finger: &Finger, estimate: &FactorEstimate) -> Vec<Row> {
    let relative = |k: usize| estimate.relative_sigmas[k];
    let mut rows = Vec::new();
    for (k, unknown) in estimate.unknowns.iter().enumerate() {
        match unknown {
            UnknownFactor::Modulus => {
                let factor = estimate.factors[k];
                rows.extend(modulus_rows(finger, factor, factor * relative(k)));
            }
            UnknownFactor::Zones(zones) => rows.extend(zones.iter().map(|&zone| {
                let value = estimate.finger.description().zones[zone].modulus_factor;
                Row { parameter: UnknownFactor::Zones(vec![zone]).to_string(), value, sigma: Some(value * relative(k)) }
            })),
        }
    }
    rows
}
