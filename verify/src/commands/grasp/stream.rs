//! Streams of the images from which the forces of a grasp are sensed.

use crate::commands::prelude::*;
use finray_files::frames::FrameWriter;
use finray_files::{open_stream, streamed};
use finray_model::scene::GraspDescription;
use finray_studies::experiments::grasp::finger_name;
use image::RgbImage;
use std::io::Write;
use std::ops::ControlFlow;

/// A finger (0 for left, 1 for right) and the file of its stream, from `left=FILE` or `right=FILE`.
pub fn stream_of_finger(text: &str) -> Result<(usize, PathBuf), String> {
    let found = text.split_once('=').and_then(|(name, file)| Some(((0..2).find(|of| finger_name(*of) == name)?, file)));
    match found {
        Some((finger, file)) if !file.is_empty() => Ok((finger, PathBuf::from(file))),
        _ => Err("expected left=FILE or right=FILE, with - as FILE for standard output".to_owned()),
    }
}

/// The streams of a grasp: YUV4MPEG2, one per finger, with one frame per step. Frame `n` (from 0) shows step `n + 1`.
pub struct Streams {
    streams: Vec<FingerStream>,
    size_px: [u32; 2],
    /// Reason why a frame could not be written.
    failed: Option<FileError>,
}

struct FingerStream {
    finger: usize,
    path: PathBuf,
    /// `None` after the reader has closed the pipe.
    writer: Option<FrameWriter<Box<dyn Write>>>,
}

impl FingerStream {
    /// Writes to the stream. If the reader closes the pipe of a stream, only that stream ends; the command continues.
    fn write(&mut self, image: &RgbImage) -> Result<(), FileError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let written = writer.write(image);
        if written.is_err() {
            self.writer = None;
        }
        streamed(&self.path, written)
    }
}

impl Streams {
    /// Opens the streams of the fingers, and writes their headers. Frames have the size of the scene's camera, and the rate `frames_per_s` of the
    /// grasp if the scene states it.
    ///
    /// # Errors
    /// [`Failure::BadInput`] if a finger or a file is named twice, or if the camera is on the gripper; [`Failure::NotComputed`] if a stream cannot be
    /// written.
    pub fn open(files: &[(usize, PathBuf)], scene: &Scene, grasp: &GraspDescription) -> Result<Streams, Failure> {
        if let [(first, one), (second, other), ..] = files
            && (files.len() > 2 || first == second || one == other)
        {
            return Err(bad_input("--stream: expected each finger once, and a file for each finger"));
        }
        if !files.is_empty() && grasp.camera_on_gripper {
            return Err(bad_input(
                "--stream: expected a camera at rest relative to the finger, as `finray live` assumes, found \
                    grasp.camera_on_gripper = true",
            ));
        }
        let size_px = scene.camera.map_or([0; 2], |camera| camera.lens.size_px());
        let open = |(finger, path): &(usize, PathBuf)| {
            let writer = match FrameWriter::yuv4mpeg2(open_stream(path)?, size_px, grasp.frames_per_s) {
                Ok(writer) => Some(writer),
                Err(reason) => streamed(path, Err(reason)).map(|()| None)?,
            };
            Ok(FingerStream { finger: *finger, path: path.clone(), writer })
        };
        Ok(Streams { streams: files.iter().map(open).collect::<Result<_, Failure>>()?, size_px, failed: None })
    }

    /// Writes the images of the left and the right finger in a step. A finger that its camera does not see gives a black frame, so that later frames
    /// keep their numbers. Returns `ControlFlow::Break` if a stream cannot be written.
    pub fn write(&mut self, images: [Option<RgbImage>; 2]) -> ControlFlow<()> {
        let black = || RgbImage::new(self.size_px[0], self.size_px[1]);
        for stream in &mut self.streams {
            let written = match &images[stream.finger] {
                Some(image) => stream.write(image),
                None => stream.write(&black()),
            };
            if let Err(failed) = written {
                self.failed = Some(failed);
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    /// Ends the streams.
    ///
    /// # Errors
    /// [`Failure::NotComputed`] with the reason why a frame could not be written.
    pub fn end(self) -> Result<(), Failure> {
        self.failed.map_or(Ok(()), |failed| Err(failed.into()))
    }
}
