//! Warnings about input that is valid but probably wrong.

use super::print_message;
use finray_files::observations::RefusedImage;
use finray_files::{Elsewhere, name_of, of_another_finger};
use finray_model::Finger;
use std::path::Path;

/// Young's modulus of diamond, MPa, rounded down. A larger modulus in a scene is probably in another unit.
const STIFFEST_MPA: f64 = 1e6;
const PA_A_MPA: f64 = 1e6;

/// Warns of moduli that are probably in Pa instead of MPa.
pub fn of_moduli(path: &Path, finger: &Finger) {
    let description = finger.description();
    let plates = [("front", description.front.youngs_modulus_mpa), ("back", description.back.youngs_modulus_mpa)];
    let ribs = description.ribs.strip.map(|strip| ("ribs", strip.youngs_modulus_mpa));
    for (part, found) in plates.into_iter().chain(ribs).filter(|(_, found)| *found > STIFFEST_MPA) {
        print_message(format_args!(
            "warning: {}: finger.{part}.youngs_modulus_mpa is {found:e} MPa, stiffer than diamond; did you mean {} MPa?",
            name_of(path),
            found / PA_A_MPA
        ));
    }
}

/// Warns of a displacement file whose undeformed nodes differ from those of `finger`.
pub fn of_displacements(path: &Path, text: &str, finger: &Finger) {
    if let Some(Elsewhere { node, stated, own }) = of_another_finger(path, text, finger) {
        print_message(format_args!(
            "warning: {}: undeformed node {node} is at ({:.2}, {:.2}) mm in the file, and at ({:.2}, {:.2}) mm in the scene: are these displacements \
             of another finger?",
            name_of(path),
            stated.x,
            stated.y,
            own.x,
            own.y
        ));
    }
}

/// Warns of images that `finray locate` refused; the running command leaves these images out.
pub fn of_refused(refused: &[RefusedImage]) {
    for RefusedImage { image, reason } in refused {
        print_message(format_args!("warning: {image} is left out, because `finray locate` refused it: {reason}"));
    }
}
