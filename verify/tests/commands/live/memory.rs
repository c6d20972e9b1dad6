//! Memory and open files of long streams.

use super::*;
use std::io::Write;
use std::process::Stdio;
use std::sync::mpsc;

/// Number of frames after which every buffer has its final size.
const WARM: usize = 1000;
/// Tolerance of the relative growth of the resident memory after [`WARM`] frames.
const GROWTH: f64 = 0.02;

/// Columns of the recorded resources: after [`WARM`] frames, and after the last frame.
const HEADER: &str =
    "stream,frames,frames_in_contact,resident_kb,descriptors,resident_at_end_kb,descriptors_at_end,date";

/// Resources of a running process.
#[derive(Debug, Clone, Copy)]
struct Resources {
    resident_kb: f64,
    descriptors: usize,
}

fn resources(process: u32) -> Resources {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).expect("a running process");
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("resident memory");
    let resident_kb = resident.trim().trim_end_matches(" kB").parse().expect("a number");
    let descriptors = std::fs::read_dir(format!("/proc/{process}/fd")).expect("open files").count();
    Resources { resident_kb, descriptors }
}

/// Sends `count` frames to `live`, repeating the given frames in turn, and records lines, forces and images. Compares the resources of `live` after
/// [`WARM`] frames with those after the last frame. A full study records the resources as the row `name` of `fixtures/results/memory.csv`.
fn check_flat(name: &str, scene: &str, header: &[u8], frames: &[Vec<u8>], count: usize) {
    let live = ["live", scene, "--contact-at", "auto@0", "--every-frame", "--quiet", "--record", "/dev/null"];
    let more: &[&str] = if header.is_empty() { &[] } else { &["--record-images"] };
    let mut command = command(&[&live[..], more].concat());
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("finray starts");
    let mut input = child.stdin.take().expect("an input");
    let out = BufReader::new(child.stdout.take().expect("an output"));
    let (measured, may_close) = mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            input.write_all(header).expect("a header");
            for frame in frames.iter().cycle().take(count) {
                input.write_all(frame).expect("a frame");
            }
            input.flush().expect("the last frame");
            // The input stays open until the running process is measured.
            may_close.recv().expect("a measurement");
        });
        let (mut warm, mut in_contact) = (None, 0);
        for (number, line) in out.lines().enumerate() {
            let line = line.expect("a line");
            in_contact += usize::from(line.contains("\"state\":\"contact\""));
            match number + 1 {
                WARM => warm = Some(resources(child.id())),
                last if last == count => {
                    let (warm, end) = (warm.expect("enough frames"), resources(child.id()));
                    println!("{count} frames, {in_contact} in contact: {warm:?}, at the end {end:?}");
                    assert!(in_contact > count / 3, "{in_contact} of {count} frames in contact");
                    assert!(end.resident_kb <= (1.0 + GROWTH) * warm.resident_kb, "{warm:?}, at the end {end:?}");
                    assert_eq!(end.descriptors, warm.descriptors);
                    if finray_tests::is_full_study() {
                        let [from, to] =
                            [warm, end].map(|used| format!("{:.0},{}", used.resident_kb, used.descriptors));
                        let figures = format!("{count},{in_contact},{from},{to},{}", finray_tests::today());
                        finray_tests::record_row("memory.csv", HEADER, name, &figures);
                    }
                    measured.send(()).expect("the sender waits");
                }
                _ => {}
            }
        }
    });
    assert!(child.wait().expect("the end").success());
}

/// Resident memory and open files stay the same in a stream of positions, with and without contact.
#[test]
#[cfg(target_os = "linux")]
fn a_long_stream_of_positions_needs_no_more_memory() {
    let [pressed, free] = [shape(&[pushed(80.0, 2.0)]), shape(&[])];
    let frames: Vec<Vec<u8>> = (0..100)
        .map(|case| {
            let shape = if case % 2 == 0 { &pressed } else { &free };
            positions(shape, 0.0, case)[0].clone().into_bytes()
        })
        .collect();
    check_flat("positions", CAMERA, b"", &frames, finray_tests::case_count(3 * WARM, 1_000_000));
}

/// Resident memory and open files also stay the same in a stream of images, which are a quarter as wide and high as the camera's images.
#[test]
#[cfg(target_os = "linux")]
fn a_long_stream_of_images_needs_no_more_memory() {
    let folder = Folder::new();
    let mut scene = finray_fixtures::CAMERA_SCENE.to_owned();
    for (full, quarter) in
        [("1600, 1400", "400, 350"), ("1360.0, 1360.0", "340.0, 340.0"), ("799.5, 699.5", "199.5, 174.5")]
    {
        assert!(scene.contains(full));
        scene = scene.replace(full, quarter);
    }
    let scene = folder.put("scene.toml", scene);
    let frames: Vec<Vec<u8>> = [0.0, 2.0]
        .iter()
        .map(|force_n| {
            let (path, load) = (folder.path("image.png"), format!("80:{force_n},0"));
            finray(&["render", &scene, "--load-at", &load, "--out", &path]).done();
            let image = image::open(&path).expect("an image").to_rgb8();
            let stream = yuv4mpeg2(&[image], "444", [1, 1], false);
            let header = stream.iter().position(|byte| *byte == b'\n').expect("a header") + 1;
            stream[header..].to_vec()
        })
        .collect();
    let header = b"YUV4MPEG2 W400 H350 F25:1 Ip A1:1 C444\n";
    check_flat("images of 400 x 350 px", &scene, header, &frames, finray_tests::case_count(WARM + WARM / 2, 100_000));
}
