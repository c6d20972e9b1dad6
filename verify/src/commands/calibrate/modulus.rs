//! `finray calibrate --measurements` without `--zones`: one factor on all moduli.

use super::{Arguments, ELEMENTS, WeightFit, failure, modulus_rows, warn_of_contradictions, warn_of_modulus};
use crate::commands::prelude::*;
use finray_model::Kinematics;
use finray_model::calibration::{self, CalibrationCase, modulus_values};

/// Estimates one factor on all moduli: by fitting the co-rotational finger, or by the paper's eq. (11) for the linear finger. Prints a warning if the
/// kinematics that were not chosen fit the measured displacements better, and their factor differs by more than sigma.
pub fn run(
    arguments: &Arguments,
    scene: &Scene,
    cases: &[CalibrationCase],
    noise_mm: Option<f64>,
) -> Result<WeightFit, Failure> {
    let finger = &scene.finger;
    let linear = calibration::youngs_modulus(finger, cases);
    let corotational = calibration::corotational_modulus(finger, cases, ELEMENTS, noise_mm);
    let found = if arguments.kinematics == Kinematics::Linear { &linear } else { &corotational };
    let found = found.as_ref().map_err(|error| failure(error.clone()))?;
    let (factor, mut sigma) = (found.factor, found.sigma);
    if !(factor.is_finite() && sigma.is_finite()) {
        return Err(bad_input(
            "not identifiable: the modulus overflows; check the units of loads (N) and displacements (mm)",
        ));
    }
    warn_of_modulus(factor, scene.stiffness_error.share());
    warn_of_contradictions(&found.outliers, found.contradiction);
    if let (Ok(linear), Ok(corotational)) = (&linear, &corotational) {
        let distances_mm = [linear.mean_distance_mm, corotational.mean_distance_mm];
        let difference = (linear.factor - corotational.factor).abs();
        match arguments.kinematics {
            Kinematics::Linear if distances_mm[1] < distances_mm[0] && difference > sigma => {
                print_message(format_args!(
                    "warning: the co-rotational finger is closer to the measured nodes (mean distance {:.3} mm) \
                        than the linear finger ({:.3} mm), and the co-rotational modulus_factor is {:.4}. \
                        Displacements are too large for --kinematics linear; sigma includes the difference of the two \
                        factors",
                    distances_mm[1], distances_mm[0], corotational.factor
                ));
                sigma = sigma.hypot(difference);
            }
            Kinematics::Corotational if distances_mm[0] < distances_mm[1] && difference > sigma => {
                print_message(format_args!(
                    "warning: the linear finger is closer to the measured nodes (mean distance {:.3} mm) than the \
                        co-rotational finger ({:.3} mm), and the linear modulus_factor is {:.4}. Use --kinematics \
                        linear if the shapes were computed with linear kinematics",
                    distances_mm[0], distances_mm[1], linear.factor
                ));
            }
            _ => {}
        }
    }
    let factor_of = |finger: &Finger| match arguments.kinematics {
        Kinematics::Linear => calibration::youngs_modulus(finger, cases),
        _ => calibration::corotational_modulus(finger, cases, ELEMENTS, noise_mm),
    };
    let thickness =
        scene.thickness_error.calibrated(finger, |finger| Ok(factor_of(finger)?.factor)).map_err(failure)?;
    Ok(WeightFit {
        files: vec![(arguments.out.clone(), csv_text(modulus_rows(finger, factor, sigma))?)],
        values: modulus_values(finger, factor, sigma / factor, thickness),
        done: format!("modulus estimated from {}", count(cases.len(), "case")),
    })
}
