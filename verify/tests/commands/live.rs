//! Tests of `live`: forces in streams of video frames, images and positions, contacts that come and go, and streams that end or break.

mod fingers;
mod latency;
mod memory;
mod page;
mod positions;
mod recording;
mod sensed;
mod video;

use crate::kit::*;
use finray_model::mesh::{FingerShape, Load};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector, statics};
use finray_tests::{finger_of, random_stream};
use image::RgbImage;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::fmt::Write;
use std::io::{BufRead, BufReader};
use video::{images, yuv4mpeg2};

/// The paper's finger with coloured markers and a camera.
const CAMERA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/camera.toml");
/// Standard deviation of the noise in a coordinate, mm.
const NOISE_MM: f64 = 0.02;

/// The JSON lines that a run printed.
fn lines(out: &str) -> Vec<Value> {
    out.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

fn states(lines: &[Value]) -> Vec<&str> {
    lines.iter().map(|line| line["state"].as_str().expect("a state")).collect()
}

fn force_n(line: &Value) -> f64 {
    line["contacts"][0]["force_n"].as_f64().unwrap_or_else(|| panic!("{line}"))
}

/// Senses every frame of a stream for a contact of unknown position, with a force along the undeformed normal.
const LIVE: [&str; 5] = ["live", CAMERA, "--contact-at", "auto@0", "--every-frame"];

/// The lines of [`LIVE`] for a stream.
fn found_in(stream: &str) -> Vec<Value> {
    lines(&finray_reading(stream.as_bytes(), &LIVE).done())
}

/// Shape of the finger under loads.
fn shape(loads: &[Load]) -> FingerShape {
    let mesh = Mesh::with_elements_per_member(&finger(), 8);
    statics::solve(&mesh, loads, Kinematics::Corotational).expect("an equilibrium")
}

/// Positions of all markers, as one line of JSON and as rows of a table, with noise of the random stream `case`.
fn positions(shape: &FingerShape, time_s: f64, case: u64) -> [String; 2] {
    let (finger, chance) = (finger(), &mut random_stream(4700, case));
    let (mut markers, mut rows) = (Vec::new(), String::new());
    for node in 1..=finger.key_node_count() {
        let noise: [f64; 2] = [0, 1].map(|_| NOISE_MM * Distribution::<f64>::sample(&StandardNormal, chance));
        let at = finger.position(NodeId(node)) + shape.motion(NodeId(node)).displacement + Vector::from(noise);
        markers.push(format!(r#"{{"node":{node},"x_mm":{},"y_mm":{},"sigma_mm":{NOISE_MM}}}"#, at.x, at.y));
        writeln!(rows, "{time_s},{node},{},{},{NOISE_MM}", at.x, at.y).expect("text");
    }
    [format!(r#"{{"t_s":{time_s},"markers":[{}]}}"#, markers.join(",")) + "\n", rows]
}

/// A frame of the finger under 1 N at 70 mm.
fn pressed_frame() -> String {
    positions(&shape(&[pushed(70.0, 1.0)]), 0.0, 1)[0].clone()
}

fn finger() -> Finger {
    finger_of(finray_fixtures::CAMERA_SCENE)
}

fn pushed(s_mm: f64, force_n: f64) -> Load {
    Load::at_position(s_mm, finger().direction(0.0) * force_n)
}

/// Positions as JSON and as a table give the same force and standard deviation as `sense`.
#[test]
fn positions_give_the_forces_of_sense() {
    let folder = Folder::new();
    let shapes = [shape(&[]), shape(&[pushed(70.0, 1.5)]), shape(&[])];
    let frames: Vec<_> = (0..3).map(|i| positions(&shapes[i], i as f64, i as u64)).collect();
    let json: String = frames.iter().map(|[line, _]| line.as_str()).collect();
    let rows: String = frames.iter().map(|[_, rows]| rows.as_str()).collect();
    // Some programs write the names of columns in quotes.
    let table = format!("\"t_s\",\"node\",\"x_mm\",y_mm,sigma_mm\n{rows}");
    let (of_json, of_table) = (found_in(&json), found_in(&table));
    assert_eq!(states(&of_json), ["none", "contact", "none"]);
    assert_eq!(force_n(&of_json[1]), force_n(&of_table[1]));
    assert_eq!(of_table[1]["time_s"], 1.0);
    // `sense` reads displacements, so the undeformed positions are subtracted.
    let rest = finger();
    let mut displaced = "node,ux_mm,uy_mm,sigma_mm\n".to_owned();
    for row in frames[1][1].lines() {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().expect("a number");
        let from = rest.position(NodeId(number(1) as usize));
        writeln!(displaced, "{},{},{},{NOISE_MM}", cells[1], number(2) - from.x, number(3) - from.y).expect("text");
    }
    let displaced = folder.put("displaced.csv", displaced);
    let sensed = finray(&["sense", CAMERA, "--displacements", &displaced, "--contact-at", "auto@0"]).done();
    let sensed = Csv::of(&sensed);
    for (column, key) in [("s_mm", "s_mm"), ("force_n", "force_n"), ("sigma_n", "sigma_n")] {
        let [theirs, ours] = [sensed.numbers(column)[0], of_json[1]["contacts"][0][key].as_f64().expect("a number")];
        assert!((ours / theirs - 1.0).abs() < 1e-9, "{key}: {ours} for {theirs}");
    }
}

/// The coordinates of a hidden marker are null in JSON, or NaN, which Python writes. A byte order mark is skipped.
#[test]
fn hidden_markers_have_no_coordinates() {
    let frame = pressed_frame();
    let (before, after) = frame.split_once(r#"{"node":6,"#).expect("node 6");
    let (_, after) = after.split_once('}').expect("its end");
    let of = |x: &str, y: &str| format!("{before}{{\"node\":6,\"x_mm\":{x},\"y_mm\":{y}}}{after}");
    let stream = format!("\u{feff}{}{}{}", of("null", "null"), of("NaN", "NaN"), of("null", "1.0"));
    let found = found_in(&stream);
    assert_eq!(states(&found), ["contact", "contact", "refused"]);
    assert_eq!([&found[0]["markers"], &found[1]["markers"]], [24, 24]);
    assert_says(found[2]["refused"].as_str().expect("a reason"), &["line 3: node 6: expected two coordinates"]);
}

/// The number of forces at unknown positions is found for two forces, one force and no force. A wrong position is refused.
#[test]
fn the_number_of_contacts_is_found() {
    let frame = |loads: &[Load], case| positions(&shape(loads), 0.0, case)[0].clone();
    let one = frame(&[pushed(70.0, 1.0)], 2);
    let stream = frame(&[], 1) + &one + &frame(&[pushed(50.0, 2.0), pushed(110.0, 1.0)], 3);
    let live = ["live", CAMERA, "--every-frame", "--contact-at"];
    let found = lines(&finray_reading(stream.as_bytes(), &[&live[..], &["auto@0"]].concat()).done());
    let contacts: Vec<usize> = found.iter().map(|line| line["contacts"].as_array().map_or(0, Vec::len)).collect();
    assert_eq!((states(&found), contacts), (vec!["none", "contact", "contact"], vec![0, 1, 2]));
    let forces: Vec<f64> = [0, 1].map(|i| found[2]["contacts"][i]["force_n"].as_f64().expect("a force")).to_vec();
    let [less, more] = [forces[0].min(forces[1]), forces[0].max(forces[1])];
    assert!((less - 1.0).abs() < 0.1 && (more - 2.0).abs() < 0.1, "{forces:?}");
    let at_100 = lines(&finray_reading(one.as_bytes(), &[&live[..], &["100@0"]].concat()).done());
    assert_eq!(states(&at_100), ["refused"]);
    assert_says(at_100[0]["refused"].as_str().expect("a reason"), &["contradicts the model"]);
}

/// Noise alone is reported as a force in less than 1 % of the frames without contact. The intervals contain the force in 93 to 97 % of the frames
/// with contact.
#[test]
fn free_frames_show_no_force_and_intervals_hold() {
    let count = finray_tests::case_count(200, 1000) as u64;
    let shapes = [shape(&[]), shape(&[pushed(70.0, 1.0)])];
    let frame = |i: u64| positions(&shapes[usize::from(i >= count)], i as f64, 100 + i)[0].clone();
    let folder = Folder::new();
    let stream = folder.put("stream", (0..2 * count).map(frame).collect::<String>());
    let found = lines(&finray(&[&LIVE[..], &["--input", &stream]].concat()).done());
    let (free, pressed) = found.split_at(count as usize);
    let wrong = free.iter().filter(|line| line["state"] != "none").count();
    assert!((wrong as f64) < 0.01 * count as f64, "{wrong} of {count}");
    let holds = |line: &&Value| {
        let ends = [0, 1].map(|i| line["contacts"][0]["interval_n"][i].as_f64().unwrap_or(f64::NAN));
        ends[0] <= 1.0 && 1.0 <= ends[1]
    };
    let held = pressed.iter().filter(holds).count() as f64 / count as f64;
    let allowed = 0.02 + 2.5 * finray_tests::share_error(0.95, count as usize);
    assert!((held - 0.95).abs() < allowed, "{held}");
}

/// If all markers are displaced by 0.3 mm, the finger seems pressed, unless the first frames show the markers without load.
#[test]
fn first_frames_may_show_the_unloaded_finger() {
    let shapes = [shape(&[]), shape(&[pushed(70.0, 1.0)])];
    let shifted: String = (0..8).map(|i| positions(&shapes[usize::from(i == 7)], 0.0, i)[0].clone()).collect();
    let shifted = lines(&shifted)
        .into_iter()
        .map(|mut line| {
            for marker in line["markers"].as_array_mut().expect("markers") {
                marker["y_mm"] = (marker["y_mm"].as_f64().expect("a number") + 0.3).into();
            }
            line.to_string() + "\n"
        })
        .collect::<String>();
    let wrong = found_in(&shifted);
    assert!(states(&wrong)[..7].iter().all(|state| *state != "none"), "{:?}", states(&wrong));
    let found = lines(&finray_reading(shifted.as_bytes(), &[&LIVE[..], &["--rest-frames", "5"]].concat()).done());
    assert_eq!(states(&found), ["none", "none", "none", "none", "none", "none", "none", "contact"]);
    assert!((force_n(&found[7]) - 1.0).abs() < 0.05, "{}", found[7]);
    // After the rest frames, each line shows the drift. The noise of the means causes 0.02 mm (1 / 5 + 1 / frames)^(1/2) in each coordinate.
    let drifts: Vec<Option<f64>> = found.iter().map(|line| line["drift_mm"].as_f64()).collect();
    assert_eq!(
        drifts.iter().map(Option::is_some).collect::<Vec<_>>(),
        [false, false, false, false, false, true, true, true]
    );
    let expected_mm = NOISE_MM * (2.0 * (1.0 / 5.0 + 1.0 / 2.0_f64)).sqrt();
    assert!(drifts[6] == drifts[7] && (drifts[6].unwrap_or(0.0) / expected_mm - 1.0).abs() < 0.3, "{drifts:?}");
    // Rest frames with the nodes in reverse order are refused.
    let reversed = lines(&positions(&shapes[0], 0.0, 1)[0]).remove(0);
    let mut markers = reversed["markers"].as_array().expect("markers").clone();
    for marker in &mut markers {
        marker["node"] = (26 - marker["node"].as_u64().expect("a node")).into();
    }
    let reversed = serde_json::json!({ "markers": markers }).to_string();
    let reversed = finray_reading(reversed.as_bytes(), &[&LIVE[..], &["--rest-frames", "1"]].concat());
    let (out, warnings) = reversed.warned();
    assert_says(lines(&out)[0]["refused"].as_str().expect("a reason"), &["from their places in the scene"]);
    assert_says(&warnings[0], &["ended 1 frame(s) before all 1 rest frames"]);
    // With `--rest-frames`, the noise of a displacement includes the noise of the mean position at rest. With only one frame at rest, a displacement
    // has 1.4 times the noise of a position.
    let folder = Folder::new();
    let free: String = (0..200).map(|i| positions(&shapes[0], 0.0, 500 + i)[0].clone()).collect();
    let path = folder.put("free", free);
    let more = ["--rest-frames", "1", "--noise-mm", "0.02", "--input", &path];
    let found = lines(&finray(&[&LIVE[..], &more].concat()).done());
    let wrong = states(&found).iter().filter(|state| **state != "none").count();
    assert!(wrong < 2, "{wrong} of 200");
}

/// A frame that cannot be evaluated is reported with its number, and the other frames are evaluated.
#[test]
fn broken_frames_are_refused_alone() {
    let folder = Folder::new();
    let live = ["live", CAMERA, "--contact-at", "auto@-20", "--every-frame"];
    let one = pressed_frame();
    let broken = format!("{one}{{\"markers\":[{{\"node\":13}}]}}\nnonsense\n{one}");
    let found = found_in(&broken);
    assert_eq!(states(&found), ["contact", "refused", "refused", "contact"]);
    assert_says(found[1]["refused"].as_str().expect("a reason"), &["line 2", "x_mm"]);
    // Only the frame with the invalid row is refused.
    let [_, rows] = positions(&shape(&[pushed(70.0, 1.0)]), 0.0, 1);
    let table = format!("t_s,node,x_mm,y_mm,sigma_mm\n{rows}1.0,2,here,3.0,0.02\n1.0,3,20.0,3.0,0.02\n");
    let found = found_in(&table);
    assert_eq!(states(&found), ["contact", "refused"]);
    assert_says(found[1]["refused"].as_str().expect("a reason"), &["line 27", "x_mm", "\"here\""]);
    // A line that is too long is refused alone, and `--format` decides the format.
    let long = format!("{one}{{\"markers\":[{}]}}\n{one}", " ".repeat(1 << 21));
    assert_eq!(states(&found_in(&long)), ["contact", "refused", "contact"]);
    let json = [&LIVE[..], &["--format", "jsonl"]].concat();
    let found = lines(&finray_reading(format!("nonsense\n{one}").as_bytes(), &json).done());
    assert_eq!(states(&found), ["refused", "contact"]);
    // In a frame without the finger, the finger is lost; in the next frame it is found again.
    let mut images = images(&folder, &[2.0]);
    images.insert(1, RgbImage::new(images[0].width(), images[0].height()));
    images.push(images[0].clone());
    let stream = yuv4mpeg2(&images, "444", [1, 1], false);
    let found = lines(&finray(&[&live[..], &["--input", &folder.put("lost", &stream)]].concat()).done());
    assert_eq!(states(&found), ["contact", "lost", "contact"]);
    // A stream that ends within a frame causes a warning.
    let path = folder.put("cut", &stream[..stream.len() - 1000]);
    let (out, warnings) = finray(&[&live[..], &["--input", &path]].concat()).warned();
    assert_eq!(states(&lines(&out)), ["contact", "lost"]);
    assert_says(&warnings[0], &["frame 2 is cut off"]);
}

/// Streams of an unknown format are refused, and the message states the expected format.
#[test]
fn streams_of_another_form_are_refused() {
    let live = ["live", CAMERA, "--contact-at", "auto@0"];
    let refused = |stream: &[u8], expected: &[&str]| assert_says(&finray_reading(stream, &live).refused(), expected);
    refused(b"", &["standard input", "expected a stream, found nothing"]);
    refused(b"\x89PNG\r\n", &["--format rgb24 and --size"]);
    refused(b"node,ux_mm\n", &["line 1", "image", "t_s"]);
    refused(b"YUV4MPEG2 W10 H10 C420p10\n", &["C420p10", "yuv444p"]);
    refused(b"YUV4MPEG2 W10\n", &["width and height"]);
    refused(b"YUV4MPEG2 W10 H10 It\n", &["progressive"]);
    assert_says(&finray(&["live", CAMERA, "--contact-at", "auto@0", "--format", "rgb24"]).refused(), &["--size"]);
    // Frames whose size differs from the camera's images are refused, and the result file stays unchanged.
    let folder = Folder::new();
    let out = folder.put("out.jsonl", "before");
    let small = finray_reading(b"YUV4MPEG2 W10 H10\n", &[&live[..], &["--out", &out]].concat());
    assert_says(&small.refused(), &["1600 x 1400 px", "10 x 10 px"]);
    assert_eq!(folder.read("out.jsonl"), "before");
    // The lines of earlier frames remain.
    let mut stream = yuv4mpeg2(&images(&folder, &[2.0]), "444", [1, 1], false);
    stream.extend(b"YUV4MPEG2 W20 H20\n");
    let answer = finray(&[&live[..], &["--every-frame", "--input", &folder.put("changed", stream)]].concat());
    assert_eq!((answer.code, answer.out.lines().count()), (Some(2), 1));
    assert_says(&answer.err, &["changed: frame 1", "FRAME", "size"]);
}

/// Each line is written before the stream ends, and a reader that closes the pipe ends the run without an error.
#[test]
fn lines_arrive_at_once_and_the_reader_may_leave() {
    let one = pressed_frame();
    let mut command = command(&["live", CAMERA, "--contact-at", "auto@0"]);
    command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut child = command.spawn().expect("finray starts");
    let mut input = child.stdin.take().expect("an input");
    let mut out = BufReader::new(child.stdout.take().expect("an output"));
    for _ in 0..3 {
        std::io::Write::write_all(&mut input, one.as_bytes()).expect("a frame");
        let mut line = String::new();
        // The input is still open, so this call waits for ever if the line is not written at once.
        out.read_line(&mut line).expect("a line");
        assert_eq!(states(&lines(&line)), ["contact"]);
    }
    drop(out);
    while std::io::Write::write_all(&mut input, one.as_bytes()).is_ok() {}
    assert_eq!(child.wait().expect("the end").code(), Some(0));
}

/// Of the frames that arrive during an evaluation, all but the newest are dropped and counted.
#[test]
fn dropped_frames_are_counted() {
    let one = pressed_frame();
    let count = 300;
    let found =
        lines(&finray_reading(one.repeat(count).as_bytes(), &["live", CAMERA, "--contact-at", "auto@0"]).done());
    let dropped: u64 = found.iter().map(|line| line["dropped"].as_u64().expect("a number")).sum();
    assert_eq!(found.len() as u64 + dropped, count as u64);
    let last = found.last().expect("a line");
    assert_eq!(last["frame"], count - 1, "the newest frame is evaluated");
    assert!(dropped > 0, "reading is faster than sensing");
}

/// A full disk ends the run with exit code 1.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error() {
    let one = pressed_frame();
    let message =
        finray_reading(one.as_bytes(), &["live", CAMERA, "--contact-at", "auto@0", "--out", "/dev/full"]).failed();
    assert_says(&message, &["/dev/full", "cannot be written"]);
}

/// An output that is also an input or another output is refused, and the input is kept.
#[test]
fn outputs_are_files_of_their_own() {
    let folder = Folder::new();
    let (scene, stream) =
        (folder.put("scene.toml", finray_fixtures::CAMERA_SCENE), folder.put("stream", pressed_frame()));
    let elsewhere = folder.path("./stream");
    let live = ["live", &scene, "--contact-at", "auto@0", "--input", &stream];
    for outputs in [
        vec!["--record", &elsewhere],
        vec!["--out", &stream],
        vec!["--record", &scene],
        vec!["--out", "a", "--record", "./a"],
    ] {
        assert_says(&finray(&[&live[..], &outputs].concat()).refused(), &["expected a separate file for each output"]);
    }
    assert_eq!(folder.read("stream"), pressed_frame());
    assert_says(&finray(&[&live[..], &["--record", "-"]].concat()).refused(), &["--record: expected a file"]);
    for name in ["1", "a__b", "a_", "a b", ""] {
        let finger = format!("{name}={scene}");
        let refusal = finray(&["live", "--finger", &finger, "--contact-at", "auto@0"]).refused();
        assert_says(&refusal, &["expected NAME=SCENE"]);
    }
}

/// A frame with an invalid time, or with markers of too many fingers, is refused; other frames are evaluated.
#[test]
fn impossible_times_and_numbers_of_fingers_are_refused() {
    let [_, rows] = positions(&shape(&[pushed(70.0, 1.0)]), 0.5, 1);
    for time in ["NaN", "inf", "-1", "abc", "", "1e30"] {
        let wrong: String =
            rows.lines().map(|row| format!("{time},{}\n", row.split_once(',').expect("cells").1)).collect();
        let table = format!("t_s,node,x_mm,y_mm,sigma_mm\n{wrong}{rows}");
        let found = found_in(&table);
        assert_eq!(states(&found), ["refused", "contact"], "{time}");
        assert_says(found[0]["refused"].as_str().expect("a reason"), &["t_s: expected a time in s"]);
    }
    let crowd: String = (0..100).map(|i| format!("0.1,13,1.0,2.0,finger{i}\n")).collect();
    let crowd = format!("t_s,node,x_mm,y_mm,finger\n{crowd}");
    let found = found_in(&crowd);
    assert_says(found[0]["refused"].as_str().expect("a reason"), &["expected at most 64 fingers"]);
}
