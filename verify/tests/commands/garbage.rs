//! Damaged input: truncated and overwritten scenes and tables never cause a panic, a hang or partial output.

use crate::kit::*;
use finray_fixtures::PAPER_SCENE;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Number of damaged copies of each input.
const COPIES: usize = 250;
/// Time limit of a run, far above the time that these commands need for any damaged scene.
const PATIENCE: Duration = Duration::from_secs(20);

/// Texts with a meaning in TOML or CSV, which are inserted into the input.
const SPICES: [&str; 24] = [
    "nan", "-inf", "1e308", "1e-308", "-0.0", "0", "99999999999999999999", "\u{feff}", "\r", "\n", "\"", "'", ",", ";",
    "=", "[", "]]", "{", "#", "\0", "\t", "\u{e9}", "[finger]", "0x",
];

/// The input after damage: truncated, or with some bytes overwritten, removed, doubled or replaced by one of [`SPICES`].
fn damaged(input: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = input.to_vec();
    if rng.random_bool(0.2) {
        bytes.truncate(rng.random_range(0..bytes.len()));
    }
    for _ in 0..rng.random_range(0..4) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        let end = (at + rng.random_range(1..12)).min(bytes.len());
        match rng.random_range(0..5) {
            0 => bytes[at] = rng.random(),
            1 => bytes[at] = b"0123456789.-+eE_\"\n,= "[rng.random_range(0..21)],
            2 => drop(bytes.drain(at..end)),
            3 => {
                let twice = bytes[at..end].to_vec();
                bytes.splice(at..at, twice);
            }
            _ => drop(bytes.splice(at..end, SPICES[rng.random_range(0..SPICES.len())].bytes())),
        }
    }
    bytes
}

/// Exit code and message of a run, which must end within [`PATIENCE`].
fn outcome(input: &[u8], arguments: &[&str]) -> (Option<i32>, String) {
    let mut child = started(input, arguments, Stdio::null());
    let start = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if start.elapsed() > PATIENCE {
            child.kill().expect("to end it");
            panic!("no end on {:?}", String::from_utf8_lossy(input));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let output = child.wait_with_output().expect("finray ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Runs the command with damaged copies on standard input. Every run must end with one of the exit codes `codes`; a failed run must print a single
/// line.
fn survives(name: &str, input: &str, arguments: &[&str], codes: &[i32]) {
    let mut rng = ChaCha8Rng::seed_from_u64(name.bytes().map(u64::from).sum());
    let mut met = Vec::new();
    for _ in 0..COPIES {
        let input = damaged(input.as_bytes(), &mut rng);
        let (code, message) = outcome(&input, arguments);
        let shown = String::from_utf8_lossy(&input);
        let code = code.unwrap_or_else(|| panic!("{name}: killed by\n{shown}"));
        assert!(codes.contains(&code), "{name}: exit code {code}, {message}\n{shown}");
        if code != 0 {
            assert!(message.starts_with("error: "), "{name}: {message:?}\n{shown}");
            assert_eq!(message.lines().count(), 1, "{name}: {message:?}\n{shown}");
        }
        met.push(code);
    }
    // Some copies are valid and some are not.
    assert!(met.contains(&0) && met.contains(&2), "{name}: {met:?}");
}

#[test]
fn damaged_scenes() {
    survives("scene", PAPER_SCENE, &["solve", "-", "--load", "19:-0.2,-1"], &[0, 1, 2]);
    let folder = Folder::new();
    let measured = folder.put("measured.csv", "node,ux_mm,uy_mm\n7,0.1,-1\n9,0.2,-1.5\n18,0.1,-1\n");
    let sense = ["sense", "-", "--displacements", &measured, "--contact", "19", "15@20"];
    survives("scene to sense", PAPER_SCENE, &sense, &[0, 1, 2]);
}

#[test]
fn damaged_scenes_with_every_key() {
    let zone = "[[finger.zone]]\nplate = \"front\"\nfrom_mm = 100\nto_mm = 153\nmodulus_factor = 0.5\n";
    let scene = paper_with(&[
        (
            "depth_mm = 20.0",
            "depth_mm = 20.0\nrod_arm_mm = 0.5\nrib_arm_mm = 0.7\nclamp_arm_mm = 0.3\npoissons_ratio = 0.3\nshear_correction = 0.8",
        ),
        ("count = 11", "positions_mm = [[27.0, 45.67], [54.0, 78.69], [81.0, 107.5], [108.0, 132.27]]"),
    ]);
    let scene = format!("{scene}\n{zone}[camera]\nnoise_mm = 0.1\n");
    survives("every key", &scene, &["solve", "-", "--load-at", "70:0.5", "--mesh-nodes", "60"], &[0, 1, 2]);
}

#[test]
fn damaged_tables() {
    let shape = finray(&["solve", PAPER, "--load", "19:0,-1"]).done();
    let sense = ["sense", PAPER, "--displacements", "-", "--contact", "19", "15@20"];
    // For impossible displacements, the search may find no equilibrium.
    survives("displacements", &shape, &sense, &[0, 1, 2]);
    let weights = weighed(PAPER, &[], &[(19, [0.0, -1.0])]);
    survives("weights", &weights, &["calibrate", PAPER, "--measurements", "-"], &[0, 2]);
}
