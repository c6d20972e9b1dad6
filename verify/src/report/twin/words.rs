//! What the twin is and is not, in sentences made from the fit.

use crate::claims::criteria::TPU_MPA;
use crate::experiments::twin::fit::TwinFit;
use crate::experiments::twin::moduli_mpa;
use crate::experiments::twin::study::{LOADED, TwinStudy};
use crate::report::format::{list, percent};
use crate::settings::TRUSTED_ERROR;

/// A set of zones whose misfit is below this comes as near to Table I as its figures are known.
const FITS: f64 = 1.0;

/// A fit, its freedom, and how far its moduli are from the material's.
pub(super) fn verdict(study: &TwinStudy) -> String {
    let large = (study.after.rows.iter().filter(|row| row.paper_mean_error > TRUSTED_ERROR))
        .map(|row| format!("{} at {} (paper {})", percent(row.mean_error), row.node, percent(row.paper_mean_error)));
    format!(
        "A fit, not a finding: in simulation the finger with softer ends errs as Table I has it, {}. {} {} Material, hysteresis and what else is \
         not published are left out.",
        list(large, ", "),
        freedom_in_words(&study.fits),
        moduli_in_words(&moduli_mpa(&study.finger)),
    )
}

/// How many numbers are fitted to how many, and how many other sets of zones do as well or better.
pub fn freedom_in_words(fits: &[TwinFit]) -> String {
    let Some((own, others)) = fits.split_first() else { return String::new() };
    // The modulus outside the zones is fitted, too.
    let parameters = own.factors.len() + 1;
    let parameters = format!("{parameters} parameters are fitted to six means and the calibrated modulus");
    let count = |of: &dyn Fn(&TwinFit) -> bool| others.iter().filter(|fit| of(fit)).count();
    match others.len() {
        0 => format!("{parameters}; other sets of zones were not fitted this time."),
        tried => format!(
            "{parameters}; of {tried} other sets of zones {} fit as well as the figures are known, {} better than this one.",
            count(&|fit| fit.misfit < FITS),
            count(&|fit| fit.misfit < own.misfit)
        ),
    }
}

/// The zones' moduli against those that the paper quotes for its material.
pub fn moduli_in_words(moduli: &[f64]) -> String {
    let [least, most] = TPU_MPA;
    let mut outside: Vec<String> = moduli
        .iter()
        .filter(|modulus| !(least..=most).contains(*modulus))
        .map(|modulus| format!("{modulus:.1}"))
        .collect();
    outside.dedup();
    match &outside[..] {
        [] => format!("The zones' moduli are within the {least} to {most} MPa that the paper quotes for TPU."),
        outside => format!(
            "Zones of {} MPa lie outside the {least} to {most} MPa that the paper quotes for TPU.",
            outside.join(" and ")
        ),
    }
}

/// How well weights on a real finger would find its zones, as far as simulation says.
pub(super) fn calibration(study: &TwinStudy) -> String {
    let Some(first) = study.calibrations.first() else { return String::new() };
    let entangled = match first.entangled().len() {
        0 => "no correlation reaches 0.95".to_owned(),
        pairs => format!("{pairs} pairs are correlated by 0.95 or more"),
    };
    format!(
        "finray calibrate --zones, simulated with {} mm noise and six weights at each of {} nodes: {} repetitions err by {:.2} stated sigma \
         (root mean square, 1 is meant); {entangled}.",
        study.noise_mm,
        LOADED.len(),
        study.calibrations.len(),
        study.rms_over_sigma()
    )
}
