//! The interactive section uses the palette and limits of the drawings.

use finray_figures::Paint;
use finray_report::drawings::percent_classes;
use finray_report::page::{SCRIPT, STYLE};
use finray_studies::settings::TRUSTED_ERROR;

/// Script and style have the palette and the limits of the drawings.
#[test]
fn the_script_has_the_limits_and_colours_of_the_drawings() {
    assert!(SCRIPT.contains(&format!("const TRUSTED = {TRUSTED_ERROR};")));
    let mut limits = 0;
    for (class, name) in percent_classes().iter().zip(["within-2", "within-5", "within-10", "within-25", "above-25"]) {
        let Paint::Colour([r, g, b]) = class.fill else { unreachable!("errors have colours") };
        assert!(STYLE.contains(&format!("--{name}: #{r:02x}{g:02x}{b:02x};")), "{name}");
        limits += usize::from(class.up_to.is_infinite() || name.ends_with(&format!("-{}", class.up_to)));
    }
    assert_eq!(limits, 5);
}
