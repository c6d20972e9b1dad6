//! What the twin is and is not, in sentences made from the fit.

use crate::claims::criteria::TPU_MPA;
use crate::experiments::twin::fit::TwinFit;
use crate::experiments::twin::moduli_mpa;
use crate::experiments::twin::study::{LOADED, TwinStudy};
use crate::report::format::{list, percent};
use crate::settings::TRUSTED_ERROR;

/// A set of zones whose misfit is below this comes as near to Table I as its figures are known.
const FITS: f64 = 1.0;

/// What the twin is, in a sentence or two: a fit, its freedom, and how far its moduli are from the material's.
pub(super) fn verdict(study: &TwinStudy) -> String {
    let large: Vec<_> = (study.after.rows.iter().filter(|row| row.paper_mean_error > TRUSTED_ERROR))
        .map(|row| format!("node {} {} (paper {})", row.node, percent(row.mean_error), percent(row.paper_mean_error)))
        .collect();
    format!(
        "A fit, not a finding: a simulated finger that was given softer zones at base and tip errs as Table I has it: {}. {} {} Material, \
         hysteresis and what else the paper did not publish are not in it.",
        large.join(", "),
        freedom_in_words(&study.fits),
        moduli_in_words(&moduli_mpa(&study.finger)),
    )
}

/// How many numbers are fitted to how many, and which other sets of zones do as well or better.
fn freedom_in_words(fits: &[TwinFit]) -> String {
    let Some((own, others)) = fits.split_first() else { return String::new() };
    // The modulus outside the zones is fitted, too.
    let parameters = format!(
        "Its {} parameters, {} factors of zones and the modulus outside, are fitted to six means and the calibrated modulus",
        own.factors.len() + 1,
        own.factors.len()
    );
    let fitting = others.iter().filter(|fit| fit.misfit < FITS).count();
    let better: Vec<&str> = others.iter().filter(|fit| fit.misfit < own.misfit).map(|fit| fit.set.name).collect();
    match (others.len(), better.len()) {
        (0, _) => format!("{parameters}; other sets of zones were not fitted this time."),
        (tried, 0) => {
            format!("{parameters}; of {tried} other sets of zones {fitting} fit as well as the figures are known.")
        }
        (tried, _) => format!(
            "{parameters}; of {tried} other sets of zones {fitting} fit as well as the figures are known, and {} better than this one.",
            better.join("; ")
        ),
    }
}

/// The zones' moduli against those that the paper quotes for its material.
fn moduli_in_words(moduli: &[f64]) -> String {
    let [least, most] = TPU_MPA;
    let listed = |moduli: &[f64]| {
        let mut words: Vec<String> = Vec::new();
        for modulus in moduli.iter().map(|modulus| format!("{modulus:.1}")) {
            if !words.contains(&modulus) {
                words.push(modulus);
            }
        }
        words.join(", ")
    };
    let outside: Vec<f64> = moduli.iter().copied().filter(|modulus| !(least..=most).contains(modulus)).collect();
    match outside.len() {
        0 => format!(
            "The zones have {} MPa, within the {least} to {most} MPa that the paper quotes for TPU.",
            listed(moduli)
        ),
        _ => format!(
            "Of the zones' moduli ({} MPa) {} MPa lie outside the {least} to {most} MPa that the paper quotes for TPU.",
            listed(moduli),
            listed(&outside)
        ),
    }
}

/// How far the fit determines the zones.
pub(super) fn fit(study: &TwinStudy) -> String {
    let Some(own) = study.fits.first() else { return String::new() };
    let factors: Vec<_> = own.factors.iter().zip(&own.sigmas).map(|(f, s)| format!("{f:.3} +- {s:.3}")).collect();
    let others = &study.fits[1..];
    let as_well: Vec<_> = others.iter().filter(|fit| fit.misfit < FITS).map(|fit| fit.set.name).collect();
    let rest = match (others.len(), as_well.len()) {
        (0, _) => String::new(),
        (tried, 0) => format!(" None of {tried} other sets of zones fits."),
        (tried, found) => format!(
            " It is not the only answer: of {tried} other sets of zones that were tried, {found} fit within the uncertainty of the figures \
             ({}). Within this family of fits the table asks for lower stiffness at the base and in the third next to the tip; it does not \
             say in which plate, in plates or ribs, or how it is spread, and no other cause was fitted.",
            as_well.join("; ")
        ),
    };
    format!(
        "Three factors and the modulus outside, four parameters, from six means and the calibrated modulus: {} (base, before the tip, tip; \
         the deviations take the six means for independent measurements), modulus outside {} of the published one; root mean square misfit {:.2} of what the numbers may be off \
         (2 % at 14, 16 and 24, 3 % at 18 to 22).{rest}",
        factors.join(", "),
        percent(own.modulus_factor),
        own.misfit
    )
}

/// Whether the errors depend on the load.
pub(super) fn spread(study: &TwinStudy) -> String {
    // At the nodes where sensing was tried.
    let sensed = study.sensing.iter().filter_map(|at| study.after.rows.iter().find(|row| row.node == at.node));
    let spans = sensed.map(|row| {
        let [lowest, highest] = row.range().map(|error| 100.0 * error);
        format!("{lowest:.0} to {highest:.0} % at {}", row.node)
    });
    format!(
        "Over the six weights the errors on the twin run from {}; the paper has 49.6 to 63.7 % at 14, at most 18 % at 16, \
         below 5 % at 18 to 22 and at most 24.2 % at 24. These ranges were not fitted.",
        list(spans, ", ")
    )
}

pub(super) fn calibration(study: &TwinStudy) -> String {
    let Some(first) = study.calibrations.first() else { return String::new() };
    let entangled = match first.entangled().len() {
        0 => "No two of them are entangled: no correlation reaches 0.95".to_owned(),
        pairs => format!("{pairs} pairs of them are strongly correlated (0.95 or more)"),
    };
    format!(
        "Such zones can be found on a real finger by hanging weights on it: finray calibrate --zones. From one noise sample \
         ({} mm) of the twin for each of six weights at nodes {}, {} repetitions find the factors again. \
         {entangled}. Over all repetitions the root mean square of error over stated sigma is {:.2} (1 is meant).",
        study.noise_mm,
        list(LOADED, ", "),
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
        assert!(words.contains("Its 4 parameters, 3 factors of zones and the modulus outside"), "{words}");
        assert!(words.contains("of 3 other sets of zones 2 fit") && words.contains(OTHERS[0].name), "{words}");
        assert!(words.contains("better than this one") && !words.contains(OTHERS[1].name), "{words}");
        let best = freedom_in_words(&[fit_of(TWIN, 0.3), fit_of(OTHERS[0], 0.4)]);
        assert!(best.contains("1 fit") && !best.contains("better"), "{best}");
        assert!(freedom_in_words(&[fit_of(TWIN, 0.3)]).contains("not fitted this time"));
    }

    /// The shipped twin is softer than the softest TPU that the paper quotes; a finger within the range is not said to be.
    #[test]
    fn moduli_are_held_against_the_material() {
        let twin = Scene::from_toml(finray_fixtures::TWIN_SCENE).expect("the twin's scene").finger;
        let words = moduli_in_words(&moduli_mpa(&twin));
        assert!(words.contains("(35.7, 7.6, 3.2 MPa) 7.6, 3.2 MPa lie outside the 10 to 1000 MPa"), "{words}");
        assert!(moduli_in_words(&[12.0, 40.0]).contains("within"));
        assert!(moduli_in_words(&[12.0, 1200.0]).contains("1200.0 MPa lie outside"));
    }
}
