//! `sense` on image files and videos: the forces of `locate` and `sense` in two steps, frame by frame.

use super::CAMERA;
use super::video::{images, whole, yuv4mpeg2};
use crate::kit::*;
use finray_files::DecodedVideo;
use finray_files::frames::{FrameReader, VideoFrame};
use image::RgbImage;
use std::io::BufReader;
use std::path::Path;
use std::process::Command;

/// Forces of the images at 80 mm and -20 degrees, N.
const FORCES_N: [f64; 3] = [0.0, 2.0, 0.0];
const COLUMNS: [&str; 5] = ["s_mm", "angle_deg", "force_n", "sigma_n", "contact"];

/// The images as files.
fn files(folder: &Folder) -> Vec<String> {
    let named = |(i, image): (usize, RgbImage)| {
        let path = folder.path(&format!("{i}.png"));
        image.save(&path).expect("an image");
        path
    };
    images(folder, &FORCES_N).into_iter().enumerate().map(named).collect()
}

/// Images are located with the scene that senses. A loaded finger has the row of `locate` and `sense`; a free one has a state and no force.
#[test]
fn images_have_the_forces_of_their_tables() {
    let folder = Folder::new();
    let files = files(&folder);
    let (shown, table) = (files.iter().map(String::as_str).collect::<Vec<_>>(), folder.path("nodes.csv"));
    let asked = ["--contact-at", "auto@-20"];
    let sensed = finray(&[&["sense", CAMERA, "--image", shown[0], shown[1], shown[2]][..], &asked].concat());
    let summary = sensed.summary.clone().expect("a summary");
    let rows = Csv::of(&sensed.done());
    assert_eq!(rows.texts("image"), ["0.png", "1.png", "2.png"]);
    assert_eq!(rows.texts("state"), ["none", "contact", "none"]);
    assert_eq!((rows.texts("force_n")[0], rows.texts("refused")), ("", vec!["", "", ""]));
    assert_says(&summary, &["3 images: 1 in contact, 2 free, 0 refused, 0 without finger"]);

    finray(&["locate", CAMERA, "--image", shown[1], "--out", &table]).done();
    let alone = Csv::of(&finray(&[&["sense", CAMERA, "--displacements", &table][..], &asked].concat()).done());
    for column in COLUMNS {
        assert_eq!(rows.texts(column)[1], alone.texts(column)[0], "{column}");
    }
    // Displacements from an image of the unloaded finger; the scene need not know the camera's pose.
    let text = std::fs::read_to_string(CAMERA).expect("the scene");
    let without =
        text.lines().filter(|line| !line.starts_with("rotation_vector_rad") && !line.starts_with("translation_mm"));
    let scene = folder.put("without.toml", without.collect::<Vec<_>>().join("\n"));
    let rest = ["--image", shown[1], "--rest", shown[0]];
    finray(&[&["locate", &scene][..], &rest, &["--out", &table]].concat()).done();
    let from_rest = Csv::of(&finray(&[&["sense", &scene][..], &rest, &asked].concat()).done());
    let alone = Csv::of(&finray(&[&["sense", &scene, "--displacements", &table][..], &asked].concat()).done());
    assert_eq!(from_rest.texts("force_n"), alone.texts("force_n"));
    assert_says(
        &finray(&[&["sense", &scene, "--image", shown[1]][..], &asked].concat()).refused(),
        &["rotation_vector_rad"],
    );
}

/// Checks the rows of a video of the images, sensed with options of the noise. The force has a relative error of at most `error`.
fn assert_frames(path: &str, noise: &[&str], error: f64) {
    let sensed = finray(&[&["sense", CAMERA, "--video", path, "--contact-at", "auto@-20"], noise].concat());
    assert_says(sensed.summary.as_deref().expect("a summary"), &["3 frames: 1 in contact, 2 free"]);
    let rows = Csv::of(&sensed.done());
    assert_eq!(rows.texts("state"), ["none", "contact", "none"]);
    assert_eq!((rows.numbers("frame"), rows.numbers("t_s")), (vec![0.0, 1.0, 2.0], vec![0.0, 0.04, 0.08]));
    let [force_n, least_n, most_n] =
        ["force_n", "low_n", "high_n"].map(|column| rows.texts(column)[1].parse::<f64>().expect("a force"));
    assert!(
        (force_n / 2.0 - 1.0).abs() < error && least_n < force_n && force_n < most_n,
        "{least_n} {force_n} {most_n}"
    );
}

#[test]
fn every_frame_of_a_video_has_a_row() {
    let folder = Folder::new();
    assert_frames(&folder.put("video.y4m", yuv4mpeg2(&images(&folder, &FORCES_N), "444", [1, 1], false)), &[], 0.002);
}

/// Runs `ffmpeg`; if it is not installed, prints a message and returns `false`, because the project does not require it.
fn ffmpeg(arguments: &[&str]) -> bool {
    let run = Command::new("ffmpeg").args(["-nostdin", "-v", "error"]).args(arguments).status();
    run.is_ok_and(|status| status.success()) || {
        println!("no ffmpeg was found: videos of other formats are not tested");
        false
    }
}

/// Largest difference of a channel, averaged over the inside of the back plate's markers, between an image and its decoded frame. Chroma that pixels
/// share accounts for 5 levels; colours decoded with the other matrix differ by 15.
const COLOUR: f64 = 8.0;

/// Difference between the channels of an image and those of the first frame of a video, averaged over the pixels with the colour of the back plate's
/// markers.
fn colour_error(image: &RgbImage, path: &str) -> [f64; 3] {
    let video = DecodedVideo::open(Path::new(path)).expect("ffmpeg");
    let mut reader = FrameReader::yuv4mpeg2(BufReader::new(video)).expect("a stream");
    let mut frame = VideoFrame::new(reader.layout());
    assert!(reader.read(&mut frame).expect("a frame"));
    let decoded = whole(&frame);
    let is_red =
        |pixel: &image::Rgb<u8>| pixel.0.iter().zip([198, 52, 44]).all(|(found, red)| found.abs_diff(red) < 14);
    let inside: Vec<_> = image.pixels().zip(decoded.pixels()).filter(|(pixel, _)| is_red(pixel)).collect();
    assert!(inside.len() > 1000, "{} pixels", inside.len());
    [0, 1, 2].map(|k| {
        let difference =
            |(image, decoded): &(&image::Rgb<u8>, &image::Rgb<u8>)| f64::from(decoded.0[k]) - f64::from(image.0[k]);
        inside.iter().map(difference).sum::<f64>() / inside.len() as f64
    })
}

/// Videos of other formats are decoded by `ffmpeg`, with colours of either matrix.
#[test]
fn ffmpeg_decodes_other_videos() {
    let folder = Folder::new();
    let images = images(&folder, &FORCES_N);
    let source = folder.put("video.y4m", yuv4mpeg2(&images, "444", [1, 1], false));
    for (matrix, filter) in [("bt601", "null"), ("bt709", "scale=out_color_matrix=bt709")] {
        let tag = if matrix == "bt601" { "smpte170m" } else { matrix };
        let path = folder.path(&format!("-{matrix}: phone.mp4"));
        let coded = ["-i", &source, "-vf", filter, "-colorspace", tag, "-pix_fmt", "yuv420p", "-crf", "10"];
        if !ffmpeg(&[&coded[..], &[&format!("file:{path}")]].concat()) {
            return;
        }
        let error = colour_error(&images[0], &path);
        assert!(error.iter().all(|channel| channel.abs() < COLOUR), "{matrix}: {error:?}");
        // Errors of compression exceed the noise that `locate` states for each marker.
        assert_frames(&path, &["--noise-mm", "0.01"], 0.02);
    }
}

/// What is no video, or needs a program that is missing, is refused, and the result file stays unchanged.
#[test]
fn files_that_are_no_video_are_refused() {
    let folder = Folder::new();
    let (noise, out) = (folder.put("noise.mp4", [0, 0, 0, 24, 102, 116, 121, 112]), folder.put("out.csv", "before"));
    let asked = ["--contact-at", "auto@-20", "--out", &out];
    let refused = |path: &str| finray(&[&["sense", CAMERA, "--video", path][..], &asked].concat()).refused();
    assert_says(&refused(&noise), &["noise.mp4", "expected YUV4MPEG2", "ffmpeg"]);
    assert_says(
        &refused(&folder.put("nodes.csv", "t_s,node,x_mm,y_mm\n0,2,1,1\n")),
        &["expected a video, found positions"],
    );
    assert_says(&refused(&folder.path("missing.mp4")), &["missing.mp4", "cannot be read"]);
    let mut without = command(&[&["sense", CAMERA, "--video", &noise][..], &asked].concat());
    let without = without.env("PATH", "").output().expect("finray runs");
    assert_says(&String::from_utf8_lossy(&without.stderr), &["noise.mp4", "no ffmpeg is on the PATH"]);
    assert_eq!((without.status.code(), folder.read("out.csv")), (Some(2), "before".to_owned()));

    let refused = |arguments: &[&str]| {
        finray(&[&["sense", CAMERA, "--contact-at", "auto@-20"][..], arguments].concat()).refused()
    };
    assert_says(&refused(&[]), &["--displacements", "--image", "--video"]);
    assert_says(&refused(&["--video", &noise, "--image", &noise]), &["cannot be used with"]);
    assert_says(&refused(&["--video", &noise, "--all-images"]), &["--displacements"]);
    assert!(Path::new(&out).exists());
}
