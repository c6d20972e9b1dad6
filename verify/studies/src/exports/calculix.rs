//! Fingers as plane continua in plane strain, solved by CalculiX: plates and ribs with their thickness, and rods, if any, as stiff discs.
//! Poisson's ratio is 0.45, for `unequal` 0.35, for `short-plain` 0.4. `fixtures/calculix/README.md` describes the export and its accuracy.

use super::{ExportedFinger, Program, Solved};

/// The paper's finger with rods of 2.5 mm diameter.
pub const PAPER: ExportedFinger = ExportedFinger {
    name: "paper",
    scene: finray_fixtures::CONTINUUM_PAPER_SCENE,
    csv: finray_fixtures::CONTINUUM_PAPER,
};
/// The paper's finger without rods: plates and ribs in one piece.
pub const PAPER_PLAIN: ExportedFinger = ExportedFinger {
    name: "paper-plain",
    scene: finray_fixtures::CONTINUUM_PAPER_PLAIN_SCENE,
    csv: finray_fixtures::CONTINUUM_PAPER_PLAIN,
};

/// CalculiX's fingers. From `wide-rods` on, they are solved at some nodes or under two forces. The rules for arms were fitted to `paper`, `thick`,
/// `paper-plain` and `thick-plain`.
pub const PROGRAM: Program = Program {
    name: "CalculiX",
    fingers: &[
        PAPER,
        PAPER_PLAIN,
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
    ],
    solved: Solved::Continuum,
};
