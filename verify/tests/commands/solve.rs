//! `finray solve`: from loads to displacements of the key nodes.

use crate::kit::*;

const HEADER: [&str; 6] = ["node", "x_mm", "y_mm", "ux_mm", "uy_mm", "theta_rad"];
/// Relative tolerance between two solutions of one equilibrium: Newton's last correction is below 1e-9 of the solution.
const NEWTON: f64 = 1e-8;
/// A difference that is far above the error of Newton's method for displacements of some millimetres.
const NOTICEABLE_MM: f64 = 1e-4;

fn solve(arguments: &[&str]) -> Csv {
    Csv::of(&finray(&[&["solve", PAPER], arguments].concat()).done())
}

#[test]
fn a_row_a_key_node_in_order_with_the_undeformed_position() {
    let shape = solve(&["--load", "19:-0.38,-1.96"]);
    assert_eq!(shape.header, HEADER);
    assert_eq!(shape.texts("node"), (1..=25).map(|n| n.to_string()).collect::<Vec<_>>());
    let (x, y) = (shape.numbers("x_mm"), shape.numbers("y_mm"));
    let height = (153.0_f64 * 153.0 - 29.0 * 29.0).sqrt();
    for i in 0..=12 {
        let share = i as f64 / 12.0;
        assert_close(&[x[i], y[i]], &[height * share, -29.0 * (1.0 - share)], 1e-14);
        assert_close(&[x[24 - i], y[24 - i]], &[height * share, 29.0 * (1.0 - share)], 1e-14);
    }
    for row in [&shape.rows[0], &shape.rows[24]] {
        assert_eq!(row[3..], ["0.0", "0.0", "0.0"], "clamped");
    }
    // The force pushes the front plate, and with it the whole finger, in the direction -y.
    assert!(shape.numbers("uy_mm")[1..24].iter().all(|u| *u < 0.0));
}

#[test]
fn numbers_are_written_with_full_precision() {
    // Twice the load causes exactly twice the linear displacement, so the test fails if a displacement is written with even one digit too few.
    let one = solve(&["--kinematics", "linear", "--load", "19:-0.17,-0.93,1.1"]);
    let two = solve(&["--kinematics", "linear", "--load", "19:-0.34,-1.86,2.2"]);
    for column in ["ux_mm", "uy_mm", "theta_rad"] {
        let doubled: Vec<f64> = one.numbers(column).iter().map(|x| 2.0 * x).collect();
        assert_eq!(two.numbers(column), doubled);
    }
    // No number is longer than necessary to read back the same value.
    for cell in one.rows.iter().flatten().skip(6).filter(|cell| cell.contains('.')) {
        let number: f64 = cell.parse().expect("a number");
        assert!(cell.len() <= format!("{number:?}").len(), "{cell}");
    }
}

#[test]
fn loads_on_one_node_add_up() {
    for kinematics in ["linear", "corotational", "corotational-chord"] {
        let sum = solve(&["--kinematics", kinematics, "--load", "19:-0.4,-2,5", "--load", "16:0,-0.5"]);
        let parts = ["--load", "19:-0.1,-1.5,4", "--load", "16:0,-0.25", "19:-0.3,-0.5,1", "16:0,-0.25"];
        let parts = solve(&[&["--kinematics", kinematics], &parts[..]].concat());
        assert_close(&displacements(&parts), &displacements(&sum), NEWTON);
    }
}

#[test]
fn an_angle_left_out_is_the_inward_normal() {
    assert_eq!(solve(&["--load-at", "80:2"]), solve(&["--load-at", "80:2,0"]));
    let shape = solve(&["--kinematics", "linear", "--load-at", "76.5:2"]);
    let reference = solve(&["--kinematics", "linear", "--load", &paper_load(19, 2.0, 0.0)]);
    assert_close(&displacements(&shape), &displacements(&reference), LINEAR_ROUNDING);
}

#[test]
fn corotational_kinematics_is_the_default_and_differs_from_the_others() {
    let load = ["--load", "13:-0.4,-2"];
    let with = |kinematics| displacements(&solve(&[&["--kinematics", kinematics], &load[..]].concat()));
    let default = displacements(&solve(&load));
    assert_eq!(default, with("corotational"));
    for other in ["linear", "corotational-chord"] {
        let largest = with(other).iter().zip(&default).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest > NOTICEABLE_MM, "{other} differs by {largest} mm alone");
    }
}

#[test]
fn the_scene_may_come_from_standard_input() {
    let scene = std::fs::read(PAPER).expect("the scene");
    let load = ["--load", "19:0,-1"];
    let piped = finray_reading(&scene, &[&["solve", "-"], &load[..]].concat()).done();
    assert_eq!(Csv::of(&piped), solve(&load));
}

#[test]
fn loads_that_the_finger_cannot_take_are_refused() {
    for (load, expected) in [
        (["--load", "1:0,-1"], "node 1 is clamped"),
        (["--load", "25:0,-1"], "node 25 is clamped"),
        (["--load", "26:0,-1"], "node 26 does not exist: the finger has nodes 1 to 25"),
        (["--load", "0:0,-1"], "node 0 does not exist"),
        (["--load-at", "0:1,0"], "s = 0 mm is not on the front plate"),
        (["--load-at", "153.001:1,0"], "reaches from 0 (clamped) to 153 mm (tip)"),
        (["--load", "19"], "expected NODE:FX,FY or NODE:FX,FY,M"),
        (["--load", "19:1"], "expected NODE:FX,FY or NODE:FX,FY,M"),
        (["--load", "19:1,2,3,4"], "expected NODE:FX,FY or NODE:FX,FY,M"),
        (["--load", "19:1,x"], "expected a finite number, found \"x\""),
        (["--load", "19:1,nan"], "expected a finite number, found \"nan\""),
        (["--load", "19:inf,0"], "expected a finite number, found \"inf\""),
        (["--load", "19:1e999,0"], "expected a finite number, found \"1e999\""),
        (["--load", "tip:1,0"], "expected the number of a node, found \"tip\""),
        (["--load", "-1:1,0"], "-1"),
        (["--load-at", "80"], "expected S_MM:FORCE,ANGLE_DEG"),
        (["--load-at", "80:1,normal"], "expected a finite number, found \"normal\""),
        (["--load-at", "80:1,0,0"], "expected a finite number, found \"0,0\""),
        (["--mesh-nodes", "24"], "expected 25 (one element per member) to 200000 mesh nodes, found 24"),
        (["--mesh-nodes", "200001"], "found 200001"),
        (["--mesh-nodes", "many"], "many"),
        (["--kinematics", "quadratic"], "corotational-chord"),
    ] {
        // A valid load is added, so that the refused load is the only fault.
        let answer = finray(&[&["solve", PAPER, "--load", "19:0,-1"], &load[..]].concat());
        assert_says(&answer.refused(), &[expected]);
    }
    assert_says(&finray(&["solve", PAPER]).refused(), &["--load NODE:FX,FY", "--load-at S_MM:FORCE,ANGLE_DEG"]);
}

/// The message names the share of the load up to which there is an equilibrium. `solve` succeeds just below the named share of the load, and fails
/// just above it.
#[test]
fn without_equilibrium_the_last_share_of_the_load_is_named() {
    let [fx, fy] = paper_force(200.0, 0.0);
    let load = |share: f64| format!("19:{},{}", share * fx, share * fy);
    let message = finray(&["solve", PAPER, "--load", &load(1.0)]).failed();
    assert_says(&message, &["no stable equilibrium", "% of the load"]);
    let percent = message.split_once("beyond ").and_then(|(_, rest)| rest.split_once(" %")).expect("a share").0;
    let share = percent.parse::<f64>().expect("a number") / 100.0;
    assert!(share > 0.01 && share < 1.0, "{message}");
    // Just below the largest load with an equilibrium, the strains are large, so `solve` warns.
    finray(&["solve", PAPER, "--load", &load(0.999 * share)]).warned();
    finray(&["solve", PAPER, "--load", &load(1.001 * share)]).failed();
    // The linear finger carries any load.
    finray(&["solve", PAPER, "--kinematics", "linear", "--load", &load(1.0)]).warned();
}

/// On the mesh of the key nodes, a long member near the base buckles only at a larger load, and displacements are a tenth of those on a fine mesh.
/// Once, no warning said so.
#[test]
fn a_mesh_that_is_too_coarse_is_warned_of() {
    let folder = Folder::new();
    let plate = "thickness_mm = 1.0\nyoungs_modulus_mpa = 50.0\n";
    let scene = format!(
        "name = \"zigzag\"\n[finger]\nbase_width_mm = 60.0\nfront_length_mm = 120.0\nback_length_mm = 150.0\ndepth_mm = 20.0\n\
         [finger.front]\n{plate}[finger.back]\n{plate}[finger.ribs]\njoints = \"rigid\"\n{plate}\
         positions_mm = [[25.0, 0.0], [25.0, 42.0], [55.0, 42.0], [55.0, 80.0], [84.0, 80.0], [84.0, 116.0]]\n"
    );
    let scene = folder.put("scene.toml", scene);
    let load = ["--load-at", "14.5833:3,-40"];
    let on = |nodes: &str| finray(&[&["solve", &scene, "--mesh-nodes", nodes], &load[..]].concat()).warned();
    let largest_mm = |csv: &str| displacements(&Csv::of(csv)).into_iter().map(f64::abs).fold(0.0, f64::max);
    let (coarse, warnings) = finray(&[&["solve", &scene], &load[..]].concat()).warned();
    let told =
        warnings.iter().find(|warning| warning.contains("the mesh of the key nodes is too coarse")).expect("a warning");
    let advice = told.rsplit_once("choose ").and_then(|(_, advice)| advice.split_once(" mesh nodes"));
    let (advised, _) = advice.expect("advice");
    let (fine, warnings) = on(advised);
    assert!(largest_mm(&fine) > 5.0 * largest_mm(&coarse));
    assert!(!warnings.iter().any(|warning| warning.contains("too coarse")), "the mesh was chosen: {warnings:?}");
    finray(&[&["solve", PAPER], &load[..]].concat()).done();
}
