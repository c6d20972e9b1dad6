//! What a scene says that is possible, and hardly meant.

use finray_model::Finger;
use finray_verify::files::name_of;
use std::path::Path;

/// Young's modulus of diamond, MPa, rounded down: what is stiffer is in another unit.
const STIFFEST_MPA: f64 = 1e6;
const PA_A_MPA: f64 = 1e6;

/// Warns of moduli that are more likely in Pa than in MPa.
pub fn of_moduli(path: &Path, finger: &Finger) {
    let description = finger.description();
    let plates = [("front", description.front.youngs_modulus_mpa), ("back", description.back.youngs_modulus_mpa)];
    let ribs = description.ribs.strip.map(|strip| ("ribs", strip.youngs_modulus_mpa));
    for (part, found) in plates.into_iter().chain(ribs).filter(|(_, found)| *found > STIFFEST_MPA) {
        eprintln!(
            "warning: {}: finger.{part}.youngs_modulus_mpa is {found:e} MPa, stiffer than diamond; did you mean {} MPa?",
            name_of(path),
            found / PA_A_MPA
        );
    }
}
