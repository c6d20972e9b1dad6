//! Sentences about the twin follow from its fits.

use finray_model::Scene;
use finray_report::twin::words::{freedom_in_words, moduli_in_words};
use finray_studies::experiments::twin::fit::TwinFit;
use finray_studies::experiments::twin::{OTHERS, TWIN, ZoneSet, moduli_mpa};

fn freedom(fits: &[TwinFit]) -> String {
    freedom_in_words(fits).expect("a fit")
}

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
    let words = freedom(&[fit_of(TWIN, 0.5), fit_of(OTHERS[0], 0.4), fit_of(OTHERS[1], 0.9), fit_of(OTHERS[2], 3.0)]);
    assert!(words.starts_with("4 parameters are fitted"), "{words}");
    assert!(words.contains("of 3 other sets of zones, 2 fit within") && words.contains("1 fit better"), "{words}");
    assert!(freedom(&[fit_of(TWIN, 0.3)]).contains("not fitted this time"));
}

/// The sentence states that moduli of the shipped twin lie outside the range that the paper quotes for TPU; moduli within the range are not reported
/// as outside.
#[test]
fn moduli_are_held_against_the_material() {
    let twin = Scene::from_toml(finray_fixtures::TWIN_SCENE).expect("the twin's scene").finger;
    let words = moduli_in_words(&moduli_mpa(&twin));
    assert!(words.contains("Zones of 7.6 and 3.2 MPa lie outside the 10 to 1000 MPa"), "{words}");
    assert!(moduli_in_words(&[12.0, 40.0]).contains("within"));
    assert!(moduli_in_words(&[12.0, 1200.0]).contains("Zones of 1200.0 MPa lie outside"));
}
