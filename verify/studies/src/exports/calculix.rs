//! Fingers as plane continua in plane strain, solved by CalculiX: plates and ribs with their thickness, and rods, if any, as stiff discs.
//! Poisson's ratio is 0.45, for `unequal` 0.35, for `short-plain` 0.4. `fixtures/calculix/README.md` describes the export and its accuracy.

use super::{ExportedFinger, Program};
use finray_model::finger::{Finger, FingerDescription};

/// The paper's finger with rods of 2.5 mm diameter.
pub const PAPER: ExportedFinger = ExportedFinger {
    name: "paper",
    scene: finray_fixtures::CONTINUUM_PAPER_SCENE,
    csv: finray_fixtures::CONTINUUM_PAPER,
};
/// The paper's finger without rods: plates and ribs in one piece. A [`Finger`] does not state the radius of its rods, so [`PROGRAM`] does not contain
/// this finger.
pub const PAPER_PLAIN: ExportedFinger = ExportedFinger {
    name: "paper-plain",
    scene: finray_fixtures::CONTINUUM_PAPER_PLAIN_SCENE,
    csv: finray_fixtures::CONTINUUM_PAPER_PLAIN,
};

/// Further fingers with and without rods, solved at some nodes or under two forces. They are not used as true fingers. `thick-plain` determined the
/// rule for arms without rods; the others only test the rules for arms.
pub const FURTHER: [ExportedFinger; 8] = [
    ExportedFinger {
        name: "wide-rods",
        scene: finray_fixtures::CONTINUUM_WIDE_RODS_SCENE,
        csv: finray_fixtures::CONTINUUM_WIDE_RODS,
    },
    ExportedFinger {
        name: "thin-ribs",
        scene: finray_fixtures::CONTINUUM_THIN_RIBS_SCENE,
        csv: finray_fixtures::CONTINUUM_THIN_RIBS,
    },
    ExportedFinger {
        name: "unequal",
        scene: finray_fixtures::CONTINUUM_UNEQUAL_SCENE,
        csv: finray_fixtures::CONTINUUM_UNEQUAL,
    },
    ExportedFinger {
        name: "hinged-feet",
        scene: finray_fixtures::CONTINUUM_HINGED_FEET_SCENE,
        csv: finray_fixtures::CONTINUUM_HINGED_FEET,
    },
    ExportedFinger {
        name: "blunt",
        scene: finray_fixtures::CONTINUUM_BLUNT_SCENE,
        csv: finray_fixtures::CONTINUUM_BLUNT,
    },
    ExportedFinger {
        name: "thick-plain",
        scene: finray_fixtures::CONTINUUM_THICK_PLAIN_SCENE,
        csv: finray_fixtures::CONTINUUM_THICK_PLAIN,
    },
    ExportedFinger {
        name: "short-plain",
        scene: finray_fixtures::CONTINUUM_SHORT_PLAIN_SCENE,
        csv: finray_fixtures::CONTINUUM_SHORT_PLAIN,
    },
    ExportedFinger {
        name: "stout-plain",
        scene: finray_fixtures::CONTINUUM_STOUT_PLAIN_SCENE,
        csv: finray_fixtures::CONTINUUM_STOUT_PLAIN,
    },
];

/// CalculiX's fingers, all with rods. An export applies to a finger if both have the same drawing; Poisson's ratio, rod arms, shear correction and a
/// common factor on all moduli may differ.
pub const PROGRAM: Program = Program {
    name: "CalculiX",
    fingers: &[
        PAPER,
        ExportedFinger {
            name: "asymmetric",
            scene: finray_fixtures::CONTINUUM_ASYMMETRIC_SCENE,
            csv: finray_fixtures::CONTINUUM_ASYMMETRIC,
        },
        ExportedFinger {
            name: "thick",
            scene: finray_fixtures::CONTINUUM_THICK_SCENE,
            csv: finray_fixtures::CONTINUUM_THICK,
        },
        ExportedFinger {
            name: "thin",
            scene: finray_fixtures::CONTINUUM_THIN_SCENE,
            csv: finray_fixtures::CONTINUUM_THIN,
        },
        ExportedFinger {
            name: "soft-zone",
            scene: finray_fixtures::CONTINUUM_SOFT_ZONE_SCENE,
            csv: finray_fixtures::CONTINUUM_SOFT_ZONE,
        },
        ExportedFinger {
            name: "hinged",
            scene: finray_fixtures::CONTINUUM_HINGED_SCENE,
            csv: finray_fixtures::CONTINUUM_HINGED,
        },
        ExportedFinger {
            name: "hinged-rigid",
            scene: finray_fixtures::CONTINUUM_HINGED_RIGID_SCENE,
            csv: finray_fixtures::CONTINUUM_HINGED_RIGID,
        },
    ],
    is_exported: has_drawing_of,
    ignored: ". The continuum keeps the E and nu with which it was exported; in the scene, poissons_ratio, rod_arm_mm, rib_arm_mm, clamp_arm_mm, fillet_mm, \
        shear_correction and a common factor on all moduli may differ",
};

/// Relative tolerance of ratios of moduli: each modulus is rounded when a common factor multiplies it, and a scene file keeps about fifteen digits.
const SAME_RATIO: f64 = 1e-12;

/// Whether two fingers differ at most in parameters of the beam model: Poisson's ratio, rod arms, shear correction, and a common factor on all
/// moduli.
fn has_drawing_of(finger: &Finger, exported: &Finger) -> bool {
    let moduli = [finger, exported].map(|finger| moduli_mpa(finger.description()));
    let factor = moduli[0][0] / moduli[1][0];
    let is_scaled = |[ours, theirs]: [f64; 2]| (ours - factor * theirs).abs() <= SAME_RATIO * ours;
    moduli[0].len() == moduli[1].len()
        && moduli[0].iter().zip(&moduli[1]).all(|(ours, theirs)| is_scaled([*ours, *theirs]))
        && without_material(finger) == without_material(exported)
}

/// Young's moduli of front plate, back plate and deformable ribs, MPa.
fn moduli_mpa(description: &FingerDescription) -> Vec<f64> {
    let strips = [Some(description.front), Some(description.back), description.ribs.strip];
    strips.into_iter().flatten().map(|strip| strip.youngs_modulus_mpa).collect()
}

fn without_material(finger: &Finger) -> FingerDescription {
    let drawn = finger.description().clone();
    let mut description = FingerDescription {
        poissons_ratio: 0.0,
        rod_arm_mm: 0.0,
        rib_arm_mm: None,
        clamp_arm_mm: None,
        fillets: None,
        shear_correction: 0.0,
        ..drawn
    };
    for strip in [Some(&mut description.front), Some(&mut description.back), description.ribs.strip.as_mut()]
        .into_iter()
        .flatten()
    {
        strip.youngs_modulus_mpa = 1.0;
    }
    description
}
