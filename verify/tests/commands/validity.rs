//! Warnings of the commands where the beam model does not hold.

use crate::kit::*;

/// The paper's finger with a depth of 0.4 um. The flat finger has the same strains as the paper's finger under a force that is 50 000 times as large.
fn flat() -> String {
    paper_with(&[("depth_mm = 20.0", "depth_mm = 0.0004")])
}

/// A force, N, that causes a strain of 16 % in the flat finger with linear kinematics. At node 19, 3 N cause a strain of 3.89 % in the paper's
/// finger.
const FLAT_N: f64 = 2.5e-4;

/// The percentage of strain in a warning, such as 16 in "not small: 16 % at".
#[track_caller]
fn strain_percent(warnings: &[String]) -> f64 {
    let said = warnings.iter().find_map(|line| line.split("strains are not small: ").nth(1));
    let said = said.unwrap_or_else(|| panic!("no strain in {warnings:?}"));
    said.split(' ').next().and_then(|number| number.parse().ok()).expect("a number")
}

#[test]
fn a_smooth_answer_at_large_strain_is_warned_of() {
    let folder = Folder::new();
    let scene = folder.put("flat.toml", flat());
    for (kinematics, force_n, least_percent) in [("linear", FLAT_N, 15.5), ("corotational", 0.5 * FLAT_N, 5.0)] {
        let load = paper_load(19, force_n, 0.0);
        let (out, warnings) = finray(&["solve", &scene, "--load", &load, "--kinematics", kinematics]).warned();
        assert_eq!(Csv::of(&out).rows.len(), 25, "the shape is written all the same");
        assert!(strain_percent(&warnings) > least_percent, "{warnings:?}");
        assert_says(
            &warnings.join("\n"),
            &["above the limit of 5 %", "largest_strain", "between nodes", "depth over thickness is 2.67e-4"],
        );
    }
}

/// Like the loads of `solve`, the forces sensed by every estimator are checked against the limits of the beam model.
#[test]
fn sensed_forces_are_judged() {
    let folder = Folder::new();
    let soft = folder.put("soft.toml", paper_with(&[("youngs_modulus_mpa = 47.976", "youngs_modulus_mpa = 25.0")]));
    let load = paper_load(19, 3.0, 0.0);
    let (shape, solved) = finray(&["solve", &soft, "--load", &load, "--mesh-nodes", "133"]).warned();
    let shape = folder.put("shape.csv", shape);
    let sense = |scene: &str, estimator: &str| {
        finray(&[
            "sense", scene, "--displacements", &shape, "--contact", "19", "--estimator", estimator, "--noise-mm",
            "0.067",
        ])
    };
    let (_, sensed) = sense(&soft, "nonlinear").warned();
    // The sensed force agrees with the load to 0.2 %, the error of the estimator, which may change the rounded percentage.
    assert!(
        (strain_percent(&sensed) - strain_percent(&solved)).abs() <= 0.05 * strain_percent(&solved),
        "{sensed:?} against {solved:?}"
    );
    for linear in ["least-squares", "ridge"] {
        let (_, warnings) = sense(&soft, linear).warned();
        assert!(warnings.iter().any(|warning| warning.contains("strains are not small")), "{linear}: {warnings:?}");
    }
    let paper = finray(&["solve", PAPER, "--load", &load]).done();
    let shape = folder.put("shape.csv", paper);
    finray(&[
        "sense", PAPER, "--displacements", &shape, "--contact", "19", "--estimator", "nonlinear", "--noise-mm", "0.067",
    ])
    .done();
}

/// The warning names the step of the press with the largest strain.
#[test]
fn a_pressed_finger_is_judged() {
    let folder = Folder::new();
    let disc = "\n[object]\nshape = \"disc\"\nradius_mm = 20\nat_mm = 74\ntravel_mm = 6\nsteps = 2\n";
    let press = |scene: String| {
        let scene = folder.put("scene.toml", scene + disc);
        finray(&["press", &scene, "--fineness", "1"])
    };
    press(paper_with(&[])).done();
    let limited = "[finger.front]\nlargest_strain = 1e-4";
    let (_, warnings) = press(paper_with(&[("[finger.front]", limited)])).warned();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert_says(&warnings[0], &["warning: step 2: strains are not small", "finger.front.largest_strain of the scene"]);
}

/// Each command that computes with the finger warns once of unstated side faces, unless the scene states them or calibrated moduli absorb them.
#[test]
fn unstated_side_faces_are_warned_of_once() {
    let folder = Folder::new();
    let printed = include_str!("../../../fixtures/calculix/paper.toml");
    let stated = folder.put("stated.toml", printed);
    let unstated = folder.put("unstated.toml", printed.replace("side_faces = \"fixed\"\n", ""));
    let load = paper_load(19, 0.5, 0.0);
    let shape = folder.put("shape.csv", finray(&["solve", &stated, "--load", &load]).done());
    let sense = |scene| finray(&["sense", scene, "--displacements", &shape, "--contact", "19", "--noise-mm", "0.05"]);
    let sensed = sense(&stated);
    let summary = "done: 1 force sensed; sigma_n includes a model error of 0.6 % (fingers with rods: 0.6 %)";
    assert_eq!(sensed.summary.as_deref(), Some(summary));
    sensed.done();
    let map = ["map", &unstated, "--places", "2", "--step-deg", "90", "--seeds", "1", "--estimator", "least-squares"];
    for answer in [finray(&["solve", &unstated, "--load", &load]), sense(&unstated), finray(&map)] {
        let (_, warnings) = answer.warned();
        let about = warnings.iter().filter(|line| line.contains("finger.side_faces is not stated")).count();
        assert_eq!((warnings.len(), about), (1, 1), "{warnings:?}");
    }
    let weights = folder.put("weights.csv", weighed(&stated, &[], &[(19, paper_force(0.5, 0.0))]));
    finray(&["calibrate", &unstated, "--measurements", &weights]).done();
}
