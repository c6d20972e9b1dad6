//! Contacts that cannot be sensed.

use super::{LEAST_SQUARES, TRUTH, linear_shape, sense_text};
use crate::kit::*;

#[test]
fn contacts_that_cannot_be_sensed_are_refused() {
    let shape = linear_shape(&TRUTH);
    for (contacts, expected) in [
        (vec![], "expected at least one contact"),
        (vec!["--contact", "1"], "node 1 is clamped"),
        (vec!["--contact", "25"], "node 25 is clamped"),
        (vec!["--contact", "26"], "node 26 does not exist"),
        (vec!["--contact", "0"], "node 0 does not exist"),
        (vec!["--contact", "12"], "contacts lie on the front plate, nodes 13 (tip) to 24"),
        (vec!["--contact", "19", "--contact", "2"], "node 2 is not a contact node"),
        (vec!["--contact", "19", "20", "19"], "contacts 1 and 3 have the same position and direction"),
        (vec!["--contact", "19@5", "19@5.0"], "contacts 1 and 2 have the same position and direction"),
        (vec!["--contact", "19", "--contact-at", "76.5"], "contacts 1 and 2 have the same position and direction"),
        // A force and the opposite force at one node are the same unknown.
        (vec!["--contact", "19", "19@180"], "not identifiable"),
        (vec!["--contact", "19", "19@360"], "not identifiable"),
        (vec!["--contact", "19", "19@30", "19@60"], "not identifiable"),
        (vec!["--contact-at", "0"], "s = 0 mm is not on the front plate"),
        (vec!["--contact-at", "153.1"], "s = 153.1 mm is not on the front plate"),
        (vec!["--contact-at", "1e-300"], "not identifiable"),
        (vec!["--contact-at", "back:0"], "s = 0 mm is not on the back plate"),
        (vec!["--contact-at", "back:153.1"], "s = 153.1 mm is not on the back plate"),
        (vec!["--contact-at", "back:auto@0"], "unknown positions lie on the front plate, found \"auto\""),
        (vec!["--contact-at", "side:3"], "after `back:` if it lies on the back plate, found \"side:3\""),
        (vec!["--contact-at", "back:x"], "expected a finite number, found \"x\""),
        (vec!["--contact-at", "back:60", "back:60@0.0"], "contacts 1 and 2 have the same position and direction"),
        (
            vec!["--contact-at", "back:60", "--estimator", "network"],
            "no network ships for these contacts (back:60 mm@0)",
        ),
        (vec!["--contact", "19@normal"], "`object` or `auto` needs the estimator nonlinear"),
        (vec!["--contact", "19@auto"], "`object` or `auto` needs the estimator nonlinear"),
        (vec!["--contact-at", "auto"], "`object` or `auto` needs the estimator nonlinear"),
        (
            vec!["--contact", "19@nan"],
            "expected an angle in degrees, `normal`, `friction`, `object`, `measured` or `auto`",
        ),
        (
            vec!["--contact", "19@"],
            "expected an angle in degrees, `normal`, `friction`, `object`, `measured` or `auto`",
        ),
        (vec!["--contact", "19@object"], "expected a table [contact.object] in the scene"),
        (vec!["--contact", "19@friction"], "expected friction or friction_range in the scene's table [contact]"),
        (vec!["--contact", "tip"], "expected the number of a node, found \"tip\""),
        (vec!["--contact", "19", "--noise-mm=-0.1"], "expected zero or more"),
        (vec!["--contact", "19", "--noise-mm", "nan"], "expected a finite number"),
        (vec!["--contact", "19", "--estimator", "guess"], "least-squares"),
    ] {
        assert_says(&sense_text(&shape, &contacts).refused(), &[expected]);
    }
}

#[test]
fn a_contact_on_the_rigid_arm_of_the_clamp_moves_nothing() {
    let folder = Folder::new();
    let scene = folder.put("scene.toml", paper_with(&[("depth_mm = 20.0", "depth_mm = 20.0\nrod_arm_mm = 2.0")]));
    let shape = linear_shape(&TRUTH);
    for contacts in [vec!["--contact-at", "1.5"], vec!["--contact", "19", "--contact-at", "1.5"]] {
        let all = [&["sense", &scene, "--displacements", "-"], &LEAST_SQUARES[..], &contacts[..]].concat();
        let message = finray_reading(shape.as_bytes(), &all).refused();
        assert_says(&message, &["not identifiable", &format!("least of all at contact {}", contacts.len() / 2)]);
        assert!(!message.contains("NaN"), "{message}");
    }
}

/// For a true force of 2 N and a wrong contact without stated noise, `sense` once stated 3.27 +- 0.22 N without a warning. Now the warning states the
/// residual; the correct contact causes no warning.
#[test]
fn a_wrong_contact_without_stated_noise_is_no_silent_answer() {
    let shape = finray(&["solve", PAPER, "--load", "19:0,-2"]).done();
    let at =
        |node: &str| finray_reading(shape.as_bytes(), &["sense", PAPER, "--displacements", "-", "--contact", node]);
    let (_, warnings) = at("15").warned();
    assert_says(&warnings.concat(), &["the residual is 1.9", "no noise is stated", "noise_mm"]);
    assert_eq!(at("19").err, "");
}

/// For a contact `auto` without a direction, `sense` once assumed the normal direction without a message.
#[test]
fn an_unknown_position_without_a_direction_says_which_is_taken() {
    let shape = finray(&["solve", PAPER, "--load-at", "80:1,0"]).done();
    let at = |contact: &str| {
        let all = ["sense", PAPER, "--displacements", "-", "--noise-mm", "0.01", "--contact-at", contact];
        finray_reading(shape.as_bytes(), &all)
    };
    assert_says(&at("auto").err, &["note: `auto` has no direction", "auto@auto"]);
    assert_eq!(at("auto@0").err, "");
}

/// With one range of positions, `--alternatives` writes the answer of `sense`.
#[test]
fn alternatives_need_an_unknown_position() {
    let shape = finray(&["solve", PAPER, "--load-at", "80:1,0"]).done();
    let at = |further: &[&str]| {
        let all = ["sense", PAPER, "--displacements", "-", "--noise-mm", "0.01", "--contact-at"];
        finray_reading(shape.as_bytes(), &[&all[..], further].concat())
    };
    let refused = at(&["80", "--alternatives"]).refused();
    assert_says(&refused, &["--alternatives: expected a contact at an unknown position"]);
    let [plain, listed] = [at(&["auto@0"]), at(&["auto@0", "--alternatives"])].map(|answer| Csv::of(&answer.done()));
    for column in ["s_mm", "angle_deg", "force_n", "low_n", "high_n", "s_low_mm", "s_high_mm"] {
        assert_eq!(plain.texts(column), listed.texts(column), "{column}");
    }
    assert_eq!(listed.texts("excess_misfit"), ["0.0"]);
}
