//! Sentences on the fit of the finger with softer ends.

use crate::format::{list, percent};
use crate::prelude::*;
use finray_studies::claims::criteria::TPU_MPA;
use finray_studies::experiments::twin::fit::TwinFit;
use finray_studies::experiments::twin::moduli_mpa;
use finray_studies::experiments::twin::study::{LOADED, TwinStudy};

/// A set of zones reproduces Table I within the accuracy of the table if the misfit of the set is below this.
const FITS: f64 = 1.0;

/// Text on the paper's conjecture that motivates the fit, and on the limits of the fit.
pub(super) const ABOUT: &str = "The paper infers from its errors that the modulus \"at the tip and base should be lower\". Here zones of both \
    plates are softened by assumption, so the fit is no evidence that soft ends are the cause. The table does not show \
    which plate or ribs are soft, and no other cause was fitted. The signs of the errors at nodes 18 to 22 are not \
    published, so an error of zero is fitted there. Weights are assumed along the normal.";

/// Sentence on the errors of the fitted finger, its number of parameters, and its moduli compared with the material's; `None` without a fit.
pub(super) fn verdict(study: &TwinStudy) -> Option<String> {
    let large = study.after.rows.iter().filter(|row| row.paper_mean_error > TRUSTED_ERROR).map(|row| {
        let [error, paper] = [row.mean_error, row.paper_mean_error].map(percent);
        format!("{error} at node {} (paper {paper})", row.node)
    });
    let (large, freedom) = (list(large, ", "), freedom_in_words(&study.fits)?);
    let moduli = moduli_in_words(&moduli_mpa(&study.finger));
    Some(format!(
        "This is a fit, not a finding: in simulation, the finger with softer ends errs as in Table I ({large}). \
            {freedom} {moduli} Material, hysteresis and other unpublished properties are not modelled."
    ))
}

/// Sentence on the number of fitted parameters, and on how many other sets of zones fit Table I, or fit it better than this set; `None` without a
/// fit.
pub fn freedom_in_words(fits: &[TwinFit]) -> Option<String> {
    let (own, others) = fits.split_first()?;
    // The modulus outside the zones is also fitted, hence one parameter more.
    let parameters = own.factors.len() + 1;
    let below = |misfit: f64| others.iter().filter(|fit| fit.misfit < misfit).count();
    let (tried, fit, better) = (others.len(), below(FITS), below(own.misfit));
    let compared = match tried {
        0 => "other sets of zones were not fitted this time.".to_owned(),
        _ => format!(
            "of {tried} other sets of zones, {fit} fit within the accuracy of Table I, and {better} fit better than this set."
        ),
    };
    Some(format!("{parameters} parameters are fitted to six means and the calibrated modulus; {compared}"))
}

/// Sentence that compares the moduli of the zones, MPa, with the range that the paper quotes for TPU.
pub fn moduli_in_words(moduli: &[f64]) -> String {
    let [least, most] = TPU_MPA;
    let outside = moduli.iter().filter(|modulus| !(least..=most).contains(*modulus));
    let mut outside: Vec<String> = outside.map(|modulus| format!("{modulus:.1}")).collect();
    outside.dedup();
    let lie = match &outside[..] {
        [] => "The zones' moduli are within".to_owned(),
        outside => format!("Zones of {} MPa lie outside", outside.join(" and ")),
    };
    format!("{lie} the {least} to {most} MPa that the paper quotes for TPU.")
}

/// Sentence on the accuracy of a calibration of the zones with weights, in simulation; `None` without a calibration.
pub(super) fn calibration(study: &TwinStudy) -> Option<String> {
    let entangled = match study.calibrations.first()?.entangled().len() {
        0 => "no correlation reaches 0.95".to_owned(),
        pairs => format!("{pairs} pairs of factors have a correlation of 0.95 or more"),
    };
    let (noise_mm, loaded, repetitions) = (study.noise_mm, LOADED.len(), study.calibrations.len());
    Some(format!(
        "The command finray calibrate --zones was simulated with {noise_mm} mm noise and six weights at each of \
            {loaded} nodes. In {repetitions} repetitions, the factors err by {:.2} stated sigma (root mean square; 1 \
            is expected); {entangled}.",
        study.rms_over_sigma()
    ))
}
