//! Forces in a stream: video frames, positions, images; contacts that come and go; streams that end or break.

use crate::kit::*;
use finray_files::frames::{FrameLayout, FrameReader, FrameWriter};
use finray_model::mesh::{FingerShape, Load};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector, statics};
use finray_tests::{finger_of, random_stream};
use image::RgbImage;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::fmt::Write;
use std::io::{BufRead, BufReader};

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

/// Images of the finger under forces (N) at 80 mm and -20 degrees.
fn images(folder: &Folder, forces_n: &[f64]) -> Vec<RgbImage> {
    let image = |force_n: &f64| {
        let (path, load) = (folder.path("image.png"), format!("80:{force_n},-20"));
        finray(&["render", CAMERA, "--load-at", &load, "--grey-noise", "2", "--blur-px", "0.8", "--out", &path]).done();
        image::open(&path).expect("an image").to_rgb8()
    };
    forces_n.iter().map(image).collect()
}

/// A byte of luma or chroma, from weights of red, green and blue (ITU-R BT.601) and an offset.
fn weighted(rgb: [u8; 3], [red, green, blue]: [f64; 3], offset: f64) -> u8 {
    let [r, g, b] = rgb.map(f64::from);
    (offset + red * r + green * g + blue * b).round().clamp(0.0, 255.0) as u8
}

/// Frames as YUV4MPEG2, encoded in floating point, independent of the decoder. Chroma has every `across`-th column and `down`-th row.
fn yuv4mpeg2(images: &[RgbImage], colour_space: &str, [across, down]: [u32; 2], is_full_range: bool) -> Vec<u8> {
    let (width, height) = images[0].dimensions();
    let range = if is_full_range { " XCOLORRANGE=FULL" } else { "" };
    let mut stream = format!("YUV4MPEG2 W{width} H{height} F25:1 Ip A1:1 C{colour_space}{range}\n").into_bytes();
    let (luma, chroma, black) = if is_full_range { (1.0, 1.0, 0.0) } else { (219.0 / 255.0, 224.0 / 255.0, 16.0) };
    let blue = [-0.168736, -0.331264, 0.5].map(|weight| weight * chroma);
    let red = [0.5, -0.418688, -0.081312].map(|weight| weight * chroma);
    for image in images {
        stream.extend(b"FRAME\n");
        let of_luma = [0.299, 0.587, 0.114].map(|weight| weight * luma);
        stream.extend(image.pixels().map(|pixel| weighted(pixel.0, of_luma, black)));
        for weights in [blue, red] {
            let of_plane = (0..height)
                .step_by(down as usize)
                .flat_map(|v| (0..width).step_by(across as usize).map(move |u| (u, v)));
            stream.extend(of_plane.map(|(u, v)| weighted(image.get_pixel(u, v).0, weights, 128.0)));
        }
    }
    stream
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

/// The forces of a video's frames are sensed for every form of chroma, for both ranges, and for raw frames.
#[test]
fn forces_are_found_in_every_form_of_video() {
    let folder = Folder::new();
    let images = images(&folder, &[0.0, 2.0, 0.0]);
    let [width, height] = [images[0].width(), images[0].height()];
    let raw: Vec<u8> = images.iter().flat_map(|image| image.as_raw().iter().copied()).collect();
    let size = format!("{width}x{height}");
    let forms: [(&str, Vec<u8>, Vec<&str>); 5] = [
        ("444", yuv4mpeg2(&images, "444", [1, 1], false), vec![]),
        ("444, full", yuv4mpeg2(&images, "444", [1, 1], true), vec![]),
        ("422", yuv4mpeg2(&images, "422", [2, 1], false), vec![]),
        ("420", yuv4mpeg2(&images, "420jpeg", [2, 2], true), vec![]),
        ("raw", raw, vec!["--format", "rgb24", "--size", &size]),
    ];
    for (form, stream, more) in forms {
        let path = folder.put("stream", stream);
        let live = ["live", CAMERA, "--contact-at", "auto@-20", "--every-frame", "--input", &path];
        let answer = finray(&[&live[..], &more].concat());
        let summary = answer.summary.clone();
        let found = lines(&answer.done());
        assert_eq!(states(&found), ["none", "contact", "none"], "{form}: {found:?}");
        assert!((force_n(&found[1]) - 2.0).abs() < 0.01, "{form}: {}", found[1]);
        assert_eq!(found[1]["markers"], 25, "{form}");
        let time_s = found[1]["time_s"].as_f64();
        assert_eq!(time_s, if form == "raw" { None } else { Some(0.04) });
        assert_eq!(
            summary.as_deref(),
            Some("done: 3 frames: 1 in contact, 2 free, 0 refused, 0 without finger; 0 dropped")
        );
    }
}

/// Decoded frames have the colours that were encoded, within rounding.
#[test]
fn decoded_colours_are_those_that_were_encoded() {
    let image =
        RgbImage::from_fn(7, 5, |u, v| image::Rgb([(37 * u + 11) as u8, (50 * v + 5) as u8, (u * v * 7) as u8]));
    for is_full_range in [false, true] {
        let stream = yuv4mpeg2(std::slice::from_ref(&image), "444", [1, 1], is_full_range);
        let mut reader = FrameReader::yuv4mpeg2(&stream[..]).expect("a stream");
        let (mut bytes, mut found) = (Vec::new(), RgbImage::new(7, 5));
        assert!(reader.read(&mut bytes).expect("a frame"));
        reader.layout().to_rgb(&bytes, &mut found);
        for (found, expected) in found.iter().zip(image.iter()) {
            // The tolerance covers rounding of luma and chroma by half a step each, with the largest gain of 1.772 x 255 / 224.
            assert!(found.abs_diff(*expected) <= 2, "{found} for {expected}");
        }
        assert!(!reader.read(&mut bytes).expect("the end"));
    }
    assert_eq!(FrameLayout::rgb([7, 5]).byte_count(), 105);
}

/// Written frames are read with the same colours, in the same order, and with the same rate.
#[test]
fn written_frames_are_read_again() {
    // Each image shows all combinations of 52 values of red and green, from 0 to 255; blue grows from image to image.
    let image = |blue: u8| RgbImage::from_fn(52, 52, |u, v| image::Rgb([(5 * u) as u8, (5 * v) as u8, blue]));
    let images: Vec<RgbImage> = (0..=255).step_by(15).map(image).collect();
    for rate in [None, Some(25.0), Some(29.97), Some(0.5)] {
        let mut stream = Vec::new();
        let mut writer = FrameWriter::yuv4mpeg2(&mut stream, [52, 52], rate).expect("a header");
        images.iter().for_each(|image| writer.write(image).expect("a frame"));
        assert!(writer.write(&RgbImage::new(52, 50)).is_err(), "a frame of another size");
        let mut reader = FrameReader::yuv4mpeg2(&stream[..]).expect("a stream");
        assert_eq!(reader.layout().per_second, rate);
        let (mut bytes, mut found) = (Vec::new(), RgbImage::new(52, 52));
        for image in &images {
            assert!(reader.read(&mut bytes).expect("a frame"));
            reader.layout().to_rgb(&bytes, &mut found);
            for (found, expected) in found.iter().zip(image.iter()) {
                // Luma and chroma are rounded by up to half a step each, so blue errs by up to 0.5 + 1.772 x 0.5 = 1.39 before it is rounded.
                assert!(found.abs_diff(*expected) <= 1, "{found} for {expected}");
            }
        }
        assert!(!reader.read(&mut bytes).expect("the end"));
    }
}

/// Positions as JSON and as a table give the same force and standard deviation as `sense`.
#[test]
fn positions_give_the_forces_of_sense() {
    let folder = Folder::new();
    let shapes = [shape(&[]), shape(&[pushed(70.0, 1.5)]), shape(&[])];
    let frames: Vec<_> = (0..3).map(|i| positions(&shapes[i], i as f64, i as u64)).collect();
    let json: String = frames.iter().map(|[line, _]| line.as_str()).collect();
    let rows: String = frames.iter().map(|[_, rows]| rows.as_str()).collect();
    let table = format!("t_s,node,x_mm,y_mm,sigma_mm\n{rows}");
    let live = ["live", CAMERA, "--contact-at", "auto@0", "--every-frame"];
    let of_json = lines(&finray_reading(json.as_bytes(), &live).done());
    let of_table = lines(&finray_reading(table.as_bytes(), &live).done());
    assert_eq!(states(&of_json), ["none", "contact", "none"]);
    // The readers of JSON and CSV round numbers differently in their last digit.
    assert!((force_n(&of_json[1]) / force_n(&of_table[1]) - 1.0).abs() < 1e-12);
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
    let found = lines(&finray(&["live", CAMERA, "--contact-at", "auto@0", "--every-frame", "--input", &stream]).done());
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
                let node = marker["node"].as_u64().expect("a node");
                // Nodes 1 and 25 of this finger are clamped.
                let off_mm = if node == 1 || node == 25 { 0.0 } else { 0.3 };
                marker["y_mm"] = (marker["y_mm"].as_f64().expect("a number") + off_mm).into();
            }
            line.to_string() + "\n"
        })
        .collect::<String>();
    let live = ["live", CAMERA, "--contact-at", "auto@0", "--every-frame"];
    let wrong = lines(&finray_reading(shifted.as_bytes(), &live).done());
    assert!(states(&wrong)[..7].iter().all(|state| *state != "none"), "{:?}", states(&wrong));
    let found = lines(&finray_reading(shifted.as_bytes(), &[&live[..], &["--rest-frames", "5"]].concat()).done());
    assert_eq!(states(&found), ["none", "none", "none", "none", "none", "none", "none", "contact"]);
    assert!((force_n(&found[7]) - 1.0).abs() < 0.05, "{}", found[7]);
    // The noise includes the noise of the mean position at rest. With one frame at rest, the noise is 1.4 times as large.
    let folder = Folder::new();
    let free: String = (0..200).map(|i| positions(&shapes[0], 0.0, 500 + i)[0].clone()).collect();
    let path = folder.put("free", free);
    let more = ["--rest-frames", "1", "--noise-mm", "0.02", "--input", &path];
    let found = lines(&finray(&[&live[..], &more].concat()).done());
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
    let found =
        lines(&finray_reading(broken.as_bytes(), &["live", CAMERA, "--contact-at", "auto@0", "--every-frame"]).done());
    assert_eq!(states(&found), ["contact", "refused", "refused", "contact"]);
    assert_says(found[1]["refused"].as_str().expect("a reason"), &["line 2", "x_mm"]);
    // Only the frame with the invalid row is refused.
    let [_, rows] = positions(&shape(&[pushed(70.0, 1.0)]), 0.0, 1);
    let table = format!("t_s,node,x_mm,y_mm,sigma_mm\n{rows}1.0,2,here,3.0,0.02\n1.0,3,20.0,3.0,0.02\n");
    let found =
        lines(&finray_reading(table.as_bytes(), &["live", CAMERA, "--contact-at", "auto@0", "--every-frame"]).done());
    assert_eq!(states(&found), ["contact", "refused"]);
    assert_says(found[1]["refused"].as_str().expect("a reason"), &["line 27", "x_mm", "\"here\""]);
    // In a frame without the finger, the finger is lost; in the next frame it is found again.
    let mut images = images(&folder, &[2.0]);
    images.insert(1, RgbImage::new(images[0].width(), images[0].height()));
    images.push(images[0].clone());
    let stream = yuv4mpeg2(&images, "444", [1, 1], false);
    let found = lines(&finray(&[&live[..], &["--input", &folder.put("lost", &stream)]].concat()).done());
    assert_eq!(states(&found), ["contact", "lost", "contact"]);
    // A stream that ends within a frame.
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

/// Frames that arrive during an evaluation are dropped except for the newest, and counted.
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

/// Two scenes of the camera, with one finger each, whose images do not overlap.
const PLACES: [(&str, &str); 2] = [("left", "[-75.0, 45.0, 240.0]"), ("right", "[-75.0, -45.0, 240.0]")];

fn scenes_of_two_fingers(folder: &Folder) -> [String; 2] {
    PLACES.map(|(name, place)| {
        let scene = finray_fixtures::CAMERA_SCENE.replace("[-75.0, 0.0, 170.0]", place);
        assert!(scene.contains(place));
        folder.put(&format!("{name}.toml"), scene)
    })
}

/// Topic, stamp (s) and force (N) of a recorded wrench.
type Wrench = (String, f64, [f64; 3]);

/// The wrenches and the lines of JSON in a recording. Decoded by hand from the standard of CDR.
fn recorded(bytes: &[u8], options: &[mcap::read::Options]) -> (Vec<Wrench>, Vec<Value>) {
    let (mut wrenches, mut found) = (Vec::new(), Vec::new());
    let messages =
        mcap::MessageStream::new_with_options(bytes, options.iter().copied().collect()).expect("a recording");
    for message in messages {
        let message = message.expect("a whole message");
        let data = &message.data[4..];
        let whole = |at: usize| u32::from_le_bytes(data[at..at + 4].try_into().expect("four bytes"));
        if message.channel.topic == "/finray/live" {
            let text = std::str::from_utf8(&data[4..3 + whole(0) as usize]).expect("text");
            found.push(serde_json::from_str(text).expect("a line of JSON"));
            continue;
        }
        let schema = message.channel.schema.as_ref().expect("a schema");
        assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("geometry_msgs/msg/WrenchStamped", "ros2msg"));
        let [from, numbers] = [12, (12 + whole(8) as usize).div_ceil(8) * 8];
        let name = std::str::from_utf8(&data[from..from - 1 + whole(8) as usize]).expect("text");
        assert_eq!(message.channel.topic.replace("/finray/", "").replace('/', "_"), name);
        let number =
            |i: usize| f64::from_le_bytes(data[numbers + 8 * i..numbers + 8 * i + 8].try_into().expect("eight bytes"));
        assert_eq!(data.len(), numbers + 48);
        assert_eq!([3, 4, 5].map(number), [0.0; 3], "the torque about the contact");
        wrenches.push((
            message.channel.topic.clone(),
            f64::from(whole(0)) + 1e-9 * f64::from(whole(4)),
            [0, 1, 2].map(number),
        ));
    }
    (wrenches, found)
}

/// Two fingers in one image are sensed apart. The recording has the same lines, and the forces as vectors in the finger frame.
#[test]
fn two_fingers_in_one_image_are_distinguished_and_recorded() {
    let folder = Folder::new();
    let scenes = scenes_of_two_fingers(&folder);
    let [mut both, right] = [0, 1].map(|i| {
        let (load, path) = (["80:2,-20", "60:1.5,-20"][i], folder.path("one.png"));
        finray(&["render", &scenes[i], "--load-at", load, "--grey-noise", "0", "--out", &path]).done();
        image::open(&path).expect("an image").to_rgb8()
    });
    let background = *right.get_pixel(0, 0);
    for (both, right) in both.pixels_mut().zip(right.pixels()) {
        if *right != background {
            *both = *right;
        }
    }
    let (stream, record) =
        (folder.put("stream", yuv4mpeg2(&[both.clone(), both], "444", [1, 1], true)), folder.path("record.mcap"));
    let fingers = [0, 1].map(|i| format!("{}={}", PLACES[i].0, scenes[i]));
    let live = ["live", "--finger", &fingers[0], "--finger", &fingers[1], "--contact-at", "auto@-20", "--every-frame"];
    let found = lines(&finray(&[&live[..], &["--input", &stream, "--record", &record]].concat()).done());
    assert_eq!(states(&found), ["contact"; 2]);
    let (wrenches, in_recording) = recorded(&std::fs::read(&record).expect("a recording"), &[]);
    assert_eq!(in_recording, found);
    assert_eq!(wrenches.len(), 4);
    for (i, (true_n, s_mm)) in [(2.0, 80.0), (1.5, 60.0)].into_iter().enumerate() {
        let (name, contact) = (PLACES[i].0, &found[1]["contacts"][i]);
        assert_eq!((&contact["finger"], &found[1]["fingers"][i]["finger"]), (&name.into(), &name.into()));
        let [force_n, at_mm] = ["force_n", "s_mm"].map(|key| contact[key].as_f64().expect("a number"));
        assert!((force_n - true_n).abs() < 0.01 && (at_mm - s_mm).abs() < 0.1, "{contact}");
        let (topic, time_s, force) = &wrenches[2 + i];
        assert_eq!((topic, time_s), (&format!("/finray/{name}/contact_1"), &0.04));
        let expected = finger().direction(-20.0) * force_n;
        // JSON rounds a number to its shortest form.
        assert_close(&force[..2], expected.as_slice(), 1e-12);
        assert_eq!(force[2], 0.0);
    }
}

/// Positions of several fingers are distinguished by name, as JSON and as a table. A name that is not expected refuses the frame.
#[test]
fn positions_of_several_fingers_have_names() {
    let folder = Folder::new();
    let fingers = scenes_of_two_fingers(&folder);
    let fingers = [0, 1].map(|i| format!("{}={}", PLACES[i].0, fingers[i]));
    let frames = [2.0, 1.0].map(|force_n| positions(&shape(&[pushed(70.0, force_n)]), 0.5, 1));
    let named = |name: &str, [line, rows]: &[String; 2]| {
        let markers = line.replace("{\"node\"", &format!("{{\"finger\":\"{name}\",\"node\""));
        let rows: String = rows.lines().map(|row| format!("{row},{name}\n")).collect();
        [markers, rows]
    };
    let [left, right] = [0, 1].map(|i| named(PLACES[i].0, &frames[i]));
    let json =
        format!("{},{}", left[0].trim_end().trim_end_matches("]}"), right[0].split_once('[').expect("markers").1);
    let table = format!("t_s,node,x_mm,y_mm,sigma_mm,finger\n{}{}", left[1], right[1]);
    let live = ["live", "--finger", &fingers[0], &fingers[1], "--contact-at", "auto@0", "--every-frame"];
    for stream in [&json, &table] {
        let found = lines(&finray_reading(stream.as_bytes(), &live).done());
        let forces = [0, 1].map(|i| found[0]["contacts"][i]["force_n"].as_f64().expect("a force"));
        assert!((forces[0] - 2.0).abs() < 0.1 && (forces[1] - 1.0).abs() < 0.1, "{forces:?}");
    }
    let found = lines(&finray_reading(left[0].as_bytes(), &live).done());
    assert_eq!(
        (&found[0]["fingers"][0]["state"], &found[0]["fingers"][1]["state"]),
        (&"contact".into(), &"lost".into())
    );
    let wrong = lines(&finray_reading(json.replace("right", "rihgt").as_bytes(), &live).done());
    assert_says(
        wrong[0]["refused"].as_str().expect("a reason"),
        &["expected a finger of left, right, found \"rihgt\""],
    );
    let twice = ["live", "--finger", &fingers[0], &fingers[0], "--contact-at", "auto@0"];
    assert_says(&finray(&twice).refused(), &["--finger left", "once"]);
}

/// All messages up to the last line can be read from the recording of a run that was killed.
#[test]
fn the_recording_of_a_killed_run_is_readable() {
    let folder = Folder::new();
    let record = folder.path("record.mcap");
    let mut command = command(&["live", CAMERA, "--contact-at", "auto@0", "--record", &record]);
    command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut child = command.spawn().expect("finray starts");
    let mut input = child.stdin.take().expect("an input");
    let mut out = BufReader::new(child.stdout.take().expect("an output"));
    let mut printed = String::new();
    for _ in 0..3 {
        std::io::Write::write_all(&mut input, pressed_frame().as_bytes()).expect("a frame");
        out.read_line(&mut printed).expect("a line");
    }
    child.kill().expect("it still runs");
    child.wait().expect("the end");
    let (wrenches, found) =
        recorded(&std::fs::read(&record).expect("a recording"), &[mcap::read::Options::IgnoreEndMagic]);
    assert_eq!(found, lines(&printed));
    assert_eq!(wrenches.len(), 3);
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
        assert_says(&finray(&[&live[..], &outputs].concat()).refused(), &["expected a file of its own"]);
    }
    assert_eq!(folder.read("stream"), pressed_frame());
    assert_says(&finray(&[&live[..], &["--record", "-"]].concat()).refused(), &["--record: expected a file"]);
    for name in ["1", "a__b", "a_", "a b", ""] {
        let finger = format!("{name}={scene}");
        let refusal = finray(&["live", "--finger", &finger, "--contact-at", "auto@0"]).refused();
        assert_says(&refusal, &["expected NAME=SCENE"]);
    }
}

/// A frame whose time is no number, or with markers of too many fingers, is refused alone.
#[test]
fn impossible_times_and_numbers_of_fingers_are_refused() {
    let [_, rows] = positions(&shape(&[pushed(70.0, 1.0)]), 0.5, 1);
    let live = ["live", CAMERA, "--contact-at", "auto@0", "--every-frame"];
    for time in ["NaN", "inf", "-1", "abc", "", "1e30"] {
        let wrong: String =
            rows.lines().map(|row| format!("{time},{}\n", row.split_once(',').expect("cells").1)).collect();
        let table = format!("t_s,node,x_mm,y_mm,sigma_mm\n{wrong}{rows}");
        let found = lines(&finray_reading(table.as_bytes(), &live).done());
        assert_eq!(states(&found), ["refused", "contact"], "{time}");
        assert_says(found[0]["refused"].as_str().expect("a reason"), &["t_s: expected a time in s"]);
    }
    let crowd: String = (0..100).map(|i| format!("0.1,13,1.0,2.0,finger{i}\n")).collect();
    let crowd = format!("t_s,node,x_mm,y_mm,finger\n{crowd}");
    let found = lines(&finray_reading(crowd.as_bytes(), &live).done());
    assert_says(found[0]["refused"].as_str().expect("a reason"), &["expected at most 64 fingers"]);
}

/// A run with a page, and its port.
struct Served {
    child: std::process::Child,
    err: BufReader<std::process::ChildStderr>,
    port: u16,
}

/// Starts `live` on a free port. `more` are further arguments.
fn served(more: &[&str]) -> Served {
    let arguments = [&["live", CAMERA, "--contact-at", "auto@0", "--serve", "127.0.0.1:0"], more].concat();
    let mut command = command(&arguments);
    command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().expect("finray starts");
    let mut err = BufReader::new(child.stderr.take().expect("standard error"));
    let mut note = String::new();
    err.read_line(&mut note).expect("a note");
    let port = note.strip_prefix("note: the page is at http://127.0.0.1:").and_then(|rest| rest.strip_suffix("/\n"));
    let port = port.and_then(|port| port.parse().ok()).unwrap_or_else(|| panic!("{note:?}"));
    Served { child, err, port }
}

/// Sends a request to the page.
fn requested(port: u16, request: &str) -> std::net::TcpStream {
    let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).expect("a connection");
    stream.set_read_timeout(Some(std::time::Duration::from_secs(20))).expect("a limit");
    std::io::Write::write_all(&mut stream, request.as_bytes()).expect("a request");
    stream
}

/// The whole answer to a request for a path.
fn fetched(port: u16, method: &str, path: &str, host: &str) -> String {
    let mut answer = String::new();
    let mut stream = requested(port, &format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    std::io::Read::read_to_string(&mut stream, &mut answer).expect("an answer");
    answer
}

/// The page draws the finger; each event is the printed line; the last event states the end. Other requests are refused.
#[test]
fn a_page_shows_each_line() {
    let Served { mut child, mut err, port } = served(&[]);
    let own = format!("127.0.0.1:{port}");
    let page = fetched(port, "GET", "/", &own);
    assert_says(&page, &["HTTP/1.1 200 OK\r\n", "Content-Security-Policy: default-src 'none';", "\"inward\":["]);
    assert!(!page.contains("NONCE") && !page.contains("FINGERS") && !page.contains("https:"), "{page:.2000}");
    for (method, path, host, status) in [
        ("GET", "/", format!("localhost:{port}"), "200 "),
        ("GET", "/", format!("[::1]:{port}"), "200 "),
        ("GET", "/etc/passwd", own.clone(), "404 "),
        ("GET", "//events", own.clone(), "404 "),
        ("POST", "/", own.clone(), "405 "),
        ("GET", "/", format!("finger.example:{port}"), "403 "),
        ("GET", "/events", "localhost".to_owned(), "403 "),
        ("GET  ", "/", own.clone(), "400 "),
    ] {
        let answer = fetched(port, method, path, &host);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{method} {path} {host}: {answer:.300}");
    }
    let long = format!("GET / HTTP/1.1\r\nHost: {own}\r\nX: {}", "x".repeat(9000));
    let mut answer = String::new();
    // The connection may be reset, because the rest of the request is not read.
    let _ = std::io::Read::read_to_string(&mut requested(port, &long), &mut answer);
    assert!(!answer.contains("200 OK"), "{answer:.300}");

    let mut events = BufReader::new(requested(port, &format!("GET /events HTTP/1.1\r\nHost: {own}\r\n\r\n")));
    let mut text = String::new();
    while text != "\r\n" {
        text.clear();
        events.read_line(&mut text).expect("a header");
    }
    let mut input = child.stdin.take().expect("an input");
    let mut out = BufReader::new(child.stdout.take().expect("an output"));
    let mut next = |text: &mut String| {
        text.clear();
        // Comments and empty lines separate events.
        while text.trim().is_empty() || text.starts_with(':') {
            text.clear();
            assert!(events.read_line(text).expect("an event") > 0, "the connection is closed");
        }
    };
    // A client that is registered after the first line gets this line, too.
    for _ in 0..3 {
        std::io::Write::write_all(&mut input, pressed_frame().as_bytes()).expect("a frame");
        let mut line = String::new();
        out.read_line(&mut line).expect("a line");
        next(&mut text);
        assert_eq!(text, format!("data: {line}"));
    }
    drop(input);
    next(&mut text);
    assert_eq!(text, "event: end\n");
    assert_eq!(child.wait().expect("the end").code(), Some(0));
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut err, &mut rest).expect("text");
    assert!(rest.starts_with("done: 3 frames: 3 in contact"), "{rest}");
}

/// Clients that never read, or never finish their request, do not delay the frames.
#[test]
fn a_slow_client_does_not_stop_the_stream() {
    let Served { mut child, mut err, port } = served(&["--every-frame"]);
    let events = format!("GET /events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n");
    let clients: Vec<_> = (0..14).map(|_| requested(port, &events)).chain([requested(port, "GET / HT")]).collect();
    // The lines exceed what the sockets buffer: a refused line has about 300 bytes.
    let frames = 40_000;
    let mut input = child.stdin.take().expect("an input");
    let writing = std::thread::spawn(move || {
        let frame = format!("{{\"markers\":\"{}\"}}\n", "x".repeat(300));
        std::io::Write::write_all(&mut input, frame.repeat(frames).as_bytes()).expect("frames");
    });
    let began = std::time::Instant::now();
    let lines = BufReader::new(child.stdout.take().expect("an output")).lines().count();
    assert_eq!(lines, frames);
    // A write to a client that does not read ends after 10 s.
    assert!(began.elapsed().as_secs() < 8, "{:?}", began.elapsed());
    writing.join().expect("all frames are written");
    assert_eq!(child.wait().expect("the end").code(), Some(0));
    drop(clients);
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut err, &mut rest).expect("text");
    assert_says(&rest, &["done: 40000 frames", "40000 refused"]);
}

/// An address that cannot be opened is refused before the scene is read. Other machines reach the page only on request, with a warning.
#[test]
fn addresses_of_the_page_are_checked() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let taken = taken.local_addr().map(|address| (taken, address.to_string())).expect("an address");
    let serve =
        |address: &str| finray(&["live", "missing.toml", "--contact-at", "auto@0", "--serve", address]).refused();
    assert_says(&serve(&taken.1), &["--serve", &taken.1, "in use"]);
    assert_says(&serve("192.0.2.1:0"), &["192.0.2.1:0", "does not have this address"]);
    assert_says(&serve("8080"), &["--serve", "127.0.0.1:8080"]);
    let answer =
        finray_reading(pressed_frame().as_bytes(), &["live", CAMERA, "--contact-at", "auto@0", "--serve", "0.0.0.0:0"]);
    assert_eq!(answer.code, Some(0));
    assert_says(
        &answer.err,
        &["warning: --serve 0.0.0.0:", "without password", "note: the page is at http://0.0.0.0:"],
    );
}
