//! Recordings for ROS 2.

use super::video::{frames_of, whole};
use super::*;
use std::io::Write;
use std::process::Stdio;

/// Topic, stamp (s) and force (N) of a recorded wrench.
type Wrench = (String, f64, [f64; 3]);

/// The messages of a recording, by type, each in the order of the recording.
pub(super) struct Recorded {
    pub wrenches: Vec<Wrench>,
    /// The lines of JSON.
    pub lines: Vec<Value>,
    /// Stamp (s) and pixels of each image, and the number of lines of JSON before the image.
    pub images: Vec<(f64, RgbImage, usize)>,
}

/// A message in CDR, without its first four bytes, and the position from which it is read further. The functions follow the standard, without a library.
struct Cdr<'m> {
    bytes: &'m [u8],
    at: usize,
}

impl<'m> Cdr<'m> {
    /// The next `count` bytes from a multiple of `size`.
    fn take(&mut self, size: usize, count: usize) -> &'m [u8] {
        let from = self.at.next_multiple_of(size);
        self.at = from + count;
        &self.bytes[from..self.at]
    }

    fn whole(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4, 4).try_into().expect("four bytes"))
    }

    fn number(&mut self) -> f64 {
        f64::from_le_bytes(self.take(8, 8).try_into().expect("eight bytes"))
    }

    fn text(&mut self) -> &'m str {
        let count = self.whole() as usize;
        let (end, text) = self.take(1, count).split_last().expect("a zero byte");
        assert_eq!(*end, 0);
        std::str::from_utf8(text).expect("text")
    }

    /// Stamp, s, and frame of a header.
    fn header(&mut self) -> (f64, &'m str) {
        (f64::from(self.whole()) + 1e-9 * f64::from(self.whole()), self.text())
    }
}

/// Reads a recording.
pub(super) fn recorded(path: &str, options: &[mcap::read::Options]) -> Recorded {
    let bytes = std::fs::read(path).expect("a recording");
    let mut found = Recorded { wrenches: Vec::new(), lines: Vec::new(), images: Vec::new() };
    let messages =
        mcap::MessageStream::new_with_options(&bytes, options.iter().copied().collect()).expect("a recording");
    for message in messages {
        let message = message.expect("a whole message");
        let mut cdr = Cdr { bytes: &message.data[4..], at: 0 };
        let schema = message.channel.schema.as_ref().expect("a schema");
        assert_eq!((schema.encoding.as_str(), message.channel.message_encoding.as_str()), ("ros2msg", "cdr"));
        match message.channel.topic.as_str() {
            "/finray/live" => found.lines.push(serde_json::from_str(cdr.text()).expect("a line of JSON")),
            "/finray/image" => {
                assert_eq!(schema.name, "sensor_msgs/msg/Image");
                let (time_s, frame) = cdr.header();
                let [height, width] = [(); 2].map(|()| cdr.whole());
                let (encoding, is_big_endian) = (cdr.text(), cdr.take(1, 1)[0]);
                let [row_bytes, byte_count] = [(); 2].map(|()| cdr.whole());
                assert_eq!((frame, encoding, is_big_endian), ("camera", "rgb8", 0));
                assert_eq!([row_bytes, byte_count], [3 * width, 3 * width * height]);
                let pixels = cdr.take(1, byte_count as usize).to_vec();
                let image = RgbImage::from_raw(width, height, pixels).expect("three bytes a pixel");
                found.images.push((time_s, image, found.lines.len()));
            }
            topic => {
                assert_eq!(schema.name, "geometry_msgs/msg/WrenchStamped");
                let (time_s, frame) = cdr.header();
                assert_eq!(topic.replace("/finray/", "").replace('/', "_"), frame);
                let [force, torque] = [(); 2].map(|()| [(); 3].map(|()| cdr.number()));
                assert_eq!(torque, [0.0; 3], "the torque about the contact");
                found.wrenches.push((topic.to_owned(), time_s, force));
            }
        }
        assert_eq!(cdr.at, cdr.bytes.len(), "the end of the message");
    }
    found
}

/// With `--record-images`, the recording also contains the pixels of each evaluated frame, to the last bit and before the line of the frame.
#[test]
fn images_are_recorded_to_the_last_bit() {
    let folder = Folder::new();
    let mut images = images(&folder, &[2.0]);
    images.push(RgbImage::new(images[0].width(), images[0].height()));
    let stream = yuv4mpeg2(&images, "420jpeg", [2, 2], false);
    let (path, record) = (folder.put("stream", &stream), folder.path("record.mcap"));
    let live = ["live", CAMERA, "--contact-at", "auto@-20", "--every-frame", "--record", &record];
    let found = lines(&finray(&[&live[..], &["--record-images", "--input", &path]].concat()).done());
    assert_eq!(states(&found), ["contact", "lost"]);
    let in_recording = recorded(&record, &[]);
    assert_eq!((in_recording.lines, in_recording.wrenches.len()), (found, 1));
    let expected: Vec<_> =
        frames_of(&stream).iter().enumerate().map(|(i, frame)| (0.04 * i as f64, whole(frame), i)).collect();
    assert!(in_recording.images == expected, "stamps, pixels or order of the images differ");
    // Without the option, no image is recorded.
    finray(&[&live[..], &["--input", &path]].concat()).done();
    assert_eq!(recorded(&record, &[]).images.len(), 0);
    // An image file is recorded with its pixels.
    let image = folder.path("image.png");
    finray(&[&live[..], &["--record-images", "--image", &image]].concat()).done();
    let [(_, recorded, 0)] = &recorded(&record, &[]).images[..] else { panic!("expected one image before its line") };
    assert!(*recorded == images[0], "the pixels differ");
    // Positions have no image.
    let message = finray_reading(pressed_frame().as_bytes(), &[&live[..], &["--record-images"]].concat()).refused();
    assert_says(&message, &["--record-images", "expected a stream of images, found positions"]);
    assert_says(&finray(&["live", CAMERA, "--contact-at", "auto@0", "--record-images"]).refused(), &["--record"]);
}

/// Starts `live` on standard input with a recording, sends frames until it has printed `count` lines, and kills it. Returns the printed lines.
fn killed_after(count: usize, header: &[u8], frame: &[u8], more: &[&str]) -> Vec<Value> {
    let mut command = command(&[&["live", CAMERA, "--contact-at", "auto@0"], more].concat());
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("finray starts");
    let mut input = child.stdin.take().expect("an input");
    let mut out = BufReader::new(child.stdout.take().expect("an output"));
    let mut printed = String::new();
    input.write_all(header).expect("a header");
    for _ in 0..count {
        input.write_all(frame).expect("a frame");
        out.read_line(&mut printed).expect("a line");
    }
    child.kill().expect("it still runs");
    child.wait().expect("the end");
    lines(&printed)
}

/// All messages up to the last line can be read from the recording of a run that was killed.
#[test]
fn the_recording_of_a_killed_run_is_readable() {
    let folder = Folder::new();
    let record = folder.path("record.mcap");
    let found = killed_after(3, b"", pressed_frame().as_bytes(), &["--record", &record]);
    let in_recording = recorded(&record, &[mcap::read::Options::IgnoreEndMagic]);
    assert_eq!((in_recording.lines, in_recording.wrenches.len()), (found, 3));
    let stream = yuv4mpeg2(&images(&folder, &[1.0]), "420jpeg", [2, 2], false);
    let header = stream.iter().position(|byte| *byte == b'\n').expect("a header") + 1;
    let (header, frame) = stream.split_at(header);
    let found = killed_after(2, header, frame, &["--record", &record, "--record-images"]);
    let in_recording = recorded(&record, &[mcap::read::Options::IgnoreEndMagic]);
    assert_eq!((in_recording.lines, in_recording.images.len()), (found, 2));
}

/// A recording on a full disk ends the run with exit code 1, with and without images.
#[test]
#[cfg(target_os = "linux")]
fn a_recording_on_a_full_disk_is_an_error() {
    let folder = Folder::new();
    let live = ["live", CAMERA, "--contact-at", "auto@0", "--record", "/dev/full"];
    let message = finray_reading(pressed_frame().as_bytes(), &live).failed();
    assert_says(&message, &["/dev/full", "cannot be written"]);
    images(&folder, &[1.0]);
    let image = folder.path("image.png");
    let message = finray(&[&live[..], &["--record-images", "--image", &image]].concat()).failed();
    assert_says(&message, &["/dev/full", "cannot be written"]);
}
