//! Latency of a video stream in real time.

use super::*;
use std::io::{Read, Write};
use std::process::Stdio;
use std::time::{Duration, Instant};

const FRAMES_PER_S: u32 = 125;
/// Latency of the sensing in Xu et al. 2021, ms.
const PAPER_MS: f64 = 40.0;
/// Columns of the recorded figures. Frames that are not evaluated were dropped.
const HEADER: &str = "stream,frames,evaluated,latency_median_ms,latency_99_percent_ms,latency_largest_ms,date";

/// Sends images of the camera's full size to `live` at [`FRAMES_PER_S`]. Half of the latencies must be below the paper's latency.
/// A full study records the latencies as a row of `fixtures/results/latency.csv`.
fn check_latency(images: &[RgbImage], colour_space: &str, subsampling: [u32; 2]) {
    let stream = yuv4mpeg2(images, colour_space, subsampling, false);
    let (header, frames) = stream.split_at(stream.iter().position(|byte| *byte == b'\n').expect("a header") + 1);
    let frames: Vec<_> = frames.chunks(frames.len() / images.len()).collect();

    let count = finray_tests::case_count(50, 600);
    let mut command = command(&["live", CAMERA, "--contact-at", "auto@-20", "--quiet"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("finray starts");
    let (mut input, mut out) = (child.stdin.take().expect("an input"), child.stdout.take().expect("an output"));
    let mut text = String::new();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            input.write_all(header).expect("a header");
            let start = Instant::now();
            for (number, frame) in (0..count as u32).zip(frames.iter().cycle()) {
                let due = start + Duration::from_secs(1) / FRAMES_PER_S * number;
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                input.write_all(frame).expect("a frame");
            }
        });
        out.read_to_string(&mut text).expect("lines");
    });
    assert!(child.wait().expect("the end").success());

    let lines = lines(&text);
    assert!(states(&lines).iter().all(|state| *state == "contact"), "{text}");
    let mut latencies_ms: Vec<_> = lines.iter().map(|line| line["latency_ms"].as_f64().expect("a latency")).collect();
    latencies_ms.sort_by(f64::total_cmp);
    let [median, most, largest] =
        [0.5, 0.99, 1.0].map(|share| latencies_ms[(share * (lines.len() - 1) as f64) as usize]);
    let figures = format!("{count},{},{median:.2},{most:.2},{largest:.2}", lines.len());
    println!("{colour_space}: {HEADER}: {figures}");
    assert!(median < PAPER_MS, "{latencies_ms:?}");
    if finray_tests::is_full_study() {
        let name = format!("images of 1600 x 1400 px C{colour_space} at {FRAMES_PER_S} per second");
        finray_tests::record_row("latency.csv", HEADER, &name, &format!("{figures},{}", finray_tests::today()));
    }
}

#[test]
fn forces_follow_images_within_the_latency_of_the_paper() {
    let images = images(&Folder::new(), &[2.0, 2.1, 2.2, 2.3]);
    check_latency(&images, "444", [1, 1]);
    check_latency(&images, "420", [2, 2]);
}
