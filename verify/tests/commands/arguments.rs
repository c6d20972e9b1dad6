//! The command line itself: help, completions, and what it does not know.

use crate::kit::*;

const COMMANDS: [&str; 6] = ["report", "solve", "sense", "calibrate", "map", "sweep"];

#[test]
fn every_command_explains_itself() {
    let help = finray(&["--help"]).done();
    assert_says(&help, &COMMANDS);
    assert_says(&help, &["completions", "Exit codes", "mm"]);
    for command in COMMANDS {
        let long = finray(&[command, "--help"]).done();
        assert_says(&long, &["Usage: finray", command, "--out", "SCENE", "Example"]);
        let short = finray(&[command, "-h"]).done();
        assert!(short.len() < long.len());
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

/// Texts are broken by hand where a terminal of 100 columns would break them: a longer line leaves a single word on the next.
#[test]
fn lines_of_the_help_fit_a_terminal() {
    let help = finray(&["--help"]).done();
    let commands =
        help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1).take_while(|line| !line.is_empty());
    let names: Vec<&str> = commands.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(COMMANDS.iter().all(|command| names.contains(command)), "{names:?}");
    for name in names {
        let written = command(&[name, "--help"]).env("COLUMNS", "1000").output().expect("finray runs");
        let text = String::from_utf8(written.stdout).expect("finray writes UTF-8");
        let long: Vec<&str> =
            text.lines().take_while(|line| !line.starts_with("Usage:")).filter(|line| line.len() > 100).collect();
        assert!(long.is_empty(), "{name}: {long:#?}");
    }
}

/// The loads and contacts in the help are ones that work.
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
        vec!["map"],
    ] {
        finray(&arguments).refused();
    }
    // Without a word the help comes, as bad input.
    let nothing = finray(&[]);
    assert_eq!(nothing.code, Some(2));
    assert_says(&nothing.err, &["Usage: finray"]);
}
