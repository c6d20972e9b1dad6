//! Tests of the images of a grasp as streams for `live`: forces of both fingers in every frame, readers that close a stream, and streams that cannot
//! be written.

use crate::kit::*;
use finray_fixtures::WATCHED_DISC_SCENE;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

/// Largest accepted error of a force, in standard deviations. Noise causes a larger error in about one of a million frames.
const MOST_SIGMAS: f64 = 5.0;
/// Largest force that `live` may miss, N: [`MOST_SIGMAS`] times the standard deviation of a force in these images, which is about 0.002 N.
const LEAST_SEEN_N: f64 = 0.01;

/// The scene of the watched grasp with ten steps and, instead of the disc, a box far from the centre. The right finger pushes the box over the table
/// while the left finger is still free. A disc would roll without force.
fn off_centre(folder: &Folder) -> String {
    let changes = [
        ("shape = \"disc\"\nradius_mm = 15.0", "shape = \"box\"\nwidth_mm = 30.0\nheight_mm = 12.0"),
        ("centre_mm = [0.5, 110.0]", "centre_mm = [3.0, 110.0]"),
        ("motor_deg = [-135.0, -405.0]", "motor_deg = [-45.0, -270.0]"),
        ("open = true", "open = false"),
    ];
    folder.put("scene.toml", replaced(WATCHED_DISC_SCENE, &changes))
}

/// True force (N) on a finger in each step: the magnitude of the sum of all contact forces.
fn true_forces(forces: &str, finger: &str) -> Vec<f64> {
    let table = Csv::of(forces);
    let [steps, fingers, contacts] = ["step", "finger", "contact"].map(|column| table.texts(column));
    let totals = (0..steps.len()).filter(|row| fingers[*row] == finger && contacts[*row] == "total");
    let force = |total: usize| {
        let parts = (0..steps.len()).filter(|row| [steps[*row], fingers[*row]] == [steps[total], finger]);
        let number = |row: usize, column: &str| table.texts(column)[row].parse::<f64>().expect("a number");
        let parts = parts.filter(|row| !["total", "clamp"].contains(&contacts[*row])).map(|row| {
            let (sin, cos) = number(row, "angle_deg").to_radians().sin_cos();
            let (normal_n, across_n) = (number(row, "force_n"), number(row, "friction_n"));
            [normal_n * cos - across_n * sin, normal_n * sin + across_n * cos]
        });
        let [x_n, y_n] = parts.fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        x_n.hypot(y_n)
    };
    totals.map(force).collect()
}

/// Checks the lines of `live` against the true forces (N), step by step.
#[track_caller]
fn assert_follows(lines: &str, true_n: &[f64], finger: &str) {
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    assert_eq!(lines.len(), true_n.len(), "{finger}: a frame a step");
    for (frame, (line, true_n)) in lines.iter().zip(true_n).enumerate() {
        assert_eq!(line["frame"], frame);
        match line["state"].as_str() {
            Some("none") => assert!(*true_n < LEAST_SEEN_N, "{finger}: {true_n} N are missed: {line}"),
            Some("contact") => {
                let number = |key: &str| line["contacts"][0][key].as_f64().expect("a number");
                let sigmas = (number("force_n") - true_n) / number("sigma_n");
                assert!(
                    sigmas.abs() < MOST_SIGMAS,
                    "{finger}: {sigmas:.1} standard deviations from {true_n} N: {line}"
                );
            }
            _ => panic!("{finger}: {line}"),
        }
    }
}

/// The left finger's images, sent through a pipe, and the right finger's images, from a file, show the true forces of each step. Streaming the images
/// does not change the results of the grasp.
#[test]
fn live_finds_the_forces_of_a_grasp_in_its_images() {
    let folder = Folder::new();
    let (scene, right, out) = (off_centre(&folder), folder.path("right.y4m"), folder.path("out"));
    let grasp = ["grasp", &scene, "--images", "--noise-mm", "0.01", "--quiet", "--out"];
    let live = ["live", &scene, "--contact-at", "auto@auto", "--every-frame"];
    let to_right = format!("right={right}");
    let mut gripper = command(&[&grasp[..], &[&out, "--stream", "left=-", "--stream", &to_right]].concat());
    let mut gripper = gripper.stdout(Stdio::piped()).spawn().expect("finray starts");
    let frames = gripper.stdout.take().expect("an output");
    let left = command(&live).stdin(frames).output().expect("finray ends");
    assert!(gripper.wait().expect("the end").success() && left.status.success());
    let forces = folder.read("out/forces.csv");
    let [true_left, true_right] = ["left", "right"].map(|finger| true_forces(&forces, finger));
    assert_follows(&String::from_utf8(left.stdout).expect("text"), &true_left, "left");
    assert_follows(&finray(&[&live[..], &["--input", &right]].concat()).done(), &true_right, "right");
    // The test would detect exchanged fingers or steps: in some steps only one finger pushes, and forces grow by much more than their uncertainty.
    let alone = true_left.iter().zip(&true_right).filter(|(left, right)| (**left == 0.0) != (**right == 0.0)).count();
    assert!(alone > 1 && true_left.last() > Some(&0.3), "{true_left:?} {true_right:?}");
    finray(&[&grasp[..], &[&folder.path("unstreamed")]].concat()).done();
    assert_eq!(folder.read("unstreamed/forces.csv"), forces);
}

/// If a reader closes its stream, only this stream ends, and the grasp goes on.
#[test]
fn a_reader_of_the_images_may_leave() {
    let folder = Folder::new();
    let (scene, out) = (off_centre(&folder), folder.path("out"));
    let mut gripper =
        command(&["grasp", &scene, "--images", "--fineness", "1", "--out", &out, "--stream", "left=-", "--quiet"]);
    let mut gripper = gripper.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("finray starts");
    let mut header = String::new();
    BufReader::new(gripper.stdout.take().expect("an output")).read_line(&mut header).expect("a header");
    assert_eq!(header, "YUV4MPEG2 W1600 H1400 F0:0 Ip A1:1 C444 XCOLORRANGE=FULL\n");
    let ended = gripper.wait_with_output().expect("the end");
    assert_eq!((ended.status.code(), String::from_utf8(ended.stderr).as_deref()), (Some(0), Ok("")));
    assert!(folder.read("out/summary.json").contains("\"done\""));
}

#[test]
fn streams_that_cannot_be_written_are_refused() {
    let folder = Folder::new();
    let (scene, out) = (off_centre(&folder), folder.path("out"));
    let run = |more: &[&str]| finray(&[&["grasp", &scene, "--fineness", "1", "--out", &out], more].concat());
    let refused = |more: &[&str], expected: &[&str]| assert_says(&run(more).refused(), expected);
    refused(&["--stream", "left=-"], &["--images"]);
    let images = |streams: &[&'static str]| [&["--images"], streams].concat();
    refused(&images(&["--stream", "up=-"]), &["left=FILE or right=FILE"]);
    refused(&images(&["--stream", "left="]), &["left=FILE or right=FILE"]);
    refused(&images(&["--stream", "left=-", "--stream", "right=-"]), &["each finger once, and a file for each"]);
    refused(&images(&["--stream", "left=a", "--stream", "left=b"]), &["each finger once, and a file for each"]);
    let on_gripper = std::fs::read_to_string(&scene).expect("a scene") + "camera_on_gripper = true\n";
    let on_gripper = folder.put("on_gripper.toml", on_gripper);
    let answer = finray(&["grasp", &on_gripper, "--out", &out, "--images", "--stream", "left=-"]);
    assert_says(&answer.refused(), &["grasp.camera_on_gripper"]);
    if cfg!(target_os = "linux") {
        let message = run(&images(&["--stream", "left=/dev/full"])).failed();
        assert_says(&message, &["/dev/full", "cannot be written"]);
    }
    assert!(!folder.names().contains(&"out".to_owned()), "nothing is written");
}

/// A disk that fills up during the grasp ends the grasp with one message and without results.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_fills_up_ends_the_grasp() {
    let folder = Folder::new();
    let (scene, out, frames) = (off_centre(&folder), folder.path("out"), folder.path("left.y4m"));
    // The shell limits the size of a file to 8192 blocks of 512 or 1024 bytes, less than two frames. A write beyond the limit fails.
    let limited = "trap '' XFSZ; ulimit -f 8192; exec \"$@\"";
    let finray = env!("CARGO_BIN_EXE_finray");
    let stream = format!("left={frames}");
    let grasp = [finray, "grasp", &scene, "--fineness", "1", "--images", "--out", &out, "--stream", &stream];
    let ended = std::process::Command::new("sh").args(["-c", limited, "sh"]).args(grasp).output().expect("a shell");
    let message = String::from_utf8(ended.stderr).expect("text");
    assert_eq!((ended.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert_says(&message, &["left.y4m", "cannot be written"]);
    assert!(!folder.names().contains(&"out".to_owned()), "nothing is written");
}
