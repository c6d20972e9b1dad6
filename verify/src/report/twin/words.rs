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
fn freedom_in_words(fits: &[TwinFit]) -> String {
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
fn moduli_in_words(moduli: &[f64]) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::twin::{OTHERS, TWIN, ZoneSet};
    use finray_model::Scene;

    fn fit_of(set: ZoneSet, misfit: f64) -> TwinFit {
        TwinFit {
            set,
            finger: Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the paper's scene").finger,
            factors: set.groups.iter().map(|(_, start)| *start).collect(),
            sigmas: vec![0.1; set.groups.len()],
            modulus_factor: 1.0,
            errors: Vec::new(),
            misfit,
        }
    }

    #[test]
    fn the_twin_is_one_of_several_fits() {
        let words = freedom_in_words(&[
            fit_of(TWIN, 0.5),
            fit_of(OTHERS[0], 0.4),
            fit_of(OTHERS[1], 0.9),
            fit_of(OTHERS[2], 3.0),
        ]);
        assert!(words.starts_with("4 parameters are fitted"), "{words}");
        assert!(words.contains("of 3 other sets of zones 2 fit as well") && words.contains("1 better"), "{words}");
        assert!(freedom_in_words(&[fit_of(TWIN, 0.3)]).contains("not fitted this time"));
    }

    /// The shipped twin is softer than the softest TPU that the paper quotes; a finger within the range is not said to be.
    #[test]
    fn moduli_are_held_against_the_material() {
        let twin = Scene::from_toml(finray_fixtures::TWIN_SCENE).expect("the twin's scene").finger;
        let words = moduli_in_words(&moduli_mpa(&twin));
        assert!(words.contains("Zones of 7.6 and 3.2 MPa lie outside the 10 to 1000 MPa"), "{words}");
        assert!(moduli_in_words(&[12.0, 40.0]).contains("within"));
        assert!(moduli_in_words(&[12.0, 1200.0]).contains("Zones of 1200.0 MPa lie outside"));
    }
}
