//! Video frames: their formats, their colours, and the forces that they show.

use super::{CAMERA, force_n, lines, states};
use crate::kit::*;
use finray_files::frames::{FrameLayout, FrameReader, FrameWriter, VideoFrame};
use finray_imaging::RgbRows;
use finray_imaging::locate::Observer;
use finray_model::Scene;
use image::RgbImage;

/// Colour spaces, each with the numbers of columns and rows that share a chroma sample.
const CHROMA: [(&str, [u32; 2]); 5] =
    [("444", [1, 1]), ("422", [2, 1]), ("420jpeg", [2, 2]), ("420mpeg2", [2, 2]), ("420paldv", [2, 2])];

/// Images of the finger under forces (N) at 80 mm and -20 degrees.
pub(super) fn images(folder: &Folder, forces_n: &[f64]) -> Vec<RgbImage> {
    let image = |force_n: &f64| {
        let (path, load) = (folder.path("image.png"), format!("80:{force_n},-20"));
        finray(&["render", CAMERA, "--load-at", &load, "--grey-noise", "2", "--blur-px", "0.8", "--out", &path]).done();
        image::open(&path).expect("an image").to_rgb8()
    };
    forces_n.iter().map(image).collect()
}

/// A byte of luma or chroma, from weights of red, green and blue (ITU-R BT.601) and an offset.
fn weighted([r, g, b]: [f64; 3], [red, green, blue]: [f64; 3], offset: f64) -> u8 {
    (offset + red * r + green * g + blue * b).round().clamp(0.0, 255.0) as u8
}

/// Pixels whose mean is the chroma sample at pixel `first` along one side of an image. `per` pixels share a sample; the sample lies between the two pixels
/// if `is_between`, otherwise at the first one.
fn averaged(first: u32, per: u32, is_between: bool, size: u32) -> Vec<u32> {
    let within = |pixels: [u32; 4]| pixels.map(|pixel| pixel.min(size - 1)).to_vec();
    match (per, is_between) {
        (1, _) => vec![first],
        (_, true) => within([first, first, first + 1, first + 1]),
        (_, false) => within([first.saturating_sub(1), first, first, first + 1]),
    }
}

/// Frames as YUV4MPEG2, encoded in floating point, independent of the decoder. `across` columns and `down` rows share a chroma sample.
pub(super) fn yuv4mpeg2(
    images: &[RgbImage],
    colour_space: &str,
    [across, down]: [u32; 2],
    is_full_range: bool,
) -> Vec<u8> {
    let (width, height) = images[0].dimensions();
    let range = if is_full_range { " XCOLORRANGE=FULL" } else { "" };
    let mut stream = format!("YUV4MPEG2 W{width} H{height} F25:1 Ip A1:1 C{colour_space}{range}\n").into_bytes();
    let (luma, chroma, black) = if is_full_range { (1.0, 1.0, 0.0) } else { (219.0 / 255.0, 224.0 / 255.0, 16.0) };
    let blue = [-0.168736, -0.331264, 0.5].map(|weight| weight * chroma);
    let red = [0.5, -0.418688, -0.081312].map(|weight| weight * chroma);
    for image in images {
        stream.extend(b"FRAME\n");
        let of_luma = [0.299, 0.587, 0.114].map(|weight| weight * luma);
        stream.extend(image.pixels().map(|pixel| weighted(pixel.0.map(f64::from), of_luma, black)));
        for weights in [blue, red] {
            for v in (0..height).step_by(down as usize) {
                for u in (0..width).step_by(across as usize) {
                    let columns = averaged(u, across, colour_space == "420jpeg", width);
                    let rows = averaged(v, down, colour_space != "420paldv", height);
                    let mut sum = [0.0; 3];
                    for (u, v) in rows.iter().flat_map(|v| columns.iter().map(move |u| (*u, *v))) {
                        let pixel = image.get_pixel(u, v).0;
                        sum.iter_mut().zip(pixel).for_each(|(sum, part)| *sum += f64::from(part));
                    }
                    let count = (rows.len() * columns.len()) as f64;
                    stream.push(weighted(sum.map(|sum| sum / count), weights, 128.0));
                }
            }
        }
    }
    stream
}

/// All pixels of a frame.
pub(super) fn whole(frame: &VideoFrame) -> RgbImage {
    let [width, height] = frame.size_px();
    let mut buffer = Vec::new();
    let rows = (0..height as usize).flat_map(|row| frame.row(row, 0..width as usize, &mut buffer).to_vec());
    RgbImage::from_raw(width, height, rows.collect()).expect("three bytes a pixel")
}

/// The frames of a stream.
pub(super) fn frames_of(stream: &[u8]) -> Vec<VideoFrame> {
    let mut reader = FrameReader::yuv4mpeg2(stream).expect("a stream");
    let mut frame = VideoFrame::new(reader.layout());
    std::iter::from_fn(|| reader.read(&mut frame).expect("frames").then(|| frame.clone())).collect()
}

/// Reads the first frame of a stream; returns the reader and the frame.
fn first_frame(stream: &[u8]) -> (FrameReader<&[u8]>, VideoFrame) {
    let mut reader = FrameReader::yuv4mpeg2(stream).expect("a stream");
    let mut frame = VideoFrame::new(reader.layout());
    assert!(reader.read(&mut frame).expect("a frame"));
    (reader, frame)
}

/// The forces in a video's frames are sensed for every chroma format, for both colour ranges, and for raw frames.
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

/// Covered markers and a jump of the exposure to half or a quarter change no force by more than the interval allows. After them, the finger is found as
/// before: the same image gives the same force within 1e-3 standard deviations. If all markers are covered, the finger is lost in this frame alone.
#[test]
fn forces_hold_through_covered_markers_and_jumps_of_exposure() {
    let folder = Folder::new();
    let plain = images(&folder, &[2.0]).remove(0);
    let path = folder.path("covered.png");
    let covered = |nodes: &[String]| {
        let hide: Vec<&str> = ["--hide"].into_iter().chain(nodes.iter().map(String::as_str)).collect();
        let render =
            ["render", CAMERA, "--load-at", "80:2,-20", "--grey-noise", "2", "--blur-px", "0.8", "--out", &path];
        finray(&[&render[..], &hide].concat()).done();
        image::open(&path).expect("an image").to_rgb8()
    };
    let [some, all] = [
        covered(&["4", "15", "16", "17", "18"].map(str::to_owned)),
        covered(&(1..=25).map(|node| node.to_string()).collect::<Vec<_>>()),
    ];
    let exposed = |share: f64| {
        let mut image = plain.clone();
        image.iter_mut().for_each(|value| *value = (f64::from(*value) * share).round() as u8);
        image
    };
    let (half, quarter) = (exposed(0.5), exposed(0.25));
    let frames = [&plain, &plain, &some, &plain, &half, &half, &plain, &quarter, &plain, &all, &plain, &plain];
    let stream = folder.put("stream", yuv4mpeg2(&frames.map(RgbImage::clone), "444", [1, 1], false));
    let live = ["live", CAMERA, "--contact-at", "auto@-20", "--every-frame", "--input", &stream];
    let found = lines(&finray(&live).done());
    let markers: Vec<u64> = found.iter().map(|line| line["markers"].as_u64().expect("a number")).collect();
    assert_eq!(markers, [25, 25, 20, 25, 25, 25, 25, 25, 25, 0, 25, 25]);
    for (i, line) in found.iter().enumerate() {
        if i == 9 {
            assert_eq!(line["state"], "lost");
            continue;
        }
        assert_eq!(line["state"], "contact", "frame {i}");
        let [force, sigma] = ["force_n", "sigma_n"].map(|key| line["contacts"][0][key].as_f64().expect("a number"));
        // The rendered image is exact, so the error is that of locating markers.
        assert!((force - 2.0).abs() < 3.0 * sigma, "frame {i}: {line}");
        if [3, 6, 8, 11].contains(&i) {
            assert!((force - force_n(&found[1])).abs() < 1e-3 * sigma, "frame {i}: {line}");
        }
    }
}

/// Decoded frames have the colours that were encoded, within rounding, where colours change linearly: the samples of chroma are interpolated at their
/// positions. At the border, where samples continue beyond the image, a part of a sample's change is missing.
#[test]
fn decoded_colours_are_those_that_were_encoded() {
    for (colour_space, chroma) in CHROMA {
        let border = if chroma == [1, 1] { 0 } else { 4 };
        let image = RgbImage::from_fn(25, 19, |u, v| {
            image::Rgb([(8 * u + 20) as u8, (9 * v + 40) as u8, (250 - 5 * u - 5 * v) as u8])
        });
        for is_full_range in [false, true] {
            let stream = yuv4mpeg2(std::slice::from_ref(&image), colour_space, chroma, is_full_range);
            let (mut reader, mut frame) = first_frame(&stream);
            let found = whole(&frame);
            for (u, v, expected) in image.enumerate_pixels() {
                if u < border || v < border || u + border >= 25 || v + border >= 19 {
                    continue;
                }
                for (found, expected) in found.get_pixel(u, v).0.iter().zip(expected.0) {
                    // The tolerance covers rounding of luma and chroma by half a step each, with the largest gain of 1.772 x 255 / 224. A sample half a
                    // pixel from its place changes red by 4.
                    assert!(found.abs_diff(expected) <= 2, "{colour_space}: {found} for {expected} at {u}, {v}");
                }
            }
            assert!(!reader.read(&mut frame).expect("the end"));
        }
    }
    assert_eq!(FrameLayout::rgb([7, 5]).byte_count(), 105);
}

/// Frames of each position of chroma, in both ranges of values, have the colours that ffmpeg converts them to. Both interpolate by cubics, ffmpeg with the
/// parameter 0.6 instead of 0.5, so that edges differ by up to 2 levels. Chroma read at another position differs by 17 levels or more.
#[test]
fn colours_are_those_of_ffmpeg() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/ffmpeg");
    let read = |name: &str| std::fs::read(format!("{folder}/{name}")).unwrap_or_else(|error| panic!("{name}: {error}"));
    for space in ["420jpeg", "420mpeg2", "420paldv"] {
        for levels in ["tv", "pc"] {
            let (video, expected) = (read(&format!("{space}-{levels}.y4m")), read(&format!("{space}-{levels}.rgb")));
            let largest = |stream: &[u8]| {
                let (_, frame) = first_frame(stream);
                whole(&frame).iter().zip(&expected).map(|(found, expected)| found.abs_diff(*expected)).max()
            };
            let differs = largest(&video).expect("pixels");
            assert!(differs <= 2, "{space} {levels}: {differs}");
            // A header may state the position of chroma in XYSCSS alone.
            let text = format!(" C{space} ").into_bytes();
            let at = video.windows(text.len()).position(|part| part == text).expect("a colour space");
            let plain = [&video[..at], b" C420 ", &video[at + text.len()..]].concat();
            assert_eq!(largest(&plain), Some(differs), "{space} {levels}");
        }
    }
}

/// A part of a row has the same pixels as in the whole row, even if the part begins within a chroma sample.
#[test]
fn parts_of_rows_are_converted_as_whole_rows() {
    let image = RgbImage::from_fn(7, 5, |u, v| image::Rgb([(37 * u) as u8, (50 * v) as u8, (29 * (u + v)) as u8]));
    for (colour_space, chroma) in CHROMA {
        let (_, frame) = first_frame(&yuv4mpeg2(std::slice::from_ref(&image), colour_space, chroma, false));
        let all = whole(&frame);
        let mut buffer = vec![1; 100];
        for (row, from) in (0..5).flat_map(|row| (0..=7).map(move |from| (row, from))) {
            for end in from..=7 {
                let expected = all.row(row, from..end, &mut Vec::new()).to_vec();
                assert_eq!(
                    frame.row(row, from..end, &mut buffer),
                    expected,
                    "{colour_space}: row {row}, {from}..{end}"
                );
            }
        }
    }
}

/// Converting a frame's pixels only where they are read gives the same observations, to the last bit, as converting all pixels first. The first image
/// is searched completely; the finger moves by up to 1 mm from image to image.
#[test]
fn frames_give_the_positions_of_their_images() {
    let folder = Folder::new();
    let images = images(&folder, &[1.0, 1.1, 1.2]);
    let scene = Scene::from_toml(finray_fixtures::CAMERA_SCENE).expect("the fixture");
    for (colour_space, chroma) in CHROMA {
        let stream = yuv4mpeg2(&images, colour_space, chroma, false);
        let mut reader = FrameReader::yuv4mpeg2(&stream[..]).expect("a stream");
        let mut frame = VideoFrame::new(reader.layout());
        let [mut of_frames, mut of_images] = [(); 2].map(|()| Observer::new(&scene, None).expect("an observer"));
        while reader.read(&mut frame).expect("frames") {
            let found = of_frames.observe(&frame).expect("a finger");
            assert_eq!(found.markers.len(), 25);
            assert_eq!(found, of_images.observe(&whole(&frame)).expect("a finger"), "{colour_space}");
        }
    }
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
        let mut frame = VideoFrame::new(reader.layout());
        for image in &images {
            assert!(reader.read(&mut frame).expect("a frame"));
            for (found, expected) in whole(&frame).iter().zip(image.iter()) {
                // Luma and chroma are rounded by up to half a step each, so blue errs by up to 0.5 + 1.772 x 0.5 = 1.39 before it is rounded.
                assert!(found.abs_diff(*expected) <= 1, "{found} for {expected}");
            }
        }
        assert!(!reader.read(&mut frame).expect("the end"));
    }
}
