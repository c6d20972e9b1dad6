//! Beams against plane continua, as `fixtures/calculix/README.md` states.

use finray_model::Mesh;
use finray_studies::claims::criteria::MOST_OF;
use finray_studies::experiments::continuum::{Constants, Deviation, deviations, tables_one};
use finray_studies::exports::ExportedFinger;
use finray_studies::exports::calculix::{PAPER_PLAIN, PROGRAM};
use finray_studies::statistics::median;
use finray_studies::truths::fine_mesh;
use finray_tests::paper;

/// Deviations of README are rounded to 0.01 %. Its arms are exact, those of the scenes rounded to 0.001 mm; 0.25 mm are 5 %, so 0.0005 mm are 0.01 %.
const ROUNDING: f64 = 2e-4;
/// README rounds deviations above 20 % to 0.1 %.
const COARSE_ROUNDING: f64 = 6e-4;

/// Name, forces, and median and largest deviation of README: beams with arms by the rule; E / (1 - nu^2) without arms.
const README: [(&str, usize, [f64; 2], [f64; 2]); 6] = [
    ("paper", 165, [0.0028, 0.0254], [0.267, 0.353]),
    ("paper-plain", 54, [0.0070, 0.0472], [0.0465, 0.0628]),
    ("asymmetric", 54, [0.0113, 0.0179], [0.441, 0.681]),
    ("thick", 54, [0.0084, 0.0552], [0.258, 0.316]),
    ("thin", 53, [0.0019, 0.0103], [0.229, 0.465]),
    ("soft-zone", 54, [0.0070, 0.0282], [0.358, 0.470]),
];

fn exported(name: &str) -> &'static ExportedFinger {
    PROGRAM.fingers.iter().chain([&PAPER_PLAIN]).find(|exported| exported.name == name).expect("a finger")
}

fn compared(
    exported: &ExportedFinger,
    constants: Constants,
    mesh: impl Fn(&finray_model::Finger) -> Mesh,
) -> Vec<Deviation> {
    let finger = constants.of(&exported.finger().expect("a scene")).expect("a finger");
    deviations(exported, &mesh(&finger)).expect("a table")
}

fn fine(finger: &finray_model::Finger) -> Mesh {
    fine_mesh(finger).expect("a mesh")
}

/// `[median, largest]` of the deviations.
fn figures(found: &[Deviation]) -> [f64; 2] {
    let shares = || found.iter().map(|deviation| deviation.displacement);
    [median(shares()).expect("cases"), shares().fold(0.0, f64::max)]
}

#[test]
fn beams_with_arms_are_as_near_to_continua_as_stated() {
    for (name, cases, with_arms, _) in README {
        let found = compared(exported(name), Constants::Arms, fine);
        assert_eq!(found.len(), cases, "{name}: beams carry every force");
        let ours = figures(&found);
        for (ours, stated) in ours.iter().zip(with_arms) {
            assert!((ours - stated).abs() < ROUNDING, "{name}: {ours}, not {stated}");
        }
    }
}

#[test]
fn beams_without_arms_are_as_far_from_continua_as_stated() {
    for (name, _, _, without_arms) in README {
        let ours = figures(&compared(exported(name), Constants::PlaneStrain, fine));
        for (ours, stated) in ours.iter().zip(without_arms) {
            assert!((ours - stated).abs() < COARSE_ROUNDING, "{name}: {ours}, not {stated}");
        }
    }
    let ours = figures(&compared(exported("paper"), Constants::Modulus, fine));
    assert!(
        (ours[0] - 0.594).abs() < COARSE_ROUNDING && (ours[1] - 0.739).abs() < COARSE_ROUNDING,
        "E alone: {ours:?}"
    );
}

/// On the continuum the paper's protocol finds a stiffer finger and senses it within some per cent; the paper's finger was sensed 56 % too strong at
/// node 14, 12 % at 16 and 20 % at 24. The bound is the report's criterion for a cause.
#[test]
fn the_continuum_does_not_explain_the_papers_errors_at_tip_and_base() {
    let tables = tables_one(&paper()).expect("every force has a shape");
    assert_eq!(tables.iter().map(|table| table.angle_deg).collect::<Vec<_>>(), [-20.0, 0.0, 20.0]);
    for table in &tables {
        for row in table.rows.iter().filter(|row| [14, 16, 24].contains(&row.node)) {
            assert_eq!(row.errors.len(), 3);
            assert!(row.mean_error < MOST_OF * row.paper_mean_error, "{} deg: {row:?}", table.angle_deg);
        }
        let tip = table.rows.iter().find(|row| row.node == 14).expect("node 14");
        assert!(tip.errors.iter().all(|error| *error < 0.0), "{tip:?}");
    }
    // `finray calibrate --kinematics linear` with the table's cases at nodes 17, 19 and 21 finds 74.197 MPa instead of 47.976.
    assert!((tables[1].modulus_factor - 74.197 / 47.976).abs() < 1e-4, "{}", tables[1].modulus_factor);
}
