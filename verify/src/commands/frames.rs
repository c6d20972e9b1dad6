//! Frames of a stream, of a video or of image files.

use crate::commands::prelude::*;
use finray_files::DecodedVideo;
use finray_files::frames::{FrameError, FrameLayout, FrameReader, VideoFrame};
use finray_files::live::FrameInfo;
use finray_files::positions::{FingerObservation, PositionError, PositionFrame, PositionReader};
use finray_imaging::RgbRows;
use finray_imaging::locate::Observer;
use finray_model::observation::Observation;
use finray_model::sensor::FrameState;
use image::RgbImage;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::time::Instant;

/// Size of a stream's read buffer, bytes: the same as the size of a pipe's buffer. Larger reads, for example of a frame's pixels, bypass the buffer.
const AT_ONCE: usize = 1 << 16;

/// Format of a stream: YUV4MPEG2 (`Y4m`); red, green and blue of each pixel, 8 bits each (`Rgb24`); or marker positions, with one row per marker
/// (`Csv`) or one line per frame (`Jsonl`). The variants have no doc comments, because the help would list them line by line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    Y4m,
    Rgb24,
    Csv,
    Jsonl,
}

/// Image or marker positions of a frame, or the reason why neither could be read.
pub enum Content {
    /// An image from a file.
    Image(RgbImage),
    /// A frame of a video.
    Video(VideoFrame),
    /// Positions of markers, by finger.
    Markers(Vec<FingerObservation>),
    /// Reason why the frame cannot be read.
    Unreadable(String),
}

impl Content {
    /// The pixels of an image.
    pub fn pixels(&self) -> Option<&dyn RgbRows> {
        match self {
            Content::Image(image) => Some(image),
            Content::Video(video) => Some(video),
            Content::Markers(_) | Content::Unreadable(_) => None,
        }
    }
}

/// A frame of a stream.
pub struct Frame {
    /// Number, times and dropped frames.
    pub info: FrameInfo,
    /// Image or positions.
    pub content: Content,
}

type Stream = Box<dyn BufRead + Send>;

/// The frames of a source, in order.
enum Frames {
    /// A stream of images.
    Images(FrameReader<Stream>),
    /// A stream of positions.
    Positions(PositionReader<Stream>),
    /// Image files in reverse order: the next file is the last of the list.
    Files(Vec<PathBuf>),
}

/// Source of frames: a stream, or a list of image files.
pub struct Source {
    /// Path of the stream; `-` for standard input.
    path: PathBuf,
    frames: Frames,
}

impl Source {
    /// A stream from a file, or from standard input for `-`. If `format` is `None`, the first byte of the stream decides; a file of an unknown format is
    /// decoded as a video. `size_px` is the size of raw frames.
    ///
    /// # Errors
    /// [`Failure`] if the stream cannot be read or its format is unknown.
    pub fn open(path: &Path, format: Option<Format>, size_px: Option<[u32; 2]>) -> Result<Source, Failure> {
        let unreadable = |reason| FileError::Unreadable { path: path.to_owned(), reason };
        let source: Box<dyn Read + Send> = match is_standard_stream(path) {
            true => Box::new(std::io::stdin()),
            false => Box::new(File::open(path).map_err(unreadable)?),
        };
        let mut source: Stream = Box::new(BufReader::with_capacity(AT_ONCE, source));
        let wrong = |reason: &dyn ToString| Failure::from(FileError::content(path, reason.to_string()));
        if size_px.is_some() != (format == Some(Format::Rgb24)) {
            return Err(bad_input("expected --size together with --format rgb24"));
        }
        let first = source.fill_buf().map_err(unreadable)?;
        let first = first.strip_prefix(b"\xef\xbb\xbf").unwrap_or(first);
        let is_text =
            || !first.iter().take_while(|byte| **byte != b'\n').any(|byte| *byte < b' ' && !b"\t\r".contains(byte));
        let format = match (format, first.first()) {
            (Some(format), _) => format,
            (None, None) => return Err(wrong(&"expected a stream, found nothing")),
            (None, Some(b'Y')) => Format::Y4m,
            (None, Some(b'{' | b' ' | b'\n' | b'\r')) => Format::Jsonl,
            (None, Some(b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'"')) if is_text() => Format::Csv,
            _ => {
                let video = if is_standard_stream(path) { None } else { Some(DecodedVideo::open(path)) };
                let reason = match video {
                    Some(Ok(video)) => {
                        source = Box::new(BufReader::with_capacity(AT_ONCE, video));
                        source.fill_buf().err()
                    }
                    Some(Err(reason)) => Some(reason),
                    None => Some(std::io::Error::other("a video is decoded from a file only")),
                };
                if let Some(reason) = reason {
                    let expected =
                        "expected YUV4MPEG2, JSON lines, CSV or a video; raw frames need --format rgb24 and --size";
                    return Err(wrong(&format!("{expected} ({reason})")));
                }
                Format::Y4m
            }
        };
        let frames = match (format, size_px) {
            (Format::Rgb24, Some(size_px)) => Frames::Images(FrameReader::raw(source, FrameLayout::rgb(size_px))),
            (Format::Y4m | Format::Rgb24, _) => {
                Frames::Images(FrameReader::yuv4mpeg2(source).map_err(|error| wrong(&error))?)
            }
            (Format::Csv | Format::Jsonl, _) => {
                Frames::Positions(PositionReader::new(source, format == Format::Jsonl).map_err(|error| wrong(&error))?)
            }
        };
        Ok(Source { path: path.to_owned(), frames })
    }

    /// Image files, in this order.
    pub fn of_images(images: &[PathBuf]) -> Source {
        let frames = Frames::Files(images.iter().rev().cloned().collect());
        Source { path: PathBuf::new(), frames }
    }

    /// Whether the frames are images.
    pub fn shows_pixels(&self) -> bool {
        !matches!(self.frames, Frames::Positions(_))
    }

    /// Refuses a stream of images whose size is not that of the scene's camera.
    ///
    /// # Errors
    /// [`Failure::BadInput`] with both sizes.
    pub fn require_size(&self, scene: &Scene) -> Result<(), Failure> {
        let Frames::Images(reader) = &self.frames else { return Ok(()) };
        let found = reader.layout().size_px;
        match scene.camera.map(|camera| camera.lens.size_px()) {
            Some(expected) if expected != found => {
                let [expected, found] = [expected, found].map(|[width, height]| format!("{width} x {height} px"));
                let message = format!("expected frames of {expected}, the size of the scene's camera, found {found}");
                Err(FileError::content(&self.path, message).into())
            }
            _ => Ok(()),
        }
    }

    /// The next frame, or `None` at the end. `number` is the frame's number in the stream. The memory of `spare`, an evaluated or dropped frame, is
    /// reused.
    ///
    /// # Errors
    /// [`Failure`] if the stream cannot be read further.
    pub fn next(&mut self, number: usize, spare: Option<Frame>) -> Result<Option<Frame>, Failure> {
        let unreadable = |reason| Failure::from(FileError::Unreadable { path: self.path.clone(), reason });
        let wrong = |reason: String| Failure::from(FileError::content(&self.path, reason));
        let frame =
            |time_s, arrived, content| Some(Frame { info: FrameInfo { number, time_s, arrived, dropped: 0 }, content });
        Ok(match &mut self.frames {
            Frames::Images(reader) => {
                let layout = reader.layout();
                let mut video = match spare.map(|frame| frame.content) {
                    Some(Content::Video(video)) => video,
                    _ => VideoFrame::new(layout),
                };
                match reader.read(&mut video) {
                    Ok(true) => {}
                    Ok(false) => return Ok(None),
                    Err(error @ FrameError::CutOff { .. }) => {
                        print_message(format_args!("warning: {}: {error}; the stream ends here", name_of(&self.path)));
                        return Ok(None);
                    }
                    Err(FrameError::Unreadable(reason)) => return Err(unreadable(reason)),
                    Err(error) => return Err(wrong(error.to_string())),
                }
                let time_s = layout.per_second.map(|rate| number as f64 / rate);
                frame(time_s, Instant::now(), Content::Video(video))
            }
            Frames::Positions(reader) => match reader.read() {
                Ok(None) => None,
                Ok(Some(PositionFrame { time_s, seen })) => {
                    frame(time_s, Instant::now(), seen.map_or_else(Content::Unreadable, Content::Markers))
                }
                Err(PositionError::Unreadable(reason)) => return Err(unreadable(reason)),
                Err(PositionError::Form(reason)) => return Err(wrong(reason)),
            },
            Frames::Files(paths) => paths.pop().and_then(|path| {
                let content = match load_image(&path) {
                    Ok((image, _)) => Content::Image(image),
                    Err(error) => Content::Unreadable(error.to_string()),
                };
                frame(None, Instant::now(), content)
            }),
        })
    }
}

/// The markers of a finger in a frame; without markers, the state of the frame and the reason for it.
pub fn observed(
    content: &Content,
    finger: &str,
    observer: Option<&mut Observer>,
) -> Result<Observation, (FrameState, String)> {
    match (content, observer) {
        (Content::Image(image), Some(observer)) => observer.observe_frame(image),
        (Content::Video(video), Some(observer)) => observer.observe_frame(video),
        (Content::Image(_) | Content::Video(_), None) => {
            Err((FrameState::Refused, "expected positions, found an image".to_owned()))
        }
        (Content::Markers(fingers), _) => match fingers.iter().find(|of| of.finger == finger) {
            Some(of_this) => Ok(of_this.seen.clone()),
            None if fingers.is_empty() => Ok(Observation::default()),
            None => Err((FrameState::Lost, "the frame has no markers of this finger".to_owned())),
        },
        (Content::Unreadable(reason), _) => Err((FrameState::Refused, reason.clone())),
    }
}

/// Number of frames in each state, in words.
pub fn states([in_contact, free, refused, lost]: [usize; 4]) -> String {
    format!("{in_contact} in contact, {free} free, {refused} refused, {lost} without finger")
}
