//! Notes on standard error that state the assumptions of a calibration: priors, base and friction.

use crate::commands::prelude::*;
use finray_model::calibration::{self, FoundView, FrictionEstimate, LeftOutObject, RigEstimate, ViewEstimate};

/// A note is printed if a parameter's posterior standard deviation exceeds this share of its prior standard deviation: the images then add little.
const HARDLY_BETTER: f64 = 0.8;

/// A parameter that ends farther from the scene's value than this many standard deviations of its prior is doubted.
const DOUBTFUL: f64 = 2.0;

/// Prints the notes about priors, base and friction. `remounted` names what `--remounted` estimates, with the priors, which are then not listed one by one.
pub fn print(found: &RigEstimate, remounted: Option<&str>) {
    if let Some(names) = remounted {
        print_message(format_args!(
            "note: --remounted estimates {names} (standard deviations of priors in mm and N mm)"
        ));
    }
    print_priors(&found.views, remounted.is_none());
    print_base(found);
    if let Some(friction) = &found.friction {
        print_friction(friction);
    }
}

/// Warns of a parameter that is far from the scene's value, as measured by the standard deviation of its prior. `change` and `prior_sd` are in the
/// same unit; nothing is known of a parameter without a prior.
pub fn warn_of_change(parameter: &str, value: f64, change: f64, prior_sd: f64) {
    if prior_sd > 0.0 && change.abs() > DOUBTFUL * prior_sd {
        print_message(format_args!(
            "warning: {parameter} is {value:.4}, {:.1} standard deviations ({prior_sd}) from the scene's value: compare the scene with the finger, \
             check forces and their units, or state a larger standard deviation",
            change.abs() / prior_sd
        ));
    }
}

/// Names the parameters that contradict their prior and, if `all`, each parameter with a prior, and whether the images hardly improve it.
fn print_priors(estimate: &ViewEstimate, all: bool) {
    for found in &estimate.quantities {
        let Some(prior_sd) = found.sought.prior_sd else { continue };
        let quantity = found.sought.quantity;
        warn_of_change(&quantity.to_string(), found.value, found.change, prior_sd);
        match found.sigma > HARDLY_BETTER * prior_sd {
            _ if !all => {}
            true => print_message(format_args!(
                "note: {quantity}: prior of {prior_sd} (standard deviation), which the images hardly improve"
            )),
            false => print_message(format_args!("note: {quantity}: prior of {prior_sd} (standard deviation)")),
        }
    }
}

/// If the scene has no standard deviations of the base, prints the assumed standard deviations, and the range of the base's rotation in the images.
fn print_base(found: &RigEstimate) {
    if !found.is_base_unstated {
        return;
    }
    let turn_deg = |view: &FoundView| (found.views.base.inverse() * view.base).rotation.angle().to_degrees();
    let turns = || found.views.views.iter().map(turn_deg);
    let (least, most) = (turns().fold(f64::INFINITY, f64::min), turns().fold(f64::NEG_INFINITY, f64::max));
    print_message(format_args!(
        "note: base.sigma_mm, base.sigma_deg are not in the scene: the base may differ from its references by {} mm and {} degree (standard \
         deviations); in the images the base is turned by {least:.2} to {most:.2} degrees relative to its references",
        calibration::UNSTATED_BASE.sd_mm,
        calibration::UNSTATED_BASE.sd_rad.to_degrees()
    ));
}

/// Warns of a negative coefficient of friction. Reports the scatter of the friction coefficient between objects and, for each left-out object, the
/// predicted and the measured mean lean of its forces.
fn print_friction(FrictionEstimate { lean, between_objects, left_out }: &FrictionEstimate) {
    let [coefficient, _] = lean.coefficient();
    if coefficient < 0.0 {
        print_message(format_args!(
            "warning: friction is {coefficient:.2}: measured forces lean from the normal towards the base, as if the object slid towards the base; \
             check the sign of fy_n, and the frame of the forces"
        ));
    }
    if let Some(between_objects) = between_objects {
        print_message(format_args!(
            "note: friction differs from object to object by {between_objects:.3} (standard deviation); friction_sigma includes this scatter and the \
             uncertainty of the scatter, which is estimated from few objects"
        ));
    }
    for LeftOutObject { object, predicted_deg, sigma_deg, measured_deg } in left_out {
        print_message(format_args!(
            "note: object {object}, left out: predicted mean lean {predicted_deg:.1} degrees, from the other \
                objects (standard deviation of one force: {sigma_deg:.1} degrees); measured mean lean \
                {measured_deg:.1} degrees"
        ));
    }
}
