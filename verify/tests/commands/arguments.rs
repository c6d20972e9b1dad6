//! The command line: help, completions and unknown arguments.

use crate::kit::*;

const GRIPPER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/gripper.toml");
const COMMANDS: [&str; 6] = ["report", "solve", "sense", "calibrate", "map", "sweep"];

#[test]
fn every_command_explains_itself() {
    let help = finray(&["--help"]).done();
    assert_says(&help, &COMMANDS);
    assert_eq!(finray(&["help", "--help"]).done(), help);
    assert_says(&help, &["completions", "Exit codes", "mm"]);
    for command in COMMANDS {
        let long = finray(&[command, "--help"]).done();
        assert_says(&long, &["Usage: finray", command, "--out", "SCENE", "Example"]);
        assert_eq!(finray(&[command, "-h"]).done(), long);
    }
    for (command, options) in [
        ("report", vec!["--quick", "--open"]),
        ("solve", vec!["--load ", "--load-at", "--kinematics", "--mesh-nodes", "corotational-chord"]),
        ("sense", vec!["--displacements", "--contact ", "--contact-at", "--estimator", "--noise-mm"]),
        ("calibrate", vec!["--measurements"]),
        ("map", vec!["--truth", "--estimator", "--force-n", "--noise-mm", "--seeds", "--seed ", "--shard"]),
        ("sweep", vec!["--truth", "--estimator", "--force-n", "--noise-mm", "--seeds", "--seed ", "--shard"]),
        ("merge", vec!["--out", "SHARD", "Example"]),
    ] {
        assert_says(&finray(&[command, "--help"]).done(), &options);
    }
    assert_says(&finray(&["--version"]).done(), &["finray 0."]);
}

/// The help must fit one page. On a help page of 90 lines, options would be far from their descriptions.
#[test]
fn the_help_of_a_command_is_one_page_that_names_its_guide() {
    let help = finray(&["--help"]).done();
    let commands =
        help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1).take_while(|line| !line.is_empty());
    let names: Vec<&str> = commands.filter_map(|line| line.strip_prefix("  ")?.split(' ').next()).collect();
    let names: Vec<_> =
        names.into_iter().filter(|name| !["", "guide", "completions", "man", "help"].contains(name)).collect();
    assert!(COMMANDS.iter().all(|command| names.contains(command)), "{names:?}");
    for name in names {
        let page = finray(&[name, "--help"]).done();
        assert!(page.lines().count() <= 45, "{name}: {} lines", page.lines().count());
        // From the line `Examples:` on, lines fit a terminal of 100 columns; above it, the names of an option's values may need more.
        let examples = page.lines().skip_while(|line| !line.starts_with("Examples:"));
        let long: Vec<_> = examples.filter(|line| line.len() > 100).collect();
        assert!(long.is_empty(), "{name}: {long:#?}");
        let guide = page.lines().last().and_then(|line| line.strip_prefix("Guide: finray guide "));
        finray(&["guide", guide.unwrap_or_else(|| panic!("{name}: no guide"))]).done();
    }
}

/// The loads and contacts in the help are valid.
#[test]
fn the_examples_in_the_help_run() {
    let shape = finray(&["solve", PAPER, "--kinematics", "linear", "--load", "19:-0.38,-1.96"]).done();
    finray(&["solve", PAPER, "--load-at", "80:2,-20", "--mesh-nodes", "684"]).done();
    let bent = finray(&["solve", PAPER, "--load", "16:-0.1,-1", "--load", "20:-0.1,-1.5"]).done();
    for (shape, contacts) in [
        (&shape, &["--contact", "19", "--estimator", "least-squares"][..]),
        (&bent, &["--contact", "16@-20", "--contact", "20@10", "--noise-mm", "0.067"]),
    ] {
        let all = [&["sense", PAPER, "--displacements", "-"], contacts].concat();
        finray_reading(shape.as_bytes(), &all).done();
    }
}

#[test]
fn shells_get_their_completions() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = finray(&["completions", shell]).done();
        assert_says(&script, &["finray", "calibrate", "displacements"]);
    }
    finray(&["completions", "cmd"]).refused();
}

/// The program and each command have a man page with the options of their help.
#[test]
fn every_command_has_a_man_page() {
    assert_says(&finray(&["man"]).done(), &[".TH finray 1", ".SH NAME", "Exit codes"]);
    for (command, option) in [("sense", "displacements"), ("live", "contact"), ("merge", "out")] {
        let page = finray(&["man", command]).done();
        assert_says(&page, &[&format!(".TH finray-{command} 1"), ".SH OPTIONS", option, "quiet", "Examples"]);
    }
    assert_says(&finray(&["man", "sens"]).refused(), &["COMMAND", "sense", "\"sens\""]);
}

#[test]
fn unknown_words_are_refused() {
    for arguments in [
        vec!["sovle", PAPER],
        vec!["solve"],
        vec!["solve", PAPER, "--loads", "19:0,-1"],
        vec!["solve", PAPER, "--load"],
        vec!["solve", PAPER, "--load", "19:0,-1", "--out"],
        vec!["solve", PAPER, "--load", "19:0,-1", "--out", "-", "--out", "-"],
        vec!["sense", PAPER, "--contact", "19"],
        vec!["calibrate", PAPER],
        vec!["report", PAPER, PAPER],
    ] {
        finray(&arguments).refused();
    }
    // Without arguments, `finray` prints the help and exits with the code for bad input.
    let nothing = finray(&[]);
    assert_eq!(nothing.code, Some(2));
    assert_says(&nothing.err, &["Usage: finray"]);
}

/// A negative number is parsed as the value of an option. The message states what is wrong with the value, and does not call the option unknown.
#[test]
fn numbers_below_zero_are_values() {
    let sense = ["sense", PAPER, "--displacements", "missing.csv", "--contact", "19"];
    for (words, expected) in [
        (&[&sense[..], &["--noise-mm", "-1"]].concat()[..], vec!["--noise-mm", "expected zero or more, found -1"]),
        (&["map", PAPER, "--force-n", "-1"], vec!["--force-n", "expected more than zero, found -1"]),
        (&["map", PAPER, "--force-n", "-1,2"], vec!["--force-n", "expected more than zero, found -1"]),
        (&["map", PAPER, "--seeds", "-1"], vec!["--seeds", "-1"]),
        (&["solve", PAPER, "--load-at", "-5:1,0"], vec!["reaches from 0 (clamped) to 153 mm (tip)"]),
        (&["solve", PAPER, "--load-at", "80:1,0", "-5:1,0"], vec!["reaches from 0 (clamped) to 153 mm (tip)"]),
        (&["solve", PAPER, "--load", "-1:0,1"], vec!["--load", "expected the number of a node"]),
        (&["solve", PAPER, "--load", "19:0,-1", "--mesh-nodes", "-3"], vec!["--mesh-nodes", "-3"]),
        (
            &["sense", PAPER, "--displacements", "missing.csv", "--contact", "-1@auto"],
            vec!["expected the number of a node"],
        ),
        (&["gripper", GRIPPER, "--errors", "-1,0,0"], vec!["--errors", "expected zero or more, found -1"]),
    ] {
        let message = finray(words).refused();
        assert_says(&message, &expected);
        assert!(!message.contains("unexpected argument") && !message.contains("use '-- "), "{message}");
    }
    for angle in ["361", "-361", "1e6"] {
        let message = finray(&[&sense[..5], &[&format!("19@{angle}")]].concat()).refused();
        assert_says(&message, &["expected an angle from -360 to 360 degrees"]);
    }
    // A letter after a dash is still parsed as an option.
    assert_says(&finray(&["solve", PAPER, "--load", "19:0,-1", "-x"]).refused(), &["unexpected argument"]);
}

/// The message for a missing table or key names file and line, as messages about other keys do.
#[test]
fn what_a_scene_lacks_is_said_with_file_and_line() {
    let folder = Folder::new();
    let out = folder.path("out.png");
    for words in [
        vec!["render", PAPER, "--out", &out],
        vec!["locate", PAPER, "--image", "missing.png"],
        vec!["grasp", PAPER, "--out", &out],
        vec!["gripper", PAPER],
    ] {
        assert_says(&finray(&words).refused(), &[&format!("{PAPER}: line 1: ")]);
    }
}
