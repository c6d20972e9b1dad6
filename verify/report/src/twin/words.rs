//! Sentences on the fit of the finger with softer ends.

use crate::prelude::*;
use finray_studies::claims::criteria::TPU_MPA;
use finray_studies::experiments::twin::fit::TwinFit;
use finray_studies::experiments::twin::moduli_mpa;
use finray_studies::experiments::twin::study::{LOADED, TwinStudy};

/// A set of zones reproduces Table I within the accuracy of the table if the misfit of the set is below this.
const FITS: f64 = 1.0;

/// Sentence on the errors of the fitted finger, its number of parameters, and its moduli compared with the material's.
pub(super) fn verdict(study: &TwinStudy) -> Result<Option<String>, ReportError> {
    let large = study.after.rows.iter().filter(|row| row.paper_mean_error > TRUSTED_ERROR);
    let large = large.map(|row| context! { error => row.mean_error, node => row.node, paper => row.paper_mean_error });
    let numbers = context! {
        large => large.collect::<Vec<_>>(),
        freedom => freedom_in_words(&study.fits)?.unwrap_or_default(),
        moduli => moduli_in_words(&moduli_mpa(&study.finger))?,
    };
    say("twin.verdict", Some(numbers))
}

/// Sentence on the number of fitted parameters, and on the number of other sets of zones that fit as well or better.
pub fn freedom_in_words(fits: &[TwinFit]) -> Result<Option<String>, ReportError> {
    let numbers = fits.split_first().map(|(own, others)| {
        let count = |of: &dyn Fn(&TwinFit) -> bool| others.iter().filter(|fit| of(fit)).count();
        context! {
            // The modulus outside the zones is also fitted, hence one parameter more.
            parameters => own.factors.len() + 1,
            tried => others.len(),
            fit => count(&|fit| fit.misfit < FITS),
            better => count(&|fit| fit.misfit < own.misfit),
        }
    });
    say("twin.freedom", numbers)
}

/// Sentence that compares the moduli of the zones, MPa, with the paper's range for its material.
pub fn moduli_in_words(moduli: &[f64]) -> Result<Option<String>, ReportError> {
    let [least, most] = TPU_MPA;
    let outside = moduli.iter().filter(|modulus| !(least..=most).contains(*modulus));
    let mut outside: Vec<String> = outside.map(|modulus| format!("{modulus:.1}")).collect();
    outside.dedup();
    say("twin.moduli", Some(context! { outside, least, most }))
}

/// Sentence on the accuracy of a calibration of the zones with weights, in simulation.
pub(super) fn calibration(study: &TwinStudy) -> Result<Option<String>, ReportError> {
    let numbers = study.calibrations.first().map(|first| {
        context! {
            noise_mm => study.noise_mm,
            loaded => LOADED.len(),
            repetitions => study.calibrations.len(),
            rms => study.rms_over_sigma(),
            pairs => first.entangled().len(),
        }
    });
    say("twin.calibration", numbers)
}
