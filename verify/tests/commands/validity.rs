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

/// The paper's finger under the paper's forces is within the limits.
#[test]
fn small_strains_go_without_a_word() {
    for node in [14, 16, 19, 22, 24] {
        finray(&["solve", PAPER, "--load", &paper_load(node, 3.0, 0.0)]).done();
        finray(&["solve", PAPER, "--load", &paper_load(node, 3.0, 0.0), "--mesh-nodes", "684"]).done();
    }
    finray(&["solve", SPRING_STEEL, "--load-at", "80:0.2,0"]).done();
}

/// A strain limit that the scene states for the material of a part replaces the default; this holds for every part.
#[test]
fn a_material_states_its_own_limit() {
    let folder = Folder::new();
    let load = paper_load(19, 3.0, 0.0);
    for part in ["front", "back", "ribs"] {
        let table = format!("[finger.{part}]");
        let with = |limit: &str| {
            folder.put("scene.toml", paper_with(&[(&table, &format!("{table}\nlargest_strain = {limit}"))]))
        };
        let (_, warnings) = finray(&["solve", &with("1e-4"), "--load", &load]).warned();
        assert_eq!(warnings.len(), 1);
        assert_says(
            &warnings[0],
            &["above the limit of 0.01 %", &format!("finger.{part}.largest_strain of the scene")],
        );
        finray(&["solve", &with("0.2"), "--load", &load]).done();
        for (limit, found) in [("0.0", "0.0"), ("-0.1", "-0.1"), ("1.5", "1.5"), ("nan", "NaN")] {
            let message = finray(&["solve", &with(limit), "--load", &load]).refused();
            let key = format!("finger.{part}.largest_strain: expected a strain above 0 and up to 1, found {found}");
            assert_says(&message, &["scene.toml: line ", &key]);
        }
    }
    // The stated limit is above the strain of the flat finger, so only its depth causes a warning.
    let flat = flat().replace("youngs_modulus_mpa = 47.976", "youngs_modulus_mpa = 47.976\nlargest_strain = 0.9");
    let scene = folder.put("flat.toml", flat);
    let load = paper_load(19, FLAT_N, 0.0);
    let (_, warnings) = finray(&["solve", &scene, "--load", &load, "--kinematics", "linear"]).warned();
    assert!(warnings.len() == 1 && warnings[0].contains("depth over thickness"), "{warnings:?}");
}

/// In members whose thickness is similar to their length, shear deformation matters.
#[test]
fn thick_members_are_warned_of() {
    let folder = Folder::new();
    let scene = folder.put("thick.toml", paper_with(&[("thickness_mm = 1.5", "thickness_mm = 6.0")]));
    let (_, warnings) = finray(&["solve", &scene, "--load", &paper_load(19, 3.0, 0.0)]).warned();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert_says(
        &warnings[0],
        &["shear, which Euler-Bernoulli beams neglect", "limit 5 %", "length / thickness", "finger.shear_correction"],
    );
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
            "sense",
            scene,
            "--displacements",
            &shape,
            "--contact",
            "19",
            "--estimator",
            estimator,
            "--noise-mm",
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
        "sense",
        PAPER,
        "--displacements",
        &shape,
        "--contact",
        "19",
        "--estimator",
        "nonlinear",
        "--noise-mm",
        "0.067",
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
