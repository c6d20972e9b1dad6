//! The command `finray gripper`.

use super::kit::{Csv, Folder, assert_says, finray, finray_reading};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/gripper.toml");

fn scene() -> String {
    std::fs::read_to_string(SCENE).unwrap()
}

#[test]
fn a_row_a_motor_angle_satisfies_the_papers_equations() {
    let csv = Csv::of(&finray(&["gripper", SCENE, "--motor-deg", "-720:720:360"]).computed());
    assert_eq!(csv.numbers("motor_deg"), [-720.0, -360.0, 0.0, 360.0, 720.0]);
    assert_eq!(csv.numbers("slider_mm"), [12.0, 16.0, 20.0, 24.0, 28.0]);
    assert_eq!(csv.texts("state"), ["regular"; 5]);
    let [phi1, phi2] = ["phi1_rad", "phi2_rad"].map(|column| csv.numbers(column));
    for (i, slider_mm) in csv.numbers("slider_mm").into_iter().enumerate() {
        assert!((40.0 * phi2[i].cos() - 25.0 * phi1[i].cos() - 30.0).abs() < 1e-12);
        assert!((25.0 * phi1[i].sin() + 40.0 * phi2[i].sin() - slider_mm).abs() < 1e-12);
        assert!((csv.numbers("base_x_mm")[i] + 25.0 * phi1[i].cos()).abs() < 1e-12);
        assert!((csv.numbers("base_y_mm")[i] - 25.0 * phi1[i].sin()).abs() < 1e-12);
    }
    assert_eq!(csv.numbers("angle_rad"), phi2);
}

#[test]
fn beyond_the_links_a_row_says_out_of_reach() {
    let csv = Csv::of(&finray(&["gripper", SCENE, "--motor-deg", "36000"]).computed());
    assert_eq!((csv.texts("state"), csv.texts("opening_mm")), (vec!["out of reach"], vec![""]));
}

#[test]
fn an_opening_finds_its_motor_angle() {
    let csv = Csv::of(&finray(&["gripper", SCENE, "--opening-mm", "60"]).computed());
    assert!((csv.numbers("opening_mm")[0] - 60.0).abs() < 1e-9);
    let too_far = finray(&["gripper", SCENE, "--opening-mm", "1000"]).refused();
    assert_says(&too_far, &["--opening-mm", "1000"]);
}

#[test]
fn without_options_the_whole_reach_is_written() {
    let csv = Csv::of(&finray(&["gripper", SCENE]).computed());
    assert!(csv.numbers("motor_deg").contains(&0.0));
    assert!(csv.texts("state").iter().all(|state| *state != "out of reach"));
    assert!(csv.numbers("slider_mm").iter().copied().fold(0.0, f64::max) > 57.0);
}

#[test]
fn bad_linkages_and_options_are_refused() {
    for (from, to, expected) in [
        ("link_mm = [25.0, 40.0]", "link_mm = [2.0, 4.0]", ["gripper.link_mm: ", "36.06 mm"]),
        ("link_mm = [25.0, 40.0]", "link_mm = [25.0, -40.0]", ["link_mm", "above zero"]),
        ("screw_pitch_mm = 4.0", "screw_pitch_mm = 0.0", ["screw_pitch_mm", "above zero"]),
        ("fixed_joint_mm = 30.0", "fixed_joint_mm = nan", ["fixed_joint_mm", "above zero"]),
        ("slider_mm = 20.0 ", "slider_mm = inf ", ["slider_mm", "height"]),
        ("slider_mm = 20.0 ", "", ["slider_mm", "missing"]),
        ("slider_mm = 20.0 ", "slider = 20.0 ", ["slider", "slider_mm"]),
    ] {
        assert_eq!(scene().matches(from).count(), 1);
        let message = finray_reading(scene().replace(from, to).as_bytes(), &["gripper", "-"]).refused();
        assert_says(&message, &expected);
        assert_says(&message, &["line "]);
    }
    for angles in ["0:360:-10", "0:1:0", "a", "1:2", "0:1e9:0.001"] {
        finray(&["gripper", SCENE, "--motor-deg", angles]).refused();
    }
    let folder = Folder::new();
    let paper = folder.put("paper.toml", scene().split("[gripper]").next().unwrap());
    assert_says(&finray(&["gripper", &paper]).refused(), &["[gripper]", "screw_pitch_mm"]);
}

/// Each cause of error has a column. A motor angle and a play whose errors move the nut by the same standard deviation cause the same error. The
/// option requires three numbers.
#[test]
fn errors_of_the_linkage_are_appended() {
    let rows = finray(&["gripper", SCENE, "--motor-deg", "0", "--errors", "3.6,0.138564064605510,0.05"]).computed();
    let rows = Csv::of(&rows);
    let of = |column: &str| rows.numbers(column)[0];
    // 3.6 degrees move the screw by 0.04 mm, which is also the standard deviation of the play.
    assert!((of("motor_error_mm") / of("backlash_error_mm") - 1.0).abs() < 1e-9);
    assert!(of("rocker_error_mm") > 0.05 && of("link_error_mm") > 0.05 && of("fixed_joint_error_mm") > 0.05);
    let message = finray(&["gripper", SCENE, "--errors", "1,2"]).refused();
    assert_says(&message, &["expected three numbers, DEG,MM,MM, found 2"]);
}
